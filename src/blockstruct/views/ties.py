"""Lines of ties, at rest and in a mechanism."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import blockstruct as bs

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TieLines:
    """Stretches of the ties of a model as lines.

    Attributes
    ----------
    names : list of str
    blocks : (M, 2) array
        Block of each end.
    ends : (M, 2, 3) array
        m.
    """

    names: list[str]
    blocks: npt.NDArray[np.int64]
    ends: Array

    @classmethod
    def of(cls, model: bs.Model) -> "TieLines":
        """Return the lines of a model, in the order of the ties in its histories."""
        segments = bs.ties.tie_segments(model.ties, model.blocks)
        number = {b.name: i for i, b in enumerate(model.blocks)}
        return cls(
            names=[s.name for s in segments],
            blocks=np.array([[number[b] for b in s.blocks] for s in segments], dtype=np.int64).reshape(-1, 2),
            ends=np.array([(s.start, s.end) for s in segments], dtype=float).reshape(-1, 2, 3),
        )

    def displacement(self, result: bs.CaseResult, iteration: int) -> Array:
        """Return the displacement (M, 2, 3) of the ends: see :meth:`blockstruct.views.solids.Solids.displacement`."""
        found = bs.results.mechanism(result.history.isel(iteration=[iteration]))
        shift, turn = (found[name].transpose("block", "axis").to_numpy() for name in ("translation", "rotation"))
        arms = self.ends - result.history["block_position"].to_numpy()[self.blocks]
        return np.asarray(shift[self.blocks] + np.cross(turn[self.blocks], arms))
