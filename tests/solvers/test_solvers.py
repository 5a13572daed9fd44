"""Solvers: their answers, tolerances and limits, the associative step, and the acceleration of an iteration."""

from dataclasses import replace

import cvxpy
import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.limit import ConicProgram, LimitProblem, true_sliding
from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import fictitious_sliding
from blockstruct.limit.program import Objective
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.solvers import ClarabelSolver, RememberingSolver
from blockstruct.solvers.anderson import Anderson
from blockstruct.solvers.cvxpy import CvxpySolver
from blockstruct.solvers.interior_point import ContactProblem, Step
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, bonded, model_of, push, single_block, solve


@pytest.fixture(scope="module")
def problem(small_model):
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0.3, 0), "nonassociative")
    return LimitProblem.of(Statics.of(small_model), case)


@pytest.fixture(scope="module")
def n0(problem):
    program = ConicProgram(problem, ProcedureSettings())
    solution = ClarabelSolver().solve(program, program.data(true_sliding(problem)), 1e-10)
    return program.unpack(solution)[1][:, 0]


def programs(problem, n0):
    """Data of every kind of program of the procedure."""
    program = ConicProgram(problem, ProcedureSettings())
    shift = np.linspace(0, 0.05, problem.n_points)
    yield program, program.data(true_sliding(problem))
    yield program, program.data(fictitious_sliding(problem, n0, 0.1, 0.3))
    yield program, program.data(fictitious_sliding(problem, n0, 1e-3, 1e-2))
    yield program, program.data(true_sliding(problem), objective=Objective(shift, 1.01), max_load_factor=0.3)


def test_clarabel_updates_in_place_what_it_would_build_anew(problem, n0):
    kept = ClarabelSolver()
    for program, numbers in programs(problem, n0):
        old, new = kept.solve(program, numbers, 1e-10), ClarabelSolver().solve(program, numbers, 1e-10)
        assert old.y[0] == pytest.approx(new.y[0], rel=1e-7)


@pytest.mark.parametrize("name", ["CLARABEL", "SCS"])
def test_cvxpy_agrees(problem, n0, name):
    assert name in cvxpy.installed_solvers()
    for program, numbers in programs(problem, n0):
        direct = ClarabelSolver().solve(program, numbers, 1e-10)
        layered = CvxpySolver(name).solve(program, numbers, 1e-9)
        assert layered.y[0] == pytest.approx(direct.y[0], rel=1e-6)


def test_multipliers_of_cvxpy_are_the_mechanism(problem):
    program = ConicProgram(problem, ProcedureSettings())
    numbers = program.data(true_sliding(problem))
    alpha, x, u = program.unpack(CvxpySolver("CLARABEL").solve(program, numbers, 1e-10))
    assert problem.w_L @ u == pytest.approx(1.0, abs=1e-8)
    v = (problem.A.T @ u).reshape(-1, 3)
    # Associative flow: opening at least μ times the sliding, no work lost.
    assert (v[:, 0] - problem.friction * np.linalg.norm(v[:, 1:], axis=1)).min() > -1e-6
    assert abs(np.sum(x * v)) < 1e-6
    residual = certify(problem, x, u, alpha, ProcedureSettings()).equilibrium_residual
    assert residual < 1e-7


def test_unstable_through_cvxpy():
    model = model_of(*single_block(1.0, 1.0))
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.BodyForce("+x", share=2)])
    result = solve(model, push(1, 0, 0), dead=dead, solver="cvxpy:clarabel")
    assert result.status == "unstable_under_dead_load"


def test_a_solver_that_lies_is_not_believed(small_model, monkeypatch):
    """Statuses are claims: a solution off by a thousandth is refused by the certificate."""
    honest = ClarabelSolver.solve

    def lying(self, program, numbers, tolerance):
        solution = honest(self, program, numbers, tolerance)
        solution.y[0] *= 1.001
        return solution

    monkeypatch.setattr(ClarabelSolver, "solve", lying)
    for flow in bs.Flow:
        result = solve(small_model, push(1, 0, 0), flow, procedure="fictitious", max_programs=20)
        assert result.status == "not_converged"
        assert np.isnan(result.load_factor)
        assert not result.certificate.holds


def failing(monkeypatch, fails):
    """Let the programs of some numbers have no solution."""
    honest, calls = ClarabelSolver.solve, []

    def solve(self, program, numbers, tolerance):
        solution = honest(self, program, numbers, tolerance)
        calls.append(1)
        return replace(solution, status=bs.vocabulary.SolverStatus.INFEASIBLE) if fails(len(calls)) else solution

    monkeypatch.setattr(ClarabelSolver, "solve", solve)


def test_infeasible_steps_raise_the_cohesion(small_model, monkeypatch):
    """The infeasibility rule: the step is repeated with four times the cohesion, and the case still converges."""
    failing(monkeypatch, lambda k: k == 5)
    result = solve(small_model, push(1, 0, 0), "nonassociative", procedure="fictitious")
    history = result.history
    assert result.status == "converged"
    assert history.solver_status[3] == "infeasible"
    assert np.isnan(history.load_factor[3])
    assert history.schedule_cohesion[4] == pytest.approx(4 * history.schedule_cohesion[3])


def test_a_last_program_without_a_solution_has_no_certificate(tmp_path, monkeypatch):
    """A certificate proves a state: without one there is none, and never a certificate of NaN."""
    # Two programs of the dead load, and the associative one.
    failing(monkeypatch, lambda k: k > 3)
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    settings = ProcedureSettings(procedure="fictitious")
    result = bs.run(model_of(*single_block(1, 2)), case, tmp_path / "a.h5", settings=settings)["push"]
    assert (result.status, result.certificate) == ("not_converged", None)
    assert np.isnan(
        [result.history[name][-1] for name in ("equilibrium_residual", "yield_excess", "interpenetration")]
    ).all()
    stored = bs.open_analysis(tmp_path / "a.h5")
    assert stored["push"].certificate is None
    assert (bs.results.contradictions(stored), bs.results.recomputed_certificate(stored, "push")) == ([], None)


def test_cases_share_the_programs_of_their_dead_load(small_model, monkeypatch):
    solved = []

    class Counting(ClarabelSolver):
        def solve(self, program, data, tolerance):
            solved.append(program.problem)
            return super().solve(program, data, tolerance)

    monkeypatch.setattr("blockstruct.solvers.ClarabelSolver", Counting)
    pushes = [bs.LoadPattern(name, [bs.BodyForce(name)]) for name in ("+x", "-x")]
    cases = [bs.LimitCase(pattern.name, SELF_WEIGHT, pattern, "nonassociative") for pattern in pushes]
    settings = ProcedureSettings(procedure="fictitious")
    both = bs.AnalysisManager(small_model, settings=settings, effects=False).run(cases)
    assert sum(not problem.w_D.any() for problem in solved) == 1
    alone = bs.AnalysisManager(small_model, settings=settings, effects=False).run(cases[1:])
    assert both["-x"].load_factor == alone["-x"].load_factor


def test_a_solution_is_kept_for_the_same_numbers_only(problem):
    own, solver = problem.dead_load_alone, RememberingSolver(ClarabelSolver())
    program = ConicProgram(own, ProcedureSettings())
    data = program.data(true_sliding(own), max_load_factor=1.0)
    first = solver.solve(program, data, 1e-8)
    assert solver.solve(ConicProgram(own, ProcedureSettings()), data, 1e-8) is first
    assert solver.solve(program, data, 1e-9) is not first
    assert solver.solve(program, program.data(true_sliding(own), max_load_factor=0.5), 1e-8) is not first


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


def iterated(step, start, accelerated, times):
    """Where an iteration is after some steps."""
    point = start
    for _ in range(times):
        after = step(point)
        point = accelerated.point(point, after) if accelerated else after
    return point


@pytest.mark.parametrize("seed", range(5))
def test_a_linear_iteration_ends_after_as_many_steps_as_it_has_directions(seed):
    """Of six directions, seven changes tell all, but for rounding: the least change in their span is none."""
    rng = np.random.default_rng(seed)
    directions, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    turn = directions @ np.diag([0.99, -0.95, 0.9, 0.8, -0.5, 0.3]) @ directions.T
    exact, start = rng.normal(size=6), np.zeros(6)

    def step(point):
        return exact + turn @ (point - exact)

    found = iterated(step, start, Anderson(rng.uniform(0.5, 2.0, size=6), memory=6), 10)
    slow = iterated(step, start, None, 10)
    assert np.linalg.norm(found - exact) < 1e-6 * np.linalg.norm(exact)
    assert np.linalg.norm(slow - exact) > 1e-2 * np.linalg.norm(exact)


def test_what_swings_for_ever_comes_to_rest():
    """A rotation by a right angle goes round its centre."""
    exact = np.array([1.0, 2.0])
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])

    def step(point):
        return exact + turn @ (point - exact)

    assert np.linalg.norm(iterated(step, np.zeros(2), None, 40) - exact) == pytest.approx(np.linalg.norm(exact))
    assert np.linalg.norm(iterated(step, np.zeros(2), Anderson(np.ones(2), 4), 6) - exact) < 1e-6


def test_at_rest_it_stays():
    accelerated, point = Anderson(np.ones(3), 4), np.array([1.0, 2.0, 3.0])
    for _ in range(6):
        np.testing.assert_array_equal(accelerated.point(point, point), point)


def test_what_suddenly_changes_more_is_not_taken_for_the_same_iteration():
    accelerated = Anderson(np.ones(1), 4)
    accelerated.point(np.zeros(1), np.array([1.0]))
    accelerated.point(np.array([1.0]), np.array([1.5]))
    far = np.array([100.0])
    np.testing.assert_array_equal(accelerated.point(np.array([1.5]), far), far)


def test_numbers_without_weight_go_along():
    """They have no say in where to go, and go there with the others."""
    accelerated, point = Anderson(np.array([1.0, 0.0]), 3), np.zeros(2)
    for _ in range(4):
        # The first halves its way to one; the second is always twice the first.
        half = (1 + point[0]) / 2
        point = accelerated.point(point, np.array([half, 2 * half]))
    np.testing.assert_allclose(point, [1.0, 2.0], rtol=1e-6)
