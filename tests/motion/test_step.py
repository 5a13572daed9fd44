"""One step of a block: it falls by g h² until it rests, and its inertia is that of its shape."""

import numpy as np
import pytest
import scipy.sparse as sp

import blockstruct as bs
from blockstruct.limit import LimitProblem
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.motion import MovingProblem
from blockstruct.solvers.step import StepProblem, solve_step
from blockstruct.statics import Placement, Statics
from structures import SELF_WEIGHT, model_of, push, single_block


def test_second_moments_of_a_box():
    _, block = single_block(0.3, 1.5, t=0.7)[0]
    expected = block.volume / 12 * np.diag([0.3**2, 0.7**2, 1.5**2])
    assert block.shape.second_moments == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("height", "falls"), [(0.05, 0.02), (0.01, 0.01)])
def test_a_block_falls_until_it_rests(height, falls):
    """In a time h with g h² = 20 mm: by 20 mm, or by 10 mm onto the ground, whose reaction is half of the weight."""
    blocks, joint = single_block(0.3, 1.5)
    model = model_of(blocks, joint)
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)))
    statics = Statics.of(model)
    moving, rest = MovingProblem(statics, LimitProblem.of(statics, case), case), Placement.of(model)
    above = Placement(rest.position + np.array([[0, 0, 0], [0, 0, height]]), rest.rotation)
    lengths = moving.lengths(above)
    there = moving.at(above, 0.1, lengths, lengths)
    problem = there.problem
    step = StepProblem(
        problem=problem,
        gap=there.contacts.gap * problem.force_unit,
        slack=np.zeros(0),
        inertia=sp.csr_array(moving.inertia / (0.02 / STANDARD_GRAVITY)),
        force=np.zeros((problem.n_points, 3)),
        compliance=moving.compliance,
        displacement=None,
    )
    found = solve_step(step, np.zeros(problem.A.shape[0]))
    assert there.twist(found.u)[1, 2] == pytest.approx(-falls, rel=1e-3)
    assert found.x[:, 0].sum() == pytest.approx(1 - falls / 0.02, abs=1e-3)
