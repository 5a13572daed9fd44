"""A loading path by splitting: many cheap iterations, and one factorisation per step."""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.path import Path, gap_of
from blockstruct.solvers.interior_point import ContactState
from blockstruct.solvers.splitting import Splitting
from blockstruct.vocabulary import PathEnd

Array = NDArray[np.float64]

#: Residual and iterations asked of the state under dead load, and of a step.
OF_DEAD_LOAD, MAX_OF_DEAD_LOAD = 1e-3, 400
TOLERANCE, MAX_OF_STEP = 1e-3, 200
#: Iterations of all steps together.
MAX_OF_PATH = 12_000
#: Share of the tolerance, and as many times the iterations, for steps after an end that was not exact; and for all
#: steps where rectangles crush about both axes at once, whose number a little rotation about the other axis decides.
CARE = 4
#: Flow-rule gap of the path, relative to the load factor, up to which it is closed. Measured on 2,430 blocks: at 0.05
#: the closed state is not exact, at 0.03 it is, and the steps between cost less than closing again.
CLOSE = 4e-2
#: The same where one step alone has hardly moved the load factor, which may be that of a peak.
AT_ONCE = 1e-2
#: Residual up to which a step is one.
ENOUGH = 0.3
#: Penalty of the state under dead load, and of a step one elastic displacement long.
OF_REST, PENALTY = 20.0, 10.0
#: Change of the penalty from one step to the next at most, and of all steps together, as ratios.
REBALANCED, OUT_OF_BALANCE = 3.0, 1e3
#: Change of the load factor while the displacement becomes e times as large, relative, up to which it has settled.
SETTLED = 4e-3
#: Displacement at which a path ends, in elastic displacements: beyond it no elastic strain is left to speak of.
FURTHEST = 1e5


class SplittingPath(Path):
    """Steps of :class:`~blockstruct.solvers.splitting.Splitting`, each longer than the last as the settings say.

    Measured on twenty walls, façades and domes of 44 to 820 blocks: what a step misses, the next one makes up for. The
    load factor at the end is that of steps with seven times as many iterations within 0.3 %, of one within 0.7 %.
    """

    blur = 2e-2

    def __init__(self, program: ConicProgram, settings: ProcedureSettings) -> None:
        super().__init__(program, settings)
        self._splitting = Splitting(self.contact)
        self._step, self._balance, self._settled = 0.0, 1.0, 0
        biaxial = settings.crushing_interaction == "biaxial" and len(self._problem.rectangles) > 0
        self._usual = self._care = CARE if biaxial else 1
        self._spent = 0

    def _at_rest(self) -> tuple[ContactState, int] | None:
        found = self._splitting.solve(
            self._rest(),
            self._splitting.start(),
            penalty=OF_REST,
            tolerance=OF_DEAD_LOAD,
            max_iterations=MAX_OF_DEAD_LOAD,
        )
        if not found.residual <= ENOUGH:
            return None
        self._state = found.state
        return found.state, found.iterations

    def advance(self, bound: float) -> Iteration | None:
        """The next step; None if the path has ended."""
        start, before = perf_counter(), self._total / self._unit
        length = self._settings.path_growth * self._step if self._step else self._settings.path_step
        if before >= FURTHEST or self._spent >= MAX_OF_PATH:
            self.end = PathEnd.LIMIT_REACHED
            return None
        s = length * self._unit
        try:
            found = self._splitting.solve(
                self._memory(self._state, s),
                self._splitting.predicted(self._state, length / self._step if self._step else 0.0),
                penalty=self._balance * PENALTY * length,
                tolerance=TOLERANCE / self._care,
                max_iterations=MAX_OF_STEP * self._care,
            )
        except RuntimeError:
            # Blocks that nothing holds, as those on their only support once it moves.
            self.end = PathEnd.STEP_NOT_SOLVED
            return None
        self._spent += found.iterations
        if not found.residual <= ENOUGH:
            self.end = PathEnd.STEP_NOT_SOLVED
            return None
        # Where forces still move and hardly miss their conditions, the penalty is too large.
        ratio = np.sqrt(found.missed / max(found.changed, 1e-300))
        self._balance *= float(np.clip(ratio, 1 / REBALANCED, REBALANCED))
        self._balance = float(np.clip(self._balance, 1 / OUT_OF_BALANCE, OUT_OF_BALANCE))
        alpha, last = found.state.alpha, self._state.alpha
        longer = np.log((before + length) / before) if before else np.inf
        hardly = bool(before) and abs(alpha - last) <= SETTLED * max(longer, 1.0) * abs(alpha)
        self._settled = self._settled + 1 if hardly else 0
        self._state, self._step = found.state, length
        self._total += s
        # What a step misses may lift it above the bound, which no state passes.
        self.peak = max(self.peak, min(alpha, bound))
        return self._step_done(found.state, s, found.iterations, perf_counter() - start)

    def at_its_end(self, last: Iteration) -> bool:
        """Whether the load factor hardly moves."""
        return self._settled > 0

    def may_close(self, last: Iteration, *, ended: bool) -> bool:
        """Whether the load factor hardly moves, or will not."""
        near = CLOSE if self._settled > 1 else AT_ONCE
        return ended or (self._settled > 0 and gap_of(last) <= near)

    def refine(self) -> None:
        """Solve later steps more exactly."""
        self._care = CARE * self._usual

    def forces(self, last: Iteration) -> Array:
        """Forces at the end of the path.

        Normal forces as friction follows them swing less than those of the last iteration.
        """
        problem = self._problem
        sliding = self._state.y.soc[: problem.n_points]
        normal = np.maximum(last.x[:, 0], -problem.tension)
        np.divide(sliding[:, 0] - problem.cohesion, problem.friction, out=normal, where=problem.friction > 0)
        return np.column_stack([normal, sliding[:, 1:]])
