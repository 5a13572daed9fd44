"""Rounded corners of bodies: what is left of their faces."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def inset(corner: Array, normal: Array, others: Array, radius: float) -> Array | None:
    """Way of the centre of a ball that rolls inside a body along a face, a radius below it.

    Towards an edge it ends where the ball touches the face beyond, at ``r tan(ε / 2)`` from the edge for an outer angle
    ε between the normals: at r for a right angle, at the edge where the surface goes on flat or turns inwards.

    Parameters
    ----------
    corner : (k, 3) array
        Corners of a convex face, counter-clockwise seen from outside.
    normal : (3,) array
    others : (k, 3) array
        Normals of the faces beyond the edges that leave the corners.
    radius
        Of the ball, m.

    Returns
    -------
    (k, 3) array or None
        Its corners; None if nothing is left of the face.
    """
    along, moves = _moves(corner, normal, others)
    points = corner + radius * moves
    left = np.roll(points, -1, axis=0) - points
    if not np.all(np.einsum("ki,ki->k", left, along) > 0):
        return None
    return np.asarray(points)


def largest_radius(corner: Array, normal: Array, others: Array) -> float:
    """Radius, m, from which on :func:`inset` leaves nothing of a face; infinite where it takes nothing off."""
    along, moves = _moves(corner, normal, others)
    # Edges get shorter in proportion to the radius.
    length = np.linalg.norm(np.roll(corner, -1, axis=0) - corner, axis=1)
    shorter = -np.einsum("ki,ki->k", np.roll(moves, -1, axis=0) - moves, along)
    return float(np.min(length[shorter > 0] / shorter[shorter > 0], initial=np.inf))


def _moves(corner: Array, normal: Array, others: Array) -> tuple[Array, Array]:
    """Directions of the edges that leave the corners, and the way of the corners at a radius of one."""
    along = np.roll(corner, -1, axis=0) - corner
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    inwards = np.cross(normal, along)
    lean = -np.einsum("ki,ki->k", others, inwards)
    away = np.maximum(lean, 0.0) / np.maximum(1 + others @ normal, 1e-9)
    rows = np.stack([inwards, np.roll(inwards, 1, axis=0), np.tile(normal, (len(corner), 1))], axis=1)
    moved = np.stack([away, np.roll(away, 1), np.full(len(corner), -1.0)], axis=1)
    # Edges in one line give one condition twice.
    return along, np.einsum("kij,kj->ki", np.linalg.pinv(rows, rcond=1e-9), moved)
