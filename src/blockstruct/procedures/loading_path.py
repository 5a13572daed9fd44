"""The loading path: from the state under dead load, with joints that are a little elastic, to collapse."""

from collections.abc import Generator
from dataclasses import replace
from time import perf_counter

import numpy as np

from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import fictitious_sliding, true_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.fictitious import admissible
from blockstruct.procedures.step import solve_step
from blockstruct.solvers.interior_point import ContactProblem, ContactSolution, ContactState, Step
from blockstruct.vocabulary import ALONG_PATH, DRIFTING, SolverStatus, Stage

#: Of displacements and gap, relative, and a tenth of it of forces: of the state under dead load, asked of a step, and
#: good enough for one that goes no further. The force that an interior point leaves on unloaded contacts holds
#: structures together: measured on two leaves beside each other, 1e-3 ends 0.8 % high, 1e-6 0.04 %.
OF_DEAD_LOAD, TOLERANCE, ENOUGH = 1e-7, 1e-5, 1e-3
#: Complementarity gap at which a step begins, in multiples of its work.
CENTRING = 1.0
#: Factorisations of one step, and of all of them.
MAX_OF_STEP, MAX_OF_PATH = 80, 600
#: A step that took no more factorisations is followed by one as much longer as the settings allow.
#: Begun in a wide state, a first step takes fewer, and says less about the next.
EASY, EASY_FIRST = 15, 10
#: Of a step after a harder one: share of the exponent of growth.
HARDER = 0.6
#: Attempts at a step: as it is, with lagging friction, and then each a third as long as the last.
ATTEMPTS = 4
#: Share of friction that does not lag.
LAG = 0.5
#: Cohesion of contacts whose friction lags, which keeps those without force from having none.
LAG_FLOOR = 1e-5
#: Change of the load factor in a step with lagging friction, relative, up to which the path may be closed.
SETTLED = 5e-3
#: Flow-rule gap of the path, relative to the load factor, at which it is closed, and up to which it may be.
CLOSE, LOOSE = 2.5e-2, 0.1
#: Flow-rule gap asked of the closed state, relative to the load factor.
CLOSED = 1e-4
#: Cohesion that keeps the program of frozen caps feasible.
CAP = 1e-9


def loading_path(
    program: ConicProgram, bound: float, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[str, Iteration | None]]:
    """Follow the loading path to its end, and close it with an exact collapse state.

    A collapse state without dilatancy is not unique: what a structure does is decided by how it is loaded. Each step
    prescribes the displacement of the variable load and finds forces, displacements and load factor
    (:class:`~blockstruct.solvers.interior_point.ContactProblem`), the contacts remembering openings and friction
    forces. Compare A. Orduña, P. B. Lourenço, "Three-dimensional limit analysis of rigid blocks assemblages. Part II",
    Int. J. Solids Struct. 42 (2005) 5161–5180, doi:10.1016/j.ijsolstr.2005.02.011.

    At its end the displacements still hold some elastic strain, which no rigid mechanism has. So two programs
    close it: the mechanism of the largest load with friction frozen at ``μ n`` of the path, and the forces that miss
    its flow rule least, at no larger a load factor. Measured on walls, façades and domes of 33 to 820 blocks: the
    load factor moves by less than the gap of the path, and the gap falls by three orders and more.

    Parameters
    ----------
    program
        The program, with the exact cones of crushing.
    bound
        A load factor that the path hardly passes, infinite without one; it gives the scale of a first guess.
    settings, solver
        Tolerances of the certificate, and the solver of the two programs.

    Yields
    ------
    Iteration
        The state under dead load, each step with its displacement, and the two programs.

    Returns
    -------
    str, Iteration or None
        Why the last program is certified, and it; or why the path did not finish.
    """
    path = _Path(program, settings, bound)
    last = path.dead_load()
    if last is None:
        return "the loading path found no state under dead load", None
    yield last
    best: Iteration | None = None
    closed: Iteration | None = None
    going, early = True, False
    while going:
        step = path.advance()
        going = step is not None
        if step is not None:
            last, closed = step, None
            yield last
        gap = last.certificate.flow_rule_gap / max(abs(last.load_factor), 1e-12)
        # The gap of friction that lags is that of its lag as well, which the closing programs have not.
        ready = gap <= LOOSE and path.settled if path.lags else gap <= CLOSE
        ready = ready or (gap <= LOOSE and not going)
        if last.displacement > 0 and ready:
            closed = yield from _closed(program, last, settings, solver)
            if closed.certificate.holds:
                best, early = closed, gap > CLOSE and not path.settled
                if closed.certificate.flow_rule_gap <= CLOSED * abs(closed.load_factor):
                    break
    if best is None:
        return f"the loading path did not finish, {path.why}", None
    if best is not closed:
        # The last iteration of a history is the certified one.
        yield best
    message = f"the certificate holds ({ALONG_PATH})"
    if early:
        # Closed too early, a path certifies whatever load factor it has come to.
        message += f", but the {program.problem.answer} was {DRIFTING} where the path ended: {path.why}"
    if path.peak > best.load_factor + 1e-3 * abs(best.load_factor):
        message += f"; on the way it passed a peak, {program.problem.said(path.peak)}"
    return message, best


def _closed(
    program: ConicProgram, last: Iteration, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Iteration]:
    """Exact collapse state at the end of a path, if its certificate holds."""
    caps = fictitious_sliding(program.problem, last.x[:, 0], CAP, 0.0)
    mechanism = solve_step(program, caps, Stage.NONASSOCIATIVE, settings, solver, c0=CAP)
    yield mechanism
    if not mechanism.solved:
        return mechanism
    closed = admissible(program, mechanism, settings, solver)
    yield closed
    return closed


class _Path:
    """Where the path has got to, and the next step of it.

    Attributes
    ----------
    peak : float
        Largest load factor so far of steps with Coulomb's law.
    why : str
        Why it ended.
    lags : bool
        Whether friction has begun to lag: ``‖t‖ ≤ μ (n + n_last) / 2``. The law is the same once forces no longer
        change, and half of what makes a step non-monotone is gone. Measured on 820 blocks: 30 factorisations per
        step of any length, where Coulomb's law is not solved.
    settled : bool
        Whether the last step has hardly moved the load factor.
    """

    def __init__(self, program: ConicProgram, settings: ProcedureSettings, bound: float) -> None:
        problem = program.problem
        normal, shear = problem.compliance.T
        shear = np.where(np.isnan(shear), normal / settings.shear_stiffness_ratio, shear)
        self._contact = ContactProblem(program, np.column_stack([normal, shear, shear]))
        self._problem, self._settings, self._sliding = problem, settings, true_sliding(problem)
        self._state, self._bound = self._contact.start(), bound
        self._total, self._step, self._spent = 0.0, 0.0, 0
        self.lags = self.settled = False
        self.peak, self.why = -np.inf, f"no end within {MAX_OF_PATH} factorisations"

    def dead_load(self) -> Iteration | None:
        """The state under dead load, None if none is found."""
        start, size = perf_counter(), len(self._state.x)
        try:
            self._unit = self._contact.elastic_displacement()
        except RuntimeError:
            return None
        # A support that will give way is held, by whatever reaction that takes.
        held = None if self._problem.settlement is None else 0.0
        rest = Step(np.zeros(size), np.zeros(size), held)
        found = self._contact.solve(rest, self._state, centring=1.0, tolerance=OF_DEAD_LOAD, max_iterations=MAX_OF_STEP)
        if not found.within(ENOUGH):
            return None
        self._spent = found.iterations
        self._state = replace(found.state, u=0 * found.state.u)
        self._next = self._settings.path_step * self._unit
        return self._iteration(replace(found, state=self._state), 1.0, start)

    def advance(self) -> Iteration | None:
        """The next step, shortened until it is solved; None if the path has ended."""
        start, iterations = perf_counter(), 0
        for _ in range(ATTEMPTS):
            if self._spent >= MAX_OF_PATH:
                return None
            s = self._next
            # The state under dead load is so far from that of a first step that it is no guess.
            guess = self._state.scaled(s / self._step) if self._step else self._afresh(s)
            found = self._lagging().solve(
                self._memory(s),
                guess,
                centring=CENTRING if self._step else None,
                tolerance=TOLERANCE,
                max_iterations=MAX_OF_STEP,
            )
            self._spent += found.iterations
            iterations += found.iterations
            if found.within(ENOUGH):
                self.settled = abs(found.state.alpha - self._state.alpha) <= SETTLED * abs(found.state.alpha)
                easy = EASY if self._step else EASY_FIRST
                self._state, self._step = found.state, s
                self._total += s
                exponent = 1.0 if iterations <= easy else HARDER
                if self.lags and self.settled:
                    exponent = 0.0
                self._next = s * self._settings.path_growth**exponent
                if not self.lags:
                    self.peak = max(self.peak, found.state.alpha)
                return self._iteration(replace(found, iterations=iterations), s, start)
            # From the dead load, whose friction is not that of the push, lagging would overshoot.
            if self.lags or not self._step:
                self._next = s / 3
            else:
                self.lags = True
        self.why = f"its steps beyond the displacement {self._displacement():.3g} are not solved"
        return None

    def _afresh(self, s: float) -> ContactState:
        """What a first step begins with: normal forces as they are on average, and the load factor of the bound."""
        normal = np.abs(self._state.x[: 3 * self._problem.n_points : 3]).mean()
        rise = min(s / self._unit, max(abs(self._bound - self._state.alpha), 1e-3))
        return self._contact.afresh(float(normal), s, self._state.alpha + rise)

    def _lagging(self) -> ContactProblem:
        """The contacts, and from the first step on that they do not solve, those whose friction lags behind."""
        if not self.lags:
            return self._contact
        last = np.maximum(self._state.x[: 3 * self._problem.n_points : 3], -self._problem.tension)
        half = fictitious_sliding(self._problem, last, LAG_FLOOR, -LAG)
        return self._contact.with_sliding(half)

    def _memory(self, s: float) -> Step:
        """What contacts and ties remember: friction forces, the opening of open contacts and of slack ties.

        Crushing, and the yielding of ties, is forgotten.
        """
        K, state = self._problem.n_points, self._state
        reference, opening = state.x.copy(), np.zeros_like(state.x)
        reference[: 3 * K : 3] = 0.0
        reference[3 * K :] = 0.0
        normal = slice(0, 3 * K, 3)
        opening[normal] = state.z.line[:K] - self._contact.compliance[normal] * state.x[normal]
        opening[self._contact.ties] = state.z.line[self._contact.slack]
        return Step(reference, opening, s)

    def _displacement(self) -> float:
        """Displacement so far, m; in multiples of the elastic one if no stiffness was given."""
        unit = self._problem.displacement_unit
        return self._total * unit if np.isfinite(unit) else self._total / self._unit

    def _iteration(self, found: ContactSolution, s: float, start: float) -> Iteration:
        problem, state = self._problem, found.state
        x, u = state.x[: 3 * problem.n_points].reshape(-1, 3), state.u / s
        T = state.x[self._contact.ties] + problem.ties.prestress(state.alpha)
        return Iteration(
            stage=Stage.LOADING_PATH,
            load_factor=state.alpha,
            x=x,
            u=u,
            v=(problem.A.T @ u).reshape(-1, 3),
            sliding=self._sliding,
            c0=0.0,
            a=0.0,
            linearised_at=None,
            certificate=certify(problem, x, u, state.alpha, self._settings, T),
            solver_status=SolverStatus.SOLVED,
            solver_iterations=found.iterations,
            solver_time=perf_counter() - start,
            tie_force=T,
            elongation=problem.ties.elongation(u),
            displacement=self._displacement(),
        )
