"""Follow a loading path by splitting.

Each step has many cheap iterations and one factorisation.
"""

from math import log2

import numpy as np

from blockstruct.arrays import SLIGHT, Array
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.path import TOLERANCE, Path
from blockstruct.solvers.interior_point import ContactState
from blockstruct.solvers.splitting import Splitting

#: Iterations in which the residual of a step must halve.
PATIENCE = 60
#: Most iterations of all steps together, if each step is twice the last. Shorter steps have more in proportion to their
#: number, to reach the same displacement.
MAX_OF_PATH = 12_000
#: Divisor of the tolerance and factor of the patience for steps after an inexact end. It applies to all steps if
#: rectangles crush about both axes at once: a small rotation about the other axis then decides the load factor. The
#: patience also applies to a state under dead load that is not found at once. Measured on a bonded house of 115 blocks
#: that crush: the residual is 1.1e-3 after 215 iterations, when it halves too slowly, and 9e-6 after 685.
CARE = 4
#: Largest residual of an accepted step.
ACCEPTED = 0.3
#: Penalty of a step of one elastic displacement, and its largest ratio from one step to the next.
PENALTY, REBALANCED = 10.0, 3.0


class SplittingPath(Path):
    """Follow a path by :class:`~blockstruct.solvers.splitting.Splitting`.

    Each step is longer than the last by the growth of the settings. The next step corrects the error of a step that
    misses its tolerance.
    """

    def __init__(self, program: ConicProgram, settings: ProcedureSettings, divided: int = 1) -> None:
        super().__init__(program, settings, divided)
        self._splitting = Splitting(self.contact)
        self._balance, self._least = 1.0, 0.0
        biaxial = settings.crushing_interaction == "biaxial" and len(self._problem.rectangles) > 0
        self._usual = self._care = CARE if biaxial else 1
        self._spent = 0.0

    def _at_rest(self) -> tuple[ContactState, int] | None:
        for care in (1, CARE):
            found = self._splitting.solve(
                self._rest(),
                self._splitting.start(),
                penalty=PENALTY,
                tolerance=TOLERANCE,
                patience=PATIENCE * care,
            )
            # Measured on 43 structures of 20 kinds: at most 5e-4 on those that stand, and 0.02 and more on others.
            if found.residual <= SLIGHT:
                return found.state, found.iterations
        return None

    def _solved(self, length: float, bound: float) -> tuple[ContactState, float, int] | None:
        try:
            found = self._splitting.solve(
                self._memory(self._state, length * self._unit),
                self._splitting.predicted(self._state, length / self._step if self._step else 0.0),
                penalty=max(self._balance, self._least) * PENALTY * length,
                tolerance=TOLERANCE / self._care,
                patience=PATIENCE * self._care,
            )
        except RuntimeError:
            # Nothing holds some blocks, for example on their only support once it moves.
            return None
        self._spent += found.iterations * log2(self._growth)
        if not found.residual <= ACCEPTED:
            return None
        # If forces still change and hardly miss their conditions, the penalty is too large.
        ratio = np.sqrt(found.missed / max(found.changed, 1e-300))
        self._balance *= float(np.clip(ratio, 1 / REBALANCED, REBALANCED))
        # The error of a step may lift it above the bound, which no state exceeds.
        self.peak = max(self.peak, min(found.state.alpha, bound))
        return found.state, length, found.iterations

    def _is_at_limit(self, bound: float) -> bool:
        self.is_exhausted = self._spent >= MAX_OF_PATH
        return self.is_exhausted or super()._is_at_limit(bound)

    def refine(self) -> None:
        """Solve later steps more exactly."""
        self._care, self._least = CARE * self._usual, 1.0

    def forces(self, last: Iteration) -> Array:
        """Return forces at the end of the path.

        The smoothed normal forces in the friction law oscillate less than the last iteration.
        """
        problem = self._problem
        sliding = self._state.y.soc[: problem.n_points]
        normal = np.maximum(last.x[:, 0], -problem.tension)
        np.divide(sliding[:, 0] - problem.cohesion, problem.friction, out=normal, where=problem.friction > 0)
        shear = np.where(problem.never_slides[:, None], last.x[:, 1:], sliding[:, 1:])
        return np.column_stack([normal, shear])
