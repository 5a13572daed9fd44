"""Finite motions of rigid bodies."""

import numpy as np

from blockstruct.arrays import Array

#: Angle, radians, below which the series of a rotation is exact to rounding.
SMALL = 1e-3
#: Matrices of the cross product with the unit vectors, (3, 9).
SKEW = np.cross(np.eye(3)[:, None], np.eye(3)).transpose(0, 2, 1).reshape(3, 9)


def rotation_matrices(vectors: Array) -> Array:
    """Return the rotation matrices (n, 3, 3) of rotation vectors (n, 3), rad (O. Rodrigues)."""
    sine, cosine, _ = _shares(vectors)
    K = _skew(vectors)
    return np.asarray(np.eye(3) + sine[:, None, None] * K + cosine[:, None, None] * (K @ K))


def rotation_vectors(matrices: Array) -> Array:
    """Return the rotation vectors (n, 3), with angles up to π, of rotation matrices (n, 3, 3)."""
    twice = np.stack([matrices[:, j, i] - matrices[:, i, j] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
    sine, cosine = np.linalg.norm(twice, axis=1) / 2, (np.trace(matrices, axis1=1, axis2=2) - 1) / 2
    vectors = twice / 2 * np.where(sine > SMALL**2, np.arctan2(sine, cosine) / np.maximum(sine, 1e-300), 1.0)[:, None]
    half = (cosine < 0) & (sine < SMALL)
    if half.any():
        # Imported here because scipy.spatial loads slowly. Near half a turn the difference does not contain the axis.
        from scipy.spatial.transform import Rotation

        vectors[half] = Rotation.from_matrix(matrices[half]).as_rotvec()
    return np.asarray(vectors)


def screw_motions(translations: Array, rotations: Array) -> tuple[Array, Array]:
    """Return the finite motions along the screws of twists.

    The result is rotation matrices (n, 3, 3), and translations (n, 3) of the origins. It is the exact exponential of a
    rigid motion: a twist about a fixed axis rotates the body about this axis, so a hinge stays in place at any angle.

    Parameters
    ----------
    translations, rotations : (n, 3) arrays
        Twist of each body: velocity of its origin, and angular velocity, times the time.
    """
    sine, cosine, cubic = _shares(rotations)
    K = _skew(rotations)
    square = K @ K
    R = np.eye(3) + sine[:, None, None] * K + cosine[:, None, None] * square
    V = np.eye(3) + cosine[:, None, None] * K + cubic[:, None, None] * square
    return R, np.einsum("nij,nj->ni", V, translations)


def _shares(vectors: Array) -> list[Array]:
    """Return ``sin θ / θ``, ``(1 − cos θ) / θ²`` and ``(θ − sin θ) / θ³`` for the lengths θ of vectors."""
    angle = np.linalg.norm(vectors, axis=1)
    square, large = angle**2, angle >= SMALL
    shares = [1 - square / 6, 0.5 - square / 24, 1 / 6 - square / 120]
    if large.any():
        a = angle[large]
        exact = np.sin(a) / a, (1 - np.cos(a)) / a**2, (a - np.sin(a)) / a**3
        for share, value in zip(shares, exact, strict=True):
            share[large] = value
    return shares


def _skew(vectors: Array) -> Array:
    """Return the matrices (n, 3, 3) of the cross product with vectors."""
    return np.asarray((vectors @ SKEW).reshape(-1, 3, 3))
