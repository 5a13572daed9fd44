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
from blockstruct.results.verification import confirm
from structures import SELF_WEIGHT, STONE, box, model_of, push, settings_of, solve

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
    wall = [box(f"wall {k}", [0, 0, 0.2 * k], [1.2, 0.25, 0.2]) for k in range(courses)]
    side = [box(f"side {k}", [0, 0.25, 0.2 * k], [0.25, 0.8, 0.2]) for k in range(courses)]
    return [box("ground", [-1, -1, -0.5], [4, 4, 0.5], fixed=True), *wall, *side]


def bricks(courses, *sides, length="1.6 m"):
    size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "depth": "0.25 m"}
    walls = [bs.Sidewall(f"side {k}", at, reach, bonded=bonded) for k, (at, reach, bonded) in enumerate(sides)]
    return bs.wall(length=length, courses=courses, material=STONE, sidewalls=walls, **size)


#: Blocks, friction, direction of the push, and the height of the wall in metres.
STRUCTURES = {
    "slabs": (lambda: slabs(4), 0.6, (1, -0.6, 0), 0.8),
    "tall slabs": (lambda: slabs(6), 0.6, (1, -0.6, 0), 1.2),
    "butted": (lambda: bricks(5, ("0 m", "0.8 m", False)), 0.6, (1, -0.6, 0), 1.0),
    "bonded": (lambda: bricks(6, ("0 m", "0.8 m", True)), 0.6, (1, -1, 0), 1.2),
    "alone": (lambda: bricks(6), 0.6, (1, -0.4, 0), 1.2),
}
QUICK = ("slabs", "alone")


def model(structure, strength=None):
    blocks, friction, _, height = STRUCTURES[structure]
    fc = {} if strength is None else {"compressive_strength": Q_(strength * 20 * height / 2, "kPa")}
    return model_of(blocks(), bs.JointMaterial("joint", friction, **fc))


@cache
def found(structure, strength, procedure):
    variable = push(*STRUCTURES[structure][2])
    return solve(model(structure, strength), variable, "nonassociative", **PROCEDURES[procedure])


def marks(structure, procedure):
    quick = structure in QUICK and procedure in ("loading path", "fictitious")
    return () if quick else pytest.mark.slow


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize(
    ("structure", "procedure"),
    [pytest.param(s, p, marks=marks(s, p)) for s in STRUCTURES for p in PROCEDURES if s != "bonded"],
)
def test_load_factors_grow_with_the_strength_to_what_they_are_without(structure, procedure):
    results = [found(structure, strength, procedure) for strength in (*STRENGTHS, None)]
    alpha = np.array([result.load_factor for result in results])
    assert (alpha[:-1] <= ALIKE * alpha[1:]).all()
    assert alpha[-2] == pytest.approx(alpha[-1], rel=ALIKE - 1)
    assert all(np.isnan(result.outcome.without_crushing) for result in results)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize("strength", [20, 1e3])
def test_a_bonded_return_pushed_along_its_diagonal(strength):
    """Its joints bend about both axes alike, and each share of their lengths decides the other."""
    without, result = (found("bonded", s, "loading path") for s in (None, strength))
    assert result.status == "converged"
    assert result.settled
    assert result.load_factor <= ALIKE * without.load_factor


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize("strength", [20, 1e3])
def test_the_iteration_of_the_paper_does_not_rise_where_it_finds_another_state(strength):
    """Without crushing it ends at 0.24 and the loading path at 0.28: crushing leads it to the higher one."""
    without, result = (found("bonded", s, "fictitious") for s in (None, strength))
    assert result.load_factor <= ALIKE * without.load_factor


@pytest.mark.parametrize("settings", [{}, {"path_steps": "interior point"}, {"procedure": "fictitious"}], ids=str)
@pytest.mark.parametrize("strength", [20, 100, 1e4])
def test_a_straight_wall_rocks_out_of_its_plane_about_its_stress_block(strength, settings):
    """Slabs of the depth t, pushed across: ``α = (t / h)(1 − γ h / f_c)``, about the lowest joint."""
    t, h = 0.25, 1.2
    blocks = [box("ground", [-1, -1, -0.5], [4, 3, 0.5], fixed=True)]
    blocks += [box(f"slab {k}", [0, 0, 0.2 * k], [2.0, t, 0.2]) for k in range(6)]
    joint = bs.JointMaterial("joint", 0.6, compressive_strength=Q_(strength * 20 * h / 2, "kPa"))
    result = solve(model_of(blocks, joint), push(0, 1, 0), "nonassociative", **settings)
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(t / h * (1 - 2 / strength), rel=1e-4)


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
    assert result.load_factor == pytest.approx(exact, rel=1e-4)


def test_associative_load_factors_do_not_rise():
    alpha = [solve(model("slabs", s), push(*STRUCTURES["slabs"][2])).load_factor for s in (*STRENGTHS, None)]
    assert np.diff(alpha).min() > -1e-6


def test_a_load_factor_that_crushing_raises_is_that_without(tmp_path):
    without = found("bonded", None, "fictitious")
    manager = bs.AnalysisManager(
        model("bonded", 1e3), tmp_path / "run.h5", settings=settings_of(procedure="fictitious")
    )
    case = bs.LimitCase("case", SELF_WEIGHT, push(1, -1, 0), "nonassociative")
    with pytest.warns(bs.errors.LoadFactorWarning):
        analysis = manager.run([case])
    result = analysis["case"]
    assert result.load_factor == result.outcome.without_crushing == pytest.approx(without.load_factor, rel=1e-9)
    assert float(result.history["load_factor"][-1]) > 1.005 * result.load_factor
    assert not result.settled
    confirm(analysis)
    stored = bs.open_analysis(tmp_path / "run.h5")["case"]
    assert stored.outcome.without_crushing == result.outcome.without_crushing
    assert str(stored) == str(result)
