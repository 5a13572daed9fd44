"""A compressive strength never raises a load factor.

The rectangular stress block is inside the conditions of joints that do not crush, so that associative load factors
cannot rise. Without dilatancy the flow of a joint decides as well.
"""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.results.verification import confirm
from structures import SELF_WEIGHT, STONE, box, model_of, push, settings_of, solve


def slabs(courses, strength=None):
    """A wall of whole slabs with another butted against its end; strength in multiples of the mean stress."""
    wall = [box(f"wall {k}", [0, 0, 0.2 * k], [1.2, 0.25, 0.2]) for k in range(courses)]
    side = [box(f"side {k}", [0, 0.25, 0.2 * k], [0.25, 0.8, 0.2]) for k in range(courses)]
    fc = {} if strength is None else {"compressive_strength": Q_(strength * 20 * 0.2 * courses / 2, "kPa")}
    blocks = [box("ground", [-1, -1, -0.5], [4, 4, 0.5], fixed=True), *wall, *side]
    return model_of(blocks, bs.JointMaterial("joint", 0.6, **fc))


@pytest.mark.parametrize("procedure", ["loading path", "fictitious"])
def test_a_load_factor_that_crushing_raises_is_that_without(procedure, tmp_path):
    without = solve(slabs(4), push(1, -0.6, 0), "nonassociative", procedure=procedure)
    manager = bs.AnalysisManager(slabs(4, 50), tmp_path / "run.h5", settings=settings_of(procedure=procedure))
    case = bs.LimitCase("case", SELF_WEIGHT, push(1, -0.6, 0), "nonassociative")
    with pytest.warns(bs.errors.LoadFactorWarning):
        analysis = manager.run([case])
    result = analysis["case"]
    assert result.load_factor == result.outcome.without_crushing == pytest.approx(without.load_factor, rel=1e-9)
    assert float(result.history["load_factor"][-1]) == result.load_factor
    assert result.outcome.drift[1] > 1.005 * result.load_factor
    assert not result.settled
    confirm(analysis)
    stored = bs.open_analysis(tmp_path / "run.h5")["case"]
    assert stored.outcome.without_crushing == result.outcome.without_crushing
    assert str(stored) == str(result)


def bonded(strength=None):
    """A wall with a return bonded to it, six courses; strength in multiples of the mean stress."""
    size = {"length": "1.6 m", "courses": 6, "unit_length": "0.4 m", "unit_height": "0.2 m", "thickness": "0.25 m"}
    blocks = bs.wall(**size, material=STONE, sidewalls=[bs.structures.Sidewall("side", "0 m", "0.8 m", bonded=True)])
    fc = {} if strength is None else {"compressive_strength": Q_(strength * 20 * 1.2 / 2, "kPa")}
    return model_of(blocks, bs.JointMaterial("joint", 0.6, **fc))


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize("strength", [20, 300, pytest.param(1e6, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"path_steps": "interior point"},
        {"crushing_interaction": "uniaxial"},
        {"procedure": "fictitious"},
        {"procedure": "fictitious", "crushing": "linearised"},
    ],
    ids=str,
)
@pytest.mark.parametrize(
    ("structure", "direction"),
    [(lambda s: slabs(6, s), (1, -0.6, 0)), pytest.param(bonded, (1, -1, 0), marks=pytest.mark.slow)],
    ids=["butted", "bonded"],
)
def test_no_strength_raises_a_load_factor(structure, direction, settings, strength):
    without = {name: value for name, value in settings.items() if not name.startswith("crushing")}
    limit, found = (
        solve(structure(s), push(*direction), "nonassociative", **of).load_factor
        for s, of in ((None, without), (strength, settings))
    )
    assert 0.8 * limit < found <= 1.01 * limit


@pytest.mark.parametrize(
    "settings", [{}, {"path_steps": "interior point"}, {"procedure": "fictitious"}, {"procedure": "shifted"}], ids=str
)
@pytest.mark.parametrize("strength", [20, 100, 1e4])
def test_a_straight_wall_rocks_out_of_its_plane_about_its_stress_block(strength, settings):
    """Slabs of the depth t, pushed across: ``α = (t / h)(1 − γ h / f_c)`` about the lowest joint."""
    t, h = 0.25, 1.2
    blocks = [box("ground", [-1, -1, -0.5], [4, 3, 0.5], fixed=True)]
    blocks += [box(f"slab {k}", [0, 0, 0.2 * k], [2.0, t, 0.2]) for k in range(6)]
    joint = bs.JointMaterial("joint", 0.6, compressive_strength=Q_(strength * 20 * h / 2, "kPa"))
    result = solve(model_of(blocks, joint), push(0, 1, 0), "nonassociative", **settings)
    assert (result.status, result.settled) == ("converged", True)
    assert result.load_factor == pytest.approx(t / h * (1 - 2 / strength), rel=1e-5)
    assert np.isnan(result.outcome.without_crushing)
