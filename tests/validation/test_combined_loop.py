"""Crushing linearised in the loop of fictitious sliding, as in F. Portioli, C. Casapulla, L. Cascini (2015), section 5.

Int. J. Solids Struct. 69–70: 252–266, doi:10.1016/j.ijsolstr.2015.05.025. A panel of depth t and height h rocks on its
base at ``(t / h) (1 − γ h / f_c)``. In its plane a bonded panel slides along its joints too, and is compared with
the exact cones of crushing in the same loop, to 0.2 %: a load factor without dilatancy is not unique.
"""

import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import solve as solve_pattern

UNIT_WEIGHT = 12e3
HEIGHT, LENGTH = 0.175, 0.4
MOST_PROGRAMS = 25
LOOP = {"procedure": "fictitious", "crushing": "linearised"}


def panel(courses: int, units: int, strength: float, depth: float = 0.2) -> bs.Model:
    """Units in running bond; strength in MPa."""
    rows = [[1] * units if j % 2 == 0 else [0.5] + [1] * (units - 1) + [0.5] for j in range(courses)]
    if units == 1:
        rows = [[1]] * courses
    tuff = bs.Material("tuff", unit_weight=Q_(UNIT_WEIGHT, "N/m^3"))
    joint = bs.JointMaterial("joint", 0.65, compressive_strength=Q_(strength, "MPa"))
    size = {"unit_length": Q_(LENGTH, "m"), "unit_height": Q_(HEIGHT, "m"), "thickness": Q_(depth, "m")}
    blocks = bs.courses(rows, material=tuff, **size)
    return bs.Model("panel", blocks, bs.detect_interfaces(blocks, joint_material=joint))


def solve(model: bs.Model, direction: str, flow: str = "nonassociative", **settings) -> bs.CaseResult:
    return solve_pattern(model, bs.LoadPattern("push", [bs.BodyForce(direction)]), flow, **settings)


def rocking(courses: int, depth: float, strength: float) -> float:
    height = courses * HEIGHT
    return depth / height * (1 - UNIT_WEIGHT * height / (strength * 1e6))


def assert_found_by_the_loop(result: bs.CaseResult) -> None:
    assert result.status == "converged"
    assert result.outcome.procedure == "fictitious"
    assert result.n_iterations <= MOST_PROGRAMS


@pytest.mark.parametrize(
    ("courses", "units", "strength", "direction"),
    [
        *((courses, 3, strength, "+y") for courses in (6, 10, 14) for strength in (1.0, 0.5, 0.3, 0.2)),
        *((courses, 6, strength, "-y") for courses in (4, 8) for strength in (0.3, 0.1)),
        *((6, 1, strength, direction) for strength in (1.0, 0.2, 0.1) for direction in ("+x", "-x", "+y", "-y")),
    ],
)
def test_panels_rock_about_their_stress_block(courses, units, strength, direction):
    """Bonded panels out of their plane, and stacks about either axis."""
    result = solve(panel(courses, units, strength), direction, **LOOP)
    assert_found_by_the_loop(result)
    assert result.outcome.settled
    depth = LENGTH if direction[1] == "x" else 0.2
    assert result.load_factor == pytest.approx(rocking(courses, depth, strength), rel=1e-7)


@pytest.mark.parametrize("strength", [1.0, 0.5, 0.3, 0.2, 0.1])
def test_panels_in_plane(strength):
    model = panel(6, 3, strength)
    lines, cones = (
        solve(model, "+x", **settings)
        for settings in (LOOP, {**LOOP, "crushing": "conic", "crushing_interaction": "uniaxial"})
    )
    assert_found_by_the_loop(lines)
    assert lines.load_factor == pytest.approx(cones.load_factor, rel=2e-3)


@pytest.mark.parametrize(("courses", "units", "strength"), [(6, 3, 0.3), (10, 3, 0.2), (8, 6, 0.1)])
def test_associative_flow_settles_by_its_tangents(courses, units, strength):
    result = solve(panel(courses, units, strength), "+y", "associative", **LOOP)
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(rocking(courses, 0.2, strength), rel=1e-4)
    assert result.n_iterations <= MOST_PROGRAMS
