"""Two capacity curves side by side."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Difference of load factors, relative to the largest of both curves, from which on two curves are told apart.
APART = 1e-2


def compared_curves(one: xr.Dataset | None, other: xr.Dataset | None) -> dict[str, Any]:
    """What two pushovers have in common, as values of one row.

    Returns
    -------
    dict
        ``d0`` (m, NaN without one) of each, with ``_other`` for the other one's;
        ``curve_difference``, the largest of two: of the difference of load factors at the same displacement, relative
        to the largest of both, and of that of the displacements at which they end, relative to the further one; 0
        where neither is a pushover, infinite where one is, or one alone comes down to zero; ``curves_part_at`` (m), the
        first displacement at which the load factors differ by more than 1 % of the largest, NaN where they do not.
    """
    row: dict[str, Any] = {}
    for curve, suffix in ((one, ""), (other, "_other")):
        row[f"d0{suffix}"] = np.nan if curve is None else float(curve["d0"])
    if one is None or other is None:
        return row | {"curve_difference": 0.0 if one is other else np.inf, "curves_part_at": np.nan}
    (way, alpha), (way_other, alpha_other) = _along(one), _along(other)
    common = np.union1d(way, way_other)
    common = common[common <= min(way[-1], way_other[-1])]
    largest = max(np.abs(alpha).max(), np.abs(alpha_other).max(), np.finfo(float).tiny)
    apart = np.abs(np.interp(common, way, alpha) - np.interp(common, way_other, alpha_other)) / largest
    parted = common[apart > APART]
    row["curves_part_at"] = float(np.interp(parted[0], way, one["displacement"])) if len(parted) else np.nan
    ends = [row[name] if np.isfinite(row[name]) else way_[-1] for name, way_ in (("d0", way), ("d0_other", way_other))]
    furthest = max(np.abs(ends).max(), np.finfo(float).tiny)
    both = np.isfinite(row["d0"]) == np.isfinite(row["d0_other"])
    row["curve_difference"] = float(max(apart.max(), abs(ends[0] - ends[1]) / furthest)) if both else np.inf
    return row


def _along(curve: xr.Dataset) -> tuple[Array, Array]:
    """Way of the control point along its direction, to and fro, m, and load factors."""
    displacement, alpha = (curve[name].transpose("step").to_numpy() for name in ("displacement", "load_factor"))
    return np.abs(np.diff(displacement, prepend=displacement[0])).cumsum(), alpha
