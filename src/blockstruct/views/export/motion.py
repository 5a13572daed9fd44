"""Motions of the blocks of a result: the mechanism, or a pushover."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.geometry import screw_motions
from blockstruct.units import si
from blockstruct.views.solids import Solids
from blockstruct.views.style import AMPLITUDE

Array = NDArray[np.float64]

#: Positions of a mechanism in one period, and duration of a period and of a whole pushover, s.
_FRAMES, _PERIOD, _WHOLE = 24, 4.0, 8.0


@dataclass(frozen=True, slots=True)
class Motion:
    """Rigid motion of all blocks.

    Attributes
    ----------
    time : (T,) array
        Increasing, from zero, s.
    position : (T, B, 3) array
        Centroids, m.
    rotation : (T, B, 3, 3) array
        Rotation of each block from its place in the model.
    """

    time: Array
    position: Array
    rotation: Array

    def points(self, solids: Solids, frame: int) -> Array:
        """Return the vertices (V, 3) of the blocks in a frame, m."""
        of = solids.block_of_vertex
        arm = solids.vertices - solids.centroids[of]
        return np.asarray(self.position[frame, of] + np.einsum("vij,vj->vi", self.rotation[frame, of], arm))


def mechanism_motion(result: bs.CaseResult, amplitude: Any = None, shares: Array | None = None) -> Motion:
    """Return the mechanism of a result: each block moves along the screw of its velocity.

    Parameters
    ----------
    result
        The result of a case.
    amplitude : quantity, length
        Length of the largest path of a centroid. The default is the amplitude of the figures.
    shares : (T,) array
        Shares of the amplitude, one for each frame. By default the blocks move to the amplitude and back.

    Raises
    ------
    ModelError
        If the result has no mechanism.
    UnitError, DimensionError
        If the amplitude is not a length.
    """
    solids = Solids.of(result.model)
    if not result.n_iterations or not np.isfinite(first := solids.displacement(result, -1)).all():
        msg = f"case {result.name!r}: no mechanism, {result.status.words}; run the case again"
        raise bs.errors.ModelError(msg)
    if amplitude is None:
        factor = AMPLITUDE * solids.size * solids.drawn_share(first)
    else:
        factor = si(amplitude, "length", "export: amplitude")
    if shares is None:
        shares = (1 - np.cos(np.linspace(0, 2 * np.pi, _FRAMES + 1))) / 2
    found = result.mechanism
    twist = [factor * found[name].transpose("block", "axis").to_numpy() for name in ("translation", "rotation")]
    moved = [screw_motions(*(share * part for part in twist)) for share in shares]
    time = np.linspace(0, _PERIOD, len(shares))
    return Motion(time, np.array([solids.centroids + t for _, t in moved]), np.array([R for R, _ in moved]))


def pushover_motion(result: bs.CaseResult) -> Motion:
    """Return the states of a pushover. The control point moves at constant speed.

    Raises
    ------
    ModelError
        If the result has no capacity curve.
    """
    curve = result.capacity
    if curve is None:
        msg = f"case {result.name!r}: no states of a pushover; run a Pushover, or export the mechanism"
        raise bs.errors.ModelError(msg)
    way = np.abs(np.diff(curve["displacement"].to_numpy(), prepend=curve["displacement"].to_numpy()[:1])).cumsum()
    # Times increase even between two states of one displacement.
    time = way / (way[-1] or 1.0) + np.arange(len(way)) / (100 * len(way))
    position = curve["position"].transpose("step", "block", "axis").to_numpy()
    return Motion(_WHOLE * time / (time[-1] or 1.0), position, bs.results.block_rotations(curve))
