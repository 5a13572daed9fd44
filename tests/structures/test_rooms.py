"""Four walls around a room: exact weight, and corners that interlock."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.structures import Opening, RoundOpening, Rubble
from refusals import refused
from structures import model_of, push, solve

STONE, LIME = bs.Material("stone", "20 kN/m^3"), bs.JointMaterial("lime", 0.6)
LENGTH, WIDTH, HEIGHT, THICKNESS = 5.3, 4.1, 3.0, 0.5
SIZE = {"length": "5.3 m", "width": "4.1 m", "height": "3 m", "thickness": "0.5 m", "unit_height": "0.5 m"}
SIZE |= {"material": STONE}
WINDOW = Opening("1.5 m", "1 m", "1 m", "1 m")
#: Windows with less wall between them than both bearings of their lintels.
NEAR = [Opening(start, "1 m", "0.6 m", "1 m") for start in ("0.8 m", "2.1 m")]
PLAN = LENGTH * WIDTH - (LENGTH - 2 * THICKNESS) * (WIDTH - 2 * THICKNESS)
#: Inner faces of the walls that cross a wall along x, and along y.
FACES = {0: (THICKNESS, LENGTH - THICKNESS), 1: (THICKNESS, WIDTH - THICKNESS)}
RANDOM = Rubble(2, "0.4 m", "1 m", "0.15 m")


@pytest.mark.parametrize(("unit", "rubble"), [(0.5, None), (0.8, None), (1.0, None), (1.2, None), (1.0, RANDOM)])
def test_corners_interlock_in_every_course(unit, rubble):
    """At each corner the wall that extends through it has a unit well across the inner face of the other wall."""
    least = 0.25 * unit if rubble is None else 0.15
    blocks = bs.room(unit_length=f"{unit} m", rubble=rubble, **SIZE)
    for name, axis in (("front", 0), ("back", 0), ("left", 1), ("right", 1)):
        for course in range(1, 7):
            parts = [b.shape.vertices[:, axis] for b in blocks if b.name.startswith(f"{name}.{course}.")]
            is_through = (course % 2 == 1) == (axis == 0)
            for face in FACES[axis]:
                across = [min(face - v.min(), v.max() - face) for v in parts]
                assert (max(across) >= least - 1e-9) == is_through, (name, course, face)
    model = model_of(blocks, LIME)
    assert model.weight == pytest.approx(20e3 * PLAN * HEIGHT)


def test_openings_and_gables_have_the_exact_weight():
    """The model refuses overlaps; no block may float."""
    oculus = RoundOpening(["2.65 m", "3.25 m"], "0.6 m", "0.2 m", 12)
    holes = {"front": [oculus], "back": [WINDOW], "left": [WINDOW], "right": [WINDOW]}
    blocks = bs.room(unit_length="1 m", openings=holes, gable="1.5 m", prefix="chapel ", **SIZE)
    found = bs.detect_interfaces(blocks, LIME)
    assert found.report.overlaps == found.report.floating == found.report.rejected == ()
    whole = PLAN * HEIGHT + 2 * THICKNESS * LENGTH * 1.5 / 2
    clear = THICKNESS * (3 * 1.0 + 12 * 0.3**2 * np.sin(np.pi / 6) / 2)
    assert bs.Model("chapel", blocks, found).weight == pytest.approx(20e3 * (whole - clear))
    assert {b.name.split(".")[0] for b in blocks} == {"chapel " + n for n in ("base", "front", "back", "left", "right")}


def test_bonded_corners_hold_the_front_back():
    """By hand the front alone overturns at t / h = 1/6; friction on the ends of the side walls adds to that."""
    without, held = (
        solve(model_of(bs.room(unit_length="1 m", bonded=bonded, **SIZE), LIME), push(0, -1, 0)).load_factor
        for bonded in (False, True)
    )
    assert THICKNESS / HEIGHT < without < held / 1.2


@pytest.mark.parametrize(
    ("words", "arguments"),
    [
        ("room 0.5 m 5.3 × 1 m", {"width": "1 m"}),
        ("room: left wall 0.2 to 1.2 m corner 0.5 3.6 m", {"openings": {"left": [Opening("0.2 m", *["1 m"] * 3)]}}),
        ("room 'frnt' front", {"openings": {"frnt": [WINDOW]}}),
        ("room: back wall opening 1 4.5 m", {"openings": {"back": [Opening("4.5 m", *["1 m"] * 3)]}}),
        ("left wall lintels course 5 1.6 to 1.9 m", {"openings": {"left": NEAR}}),
        ("room courses height", {"height": None}),
    ],
)
def test_refused_rooms(words, arguments):
    with refused(bs.errors.ModelError, words):
        bs.room(**SIZE | {"unit_length": "1 m"} | arguments)
