"""Steps of bodies against steps of all blocks."""

import numpy as np
import pytest
import scipy.sparse as sp

import blockstruct as bs
from blockstruct.analysis import StepDone
from blockstruct.limit import LimitProblem, MovingProblem, Placement, ProcedureSettings
from blockstruct.limit.bodies import Bodies, bodies_of
from blockstruct.procedures.body_step import Carried, solve_as_bodies
from blockstruct.procedures.carried_forces import carried_forces
from blockstruct.procedures.finite_step import CountingSolver, Question, solve_finite_step
from blockstruct.solvers import ClarabelSolver
from blockstruct.solvers.interior_point import ContactProblem
from blockstruct.statics import Statics
from structures import SELF_WEIGHT, model_of, push, slipping_units

SETTINGS = ProcedureSettings()


class Wall:
    """A wall of eight courses, 2 m by 1.6 m and 0.2 m thick, pushed across: it turns about its foot as one."""

    def __init__(self, friction):
        stone = bs.Material("stone", "20 kN/m^3")
        rows = [[1] * 5 if j % 2 == 0 else [0.5, 1, 1, 1, 1, 0.5] for j in range(8)]
        blocks = bs.courses(rows, unit_length="0.4 m", unit_height="0.2 m", depth="0.2 m", material=stone)
        self.model = model_of(blocks, bs.JointMaterial("dry", friction))
        direction = (0, 1, 0)
        case = bs.Pushover("push", SELF_WEIGHT, push(*direction), control=(blocks[-1].name, direction))
        statics = Statics.of(self.model)
        self.moving = MovingProblem(statics, LimitProblem.of(statics, case), case)
        self.placement = Placement.of(self.model)
        self.twist = np.zeros((len(blocks), 6))

    def at(self, placement):
        return self.moving.at(placement, 0.02, self.moving.lengths(placement))

    def question(self, moved, work=10.0):
        return Question.of(moved, work, self.twist, 0.01, rocks=False)


def solver():
    return CountingSolver(ClarabelSolver())


def whole(question, by=None):
    return solve_finite_step(question, SETTINGS, by or solver())


def of_bodies(moved, question, carried):
    return solve_as_bodies(moved, carried.recalled(moved, question), carried.body, SETTINGS, solver())


def test_the_same_state():
    """A step further on, bodies and all blocks have one load factor, ``tan(atan(t / h) − θ)``, and one motion."""
    wall = Wall(0.65)
    moved = wall.at(wall.placement)
    first = whole(wall.question(moved))
    carried = Carried.of(moved, first.x, first.u)
    assert len(np.unique(carried.body)) == 2
    twist = moved.twist(first.u)
    angle = 0.02
    after = wall.at(wall.placement.moved(twist * angle / np.abs(twist[-1, 3])))
    question = wall.question(after)
    found, all_blocks = of_bodies(after, question, carried), whole(question)
    assert found.holds
    assert found.load_factor == pytest.approx(np.tan(np.arctan(0.2 / 1.6) - angle), abs=1e-5)
    assert found.load_factor == pytest.approx(all_blocks.load_factor, abs=1e-5)
    assert found.u == pytest.approx(all_blocks.u, abs=1e-3 * np.abs(all_blocks.u).max())
    # The certificate is that of all blocks, and what was solved hardly has any.
    assert found.x.shape == all_blocks.x.shape
    bodies = Bodies.of(after, carried.body)
    assert bodies.problem.A.shape[0] == 6
    assert bodies.problem.n_points < after.problem.n_points / 8


def test_bodies_that_would_come_apart():
    """With little friction courses slide: what holds the wall together as one body is not carried, and is found out."""
    wall = Wall(0.1)
    moved = wall.at(wall.placement)
    question = wall.question(moved)
    slides = whole(question)
    assert slides.load_factor == pytest.approx(0.1, abs=1e-4)
    as_one = Carried.of(moved, slides.x, slides.u)
    free = np.arange(len(wall.model.blocks)) == np.arange(len(wall.model.blocks))
    free[[i for i, b in enumerate(wall.model.blocks) if b.fixed]] = False
    glued = Carried(free.astype(int), as_one.place, as_one.force)
    assert of_bodies(moved, question, glued) is None


def test_a_motion_that_goes_on(monkeypatch):
    """Where sliding and shift of the first program agree, and nothing rubs, it is the step, and no loop is begun."""
    wall = Wall(0.65)
    moved = wall.at(wall.placement)
    twist = moved.twist(whole(wall.question(moved)).u)
    monkeypatch.setattr("blockstruct.procedures.finite_step.ContactProblem", None)
    counting = solver()
    after = whole(Question.of(moved, 10.0, twist, 0.01, rocks=False), counting)
    assert counting.programs == 1
    assert after.holds


def test_what_leads_nowhere_is_counted(monkeypatch):
    """A curve tells of all programs and iterations between its states, also of bodies that come apart."""
    solved, iterations, at_step = [], [], []

    def counted(method):
        def solve(*args, **options):
            found = method(*args, **options)
            iterations.append(found.iterations)
            return found

        return solve

    def program(*args):
        solved.append(1)
        return one(*args)

    def listen(event):
        if isinstance(event, StepDone):
            at_step.append((len(solved), sum(iterations)))

    one = counted(ClarabelSolver.solve)
    monkeypatch.setattr(ClarabelSolver, "solve", program)
    monkeypatch.setattr(ContactProblem, "solve", counted(ContactProblem.solve))
    model = slipping_units()
    control = (model.blocks[-1].name, (1, 0, 0))
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=control, steps=8)
    curve = bs.AnalysisManager(model, listeners=[listen]).run([case])["push"].capacity
    assert int(curve["body_failures"].max()) > 1
    told = np.column_stack([curve["programs"], curve["solver_iterations"]])
    assert told[1:].tolist() == np.diff(at_step, axis=0).tolist()


def test_nothing_to_gain():
    """Blocks that each go their own way, and a structure at rest, are left to the step of all blocks."""
    wall = Wall(0.65)
    moved = wall.at(wall.placement)
    question = wall.question(moved)
    rocks = whole(question)
    carried = Carried.of(moved, rocks.x, rocks.u)
    for body in (np.arange(len(carried.body)), np.zeros(len(carried.body), dtype=int)):
        assert of_bodies(moved, question, Carried(body, carried.place, carried.force)) is None


def test_blocks_that_part_at_a_hinge():
    """One that turns about a patch of half a millimetre is slow there, and yet another body than what it touches."""
    stone = bs.Material("stone", unit_weight="20 kN/m^3")
    still = bs.Block.box("still", "[1, 0, -0.9995] m", "[1, 1, 1] m", stone, fixed=True)
    turns = bs.Block.box("turns", "[0, 0, 0] m", "[1, 1, 1] m", stone)
    model = model_of([still, turns], bs.JointMaterial("dry", 0.65))
    case = bs.Pushover("push", SELF_WEIGHT, push(-1, 0, 0), control=("turns", (-1, 0, 0)))
    statics = Statics.of(model)
    moving = MovingProblem(statics, LimitProblem.of(statics, case), case)
    placement = Placement.of(model)
    moved = moving.at(placement, 0.02, moving.lengths(placement))
    rocks = np.zeros((2, 6))
    # About the axis y through the corner at (1, 0).
    rocks[1] = [-0.5, 0, -0.5, 0, -1, 0]
    assert len(moved.contacts.gap) == 4
    assert bodies_of(moved, moved.velocities(rocks)).tolist() == [0, 1]
    assert bodies_of(moved, moved.velocities(0 * rocks)).tolist() == [0, 0]


@pytest.mark.parametrize(("share", "found"), [(0.5, True), (2.0, False)])
def test_carried_forces(share, found):
    """A weight on one contact point, pushed by a share of what friction holds."""
    A = sp.csc_array(np.eye(6)[:, :3])
    wanted = np.array([1.0, 0.6 * share, 0, 0, 0, 0])
    x = carried_forces(A, np.array([0.6]), np.array([[0.9, 0.0, 0.0]]), wanted)
    if found:
        assert A @ x.ravel() == pytest.approx(wanted, abs=1e-6)
    else:
        assert x is None
