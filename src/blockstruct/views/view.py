"""Direction of view on a structure, and the loads on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.text import SMALL
from blockstruct.views.solids import Solids

Array = NDArray[np.float64]

#: Right, up, and toward the reader.
_PLANE = {
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
_LABELS = {"x": ("y [m]", "z [m]"), "y": ("x [m]", "z [m]"), "z": ("x [m]", "y [m]")}
#: Thickness, relative to its extent, below which a structure is drawn in elevation, unless something moves across it by
#: more than the second share.
_THIN, _ACROSS = 0.25, 0.1
#: Angles of a view in space, degrees: downwards, and from the push to the side, so that motion comes nearer and
#: sideways.
_ELEVATION, _BESIDE = 24.0, 55.0


@dataclass(frozen=True, slots=True)
class View:
    """Orthographic projection.

    Attributes
    ----------
    basis : (3, 3) array
        Unit vectors to the right, up and toward the reader.
    labels
        Labels of the two axes; none in space.
    """

    basis: Array
    labels: tuple[str, str] | None

    @classmethod
    def of(cls, shown: bs.Model | bs.CaseResult, look: Any = None) -> "View":
        """Return the view for a look; without one, the view that suits the structure.

        Raises
        ------
        ModelError
            If the look is not one of :func:`blockstruct.views.figures.structure`.
        """
        if look is None:
            look = best_look(shown)
        if isinstance(look, str) and look in _PLANE:
            return cls(np.array(_PLANE[look], dtype=float), _LABELS[look])
        if isinstance(look, str) and look == "3d":
            return cls(_basis(_azimuth(shown), _ELEVATION), None)
        try:
            azimuth, elevation = (float(angle) for angle in look)
        except (TypeError, ValueError):
            msg = (
                f"figure: look {look!r}; give 'x' or 'y' for an elevation, 'z' for a plan, '3d' for space, "
                "or azimuth and elevation in degrees as (-60, 25)"
            )
            raise bs.errors.ModelError(msg) from None
        return cls(_basis(azimuth, elevation), None)

    @property
    def flat(self) -> bool:
        """Whether the view is an elevation or a plan."""
        return self.labels is not None

    def project(self, points: Array) -> Array:
        """Return right and up coordinates (…, 2) of points or vectors (…, 3)."""
        return np.asarray(points @ self.basis[:2].T)


def best_look(shown: bs.Model | bs.CaseResult) -> str:
    """Return an elevation for a thin structure without motion or push across it; otherwise space."""
    model = shown if isinstance(shown, bs.Model) else shown.model
    extent = np.ptp(Solids.of(model).vertices, axis=0)
    thin = int(np.argmin(extent[:2]))
    if extent[thin] > _THIN * extent.max():
        return "3d"
    if isinstance(shown, bs.CaseResult):
        across = [abs(push(shown)[thin])]
        if shown.n_iterations:
            motion = np.abs(np.nan_to_num(shown.mechanism["translation"].transpose("block", "axis"))).max(axis=0)
            across.append(motion[thin] / max(motion.max(), np.finfo(float).tiny))
        if max(across) > _ACROSS:
            return "3d"
    return "xy"[thin]


def eye(shown: bs.Model | bs.CaseResult) -> Array:
    """Return the unit vector (3,) toward the reader in space."""
    look = best_look(shown)
    azimuth = _azimuth(shown) if look == "3d" else {"x": 15.0, "y": -75.0}[look]
    return np.asarray(_basis(azimuth, _ELEVATION if look == "3d" else 12.0)[2])


def _azimuth(shown: bs.Model | bs.CaseResult) -> float:
    """Return a direction of view oblique to a horizontal push, that shows most of the structure."""
    direction = push(shown)[:2] if isinstance(shown, bs.CaseResult) else np.zeros(2)
    if np.linalg.norm(direction) < 0.1:
        return -_BESIDE
    towards = float(np.degrees(np.arctan2(direction[1], direction[0])))
    model = shown.model if isinstance(shown, bs.CaseResult) else shown
    vertices = Solids.of(model).vertices

    def seen(azimuth: float) -> tuple[float, float]:
        width = float(np.ptp(vertices @ _basis(azimuth, 0)[0]))
        # From −y if both sides are alike, as in elevations.
        return round(width, 6), -float(np.sin(np.radians(azimuth)))

    return max((towards - _BESIDE, towards + _BESIDE), key=seen)


def _basis(azimuth: float, elevation: float) -> Array:
    a, e = np.radians([azimuth, elevation])
    toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.array([right, np.cross(toward, right), toward])


def round_value(value: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that does not exceed a value.

    >>> round_value(314.0), round_value(0.07)
    (200.0, 0.05)
    """
    power = 10.0 ** np.floor(np.log10(value))
    steps: Sequence[int] = (5, 2, 1)
    return float(next((s * power for s in steps if s * power <= value * (1 + 1e-9)), power))


@dataclass(frozen=True, slots=True)
class LoadArrows:
    """Forces of a load pattern that are drawn, without the weight of the blocks.

    Attributes
    ----------
    name : str
        Name of the pattern.
    grows : bool
        Whether the load factor multiplies it.
    block : (n,) array
        Index of the block of each force.
    point, force : (n, 3) arrays
        m and N, at a load factor of 1.
    largest, total : float
        Largest force, and resultant of all forces including the ones too small to draw, N.
    """

    name: str
    grows: bool
    block: NDArray[np.int64]
    point: Array
    force: Array
    largest: float
    total: float


def load_arrows(result: bs.CaseResult) -> list[LoadArrows]:
    """Return the forces of the dead and the variable load of a case, without patterns that have none.

    Forces below 2 % of the largest of their pattern are left out, and couples, too.
    """
    arrows_of = []
    for k, pattern in enumerate(result.case.patterns):
        carried = [load for load in pattern.loads if not isinstance(load, bs.SelfWeight)]
        block, point, force = _acting(bs.LoadPattern(pattern.name, carried), result.model, result.case.dead)
        size = np.linalg.norm(force, axis=1)
        if len(size):
            shown = size > SMALL * size.max()
            total = float(np.linalg.norm(force.sum(axis=0)))
            arrows = (block[shown], point[shown], force[shown], float(size.max()), total)
            arrows_of.append(LoadArrows(pattern.name, k > 0, *arrows))
    return arrows_of


def applied(pattern: bs.LoadPattern, model: bs.Model, dead: bs.LoadPattern) -> tuple[Array, Array]:
    """Return points (n, 3) in m and forces (n, 3) in N of a load pattern on free blocks, without couples.

    A mass-proportional force also moves the weights of the dead load.
    """
    _, points, forces = _acting(pattern, model, dead)
    return points, forces


def _acting(pattern: bs.LoadPattern, model: bs.Model, dead: bs.LoadPattern) -> tuple[NDArray[np.int64], Array, Array]:
    """Return blocks (n,), points (n, 3) and forces (n, 3) of a load pattern on free blocks."""
    loads = bs.results.applied_loads(model, pattern, dead)
    free = np.array([not b.fixed for b in model.blocks])
    acts = free[loads.block] & loads.force.any(axis=1)
    return loads.block[acts], loads.point[acts], loads.force[acts]


def driving(result: bs.CaseResult) -> tuple[Array, Array]:
    """Return points (n, 3) in m and vectors (n, 3) of the variable load in N, or of moving supports.

    The vectors of supports are their motions. A support that turns has none: its reaction is a couple.
    """
    case = result.case
    if not isinstance(case, bs.SettlementCase):
        return applied(case.patterns[-1], result.model, case.dead)
    points = np.array([result.model.block(name).centroid for name in case.supports])
    motion = np.array(case.direction if case.about is None else (0.0, 0.0, 0.0))
    return points, np.broadcast_to(motion, points.shape)


def push(result: bs.CaseResult) -> Array:
    """Return the unit vector (3,) of the resultant of :func:`driving`; zero if its vectors cancel."""
    _, forces = driving(result)
    total = forces.sum(axis=0)
    size = float(np.linalg.norm(total))
    return total / size if size > 1e-9 * np.linalg.norm(forces, axis=1).sum() else np.zeros(3)
