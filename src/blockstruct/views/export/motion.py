"""Motions of the blocks of a result, its mechanism or its pushover, and moved blocks as OBJ and STL files."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.geometry.screws import screw_motions
from blockstruct.geometry.triangles import triangulated
from blockstruct.units import si
from blockstruct.views.output import target_with, write_bytes, write_text
from blockstruct.views.selection import given_result
from blockstruct.views.solids import Solids
from blockstruct.views.style import AMPLITUDE

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Positions of a mechanism in one period, and duration of a period and of a whole pushover, s.
_FRAMES, _PERIOD, _WHOLE = 24, 4.0, 8.0
#: A triangle of binary STL: normal, corners, and two bytes without meaning.
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


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
        return self.moved(solids.vertices, solids.block_of_vertex, solids.centroids, frame)

    def moved(self, points: Array, blocks: Index, centroids: Array, frame: int) -> Array:
        """Return points (…, 3) of blocks (…,), m, in a frame."""
        arms = points - centroids[blocks]
        turned = np.einsum("...ij,...j->...i", self.rotation[frame, blocks], arms)
        return np.asarray(self.position[frame, blocks] + turned)


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
    mechanism = result.mechanism
    twist = [factor * mechanism[name].transpose("block", "axis").to_numpy() for name in ("translation", "rotation")]
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


def write_moved(result: bs.CaseResult, path: str | Path, *, amplitude: Any = None, step: int | None = None) -> Path:
    """Write the blocks as a mechanism or a pushover has moved them, in m.

    OBJ has an object for each block. STL has the triangles of all blocks in single precision.

    Parameters
    ----------
    result
        The result of a case.
    path
        An ``.obj`` or ``.stl`` file; an existing file is replaced.
    amplitude : quantity, length
        Largest translation of a centroid in the mechanism; ``"0 m"`` for the blocks at rest. The default is the
        amplitude of the figures.
    step
        State of a pushover, instead of the mechanism; −1 is the last.

    Raises
    ------
    ModelError
        If the argument is not a result, has no mechanism, or has no such state.
    StorageError
        If the path ends in another suffix or cannot be written.
    """
    target = target_with(path, ".obj", ".stl")
    given_result(result, "write_moved")
    if step is None:
        motion, frame = mechanism_motion(result, amplitude, np.ones(1)), 0
    else:
        motion, frame = pushover_motion(result), step
        if not -len(motion.time) <= step < len(motion.time):
            msg = f"case {result.name!r}: no state {step}; it has 0 to {len(motion.time) - 1} (-1 is the last)"
            raise bs.errors.ModelError(msg)
    solids = Solids.of(result.model)
    points = motion.points(solids, frame)
    if target.suffix.lower() == ".obj":
        lines = [f"# {result.name}: {result.headline}"]
        start = 0
        for block in result.model.blocks:
            n = len(block.shape.vertices)
            lines.append(f"o {block.name}")
            lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points[start : start + n].tolist()]
            lines += [f"f {' '.join(str(start + i + 1) for i in face)}" for face in block.shape.faces]
            start += n
        return write_text("\n".join(lines) + "\n", target)
    corners = points[[triangle for loop in solids.loops for triangle in triangulated(points, loop.tolist())]]
    body = np.zeros(len(corners), dtype=_TRIANGLE)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    body["normal"] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    body["corners"] = corners
    return write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + body.tobytes(), target)
