"""Distributions of load factors, and shares of records under which a structure collapses."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.errors import ModelError, shown
from blockstruct.studies.design import LATIN
from blockstruct.vocabulary import Status

Array = NDArray[np.float64]
_NONE = {"units": "dimensionless"}


def summary(
    data: xr.Dataset,
    *,
    fractiles: Sequence[float] = (0.05, 0.5, 0.95),
    confidence: float = 0.9,
    below: Sequence[float] = (),
) -> xr.Dataset:
    """Return fractiles of the load factor with confidence intervals.

    They assume no distribution of the load factor.

    Parameters
    ----------
    data
        A study of distributions, or of paired samples.
    fractiles
        Probabilities of a lower load factor.
    confidence
        Least probability that an interval contains the true value; it holds exactly for independent samples.
    below
        Load factors whose probability of a lower value is required.

    Returns
    -------
    xarray.Dataset
        Along ``case`` and ``fractile``: ``load_factor``, ``lower`` and ``upper``. These are order statistics, infinite
        if there are too few runs.

        Along ``case`` and ``level``: ``probability``, ``probability_lower`` and ``probability_upper``
        (Clopper–Pearson).

        Along ``case``: ``mean_load_factor`` and ``standard_deviation`` of the finite load factors, and numbers of runs:

        - ``runs``: all runs;
        - ``unstable``: unstable under their dead load; the load factor counts as −∞;
        - ``unbounded``: the load factor counts as +∞;
        - ``unknown``: failed, not converged, or dependent on self-stress. They are left out of every estimate. Every
          interval is as wide as if their load factors could have any value;
        - ``drifting``: stopped while drifting; they count with their last load factor.

        Settlements are left out, because they have reactions instead of load factors.

    Raises
    ------
    ModelError
        If the study is a grid, has only settlements or only failed runs, or a probability is not between 0 and 1.

    Notes
    -----
    Of n independent samples, the number below the p-fractile has a binomial distribution. The order statistics of the
    ranks ``binom.ppf((1 ∓ γ)/2, n, p)`` therefore enclose the fractile with a probability of γ or more. The points of a
    Latin hypercube are not independent. Its estimates usually scatter less, and the intervals are not exact, as
    ``exact`` states.
    """
    if "run" not in data.dims or "load_factor" not in data:
        over = ", ".join(map(str, data.dims)) or "nothing"
        msg = f"summary: data along {over} are not samples; give a study of distributions"
        raise ModelError(msg)
    if not data.sizes["case"]:
        n = data.sizes["run"]
        failed = "the only run failed" if n == 1 else f"all {n} runs failed, the first one"
        msg = (
            f"summary: {failed}: {data['problem'].to_numpy()[0]}; mend what "
            "data.problem tells of each, and run the study again"
        )
        raise ModelError(msg)
    names = cases_with_load_factors(data)
    if not names:
        of_them = "reaction" if "reaction" in data else "reaction_moment"
        named = ", ".join(map(str, data["case"].to_numpy()))
        msg = (
            f"summary: {named}: settlements have no load factors; take the fractiles of their reactions, "
            f"data.{of_them}.quantile(…, dim='run')"
        )
        raise ModelError(msg)
    data = data.sel(case=names)
    wanted, levels = _probabilities(fractiles, "fractiles"), np.asarray(below, dtype=float)
    (gamma,) = _probabilities([confidence], "confidence")
    columns = [_of_case(data.sel(case=case), wanted, float(gamma), levels) for case in data["case"].to_numpy()]
    held = xr.concat(columns, dim="case")
    held["case"] = data["case"]
    exact = data.attrs.get("sampling") != LATIN
    return held.assign_attrs(confidence=float(gamma), sampling=data.attrs.get("sampling", ""), exact=int(exact))


def cases_with_load_factors(data: xr.Dataset) -> list[str]:
    """Return the names of the cases of a study that are not settlements.

    The answers of settlements are reactions.
    """
    settles = np.zeros(data.sizes["case"], dtype=bool)
    for name in ("reaction", "reaction_moment"):
        if name in data:
            settles |= data[name].notnull().any([dim for dim in data[name].dims if dim != "case"]).to_numpy()
    return [str(name) for name in data["case"].to_numpy()[~settles]]


def _of_case(data: xr.Dataset, fractiles: Array, confidence: float, levels: Array) -> xr.Dataset:
    from scipy.stats import binom, binomtest

    status, alpha = data["status"].to_numpy(), data["load_factor"].to_numpy()
    unstable, unbounded = status == Status.UNSTABLE, status == Status.UNBOUNDED
    converged = status == Status.CONVERGED
    # A table made by hand may not contain ``settled``.
    settled = data["settled"].to_numpy() != 0 if "settled" in data else converged
    drifting = converged & ~settled
    values = np.where(unstable, -np.inf, np.where(unbounded, np.inf, alpha))
    known = unstable | unbounded | converged
    n, tail = len(values), (1 - confidence) / 2
    lowest = np.sort(np.where(known, values, -np.inf))
    highest = np.sort(np.where(known, values, np.inf))
    # Ranks beyond either end need more runs than there are.
    ranked_low, ranked_high = np.concatenate([[-np.inf], lowest]), np.concatenate([highest, [np.inf]])
    below, above = (np.asarray(binom.ppf(q, n, fractiles)).astype(int) for q in (tail, 1 - tail))
    certain = np.sort(values[known])
    at = np.maximum(np.ceil(fractiles * len(certain)).astype(int), 1) - 1
    estimate = certain[at] if len(certain) else np.full(len(fractiles), np.nan)

    counts = np.array([np.sum(certain < level) for level in levels], dtype=float)
    fewest = [binomtest(int(k), n).proportion_ci(confidence, method="exact").low for k in counts]
    most = [binomtest(int(k + (~known).sum()), n).proportion_ci(confidence, method="exact").high for k in counts]
    finite = alpha[converged]
    spread = float(finite.std(ddof=1)) if len(finite) > 1 else np.nan
    along = ("fractile",)
    numbers: dict[str, Any] = {
        "load_factor": (along, estimate, _NONE | {"long_name": "load factor α at the fractile"}),
        "lower": (along, ranked_low[below], _NONE | {"long_name": "lower end of the confidence interval"}),
        "upper": (along, ranked_high[above], _NONE | {"long_name": "upper end of the confidence interval"}),
        "probability": (("level",), counts / max(known.sum(), 1), _NONE),
        "probability_lower": (("level",), np.array(fewest, dtype=float), _NONE),
        "probability_upper": (("level",), np.array(most, dtype=float), _NONE),
        "mean_load_factor": ((), float(finite.mean()) if len(finite) else np.nan, _NONE),
        "standard_deviation": ((), spread, _NONE),
        "runs": ((), n),
        "unstable": ((), int(unstable.sum())),
        "unbounded": ((), int(unbounded.sum())),
        "unknown": ((), int((~known).sum())),
        "drifting": ((), int(drifting.sum())),
    }
    return xr.Dataset(numbers, coords={"fractile": ("fractile", fractiles, _NONE), "level": ("level", levels, _NONE)})


def _probabilities(values: Sequence[float], what: str) -> Array:
    shares = np.asarray(values, dtype=float)
    if shares.ndim != 1 or not len(shares) or not ((shares > 0) & (shares < 1)).all():
        msg = f"summary: {what} {shown(values)}; give numbers between 0 and 1, as 0.05"
        raise ModelError(msg)
    return shares


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
    summary = xr.Dataset(variables, coords={over: data[over], "fractile": list(FRACTILES)})
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
        summary["peak_displacement"] = ((over, "fractile"), np.array(rows), attrs)
    return summary
