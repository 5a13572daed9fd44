"""A compressive strength never raises a load factor.

The rectangular stress block is inside the conditions of joints that do not crush, so that associative load factors
cannot rise. Without dilatancy the flow of a joint decides as well.
"""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.results.verification import confirm
from structures import SELF_WEIGHT, box, model_of, push, settings_of, solve


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
    assert float(result.history["load_factor"][-1]) > 1.005 * result.load_factor
    assert not result.settled
    confirm(analysis)
    stored = bs.open_analysis(tmp_path / "run.h5")["case"]
    assert stored.outcome.without_crushing == result.outcome.without_crushing
    assert str(stored) == str(result)


@pytest.mark.parametrize("flow", list(bs.Flow))
def test_a_load_factor_that_crushing_lowers_is_its_own(flow):
    model = model_of(
        [box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True), box("block", [0, 0, 0], [0.5, 0.5, 1.5])],
        bs.JointMaterial("joint", 0.9, compressive_strength="300 kPa"),
    )
    result = solve(model, push(1, 0, 0), flow)
    assert result.load_factor == pytest.approx(0.9 / 3, rel=1e-6)
    assert np.isnan(result.outcome.without_crushing)
    assert result.settled
