"""One step of a block: it falls by g h² until it rests, and its inertia is that of its shape."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import blockstruct as bs
from blockstruct.limit import LimitProblem
from blockstruct.limit.certificate import certify
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.motion.moving_problem import MovingProblem
from blockstruct.solvers.step import StepProblem, solve_step
from blockstruct.statics.moved import Placement
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, bonded, model_of, push, single_block


def test_second_moments_of_a_box():
    _, block = single_block(0.3, 1.5, t=0.7)[0]
    expected = block.volume / 12 * np.diag([0.3**2, 0.7**2, 1.5**2])
    assert block.shape.second_moments == pytest.approx(expected, abs=1e-12)


def at(model, direction, height=0.0):
    """What moves, and the model whose last block is at a height above its place."""
    case = bs.Pushover("push", SELF_WEIGHT, push(*direction), control=(model.blocks[-1].name, direction))
    statics = Statics.of(model)
    moving, rest = MovingProblem(statics, LimitProblem.of(statics, case), case), Placement.of(model)
    position = rest.position.copy()
    position[-1, 2] += height
    placement = Placement(position, rest.rotation)
    lengths = moving.lengths(placement)
    return moving, moving.at(placement, 0.1, lengths, lengths)


def step_of(moving, there, inertia, **more):
    """A step from no forces, of so many times the inertia."""
    problem = there.problem
    return StepProblem(
        problem=problem,
        gap=there.contacts.gap * problem.force_unit,
        slack=np.zeros(0),
        inertia=sp.csr_array(moving.inertia * inertia),
        force=np.zeros((problem.n_points, 3)),
        compliance=moving.compliance,
        displacement=None,
        **more,
    )


@pytest.mark.parametrize(("height", "falls"), [(1.0, 0.02), (0.05, 0.02), (0.01, 0.01)])
def test_a_block_falls_until_it_rests(height, falls):
    """In a time h with g h² = 20 mm: by 20 mm, or by 10 mm onto the ground, whose reaction is half of the weight."""
    moving, there = at(model_of(*single_block(0.3, 1.5)), (1, 0, 0), height)
    problem = there.problem
    step = step_of(moving, there, STANDARD_GRAVITY / 0.02)
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
    moving, there = at(model_of(bonded(2, 3, "0.3 m"), bs.JointMaterial("dry", 0.6)), direction)
    problem = there.problem
    assert there.mirror.half.n_points < 0.6 * problem.n_points
    step = step_of(moving, there, 0.1, load_factor=0.1)
    still = np.zeros(problem.A.shape[0])
    whole, half = (solve_step(replace(step, mirror=mirror), still) for mirror in (None, there.mirror))
    assert half.x == pytest.approx(whole.x, abs=1e-6)
    assert half.u == pytest.approx(whole.u, abs=1e-6 * np.abs(whole.u).max())
