"""The interior-point loop with rigid contacts and associative sliding: one step is the associative program."""

from dataclasses import replace

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.limit import ConicProgram, LimitProblem, true_sliding
from blockstruct.limit.certificate import certify
from blockstruct.solvers import ClarabelSolver
from blockstruct.solvers.interior_point import ContactProblem, Step
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, bonded, model_of, push, single_block

#: Of the load factor, relative: the loop stops at a gap of a millionth of the work.
EXACT = 1e-6


def program_of(model, direction):
    case = bs.LimitCase("push", SELF_WEIGHT, push(*direction), "associative")
    return ConicProgram(LimitProblem.of(Statics.of(model), case), bs.ProcedureSettings(crushing="conic"))


def one_rigid_step(program):
    """Load factor and certificate of one step from nothing; displacements of order one, as in the program."""
    problem, settings = program.problem, bs.ProcedureSettings()
    contact = ContactProblem(program, np.zeros((problem.n_points, 3)))
    nothing = np.zeros(contact.conditions.size)
    step = Step(reference=nothing, opening=nothing, displacement=program.total)
    found = contact.solve(step, contact.start(), centre=False, tolerance=EXACT)
    state = found.state
    x, T = state.x[: 3 * problem.n_points].reshape(-1, 3), state.x[contact.ties] + problem.ties.prestress(state.alpha)
    return state.alpha, certify(problem, x, state.u / program.total, state.alpha, settings, T)


@pytest.mark.parametrize(("mu", "expected"), [(0.8, 0.4), (0.3, 0.3)], ids=["overturns", "slides"])
def test_single_block(mu, expected):
    alpha, certificate = one_rigid_step(program_of(model_of(*single_block(0.4, 1.0, mu=mu)), (1, 0, 0)))
    assert alpha == pytest.approx(expected, rel=EXACT)
    assert certificate.holds


@pytest.mark.parametrize(
    ("measure", "value", "admissible"),
    [("flow_rule_gap", 1.0, True), ("equilibrium_residual", 1.0, False), ("yield_excess", np.nan, False)],
)
def test_forces_are_admissible_whatever_the_mechanism(measure, value, admissible):
    _, certificate = one_rigid_step(program_of(model_of(*single_block(0.4, 1.0, mu=0.8)), (1, 0, 0)))
    assert certificate.admissible
    assert replace(certificate, **{measure: value}, holds=False).admissible is admissible


def wall(strength):
    return model_of(bonded(3, 4), bs.JointMaterial("joint", 0.65, compressive_strength=strength))


def tied_wall():
    model = wall(None)
    third = [b for b in model.blocks if not b.fixed and abs(b.centroid[2] - 0.5) < 1e-6]
    first, *_, last = sorted(third, key=lambda b: b.centroid[0])
    ends = ((b.name, Q_(b.centroid, "m")) for b in (first, last))
    return model.with_ties([bs.Tie("tie", *ends, yield_force="0.2 kN")])


@pytest.mark.parametrize(
    "model", [lambda: wall(None), lambda: wall(Q_(200, "kPa")), tied_wall], ids=["friction", "crushing", "tie"]
)
@pytest.mark.parametrize("direction", [(1, 0, 0), (0.3, 1, 0)], ids=["in plane", "out of plane"])
def test_walls_have_the_load_factor_of_the_conic_program(model, direction):
    program = program_of(model(), direction)
    exact = ClarabelSolver().solve(program, program.data(true_sliding(program.problem)), 1e-10)
    expected, _, _ = program.unpack(exact)
    alpha, certificate = one_rigid_step(program)
    assert alpha == pytest.approx(expected, rel=EXACT)
    assert certificate.holds
