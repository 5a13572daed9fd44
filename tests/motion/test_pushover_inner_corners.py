"""Pushovers of blocks with inner corners, which touch another block at one point in two directions."""

from dataclasses import replace

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.limit import LimitProblem
from blockstruct.motion.course import forces_at, loaded
from blockstruct.motion.moving_problem import MovingProblem
from blockstruct.motion.state import MotionState
from blockstruct.statics.moved import Placement
from blockstruct.statics.statics import Statics
from blockstruct.structures.builder import prism
from structures import SELF_WEIGHT, STONE, box, model_of, moved, push, rotation

#: The procedure whose collapse state these curves begin with.
FICTITIOUS = bs.ProcedureSettings(procedure="fictitious")


def notched(friction):
    """A block of 1 m by 1.5 m on two supports, whose step it embraces: 0.2 m high, in the middle."""
    outline = [[0, 0], [0.5, 0], [0.5, 0.2], [1, 0.2], [1, 1.5], [0, 1.5]]
    supports = [
        box("low", [-1, 0, -0.5], [1.5, 1, 0.5], fixed=True),
        box("high", [0.5, 0, -0.5], [3, 1, 0.7], fixed=True),
    ]
    return model_of([*supports, prism("block", outline, (0, 1), STONE)], bs.JointMaterial("dry", friction))


def angular(friction):
    """Three blocks on the ground, one on the other, L-shaped in plan, with faces of two parts and more."""
    outline = [[0, 0], [1, 0], [1, 0.3], [0.3, 0.3], [0.3, 1], [0, 1]]
    courses = [prism(f"course {i}", outline, (i / 2, i / 2 + 0.5), STONE) for i in range(3)]
    ground = box("ground", [-1, -2, -0.5], [3, 3, 0.5], fixed=True)
    lying = moved(courses, rotation((1, 0, 0), np.pi / 2))
    return model_of([ground, *lying], bs.JointMaterial("dry", friction))


def case_of(model, direction, **more):
    block = model.blocks[-1].name
    return bs.Pushover("push", SELF_WEIGHT, push(*direction), control=(block, direction), steps=20, **more)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0)])
@pytest.mark.parametrize("friction", [0.5, 0.65])
def test_a_notched_block(friction, direction):
    """The curve begins at the load factor of the loading path and continues from there.

    At the top of the riser the tread has a contact point as well. Each must remember only its own force.
    """
    model = notched(friction)
    result = bs.run(model, case_of(model, direction))["push"]
    curve = result.capacity["load_factor"].to_numpy()
    assert curve[0] == pytest.approx(result.load_factor, rel=2e-4)
    assert curve[1] == pytest.approx(curve[0], rel=0.04)


@pytest.mark.parametrize("friction", [0.4, 0.8])
def test_faces_in_parts(friction):
    model = angular(friction)
    result = bs.run(model, case_of(model, (1, 0, 0)), settings=FICTITIOUS)["push"]
    assert float(result.capacity["load_factor"][0]) == pytest.approx(result.load_factor, rel=1e-4)
    assert bool(result.capacity["holds"][:6].all())


@pytest.mark.parametrize("model", [notched(0.5), angular(0.5)])
def test_no_force_is_remembered_twice(model):
    """Contact points at one place share what was there: remembered forces act on blocks as they did."""
    case = case_of(model, (1, 0, 0))
    statics = Statics.of(model)
    problem = LimitProblem.of(statics, case)
    moving, rest = MovingProblem(statics, problem, case), Placement.of(model)
    lengths = moving.lengths(rest)
    there = moving.at(rest, 0.02, lengths, lengths)
    x = np.random.default_rng(7).normal(size=(problem.n_points, 3))
    nothing = np.zeros_like(rest.position)
    at_rest = replace(there.contacts, points=statics.points, cell=np.full(problem.n_points, -1))
    state = MotionState(
        load_factor=0.0,
        position=rest.position,
        rotation=rest.vectors,
        velocity=nothing,
        angular_velocity=nothing,
        motion_time=1.0,
        inertia_time=np.inf,
        falls=False,
        reach=0.02,
        tie_force=np.zeros(0),
        solver_iterations=0,
        solver_time=0.0,
        **loaded(at_rest, x * problem.force_unit[:, None]),
        crushed_depth=np.zeros(0),
        crushed_slope=np.zeros((0, 3)),
        crushed_share=np.zeros(0),
    )
    assert there.problem.A @ forces_at(there, state).ravel() == pytest.approx(problem.A @ x.ravel(), abs=1e-9)
