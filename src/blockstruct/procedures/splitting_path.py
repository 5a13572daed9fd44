"""A loading path by splitting: many cheap iterations, and one factorisation per step."""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.path import Path
from blockstruct.solvers.interior_point import ContactState
from blockstruct.solvers.splitting import Splitting
from blockstruct.vocabulary import PathEnd

Array = NDArray[np.float64]

#: Residual of a step, and iterations in which it must halve. Measured on 37 structures
#: against an independent path: with 1e-4, 3e-5 and 1e-5 the cases cost the same to 3 %, and 4, 1 and 3 load factors are
#: off by more than 0.25 %.
TOLERANCE, PATIENCE = 3e-5, 60
#: Iterations of all steps together.
MAX_OF_PATH = 12_000
#: Share of the tolerance, and as many times the patience, for steps after an end that was not exact; and for all
#: steps where rectangles crush about both axes, whose levers depend on small forces at their edges.
CARE = 4
#: Residual up to which a step is one.
ENOUGH = 0.3
#: Penalty of a step one elastic displacement long, and its largest change from one step to the next, as a ratio.
PENALTY, REBALANCED = 10.0, 3.0


class SplittingPath(Path):
    """Steps of :class:`~blockstruct.solvers.splitting.Splitting`, each longer than the last as the settings say.

    A step that misses its tolerance is corrected by the next one.
    """

    def __init__(self, program: ConicProgram, settings: ProcedureSettings, divided: int = 1) -> None:
        super().__init__(program, settings, divided)
        self._splitting = Splitting(self.contact)
        self._step, self._balance = 0.0, 1.0
        self._usual = self._care = CARE if program.is_frozen else 1
        self._spent = 0

    def _at_rest(self) -> tuple[ContactState, int] | None:
        found = self._splitting.solve(
            self._rest(),
            self._splitting.start(),
            penalty=PENALTY,
            tolerance=TOLERANCE,
            patience=PATIENCE,
        )
        if not found.residual <= ENOUGH:
            return None
        self._state = found.state
        return found.state, found.iterations

    def advance(self, bound: float) -> Iteration | None:
        """The next step; None if the path has ended."""
        start = perf_counter()
        length = self._growth * self._step if self._step else self._first
        if self._is_at_limit or self._spent >= MAX_OF_PATH:
            self.end = PathEnd.LIMIT_REACHED
            return None
        s, before = length * self._unit, self._total / self._unit
        memory = self._memory(self._state, s)
        if self.program.is_frozen:
            self._last = self.contact.with_conditions(self._sliding, self._next_bearing())
            self._splitting = Splitting(self._last)
        try:
            found = self._splitting.solve(
                memory,
                self._splitting.predicted(
                    self._state, length / self._step if self._step else 0.0, 1 + length / before if before else 1.0
                ),
                penalty=self._balance * PENALTY * length,
                tolerance=TOLERANCE / self._care,
                patience=PATIENCE * self._care,
            )
        except RuntimeError:
            # Blocks that nothing holds, as those on their only support once it moves.
            return None
        self._spent += found.iterations
        if not found.residual <= ENOUGH:
            return None
        # Where forces still move and hardly miss their conditions, the penalty is too large.
        ratio = np.sqrt(found.missed / max(found.changed, 1e-300))
        self._balance *= float(np.clip(ratio, 1 / REBALANCED, REBALANCED))
        self._state, self._step = found.state, length
        self._total += s
        # What a step misses may lift it above the bound, which no state passes.
        self.peak = max(self.peak, min(found.state.alpha, bound))
        return self._step_done(found.state, s, found.iterations, perf_counter() - start)

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
