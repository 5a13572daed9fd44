"""Cut courses of walls at rings of voussoirs, at the slopes of a gable and at a batter."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.geometry.tolerances import ROUNDING

Array = NDArray[np.float64]


def cut(region: Any, joints: Sequence[float], smallest: float) -> list[Array]:
    """Return the outlines (k, 2) of the pieces between vertical joints of a region, in the order of their centroids.

    A joint is dropped if a piece next to it would be smaller than the ``smallest`` area or not connected. A separate
    part of the region stays a piece even if it is smaller.

    Raises
    ------
    ModelError
        If a hole of the region lies within one piece.
    """
    outlines = []
    for part in shapely.get_parts(region):
        if part.area <= ROUNDING * smallest:
            continue
        low, foot, high, top = part.bounds
        lines = [low, *sorted(x for x in joints if low + ROUNDING < x < high - ROUNDING), high]
        while True:
            pieces = [shapely.intersection(part, shapely.box(a, foot, b, top)) for a, b in pairwise(lines)]
            bad = [k for k, piece in enumerate(pieces) if piece.area < smallest or not _is_whole(piece)]
            if not bad or len(lines) == 2:
                break
            k = bad[0]
            neighbours = [(pieces[j].area, line) for j, line in ((k - 1, k), (k + 1, k + 1)) if 0 <= j < len(pieces)]
            del lines[min(neighbours)[1]]
        if not all(map(_is_whole, pieces)):
            msg = (
                f"wall: between {low:.6g} and {high:.6g} m along the wall a ring of voussoirs lies within one unit of "
                f"the course from {foot:.6g} to {top:.6g} m; give lower courses, or a larger opening"
            )
            raise ModelError(msg)
        outlines += pieces
    outlines.sort(key=lambda piece: piece.centroid.x)
    return [clean(shapely.get_coordinates(piece)[:-1]) for piece in outlines]


def clean(outline: Array) -> Array:
    """Return the outline without repeated corners and without corners on a line with their neighbours."""
    size = float(np.ptp(outline, axis=0).max())
    kept = list(outline)
    k = 0
    while len(kept) > 3 and k < len(kept):
        before, here, after = kept[k - 1], kept[k], kept[(k + 1) % len(kept)]
        base = after - before
        off = (here - before)[0] * base[1] - (here - before)[1] * base[0]
        if np.linalg.norm(here - before) < ROUNDING * size or abs(off) < ROUNDING * size * np.linalg.norm(base):
            del kept[k]
            k = max(k - 1, 0)
        else:
            k += 1
    return np.array(kept)


def _is_whole(piece: Any) -> bool:
    return piece.geom_type == "Polygon" and not len(piece.interiors)
