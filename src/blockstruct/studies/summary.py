"""Rows of a study as a Dataset, fractiles of its load factors, shares of collapses, and first-order scatter."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from blockstruct.analysis.manager import run_again
from blockstruct.arrays import NEGLIGIBLE, Array
from blockstruct.errors import ModelError, StudyWarning, check_known, shown
from blockstruct.model import JOINT_PROPERTIES, JointMaterial, LimitCase, Model
from blockstruct.results.case_result import CaseResult
from blockstruct.results.interfaces import sliding_rates
from blockstruct.studies.design import GRID, LATIN, Design
from blockstruct.studies.plan import Problem
from blockstruct.units import si
from blockstruct.vocabulary import Flow, Stage, Status

#: Status of a case of a failed run, or of a run that another study is carrying out. It is not a status of a limit case.
FAILED, ELSEWHERE = "failed", "elsewhere"
_NONE = {"units": "dimensionless"}
_NUMBERS: Mapping[str, dict[str, str]] = {
    "load_factor": _NONE | {"long_name": "load factor α"},
    "bound": _NONE | {"long_name": "associative load factor, an upper bound of every flow rule"},
    "settled": _NONE | {"long_name": "1 if the load factor had settled when the procedure ended"},
    "flow_rule_gap": _NONE | {"long_name": "flow-rule gap of the certificate"},
    "n_iterations": _NONE | {"long_name": "programs"},
    "reaction": {"units": "newton", "long_name": "reaction of a settlement"},
    "reaction_moment": {"units": "newton * meter", "long_name": "reaction of a settlement that turns"},
    "d0": {"units": "meter", "long_name": "displacement of a pushover at which the load factor is zero"},
    "curve_end": {"units": "meter", "long_name": "displacement of the last state of a pushover"},
    "peak_displacement": {"units": "meter", "long_name": "largest displacement of a block under a record"},
    "collapse_time": {"units": "second", "long_name": "time of a record at which a block has fallen"},
    "duration": {"units": "second", "long_name": "wall-clock time of the case"},
}
_TEXTS = ("status", "flow", "reason", "procedure", "curve_ended")
#: Variables that every case of a run has.
_OF_CASE = (*_NUMBERS, *_TEXTS)
_OF_RUN = ("problem", "path", "elsewhere")
_TAKEN = {"run", "case", "missing_curve", *_OF_CASE, *_OF_RUN}
_REACTIONS = {"reaction", "reaction_moment"}
#: Numbers that only some kinds of cases have.
_OF_SOME = (*_REACTIONS, "d0", "curve_end", "peak_displacement", "collapse_time")
_COLUMNS = {"bound": "associative_load_factor"}


def check_parameter_names(names: Iterable[str]) -> None:
    """Refuse parameters with the names of variables of a study.

    Raises
    ------
    ModelError
    """
    taken = [name for name in names if name in _TAKEN]
    if taken:
        msg = (
            f"study: {'parameter' if len(taken) == 1 else 'parameters'} {', '.join(taken)}: what a study gives has "
            f"these names itself: {', '.join(sorted(_TAKEN))}; give build other ones, as {taken[0]}_of_build"
        )
        raise ModelError(msg)


def dataset_of(design: Design, rows: Sequence[Sequence[Mapping[str, Any]]], problems: Sequence[Problem]) -> xr.Dataset:
    """Return the dataset of a study.

    Parameters
    ----------
    design
        Design of its runs.
    rows
        Rows of the archive, for each run.
    problems
        Why a run has no results; false if it has results.
    """
    cases = list(dict.fromkeys(str(row["case"]) for of_run in rows for row in of_run))
    dims, shape = list(design.dims), list(design.dims.values())
    at = {case: j for j, case in enumerate(cases)}
    size = (len(rows), len(cases))
    numbers = {name: np.full(size, np.nan) for name in _NUMBERS}
    texts = {name: np.full(size, "", dtype=object) for name in _TEXTS}
    for statuses, problem in zip(texts["status"], problems, strict=True):
        if problem:
            statuses[:] = _status_of(problem.is_elsewhere)
    paths = np.array([of_run[0]["path"] if of_run else "" for of_run in rows], dtype=object)
    for i, of_run in enumerate(rows):
        for row in of_run:
            for name, values in (*numbers.items(), *texts.items()):
                values[i, at[row["case"]]] = row.get(_COLUMNS.get(name, name), values[i, at[row["case"]]])
            if not _REACTIONS.isdisjoint(row):
                # The bound of a reaction is not a load factor.
                numbers["bound"][i, at[row["case"]]] = np.nan
    along = [*dims, "case"]
    for name in _OF_SOME:
        if np.isnan(numbers[name]).all():
            del numbers[name]
    variables: dict[str, Any] = {n: (along, v.reshape(*shape, -1), _NUMBERS[n]) for n, v in numbers.items()}
    variables |= {n: (along, v.reshape(*shape, -1)) for n, v in texts.items()}
    why, elsewhere = np.array([p.text for p in problems], dtype=object), np.array([p.is_elsewhere for p in problems])
    variables["problem"] = (dims, why.reshape(shape), {"long_name": "why a run has no results"})
    variables["elsewhere"] = (dims, elsewhere.reshape(shape), {"long_name": "another study is carrying the run out"})
    variables["path"] = (dims, paths.reshape(shape), {"long_name": "file in the store"})
    coords: dict[str, Any] = {"case": np.array(cases, dtype=object)}
    if design.sampling != GRID:
        coords["run"] = np.arange(len(rows))
    for name, axis in design.axes.items():
        attrs = {"units": axis.unit} if axis.unit else {}
        coords[name] = (name if design.sampling == GRID else "run", axis.coordinate, attrs)
    for name, value in design.fixed.items():
        quantity = hasattr(value, "magnitude")
        coords[name] = ((), value.magnitude, {"units": str(value.units)}) if quantity else ((), value)
    of_all: dict[str, Any] = {"sampling": design.sampling} | ({} if design.seed is None else {"seed": design.seed})
    return xr.Dataset(variables, coords=coords, attrs=of_all)


def _status_of(is_elsewhere: bool) -> str:
    """Return the status of the cases of a run without results."""
    return ELSEWHERE if is_elsewhere else FAILED


def frame_of(data: xr.Dataset) -> pd.DataFrame:
    """Return the rows of a study as a table, one per case of each run.

    A run that failed before it had cases has one row.

    Parameters
    ----------
    data
        Dataset from :func:`blockstruct.study`.

    Returns
    -------
    pandas.DataFrame
        ``run``, the parameters, ``case``, the variables of the study. ``settled`` is false if the load factor had not
        settled when the procedure ended. ``missing_curve`` is why a pushover with a collapse state has no capacity
        curve, otherwise empty. ``attrs["units"]`` has the units.
    """
    of_case = [name for name in _OF_CASE if name in data]
    parameters = [str(name) for name in data.coords if name not in ("run", "case")]
    cases, along = data["case"].to_numpy(), data["problem"].dims
    of_run = {name: data[name].broadcast_like(data["problem"]).transpose(*along) for name in (*parameters, *_OF_RUN)}
    runs = {name: values.to_numpy().ravel() for name, values in of_run.items()}
    # If every run failed, there are no cases.
    size = (data["problem"].size, len(cases))
    columns = {name: data[name].transpose(*along, "case").to_numpy().reshape(size) for name in of_case}
    rows = []
    for k, problem in enumerate(runs["problem"]):
        held = {name: runs[name][k] for name in parameters}
        present = [j for j in range(len(cases)) if columns["status"][k, j] not in ("", FAILED, ELSEWHERE)]
        held |= {"run": k, "problem": problem, "path": runs["path"][k]}
        rows += [{**held, "case": cases[j], **{name: columns[name][k, j] for name in of_case}} for j in present]
        if not present:
            rows.append({**held, "case": "", "load_factor": np.nan, "status": _status_of(runs["elsewhere"][k])})
    table = pd.DataFrame(rows, columns=["run", *parameters, "case", *of_case, "problem", "path"])
    table["settled"] = table["settled"] == 1
    without = table["curve_end"].isna() if "curve_end" in table else np.ones(len(table), dtype=bool)
    table["missing_curve"] = [
        str(ended) if is_missing else "" for ended, is_missing in zip(table["curve_ended"], without, strict=True)
    ]
    units = {name: data[name].attrs.get("units") for name in (*parameters, *of_case)}
    table.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    return table


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
    for name in _REACTIONS:
        if name in data:
            settles |= data[name].notnull().any([dim for dim in data[name].dims if dim != "case"]).to_numpy()
    return [str(name) for name in data["case"].to_numpy()[~settles]]


def _of_case(data: xr.Dataset, fractiles: Array, confidence: float, levels: Array) -> xr.Dataset:
    from scipy.stats import binom

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
    fewest, most = (_exact_interval(k, n, confidence)[end] for end, k in enumerate((counts, counts + (~known).sum())))
    finite = alpha[converged]
    spread = float(finite.std(ddof=1)) if len(finite) > 1 else np.nan
    along = ("fractile",)
    numbers: dict[str, Any] = {
        "load_factor": (along, estimate, _NONE | {"long_name": "load factor α at the fractile"}),
        "lower": (along, ranked_low[below], _NONE | {"long_name": "lower end of the confidence interval"}),
        "upper": (along, ranked_high[above], _NONE | {"long_name": "upper end of the confidence interval"}),
        "probability": (("level",), counts / max(known.sum(), 1), _NONE),
        "probability_lower": (("level",), fewest, _NONE),
        "probability_upper": (("level",), most, _NONE),
        "mean_load_factor": ((), float(finite.mean()) if len(finite) else np.nan, _NONE),
        "standard_deviation": ((), spread, _NONE),
        "runs": ((), n),
        "unstable": ((), int(unstable.sum())),
        "unbounded": ((), int(unbounded.sum())),
        "unknown": ((), int((~known).sum())),
        "drifting": ((), int(drifting.sum())),
    }
    return xr.Dataset(numbers, coords={"fractile": ("fractile", fractiles, _NONE), "level": ("level", levels, _NONE)})


def _exact_interval(k: Array, n: Any, confidence: float) -> tuple[Array, Array]:
    """Return the exact interval of Clopper and Pearson of the share k / n."""
    from scipy.stats import beta

    tail = (1 - confidence) / 2
    with np.errstate(invalid="ignore"):
        low = np.where(k > 0, beta.ppf(tail, k, n - k + 1), 0.0)
        high = np.where(k < n, beta.ppf(1 - tail, k + 1, n - k), 1.0)
    return low, high


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
        ``peak_displacement``, m, in which a collapse counts as an infinite displacement. ``undecided`` is the number
        of records without an answer. The interval is as wide as if they could end either way; nothing else counts
        them. The attribute ``confidence`` is the argument.

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
    unknown = (counts | (status == Status.UNDECIDED)).any(axis=0) & ~counts
    n, k, u = (of_record.sum(axis=1) for of_record in (counts, falls, unknown))
    low, high = (_exact_interval(ends, n + u, confidence)[side] for side, ends in enumerate((k, k + u)))
    variables = {
        "records": (over, n, _NONE | {"long_name": "records with an answer"}),
        "collapses": (over, k, _NONE | {"long_name": "records under which the structure collapses"}),
        "share": (over, k / np.where(n > 0, n, np.nan), _NONE | {"long_name": "share of collapses"}),
        "low": (over, low, _NONE | {"long_name": f"low end of the {confidence:.0%} interval"}),
        "high": (over, high, _NONE | {"long_name": f"high end of the {confidence:.0%} interval"}),
        "undecided": (over, u, _NONE | {"long_name": "records without an answer"}),
    }
    coords = {over: data[over], "fractile": list(FRACTILES)}
    summary = xr.Dataset(variables, coords=coords, attrs={"confidence": confidence})
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


#: Relative step of the coefficients in the test for a kink, and tolerated difference of derivatives in the test.
_STEP, _SAME = 1e-4, 0.02


def first_order(result: CaseResult, standard_deviation: float | Mapping[str, float]) -> xr.Dataset:
    """Return the sensitivity of the load factor to the friction of joints.

    The result includes the first-order scatter of the load factor.

    Parameters
    ----------
    result
        Result of a converged case with associative flow.
    standard_deviation
        Standard deviation of the friction coefficients: one value, or one for each joint material by name.

    Returns
    -------
    xarray.Dataset
        Along ``interface``: ``derivative``, dα/dμ_k; ``friction_coefficient``; ``joint_material``; ``contribution``,
        the derivative times the standard deviation. Joints are in order of their contributions. Without dimension:
        ``load_factor``, and its standard deviation ``independent``, for independent coefficients of all joints, and
        ``correlated``, for equal coefficients within a joint material. The attribute ``unique`` is 1 if the derivatives
        exist.

    Warns
    -----
    StudyWarning
        If the load factor has no derivatives there. Run a study of samples instead.

    Raises
    ------
    ModelError
        If the case did not converge, or is without dilatancy, in which case multipliers are not derivatives.

    Notes
    -----
    The associative load factor is the value of a convex program. Its derivative with respect to the bound of a
    condition is the multiplier of the condition [1]_. At contact point k the condition is ``‖(s, t)‖ ≤ c A + μ n``.
    Its multiplier is the sliding velocity ``‖v_t‖`` (with ``w_L·u = 1``). Hence ``dα/dμ_k = n ‖v_t‖``, summed over the
    points of a joint. If a joint has the torsion of uniform pressure, the sliding rate of its cone is added.

    These values are derivatives if mechanism and forces are unique. If several mechanisms share a load factor, the load
    factor has a kink. An example is a wall of equal joints that slides at any course. The load factor then follows the
    weakest mechanism and falls more than any derivative predicts. Two more runs detect a kink: all coefficients a
    little higher and lower, in shares drawn at random. ``unique`` gives the outcome.

    References
    ----------
    .. [1] S. Boyd, L. Vandenberghe, Convex Optimization, Cambridge University Press 2004, section 5.6.
    """
    if not isinstance(result, CaseResult):
        msg = f"first_order: {shown(result)} is not a result; give that of a case, as analysis['push']"
        raise ModelError(msg)
    if not isinstance(result.case, LimitCase):
        msg = f"first_order: case {result.name!r} has no variable load; give the result of a LimitCase"
        raise ModelError(msg)
    if result.case.flow is not Flow.ASSOCIATIVE or result.status is not Status.CONVERGED:
        msg = (
            f"first_order: case {result.name!r} has {result.case.flow} flow and {result.status.predicate}; run it with "
            "flow='associative': its load factor is an upper bound of the other, and has derivatives"
        )
        raise ModelError(msg)
    history = result.history
    last = history.isel(iteration=int(np.flatnonzero(history["stage"].to_numpy() == Stage.ASSOCIATIVE.value)[-1]))
    normal = last["contact_force"].sel(component="n").to_numpy()
    sliding = sliding_rates(result.model, last, result.settings.crushing_cells)
    of_point = history["interface_of_contact_point"].to_numpy()
    derivative = np.bincount(of_point, normal * sliding, minlength=history.sizes["interface"])
    joints = [interface.joint_material for interface in result.model.interfaces]
    names = np.array([joint.name for joint in joints], dtype=object)
    contribution = derivative * _of_joints(standard_deviation, names)
    order = np.argsort(-np.abs(contribution), kind="stable")
    sums = [contribution[names == name].sum() for name in dict.fromkeys(names)]
    along = ("interface",)
    predicted, left, right = _kink(result, derivative)
    # If friction has no effect, as in rocking, the derivatives are rounding errors.
    same = max(_SAME * float(np.abs(derivative).sum()), NEGLIGIBLE * abs(result.load_factor))
    unique = max(abs(left - predicted), abs(right - predicted)) <= same
    if not unique:
        msg = (
            f"first_order: case {result.name!r} has no derivatives with respect to friction: several mechanisms or "
            f"force states have its load factor (together, {left:.3g} downwards and {right:.3g} upwards, where the "
            f"multipliers say {predicted:.3g}); run a study with samples of the friction of each joint instead"
        )
        warnings.warn(msg, StudyWarning, stacklevel=2)
    columns: dict[str, Any] = {
        "derivative": (along, derivative, _NONE | {"long_name": "dα/dμ"}),
        "friction_coefficient": (along, [joint.friction_coefficient for joint in joints], _NONE),
        "joint_material": (along, names),
        "contribution": (along, contribution, _NONE | {"long_name": "dα/dμ times the standard deviation of μ"}),
    }
    scalars: dict[str, Any] = {
        "load_factor": ((), result.load_factor, _NONE),
        "independent": ((), float(np.linalg.norm(contribution)), _NONE),
        "correlated": ((), float(np.linalg.norm(sums)), _NONE),
    }
    coords = {"interface": history["interface"].to_numpy()}
    table = xr.Dataset(columns, coords=coords).isel(interface=order)
    return table.assign(scalars).assign_attrs(case=result.name, unique=int(unique))


def _kink(result: CaseResult, derivative: Any) -> tuple[float, float, float]:
    """Return the derivative in one direction of all coefficients.

    Three values: by the multipliers, and one-sided downwards and upwards.
    """
    interfaces = result.model.interfaces
    mu = np.array([interface.joint_material.friction_coefficient for interface in interfaces])
    # Joints that never slide keep their coefficients.
    share = np.random.default_rng(0).uniform(0.5, 1.5, len(mu)) * np.where(np.isinf(mu), 0.0, mu)

    def load_factor(step: float) -> float:
        changed = []
        for k, interface in enumerate(interfaces):
            values = {name: getattr(interface.joint_material, name) for name in JOINT_PROPERTIES}
            # Dilatancy has no effect in associative flow, and may not exceed the friction angle.
            values |= {"friction_coefficient": mu[k] + step * share[k], "dilatancy_angle": 0.0}
            if 0 < mu[k] < np.inf:
                # Tensile strength may not exceed the tension at the apex of the friction cone.
                most = values["cohesion"] / values["friction_coefficient"]
                values["tensile_strength"] = min(values["tensile_strength"], most)
            joint = JointMaterial.from_si(f"{k}", values, torsion=interface.joint_material.torsion)
            changed.append(interface.with_joint_material(joint))
        model = Model(result.model.name, result.model.blocks, changed, ties=result.model.ties)
        return run_again(result, model).load_factor

    left, right = ((load_factor(step) - result.load_factor) / step for step in (-_STEP, _STEP))
    return float(derivative @ share), left, right


def _of_joints(given: Any, names: Any) -> Any:
    """Return the standard deviation of each joint."""
    if not isinstance(given, Mapping):
        given = dict.fromkeys(names, given)
    for name in given:
        check_known(name, sorted(set(names)), "first_order: no joint material")
    deviations = {n: si(v, "dimensionless", f"first_order: standard deviation of {n!r}") for n, v in given.items()}
    for name, value in deviations.items():
        if value < 0:
            msg = f"first_order: standard deviation {value:g} of {name!r}; give zero or more"
            raise ModelError(msg)
    return np.array([deviations.get(name, 0.0) for name in names])
