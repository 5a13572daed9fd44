"""A compressive strength never raises a load factor.

The rectangular stress block is inside the conditions of joints that do not crush, so that associative load factors
cannot rise. Without dilatancy the flow of a joint decides as well. With the normal of the effective rectangle a return
that overturns settled towards its neighbour, and leant on it: load factors rose by 14 to 36 % at any strength, and did
not go back to those of joints that do not crush as the strength grew.
"""

from functools import cache

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import STONE, box, model_of, push, settings_of, solve

#: In multiples of the mean stress under the dead load.
STRENGTHS = [20, 100, 1e3, 1e6]
PROCEDURES = {
    "loading path": {},
    "interior-point path": {"path_steps": "interior point"},
    "fictitious": {"procedure": "fictitious"},
    "shifted": {"procedure": "shifted"},
}
#: A load factor may rise by this: by which two runs of one structure may differ.
ALIKE = 1.01


def slabs(courses):
    """A wall of whole slabs, and another butted against its end."""
    wall = [box(f"wall {k}", [0, 0, 0.25 * k], [1.5, 0.3, 0.25]) for k in range(courses)]
    side = [box(f"side {k}", [0, 0.3, 0.25 * k], [0.3, 0.9, 0.25]) for k in range(courses)]
    return [box("ground", [-1, -1, -0.5], [4, 4, 0.5], fixed=True), *wall, *side]


def bricks(courses, *sides, depth="0.25 m", length="1.6 m"):
    size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "depth": depth}
    walls = [bs.Sidewall(f"side {k}", at, reach, bonded=bonded) for k, (at, reach, bonded) in enumerate(sides)]
    return bs.wall(length=length, courses=courses, material=STONE, sidewalls=walls, **size)


#: Blocks, friction, direction of the push, and the height of the wall in metres.
STRUCTURES = {
    "slabs": (lambda: slabs(4), 0.6, (1, -0.6, 0), 1.0),
    "tall slabs": (lambda: slabs(6), 0.55, (1, -0.6, 0), 1.5),
    "butted": (lambda: bricks(5, ("0 m", "0.8 m", False)), 0.6, (1, -0.6, 0), 1.0),
    "butted at both ends": (
        lambda: bricks(5, ("0 m", "0.8 m", False), ("1.35 m", "0.8 m", False)),
        0.65,
        (0.3, -1, 0),
        1.0,
    ),
    "bonded": (lambda: bricks(6, ("0 m", "0.8 m", True)), 0.6, (1, -1, 0), 1.2),
    "alone": (lambda: bricks(6), 0.6, (1, -0.4, 0), 1.2),
}
QUICK = ("slabs", "alone")


@cache
def load_factor(structure, strength, procedure):
    blocks, friction, direction, height = STRUCTURES[structure]
    stress = None if strength is None else Q_(strength * 20 * height / 2, "kPa")
    model = model_of(blocks(), bs.JointMaterial("soft", friction, compressive_strength=stress))
    result = solve(model, push(*direction), "nonassociative", **PROCEDURES[procedure])
    assert result.status == "converged"
    return float(result.load_factor)


def marks(structure, procedure):
    quick = structure in QUICK and procedure in ("loading path", "fictitious")
    return () if quick else pytest.mark.slow


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize(
    ("structure", "procedure"), [pytest.param(s, p, marks=marks(s, p)) for s in STRUCTURES for p in PROCEDURES]
)
def test_a_strength_never_raises_a_load_factor(structure, procedure):
    without = load_factor(structure, None, procedure)
    found = np.array([load_factor(structure, strength, procedure) for strength in STRENGTHS])
    assert (found <= ALIKE * without).all()
    # It grows with the strength, up to what it is without.
    assert (found[:-1] <= ALIKE * found[1:]).all()
    assert found[-1] == pytest.approx(without, rel=ALIKE - 1)


def test_a_path_that_goes_on_stays_where_it_is():
    """Over 1,000 elastic displacements, of steps solved exactly.

    Each step with the normal flow of its own settles strips of different depth away from each other: at this strength
    the load factor then leaves its plateau, and rises by 9 %.
    """
    from blockstruct.limit import ConicProgram, LimitProblem
    from blockstruct.procedures.interior_point_path import InteriorPointPath
    from blockstruct.procedures.procedure import of_steps
    from blockstruct.statics import Statics

    blocks, friction, direction, height = STRUCTURES["butted"]
    joint = bs.JointMaterial("soft", friction, compressive_strength=Q_(1000 * 20 * height / 2, "kPa"))
    case = bs.LimitCase("case", bs.LoadPattern("dead", [bs.SelfWeight()]), push(*direction), "nonassociative")
    problem, settings = LimitProblem.of(Statics.of(model_of(blocks(), joint)), case), settings_of(path_growth=3.0)
    path = InteriorPointPath(of_steps(ConicProgram(problem, settings), settings), settings)
    assert path.dead_load is not None
    found = []
    while not found or found[-1].displacement < 300:
        found.append(path.advance(np.inf))
    load_factors = [step.load_factor for step in found[2:]]
    assert max(load_factors) < 1.005 * min(load_factors)


def test_associative_load_factors_do_not_rise():
    blocks, friction, direction, height = STRUCTURES["slabs"]
    found = []
    for strength in (*STRENGTHS, None):
        stress = None if strength is None else Q_(strength * 20 * height / 2, "kPa")
        model = model_of(blocks(), bs.JointMaterial("soft", friction, compressive_strength=stress))
        found.append(solve(model, push(*direction)).load_factor)
    assert np.diff(found).min() > -1e-6


@pytest.mark.parametrize("procedure", PROCEDURES)
@pytest.mark.parametrize("angle", [10, 30, 45])
def test_a_block_crushes_towards_its_corner_along_every_procedure(angle, procedure):
    """Pushed by α W along (cos, sin): ``e = α h / 2`` of it each way, and ``W = f_c (b − 2 e_1)(b − 2 e_2)``.

    The load factor is the smaller root of ``(b − α h cos)(b − α h sin) = b² / 5``.
    """
    b, h, share = 0.6, 1.5, 0.2
    blocks = [box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True), box("block", [0, 0, 0], [b, b, h])]
    joint = bs.JointMaterial("soft", 0.9, compressive_strength=Q_(20 * h / share, "kPa"))
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    exact = min(np.roots([h * h * c * s, -b * h * (c + s), b * b * (1 - share)]))
    result = solve(model_of(blocks, joint), push(c, s, 0), "nonassociative", **PROCEDURES[procedure])
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(exact, rel=1e-5)
