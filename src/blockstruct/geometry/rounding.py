"""Faces of bodies with rounded corners."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def inset(corner: Array, normal: Array, others: Array, radius: float) -> Array | None:
    """Return the region of the centre of a ball that rolls inside a body along a face, one radius below the face.

    Towards an edge the region ends where the ball touches the adjacent face, at ``r tan(ε / 2)`` from the edge, with
    the outer angle ε between the normals. The distance is r for a right angle, and zero for a flat or inner edge.

    Parameters
    ----------
    corner : (k, 3) array
        Corners of a convex face, counter-clockwise seen from outside.
    normal : (3,) array
    others : (k, 3) array
        Normals of the adjacent faces, at the edges that start at the corners.
    radius
        Radius of the ball, m.

    Returns
    -------
    (k, 3) array or None
        Corners of the region; None if it is empty.
    """
    along, moves = _moves(corner, normal, others)
    points = corner + radius * moves
    left = np.roll(points, -1, axis=0) - points
    if not np.all(np.einsum("ki,ki->k", left, along) > 0):
        return None
    return np.asarray(points)


def largest_radius(corner: Array, normal: Array, others: Array) -> float:
    """Return the radius, m, from which on :func:`inset` is empty; infinite if the face keeps its size."""
    along, moves = _moves(corner, normal, others)
    # Edges shorten in proportion to the radius.
    length = np.linalg.norm(np.roll(corner, -1, axis=0) - corner, axis=1)
    shorter = -np.einsum("ki,ki->k", np.roll(moves, -1, axis=0) - moves, along)
    return float(np.min(length[shorter > 0] / shorter[shorter > 0], initial=np.inf))


def _moves(corner: Array, normal: Array, others: Array) -> tuple[Array, Array]:
    """Return the directions of the edges from the corners, and the moves of the corners per unit of radius."""
    along = np.roll(corner, -1, axis=0) - corner
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    inwards = np.cross(normal, along)
    lean = -np.einsum("ki,ki->k", others, inwards)
    away = np.maximum(lean, 0.0) / np.maximum(1 + others @ normal, 1e-9)
    rows = np.stack([inwards, np.roll(inwards, 1, axis=0), np.tile(normal, (len(corner), 1))], axis=1)
    moved = np.stack([away, np.roll(away, 1), np.full(len(corner), -1.0)], axis=1)
    # Collinear edges repeat one condition, hence the pseudo-inverse.
    return along, np.einsum("kij,kj->ki", np.linalg.pinv(rows, rcond=1e-9), moved)
