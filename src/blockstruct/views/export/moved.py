"""Moved blocks as OBJ and STL files."""

from pathlib import Path
from typing import Any

import numpy as np

import blockstruct as bs
from blockstruct.geometry import triangulated
from blockstruct.views.export.motion import mechanism_motion, pushover_motion
from blockstruct.views.output import target_with, write_bytes, write_text
from blockstruct.views.selection import given_result
from blockstruct.views.solids import Solids

#: A triangle of binary STL: normal, corners, and two bytes without meaning.
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


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
