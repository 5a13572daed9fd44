"""Join contact areas that faceted faces divide into pieces."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.geometry.coplanar import FacePair
from blockstruct.geometry.polygon import plane_axes, uncrossed
from blockstruct.geometry.tolerances import SNAP

Array = NDArray[np.float64]


def joined_pairs(pairs: Sequence[FacePair], gap: float, angle: float, rounding: float) -> list[FacePair]:
    """Join face pairs of the same bodies that lie in one plane and touch.

    Pieces lie in one plane if their normals are within the angle of the mean normal, and their corners within the gap
    of the mean plane. Pieces around a hole stay separate, because an interface has no holes.

    Parameters
    ----------
    pairs
        In the order of :func:`coplanar_face_pairs`.
    gap, angle, rounding
        Tolerances of the detection; angle in radians.
    """
    joined: list[FacePair] = []
    of_bodies: dict[frozenset[int], list[FacePair]] = {}
    for pair in pairs:
        of_bodies.setdefault(frozenset((pair.minus, pair.plus)), []).append(pair)
    for rest in of_bodies.values():
        while len(rest) > 1:
            in_plane = _in_one_plane(rest, rest, gap, angle)
            if not in_plane.all():
                in_plane = _in_one_plane(rest, [max(rest, key=lambda p: p.area)], gap, angle)
            joined += _whole([p for p, fits in zip(rest, in_plane, strict=True) if fits], gap, rounding)
            rest = [p for p, fits in zip(rest, in_plane, strict=True) if not fits]
        joined += rest
    joined.sort(key=lambda p: (p.minus, p.plus, *p.polygon[0]))
    return joined


def _plane(pieces: Sequence[FacePair]) -> tuple[Array, Array]:
    """Return the middle (3,) and the unit normal (3,) of pieces, weighted by their areas."""
    weight = np.array([p.area for p in pieces])
    normal = weight @ _normals(pieces, pieces[int(np.argmax(weight))])
    middle = weight @ np.array([p.polygon.mean(axis=0) for p in pieces]) / weight.sum()
    return middle, normal / np.linalg.norm(normal)


def _normals(pieces: Sequence[FacePair], like: FacePair) -> Array:
    """Return the normals (m, 3) towards the plus side of one piece; in a rough vertical joint the sides may differ."""
    return np.array([p.normal if p.minus == like.minus else -p.normal for p in pieces])


def _in_one_plane(
    pieces: Sequence[FacePair], reference: Sequence[FacePair], gap: float, angle: float
) -> NDArray[np.bool_]:
    """Return which pieces lie in the mean plane of a reference. A single reference piece always does."""
    middle, normal = _plane(reference)
    normals = _normals(pieces, max(reference, key=lambda p: p.area))
    tilt = 2 * np.arcsin(np.minimum(np.linalg.norm(normals - normal, axis=1) / 2, 1.0))
    off = np.array([np.abs((p.polygon - middle) @ normal).max() for p in pieces])
    is_reference = np.array([len(reference) == 1 and p is reference[0] for p in pieces])
    return np.asarray(((tilt <= angle) & (off <= gap)) | is_reference)


def _whole(pieces: list[FacePair], gap: float, rounding: float) -> list[FacePair]:
    if len(pieces) == 1:
        return pieces
    middle, normal = _plane(pieces)
    axes = np.stack(plane_axes(normal))
    outlines = uncrossed(np.array([shapely.Polygon((p.polygon - middle) @ axes.T) for p in pieces]))
    union = shapely.union_all(outlines, grid_size=SNAP * rounding)
    pieced = union
    if _has_holes(union) or len(shapely.get_parts(union)) > 1:
        # Close slits between pieces of a rough face that are no wider than the gap.
        closed = shapely.buffer(union, gap, join_style="mitre", mitre_limit=20)
        union = shapely.buffer(closed, -gap, join_style="mitre", mitre_limit=20)
    parts = shapely.get_parts(uncrossed(shapely.get_parts(shapely.simplify(shapely.normalize(union), rounding))))
    parts = parts[(shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & ~shapely.is_empty(parts)]
    # Closed slits may leave corners outside all pieces.
    parts = parts[shapely.area(shapely.intersection(parts, pieced)) > 0.5 * shapely.area(parts)]
    if _has_holes(union) or not 0 < len(parts) < len(pieces):
        return pieces
    largest = max(pieces, key=lambda p: p.area)
    return [
        FacePair(
            largest.minus,
            largest.plus,
            middle + shapely.get_coordinates(part)[:-1] @ axes,
            normal,
            float(part.area),
            max((p.gap for p in pieces), key=abs),
            min(p.closest for p in pieces),
            max(p.angle for p in pieces),
        )
        for part in shapely.orient_polygons(parts)
    ]


def _has_holes(shape: shapely.Geometry) -> bool:
    return bool(shapely.get_num_interior_rings(shapely.get_parts(shape)).any())
