"""Invariances of the load factor, and inequalities that hold for every structure."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import blockstruct as bs
from blockstruct import Q_
from properties import few
from structures import model_of, moved, push, rotation, solve

DRY = bs.JointMaterial("dry", 0.65)

BONDS = st.sampled_from(
    [
        [[1, 1, 1], [0.5, 1, 1, 0.5], [1, 1, 1]],
        [[1, 1, 1], [0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5], [0.5, 2, 0.5], [1, 1, 1]],
        [[2, 1], [1, 2], [1.5, 1.5], [0.5, 2, 0.5]],
    ]
)
UNITS = {"m, kN": ("m", "kN/m^3"), "mm, N": ("mm", "N/mm^3"), "ft, lbf": ("ft", "lbf/ft^3")}
SIZE = np.array([0.4, 0.175, 0.12])


def wall(rows, length_unit="m", weight_unit="kN/m^3"):
    length, height, depth = (Q_(Q_(v, "m").to(length_unit).magnitude, length_unit) for v in SIZE)
    weight = Q_(Q_(12, "kN/m^3").to(weight_unit).magnitude, weight_unit)
    material = bs.Material("tuff", weight)
    return bs.courses(rows, unit_length=length, unit_height=height, thickness=depth, material=material)


def agree(one, other, flow):
    """Equal load factors: the associative one is unique, the other one carries rounding through its iteration."""
    assert one.status == other.status == "converged"
    assert one.load_factor == pytest.approx(other.load_factor, rel=1e-6 if flow == "associative" else 1e-5)


@few(12)
@given(rows=BONDS, units=st.sampled_from(sorted(UNITS)), flow=st.sampled_from(list(bs.Flow)))
def test_units(rows, units, flow):
    results = [solve(model_of(wall(rows, *u), DRY), push(1, 0.2, 0), flow) for u in (UNITS["m, kN"], UNITS[units])]
    agree(*results, flow)


@few(12)
@given(
    rows=BONDS,
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle=st.floats(-3, 3),
    shift=st.tuples(*[st.floats(-50, 50)] * 3),
    flow=st.sampled_from(list(bs.Flow)),
)
def test_rigid_motion(rows, axis, angle, shift, flow):
    R = rotation(axis, angle)
    blocks = wall(rows)
    dead, turned = (bs.LoadPattern("dead", [bs.BodyForce(M @ [0, 0, -1])]) for M in (np.eye(3), R))
    here = solve(model_of(blocks, DRY), push(1, 0.2, 0), flow, dead)
    there = solve(model_of(moved(blocks, R, shift), DRY), push(*(R @ [1, 0.2, 0])), flow, turned)
    agree(here, there, flow)


@few(12)
@given(rows=BONDS, seed=st.integers(0, 1000), flow=st.sampled_from(list(bs.Flow)))
def test_block_order(rows, seed, flow):
    blocks = wall(rows)
    shuffled = [blocks[i] for i in np.random.default_rng(seed).permutation(len(blocks))]
    agree(*(solve(model_of(b, DRY), push(1, 0.2, 0), flow) for b in (blocks, shuffled)), flow)


@few(12)
@given(rows=BONDS, mu=st.floats(0.2, 0.8), more=st.floats(1.05, 1.5))
def test_associative_load_factor_grows_with_friction(rows, mu, more):
    weak, strong = (solve(model_of(wall(rows), bs.JointMaterial("j", m)), push(1, 0, 0)) for m in (mu, more * mu))
    assert weak.load_factor <= strong.load_factor * (1 + 1e-6)


@few(12)
@given(rows=BONDS, psi=st.sampled_from([5.0, 15.0, 25.0, 33.0]))
def test_dilatancy_between_none_and_full(rows, psi):
    dilatant = bs.JointMaterial("dilatant", 0.65, dilatancy_angle=Q_(psi, "deg"))
    upper = solve(model_of(wall(rows), DRY), push(1, 0, 0))
    between = solve(model_of(wall(rows), dilatant), push(1, 0, 0), "nonassociative")
    assert between.status == "converged"
    assert between.load_factor <= upper.load_factor * (1 + 1e-6)


def test_full_dilatancy_is_associative():
    rows = [[1, 1, 1], [0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5], [0.5, 2, 0.5], [1, 1, 1]]
    full = bs.JointMaterial("full", friction_angle="30 deg", dilatancy_angle="30 deg")
    model = model_of(wall(rows), full)
    results = [solve(model, push(1, 0, 0), flow) for flow in ("associative", "nonassociative")]
    agree(*results, "associative")
