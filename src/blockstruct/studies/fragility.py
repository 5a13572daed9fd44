"""Shares of records under which a structure collapses."""

import numpy as np
import xarray as xr

from blockstruct.errors import ModelError, shown
from blockstruct.vocabulary import Status

#: Fractiles of the peak displacement.
FRACTILES = (0.16, 0.5, 0.84)


def fragility(data: xr.Dataset, over: str = "scale", *, confidence: float = 0.95) -> xr.Dataset:
    """Return the share of records under which a structure collapses, over a parameter such as a scale factor.

    Parameters
    ----------
    data
        Dataset of a study of :class:`~blockstruct.RecordCase`.
    over
        Parameter of the study. All other parameters and cases are counted together.
    confidence
        Probability that the interval of each share holds the true one: the exact interval of C. J. Clopper and
        E. S. Pearson (1934), Biometrika 26(4), for independent records.

    Returns
    -------
    xarray.Dataset
        Over the parameter: ``records``, the number of records that the structure stands or collapses under;
        ``collapses``, the number of the latter; ``share``; ``low`` and ``high``, its interval; and over ``fractile``
        ``peak_displacement``, m, in which a collapse counts as an infinite displacement. Runs that failed or are
        undecided do not count.

    Raises
    ------
    ModelError
        If the study does not have the parameter, or no record.

    Examples
    --------
    >>> status = xr.DataArray([["stands", "stands"], ["stands", "collapses"]], dims=["scale", "case"])
    >>> data = xr.Dataset({"status": status}, coords={"scale": [1.0, 2.0]})
    >>> found = fragility(data)
    >>> found.share.values.tolist(), found.low.round(3).values.tolist(), found.high.round(3).values.tolist()
    ([0.0, 0.5], [0.0, 0.013], [0.842, 0.987])
    """
    from scipy.stats import beta

    if over not in data["status"].dims:
        msg = f"fragility: the study has no parameter {shown(over)}; it has {', '.join(map(str, data['status'].dims))}"
        raise ModelError(msg)
    if not 0 < confidence < 1:
        msg = f"fragility: confidence {shown(confidence)}; give a probability between 0 and 1"
        raise ModelError(msg)
    rest = [dim for dim in data["status"].dims if dim != over]
    status = data["status"].transpose(over, *rest).to_numpy().reshape(data.sizes[over], -1)
    falls = status == Status.COLLAPSES
    counts = falls | (status == Status.STANDS)
    if not counts.any():
        msg = "fragility: no case of the study is a record with an answer; give a study of RecordCase"
        raise ModelError(msg)
    n, k = counts.sum(axis=1), falls.sum(axis=1)
    tail = (1 - confidence) / 2
    with np.errstate(invalid="ignore"):
        low = np.where(k > 0, beta.ppf(tail, k, n - k + 1), 0.0)
        high = np.where(k < n, beta.ppf(1 - tail, k + 1, n - k), 1.0)
    plain = {"units": "dimensionless"}
    variables = {
        "records": (over, n, plain | {"long_name": "records with an answer"}),
        "collapses": (over, k, plain | {"long_name": "records under which the structure collapses"}),
        "share": (over, k / np.where(n > 0, n, np.nan), plain | {"long_name": "share of collapses"}),
        "low": (over, np.where(n > 0, low, 0.0), plain | {"long_name": f"low end of the {confidence:.0%} interval"}),
        "high": (over, np.where(n > 0, high, 1.0), plain | {"long_name": f"high end of the {confidence:.0%} interval"}),
    }
    found = xr.Dataset(variables, coords={over: data[over], "fractile": list(FRACTILES)})
    if "peak_displacement" in data:
        peak = data["peak_displacement"].transpose(over, *rest).to_numpy().reshape(data.sizes[over], -1)
        peak = np.where(falls, np.inf, np.where(counts, peak, np.nan))
        rows = [
            np.quantile(row[~np.isnan(row)], FRACTILES, method="inverted_cdf")
            if (~np.isnan(row)).any()
            else [np.nan] * 3
            for row in peak
        ]
        attrs = {"units": "meter", "long_name": "fractiles of the peak displacement, infinite where more collapse"}
        found["peak_displacement"] = ((over, "fractile"), np.array(rows), attrs)
    return found
