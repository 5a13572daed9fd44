"""Motions that a collapse state leaves open: walls that stand apart, and joints that open at rates of their own."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.text import assessment
from facades import DRY, portal, solve
from structures import SELF_WEIGHT, box, model_of, push

SITE = bs.assess.ntc_spectrum(Q_(0.1, "g_0"), 2.4, "0.3 s", "B")


def standing(*walls, ties=()):
    """Walls (x, y, length, thickness, height), m, each a block on one ground."""
    blocks = [box(f"wall {k}", [x, y, 0], size) for k, (x, y, *size) in enumerate(walls)]
    ground = box("ground", [-1, -1, -0.5], [20, 5, 0.5], fixed=True)
    return model_of([ground, *blocks], DRY, "walls").with_ties(ties)


def checked(model, **more):
    return bs.assess.local_mechanism(solve(model, push(0, -1, 0)), spectrum=SITE, **more)


@pytest.mark.parametrize("lengths", [(12,), (3, 9), (1, 2, 9)])
def test_walls_apart_are_checked_as_one_wall_is(lengths):
    """0.5 m × 6 m: α0 = 1/12, e* = 1, a0* = g / 12 / 1.35; over all of the parts e* would be 0.75 and 0.47.

    a_Z / 2 = 0.1 g S / 2 with S = 1.2: ratio 1 / 12 / 1.35 / 0.06 = 1.028807.
    """
    starts = np.cumsum([0, *lengths[:-1]]) + 0.02 * np.arange(len(lengths))
    check = checked(standing(*((x, 0, length, 0.5, 6) for x, length in zip(starts, lengths, strict=True))))
    assert (check.alpha0, check.e_star, check.ratio) == pytest.approx((1 / 12, 1.0, 1 / 12 / 1.35 / 0.06), rel=1e-6)
    assert ("separate_mechanisms" in [note.code for note in check.notes]) == (len(lengths) > 1)
    assert sum(body.moves for body in check.bodies) == 1


def test_the_part_with_the_lowest_ratio_is_relied_on():
    """Piers of 0.25 m × 2.5 m and 2 m × 20 m have one α0; by displacement the smaller one has an eighth of d0."""
    small, large = (0, 0, 5, 0.25, 2.5), (10, 0, 5, 2, 20)
    together = checked(standing(large, small), method="displacement")
    alone = [checked(standing(one), method="displacement").ratio for one in (small, large)]
    assert alone[1] > 2 * alone[0]
    assert together.ratio == pytest.approx(alone[0], rel=1e-6)
    parts = [("body 2 (wall 1)", together.ratio), ("body 1 (wall 0)", alone[1])]
    assert assessment.separate_mechanisms(2, parts, []) in together.notes


#: Load factor of a wall of 0.2 m × 3 m, 60 kN, and one of 0.8 m × 4 m, 320 kN, that turn by one angle.
TIED = (60 * 0.1 + 320 * 0.4) / (60 * 1.5 + 320 * 2)


@pytest.mark.parametrize(
    ("yield_force", "e_star", "bodies"),
    [(90, (60 * 1.5 + 320 * 2) ** 2 / (380 * (60 * 1.5**2 + 320 * 2**2)), 2), ((TIED * 90 - 6) / 2, 1.0, 1)],
)
def test_a_tie_that_does_not_yield_makes_one_mechanism_of_two_walls(yield_force, e_star, bodies):
    """A thin wall goes over and pulls a thick one along by a tie at 2 m, with (α 60 · 1.5 − 60 · 0.1) / 2 = 5.26 kN.

    If it yields at just that force, either wall goes over with it by itself.
    """
    ends = ("wall 0", Q_([2.5, 0.2, 2], "m")), ("wall 1", Q_([2.5, 1, 2], "m"))
    tie = bs.Tie("tie", *ends, yield_force=Q_(yield_force, "kN"))
    check = checked(standing((0, 0, 5, 0.2, 3), (0, 1, 5, 0.8, 4), ties=[tie]))
    assert (check.alpha0, check.e_star) == pytest.approx((TIED, e_star), rel=1e-5)
    assert sum(body.moves for body in check.bodies) == bodies


def test_a_pushover_checks_the_mechanism_that_it_follows():
    """One of two equal piers is followed to its d0, half its thickness; the other one is not checked by it."""
    model = standing((10, 0, 5, 0.6, 6), (0, 0, 5, 0.5, 5))
    case = bs.Pushover("p", SELF_WEIGHT, push(0, -1, 0), control=("wall 0", (0, -1, 0)), steps=10)
    result = bs.run(model, case)["p"]
    check = bs.assess.local_mechanism(result, spectrum=SITE, method="displacement")
    assert check.curve.d0 == pytest.approx(0.3, rel=1e-5)
    assert check.notes[0] == assessment.separate_mechanisms(2, [("body 1 (wall 0)", check.ratio)], ["body 2 (wall 1)"])


def tower(*courses, mu=0.9):
    """Courses (front, thickness), m, each 1 m high and 1 m long."""
    ground = box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True)
    blocks = [box(f"course {k}", [0, front, k], [1, thickness, 1]) for k, (front, thickness) in enumerate(courses)]
    return model_of([ground, *blocks], bs.JointMaterial("dry", mu))


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
def test_a_tower_whose_joints_open_together_has_all_its_mass(flow):
    """Courses of 0.6 m and 0.3 m, flush in front: either joint opens at α0 = 0.3, what turns is one body, e* = 1."""
    model = tower((0, 0.6), (0, 0.3))
    check = bs.assess.local_mechanism(solve(model, push(0, -1, 0), flow), spectrum=SITE)
    assert (check.alpha0, check.e_star, check.ratio) == pytest.approx((0.3, 1.0, 0.3 / 1.35 / 0.06), rel=1e-5)
    # The motion that the procedure ended at is one of many, each with another e*.
    assert check.participation.e_star < 0.6
    assert check.verdict.governing.way is not bs.assess.Way.COLLAPSE


def test_a_pushover_of_an_ambiguous_mechanism_has_no_curve():
    """Its control point depends on the motion found."""
    case = bs.Pushover("p", SELF_WEIGHT, push(0, -1, 0), control=("course 1", (0, -1, 0)), steps=5)
    result = bs.run(tower((0, 0.6), (0, 0.3)), case)["p"]
    with pytest.raises(bs.errors.ModelError, match="the mechanism is not unique"):
        bs.assess.local_mechanism(result, spectrum=SITE, method="displacement")
    assert "the mechanism is not unique" in bs.assess.local_mechanism(result, spectrum=SITE).missing_curve


def test_the_least_capacity_of_a_later_mechanism_is_printed():
    """A portal has e* = 0.9; whatever begins at a larger α0 has e* ≤ 1, and thus at least α0 g / FC."""
    check = bs.assess.local_mechanism(solve(portal(), push(1, 0, 0)), spectrum=SITE)
    assert check.e_star < 0.95
    assert f"at least α0 g / FC = {check.alpha0 * 9.80665 / 1.35:.4g} m/s²" in str(check)
