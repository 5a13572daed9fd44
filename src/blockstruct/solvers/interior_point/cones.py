"""Compute with products of cones and their Nesterov–Todd scaling.

The cones are second-order cones of three dimensions and half-lines. The algebra is the algebra of symmetric cones: Y.
E. Nesterov, M. J. Todd (1997), doi:10.1287/moor.22.1.1; for second-order cones F. Alizadeh, D. Goldfarb (2003),
doi:10.1007/s10107-002-0339-5.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import Array

#: Smallest divisor, for a determinant that rounding has made zero.
TINY = np.finfo(float).tiny


@dataclass(frozen=True, slots=True)
class ConeVector:
    """Point, or change of a point, in a product of cones.

    The product has M cones ``‖(y_1, y_2)‖ ≤ y_0`` and L half-lines ``y ≥ 0``.

    Attributes
    ----------
    soc : (M, 3) array
        Entries of the cones.
    line : (L,) array
        Entries of the half-lines.
    """

    soc: Array
    line: Array

    @classmethod
    def identity(cls, m: int, n: int) -> Self:
        """Return the unit element of m cones and n half-lines."""
        return cls(np.tile([1.0, 0.0, 0.0], (m, 1)), np.ones(n))

    @property
    def rows(self) -> Array:
        """Return all entries (L + 3 M,), half-lines first."""
        return np.concatenate([self.line, self.soc.ravel()])

    @property
    def degree(self) -> int:
        """Return the number of cones and half-lines."""
        return len(self.soc) + len(self.line)

    def dot(self, other: "ConeVector") -> float:
        """Return the inner product."""
        return float((self.soc * other.soc).sum() + self.line @ other.line)

    def __add__(self, other: "ConeVector") -> "ConeVector":
        return ConeVector(self.soc + other.soc, self.line + other.line)

    def __sub__(self, other: "ConeVector") -> "ConeVector":
        return ConeVector(self.soc - other.soc, self.line - other.line)

    def __mul__(self, factor: float) -> "ConeVector":
        return ConeVector(factor * self.soc, factor * self.line)

    __rmul__ = __mul__

    def times(self, other: "ConeVector") -> "ConeVector":
        """Return the Jordan product."""
        a, b = self.soc, other.soc
        product = a[:, :1] * b + b[:, :1] * a
        product[:, 0] = (a * b).sum(axis=1)
        return ConeVector(product, self.line * other.line)

    def solve(self, other: "ConeVector") -> "ConeVector":
        """Return the q with ``self ∘ q = other``."""
        a, b = self.soc, other.soc
        head = (a[:, 0] * b[:, 0] - (a[:, 1:] * b[:, 1:]).sum(axis=1)) / _determinant(a)
        tail = (b[:, 1:] - a[:, 1:] * head[:, None]) / a[:, :1]
        return ConeVector(np.column_stack([head, tail]), other.line / self.line)

    def longest_step(self, change: "ConeVector") -> float:
        """Return the largest t for which ``self + t change`` stays inside.

        It is infinite if there is no limit.
        """
        y, d = self.soc.T.copy(), change.soc.T.copy()
        squares, products = d * d, y * d
        a, b, c = squares[0] - squares[1] - squares[2], products[0] - products[1] - products[2], _determinant(self.soc)
        with np.errstate(all="ignore"):
            root = np.copysign(np.sqrt(b * b - a * c), b)
            q = -(b + root)
            candidates = np.concatenate([q / a, c / q, (-y[0] / d[0])[d[0] < 0]])
            lines = (-self.line / change.line)[change.line < 0]
        # Without a positive real root, the ray never leaves the cone.
        ahead = candidates[candidates > 0]
        return float(min(ahead.min(initial=np.inf), lines.min(initial=np.inf)))

    def inverse(self) -> "ConeVector":
        """Return the q with ``self ∘ q = e``."""
        soc = self.soc * [1.0, -1.0, -1.0] / _determinant(self.soc)[:, None]
        return ConeVector(soc, 1 / self.line)

    def inside(self, other: "ConeVector", share: float) -> "ConeVector":
        """Return self in each cone where it is deep enough, else other.

        The depth inside the cone must exceed a share of the depth of ``other``.
        """
        depth, least = (v.soc[:, 0] - np.hypot(v.soc[:, 1], v.soc[:, 2]) for v in (self, other))
        soc = np.where((depth > share * least)[:, None], self.soc, other.soc)
        return ConeVector(soc, np.where(self.line > share * other.line, self.line, other.line))

    def clipped(self, low: float, high: float) -> "ConeVector":
        """Return the vector with eigenvalues clipped to an interval."""
        return self.spectral(lambda value, _: np.clip(value, low, high), self.soc[:, 0], self.line)

    def spectral(self, function: Callable[[Array, Array], Array], soc: Array, line: Array) -> "ConeVector":
        """Apply a function to the eigenvalues.

        The function has a parameter for each cone (M,) and half-line (L,).
        """
        size = np.hypot(self.soc[:, 1], self.soc[:, 2])
        direction = self.soc[:, 1:] / np.maximum(size, TINY)[:, None]
        low, high = function(self.soc[:, 0] - size, soc), function(self.soc[:, 0] + size, soc)
        tail = ((high - low) / 2)[:, None] * direction
        return ConeVector(np.column_stack([(low + high) / 2, tail]), function(self.line, line))


def centred(y: ConeVector, z: ConeVector, mu: float) -> ConeVector:
    """Return the y' near y for which ``z' = mu y'⁻¹`` is near z.

    Neither y nor z need be inside. ``y' − ρ z' = y − ρ z``, where ρ is the ratio of their sizes. In each cone, ρ is
    within a factor of three of the mean. Large entries therefore hardly change. Measured: further from the mean, forces
    change so much that the loop does not recover. At the mean itself, walls of 800 blocks take half as many iterations
    again.
    """
    of_y, of_z = (np.linalg.norm(v.soc, axis=1) for v in (y, z))
    mean = max(float(of_y.mean()), TINY) / max(float(of_z.mean()), TINY)
    soc, line = (
        np.clip(a / np.maximum(b, TINY), mean / 3, 3 * mean)
        for a, b in ((of_y, of_z), (np.abs(y.line), np.abs(z.line)))
    )
    w = ConeVector(y.soc - soc[:, None] * z.soc, y.line - line * z.line)

    def root(value: Array, rho: Array) -> Array:
        """Return the positive root of ``t² − value t − rho mu``."""
        length = np.sqrt(value**2 + 4 * rho * mu)
        return np.where(value > 0, (value + length) / 2, 2 * rho * mu / np.maximum(length - value, TINY))

    return w.spectral(root, soc, line)


def _determinant(y: Array) -> Array:
    size = np.hypot(y[:, 1], y[:, 2])
    return np.asarray(np.maximum((y[:, 0] - size) * (y[:, 0] + size), TINY))


class Scaling:
    """Symmetric scaling W of Nesterov & Todd: ``W z = W⁻¹ y = λ``.

    Parameters
    ----------
    y, z
        Points strictly inside.
    """

    def __init__(self, y: ConeVector, z: ConeVector) -> None:
        of_y, of_z = np.sqrt(_determinant(y.soc)), np.sqrt(_determinant(z.soc))
        ys, zs = y.soc / of_y[:, None], z.soc / of_z[:, None]
        half = np.sqrt((1 + (ys * zs).sum(axis=1)) / 2)
        w = ys - zs
        w[:, 0] = ys[:, 0] + zs[:, 0]
        self._w = w / (2 * half)[:, None]
        self._eta = np.sqrt(of_y / of_z)
        self._line = np.sqrt(y.line / z.line)
        self.point = self.times(z)

    def times(self, a: ConeVector) -> ConeVector:
        """Return ``W a``."""
        return self._applied(a, 1.0, self._eta, self._line)

    def divided(self, a: ConeVector) -> ConeVector:
        """Return ``W⁻¹ a``."""
        return self._applied(a, -1.0, 1 / self._eta, 1 / self._line)

    def inverse_square(self) -> tuple[Array, Array]:
        """Return ``W⁻²``: cones (M, 3, 3), half-lines (L,)."""
        w = self._w * [1.0, -1.0, -1.0]
        square = 2 * w[:, :, None] * w[:, None, :] - np.diag([1.0, -1.0, -1.0])
        return square / (self._eta**2)[:, None, None], self._line**-2.0

    def _applied(self, a: ConeVector, sign: float, eta: Array, line: Array) -> ConeVector:
        w, v = self._w, a.soc
        inner = w[:, 1] * v[:, 1] + w[:, 2] * v[:, 2]
        out = v + w * (inner / (1 + w[:, 0]) + sign * v[:, 0])[:, None]
        out[:, 0] = w[:, 0] * v[:, 0] + sign * inner
        return ConeVector(out * eta[:, None], a.line * line)
