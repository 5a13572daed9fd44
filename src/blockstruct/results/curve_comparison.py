"""Comparison of two capacity curves."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Difference of load factors, relative to the largest of both curves, from which two curves count as different.
APART = 1e-2


def compared_curves(one: xr.Dataset | None, other: xr.Dataset | None) -> dict[str, Any]:
    """Compare two capacity curves; return the values of one row.

    Returns
    -------
    dict
        ``d0`` (m, NaN without one) of each curve, with the suffix ``_other`` for the second.

        ``curve_difference`` is the larger of two differences. One is the largest difference of load factors at the same
        displacement, relative to the largest load factor of both. The other is the difference of the final
        displacements, relative to the larger one. It is 0 if neither is a pushover. It is infinite if only one is a
        pushover, or only one curve reaches zero.

        ``curves_part_at`` (m) is the first displacement at which the load factors differ by more than 1 % of the
        largest; NaN if they do not.
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
    """Return the path length of the control point, m, and load factors.

    The length adds motions to and fro along the direction of the point.
    """
    displacement, alpha = (curve[name].transpose("step").to_numpy() for name in ("displacement", "load_factor"))
    return np.abs(np.diff(displacement, prepend=displacement[0])).cumsum(), alpha
