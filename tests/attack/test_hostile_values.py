"""Absurd values for every argument of every public constructor: an object, or one error of ours."""

import datetime
import itertools
import math
from decimal import Decimal
from fractions import Fraction
from functools import partial

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from trials import attack

STONE = bs.Material("stone", "20 kN/m^3")
JOINT = bs.JointMaterial("joint", 0.6)
BASE = bs.Block.box("base", Q_([0, 0, -1], "m"), Q_([1, 1, 1], "m"), STONE, fixed=True)
BLOCK = bs.Block.box("block", Q_([0, 0, 0], "m"), Q_([1, 1, 1], "m"), STONE)
INTERFACES = bs.detect_interfaces([BASE, BLOCK], JOINT).interfaces
DEAD = bs.LoadPattern("dead", [bs.SelfWeight()])
PUSH = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
MODEL = bs.Model("model", [BASE, BLOCK], INTERFACES)
VERTICES = Q_(BLOCK.shape.vertices, "m")
FACES = [list(face) for face in BLOCK.shape.faces]
SIZES = {"unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm"}
ENDS = {"start": ["0 m", "0 m", "1 m"], "end": ["1 m", "1 m", "1 m"]}
RING = {"span": "2 m", "thickness": "20 cm", "material": STONE}

#: Calls that make what they are given; each argument in turn is made absurd.
MAKE = [
    partial(bs.Material, name="m", unit_weight="20 kN/m^3", source="a test"),
    partial(bs.Material, name="m", density="2000 kg/m^3"),
    partial(bs.JointMaterial, name="j", friction_coefficient=0.6, dilatancy_angle="1 deg", cohesion="1 kPa",
        tensile_strength="1 kPa", compressive_strength="1 MPa", normal_stiffness="10 GPa/m",
        shear_stiffness="5 GPa/m", source="a test"),
    partial(bs.Block.box, name="b", origin=["0 m"] * 3, size=["1 m"] * 3, material=STONE, fixed=False),
    partial(bs.Block.from_faces, name="b", vertices=VERTICES, faces=FACES, material=STONE, fixed=False),
    partial(bs.Tie, name="t", start=("base", ["0 m"] * 3), end=("block", ["1 m"] * 3), area="1 cm^2",
        strength="200 MPa", punching_force="10 kN", bond_force="10 kN", prestress="1 kN", elongation_limit="1 cm"),
    partial(bs.ties.BondedBar, name="t", start=["0 m"] * 3, end=["1 m"] * 3, diameter="1 cm", bond_strength="1 MPa",
        yield_force="10 kN"),
    partial(bs.Interface, name="i", minus="a", plus="b", polygon=Q_(INTERFACES[0].polygon, "m"), joint_material=JOINT),
    partial(bs.BodyForce, direction=(1, 0, 0), share=0.5),
    partial(bs.PointLoad, block="b", point=["0 m"] * 3, force=["1 kN"] * 3),
    partial(bs.FaceLoad, block="b", face=1, traction=["1 kPa"] * 3),
    partial(bs.FaceLoad, block="b", face=1, pressure="1 kPa", unit_weight="9.81 kN/m^3", level="1 m"),
    partial(bs.Weight, block="b", point=["0 m"] * 3, weight="1 kN", mass_share=0.5),
    partial(bs.LineLoad, weight_per_length="1 kN/m", **ENDS, block="b", spanning=True, mass_share=1),
    partial(bs.AreaLoad, weight_per_area="1 kPa", **ENDS, block="b", spanning=True, mass_share=1),
    partial(bs.FillLoad, unit_weight="18 kN/m^3", start=["0 m"] * 3, end=["1 m"] * 3, block="b",
        lateral_coefficient=0.3, mass_share=1),
    partial(bs.Moment, block="b", moment=["1 kN*m"] * 3),
    partial(bs.LoadPattern, name="p", loads=[bs.SelfWeight()]),
    partial(bs.LimitCase, name="c", dead=DEAD, variable=PUSH, flow="associative"),
    partial(bs.Model, name="m", blocks=[BASE, BLOCK], interfaces=INTERFACES, detection=None),
    partial(bs.detect_interfaces, blocks=[BASE, BLOCK], joint_material=JOINT, tolerance="1 mm",
        angle_tolerance="1 deg", area_tolerance="1 cm^2", explicit=()),
    partial(bs.ProcedureSettings.of, values={}),
    partial(bs.courses, **SIZES, rows=[[1, 1], [0.5, 1, 0.5]], material=STONE, origin=["0 m"] * 3, base=True,
        prefix=""),
    partial(bs.structures.Opening, start="1 m", sill="1 m", width="1 m", height="1 m", bearing="20 cm"),
    partial(bs.structures.Sidewall, name="s", at="0 m", length="1 m", openings=(), bonded=True),
    partial(bs.wall, **SIZES, length="2 m", courses=4, material=STONE, openings=(), sidewalls=(), leaves=1,
        header_every=2, base=True, prefix=""),
    partial(bs.structures.Opening, start="1 m", sill="0 m", width="1 m", height="1 m", rise="0.5 m", ring="0.2 m",
        voussoirs=9),
    partial(bs.structures.RoundOpening, centre=["2 m", "2 m"], diameter="1 m", ring="0.2 m", voussoirs=8),
    partial(bs.structures.Rubble, seed=1, shortest="0.2 m", longest="0.5 m", overlap="0.05 m"),
    partial(bs.structures.Buttress, name="b", at="1 m", width="0.5 m", courses=3, projection="1 m",
        top_projection="0.5 m", behind=True, bonded=False),
    partial(bs.wall, **SIZES, length="3 m", courses=4, material=STONE, gable="1 m",
        rubble=bs.structures.Rubble(1, "0.2 m", "0.5 m", "0.05 m"),
        buttresses=[bs.structures.Buttress("b", "1 m", "0.5 m", 3, "1 m")]),
    partial(bs.structures.pier_spandrel, **SIZES, bays=1, storeys=1, pier_width="80 cm", opening_width="80 cm",
        opening_height="1 m", spandrel_height="40 cm", material=STONE, base=True),
    partial(bs.arch, **RING, depth="20 cm", voussoirs=9, rise="0.5 m", skewback="20 deg", abutments=True,
        origin=["0 m"] * 3),
    partial(bs.structures.arch_on_piers, **RING, depth="20 cm", voussoirs=8, pier_width="40 cm", pier_height="1 m",
        pier_courses=4, rise="1.4 m"),
    partial(bs.structures.barrel_vault, **RING, length="2 m", voussoirs=9, units=2, rise="0.5 m", staggered=True),
    partial(bs.structures.cross_vault, **RING, courses=3, units=3, base=True),
    partial(bs.structures.dome, **RING, courses=4, units=8, oculus="40 cm", rise="1.4 m", staggered=True,
        keystone=False, base=True),
    partial(bs.structures.column, height="3 m", diameter="1 m", top_diameter="80 cm", drums=3, sides=8,
        material=STONE),
    partial(bs.structures.stack, count=3, size=["1 m"] * 3, shift=["1 cm", "0 m"], material=STONE),
    partial(bs.structures.tilted, blocks=[BASE, BLOCK], angle="10 deg", axis=(0, 1, 0), about=["0 m"] * 3),
    partial(bs.AnalysisManager, model=MODEL, settings=None, listeners=(), tags=()),
]  # fmt: skip


def _itself():
    """A list that holds itself."""
    own = []
    own.append(own)
    return own


def _deep():
    nested = []
    for _ in range(3_000):
        nested = [nested]
    return nested


ABSURD = {
    "None": None, "True": True, "-1": -1, "0": 0, "1e308": 1e308, "10**9": 10**9, "10**400": 10**400, "nan": math.nan,
    "inf": math.inf, "1j": 1j, "Decimal": Decimal("NaN"), "Fraction": Fraction(1, 3),
    "date": datetime.date(2026, 1, 31), "empty text": "", "NUL": "\0", "surrogate": "\ud800",
    "long text": "k" * 100_000, "long unit": "1 " + "k" * 100_000, "brackets": "[" * 10_000, "bytes": b"1 m",
    "object": object(), "function": len, "class": bs.Block, "empty list": [], "list of lists": [[]],
    "list that holds itself": _itself(), "deep list": _deep(), "three None": [None] * 3, "three inf": ["1e400 m"] * 3,
    "mapping": {"a": 1}, "set": {1, 2}, "range": range(3), "array": np.zeros((3, 3, 3)), "empty array": np.array([]),
    "array of texts": np.array(["a", "b", "c"]), "array of objects": np.array([None, object(), 1], dtype=object),
    **{f"{number} {unit}": f"{number} {unit}" for unit in ("m", "kN/m^3", "deg", "MPa", "kg/m^3", "m^2")
        for number in ("0", "-1", "1e-320", "1e-160", "1e160", "1e308", "1e999", "nan")},
    **{f"three {number} m": [f"{number} m"] * 3 for number in ("0", "-1", "1e-320", "1e-160", "1e160", "1e308")},
    **{f"three {number}": (number,) * 3 for number in (1e-320, 1e-160, 1e160, 1e308, math.nan, 10**400)},
    "quantity of texts": Q_(np.array(["a"]), "m"), "quantity of nan": Q_(math.nan, "m"),
    "quantity of a list of lists": Q_([[1.0, 2.0], [3.0, 4.0]], "m"), "quantity of degrees Celsius": Q_(20, "degC"),
    "1e160 times the polygon": Q_(INTERFACES[0].polygon * 1e160, "m"),
    "1e-160 times the polygon": Q_(INTERFACES[0].polygon * 1e-160, "m"), "1e160 times the vertices": VERTICES * 1e160,
    "1e-160 times the vertices": VERTICES * 1e-160, "rows of absurd numbers": [[10**400, 1], [math.inf, 1], [True]],
    "a row of texts": [["1"], ["2"]], "a long row": [[1e-300, 1e300]], "huge faces": [[10**30, 1, 2]] * 6,
    "faces of floats": [[0.5, 1, 2]] * 6,
    "nested settings": {"crushing_cells": {"a": [1]}, "schedule": {"slope": [1]}},
    "settings of bytes": {"numerics": {"solver": b"clarabel"}, "crushing_cells": 10**400},
    "settings of texts": {"crushing_cells": "3"}, "settings of numbers": {1: 2},
}  # fmt: skip


def trials(every=1):
    cases = [(k, *row) for k, make in enumerate(MAKE) for row in itertools.product(make.keywords, ABSURD)]
    # A function that the user gives as a joint material may raise what it likes.
    cases = [case for case in cases if case[1:] != ("joint_material", "function")]
    for k, argument, what in cases[every - 1 :: every]:
        changed = partial(MAKE[k], **{argument: ABSURD[what]})
        yield f"{k} {changed.func.__qualname__}({argument}={what})", changed


def test_all_are_made_of_what_is_given():
    assert all(make() is not None for make in MAKE)


@pytest.mark.parametrize("every", [23, pytest.param(1, marks=pytest.mark.slow)])
def test_absurd_values(every, tell):
    tell("absurd values", attack(trials(every)).values())
