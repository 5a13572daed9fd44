"""One step of a block: it falls by g h² until it rests, and its inertia is that of its shape."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import blockstruct as bs
from blockstruct.limit import LimitProblem
from blockstruct.limit.certificate import certify
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.motion import MovingProblem
from blockstruct.solvers.step import StepProblem, solve_step
from blockstruct.statics import Placement, Statics
from structures import SELF_WEIGHT, model_of, push, single_block


def test_second_moments_of_a_box():
    _, block = single_block(0.3, 1.5, t=0.7)[0]
    expected = block.volume / 12 * np.diag([0.3**2, 0.7**2, 1.5**2])
    assert block.shape.second_moments == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("height", "falls"), [(1.0, 0.02), (0.05, 0.02), (0.01, 0.01)])
def test_a_block_falls_until_it_rests(height, falls):
    """In a time h with g h² = 20 mm: by 20 mm, or by 10 mm onto the ground, whose reaction is half of the weight.

    A metre above the ground there are no contacts at all.
    """
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
    inertia = moving.inertia @ found.u / (0.02 / STANDARD_GRAVITY)
    balanced = replace(problem, w_D=problem.w_D - inertia)
    assert certify(balanced, found.x, found.u, 0.0, bs.ProcedureSettings()).equilibrium_residual < 1e-3
    assert (there.mirror is None) == (height == 1.0)


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0)])
def test_half_of_a_wall_gives_the_step_of_the_whole(direction):
    """A wall in its plane has its middle plane as mirror, a wall pushed across the plane at half of its length."""
    stone = bs.Material("stone", "20 kN/m^3")
    blocks = bs.courses(
        [[1, 1], [0.5, 1, 0.5], [1, 1]], unit_length="0.4 m", unit_height="0.2 m", thickness="0.3 m", material=stone
    )
    model = model_of(blocks, bs.JointMaterial("dry", 0.6))
    case = bs.Pushover("push", SELF_WEIGHT, push(*direction), control=(blocks[-1].name, direction))
    statics = Statics.of(model)
    moving, rest = MovingProblem(statics, LimitProblem.of(statics, case), case), Placement.of(model)
    lengths = moving.lengths(rest)
    there = moving.at(rest, 0.1, lengths, lengths)
    problem = there.problem
    assert there.mirror.half.n_points < 0.6 * problem.n_points
    step = StepProblem(
        problem=problem,
        gap=there.contacts.gap * problem.force_unit,
        slack=np.zeros(0),
        inertia=sp.csr_array(moving.inertia / 10),
        force=np.zeros((problem.n_points, 3)),
        compliance=moving.compliance,
        displacement=None,
        load_factor=0.1,
    )
    still = np.zeros(problem.A.shape[0])
    whole, half = (solve_step(replace(step, mirror=mirror), still) for mirror in (None, there.mirror))
    assert half.x == pytest.approx(whole.x, abs=1e-6)
    assert half.u == pytest.approx(whole.u, abs=1e-6 * np.abs(whole.u).max())
