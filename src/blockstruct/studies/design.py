"""The runs of a study: grids, paired lists, samples of distributions."""

import hashlib
import itertools
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import DimensionError, ModelError, shown
from blockstruct.results import checked_parameters, checked_value, plain_value, stored_value
from blockstruct.units import Q_

GRID, PAIRED, LATIN, MONTE_CARLO = "grid", "paired", "latin hypercube", "monte carlo"
#: Largest number of runs of a study; more are taken as a mistake.
MOST_RUNS = 100_000


@dataclass(frozen=True, slots=True)
class Run:
    """One run: the values of all parameters, and the name of its file.

    Attributes
    ----------
    values : dict
        Numbers, texts and quantities by parameter.
    name : str
        Name of the file without suffix. It depends on the values alone.
    """

    values: dict[str, Any]
    name: str

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> "Run":
        """Return the run of values.

        The name uses coherent SI units: 4 MPa and 4000 kPa give the same name.
        """
        plain = {name: plain_value(value) for name, value in values.items()}
        digest = hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()
        return cls(dict(values), f"run-{digest[:12]}")

    @property
    def stored(self) -> dict[str, Any]:
        """Return the values as JSON stores them and as a worker receives them.

        Quantities belong to one process and cannot be sent.
        """
        return {name: stored_value(value) for name, value in self.values.items()}


@dataclass(frozen=True, slots=True)
class Axis:
    """Values of a parameter: along its own dimension, or in every run.

    Attributes
    ----------
    values : tuple
        Values as ``build`` receives them.
    coordinate : array
        Numbers in the unit of the first value, NaN for None; or texts, truth values.
    unit : str
        Long name of the unit; empty without one.
    """

    values: tuple[Any, ...]
    coordinate: NDArray[Any]
    unit: str


@dataclass(frozen=True, slots=True)
class Design:
    """The runs of a study and their layout.

    Attributes
    ----------
    sampling : str
    axes : dict of str to Axis
        Axes of the varied parameters: one dimension each in a grid, otherwise along ``run``.
    fixed : dict
        Values that all runs share.
    runs : list of Run
        In order, the last axis varying fastest.
    seed : int or None
        Seed of the samples.
    """

    sampling: str
    axes: dict[str, Axis]
    fixed: dict[str, Any]
    runs: list[Run]
    seed: int | None

    @property
    def dims(self) -> dict[str, int]:
        """Dimensions of the runs, with their sizes."""
        if self.sampling == GRID:
            return {name: len(axis.values) for name, axis in self.axes.items()}
        return {"run": len(self.runs)}


def design_of(parameters: Mapping[str, Any], sampling: str | None, runs: int | None, seed: int) -> Design:
    """Return the design of a study.

    Parameters
    ----------
    parameters
        By name: a list of values, a frozen distribution of scipy.stats (with a unit as ``Q_(distribution, "MPa")``), or
        one value for all runs.
    sampling
        ``"grid"`` or ``"paired"`` for lists, ``"monte carlo"`` or ``"latin hypercube"`` for distributions; None selects
        the first.
    runs
        Number of samples.
    seed
        Seed of the samples: the same seed gives the same samples.

    Raises
    ------
    ModelError
        If the parameters give no runs.
    UnitError, DimensionError
        If the values of one parameter have several dimensions, or only some of them have a unit.
    """
    if not isinstance(parameters, Mapping) or not parameters:
        msg = f"study: parameters are {shown(parameters)}; give a mapping of names to values, lists or distributions"
        raise ModelError(msg)
    drawn = {name: value for name, value in parameters.items() if _is_distribution(value)}
    listed = {name: value for name, value in parameters.items() if name not in drawn and _is_list(value)}
    rest = {name: value for name, value in parameters.items() if name not in drawn and name not in listed}
    fixed = checked_parameters(rest, "study")
    checked_parameters(dict.fromkeys(parameters), "study")
    if drawn and listed:
        msg = (
            f"study: {', '.join(listed)} {'is a list' if len(listed) == 1 else 'are lists'}, {', '.join(drawn)} drawn "
            "from a distribution; give one value to what stays the same, and run a study for each other value"
        )
        raise ModelError(msg)
    kinds = (MONTE_CARLO, LATIN) if drawn else (GRID, PAIRED)
    how = kinds[0] if sampling is None else sampling
    if how not in kinds:
        what = "distributions" if drawn else "lists and values"
        msg = f"study: sampling {shown(sampling)} of {what}; give {' or '.join(map(repr, kinds))}"
        raise ModelError(msg)
    if drawn:
        axes = _samples(drawn, how, _count(runs), seed)
        points: Iterable[Sequence[Any]] = zip(*(axis.values for axis in axes.values()), strict=True)
    else:
        if runs is not None:
            msg = f"study: runs={shown(runs)} is for distributions; lists have as many runs as values"
            raise ModelError(msg)
        axes = {name: _axis(name, values) for name, values in listed.items()}
        points = _points(axes, how)
    found = [Run.of({**dict(zip(axes, point, strict=True)), **fixed}) for point in points]
    return Design(how, axes, fixed, found, seed if drawn else None)


def _points(axes: Mapping[str, Axis], how: str) -> Iterator[Sequence[Any]]:
    sizes = {name: len(axis.values) for name, axis in axes.items()}
    if how == PAIRED and len(set(sizes.values())) > 1:
        counts = ", ".join(f"{name} {n}" for name, n in sizes.items())
        msg = f"study: lists side by side have different lengths: {counts}; give as many values of each, or a grid"
        raise ModelError(msg)
    count = int(np.prod(list(sizes.values()), dtype=float)) if how == GRID else max(sizes.values(), default=1)
    if count > MOST_RUNS:
        msg = f"study: a grid of {count:,} runs, more than {MOST_RUNS:,}; give shorter lists, or distributions"
        raise ModelError(msg)
    values = [axis.values for axis in axes.values()]
    return itertools.product(*values) if how == GRID else zip(*values, strict=True)


def _axis(name: str, given: Any) -> Axis:
    values = tuple(checked_value(value, f"study: {name}") for value in given)
    if not values:
        msg = f"study: {name} has no value; give at least one"
        raise ModelError(msg)
    coordinate, unit = _coordinate(name, values)
    return Axis(values, coordinate, unit)


def _coordinate(name: str, values: Sequence[Any]) -> tuple[NDArray[Any], str]:
    """Return values as an array in their first unit, and the unit.

    None becomes NaN.
    """
    some = [value for value in values if value is not None]
    kinds = {"quantity" if hasattr(v, "magnitude") else "text" if isinstance(v, str | bool) else "number" for v in some}
    if len(kinds) > 1:
        msg = f"study: {name} mixes a {' and a '.join(sorted(kinds))}; give all its values with a unit, or none"
        raise DimensionError(msg)
    if kinds == {"text"} or not kinds:
        return np.array(values, dtype=object), ""
    if kinds == {"number"}:
        return np.array([np.nan if v is None else v for v in values]), "dimensionless"
    unit = str(some[0].units)
    dimension = plain_value(some[0])[1]
    for value in some:
        if plain_value(value)[1] != dimension:
            msg = f"study: {name}: {value} is not a {dimension} as {some[0]} is; give values of one dimension"
            raise DimensionError(msg)
    # Values given in that unit are not converted.
    magnitudes = [
        np.nan if v is None else v.magnitude if str(v.units) == unit else v.to(unit).magnitude for v in values
    ]
    return np.array(magnitudes, dtype=float), unit


def _samples(drawn: Mapping[str, Any], how: str, count: int, seed: Any) -> dict[str, Axis]:
    """Return samples by the inverse distribution functions."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        msg = f"study: seed is {shown(seed)}; give a whole number, the same one for the same samples"
        raise ModelError(msg)
    generator = np.random.default_rng(int(seed))
    if how == LATIN:
        from scipy.stats import qmc

        cube = qmc.LatinHypercube(len(drawn), seed=generator).random(count)
    else:
        # One row per run: more runs with the same seed begin with the same samples.
        cube = generator.random((count, len(drawn)))
    axes = {}
    for (name, given), column in zip(drawn.items(), cube.T, strict=True):
        distribution, unit = (given.magnitude, str(given.units)) if hasattr(given, "magnitude") else (given, "")
        numbers = np.asarray(distribution.ppf(column), dtype=float)
        if not np.isfinite(numbers).all():
            msg = f"study: {name}: its distribution gives {numbers[~np.isfinite(numbers)][0]}; check its parameters"
            raise ModelError(msg)
        values = [Q_(float(v), unit) if unit else float(v) for v in numbers]
        axes[name] = _axis(name, values)
    return axes


def _count(runs: Any) -> int:
    if isinstance(runs, bool) or not isinstance(runs, int | np.integer) or not 1 <= runs <= MOST_RUNS:
        msg = f"study: runs={shown(runs)}; give the number of samples of the distributions, 1 to {MOST_RUNS:,}"
        raise ModelError(msg)
    return int(runs)


def _is_distribution(value: Any) -> bool:
    return callable(getattr(getattr(value, "magnitude", value), "ppf", None))


def _is_list(value: Any) -> bool:
    if isinstance(value, str | bytes | Mapping):
        return False
    if hasattr(value, "magnitude"):
        return bool(np.ndim(value.magnitude))
    return np.iterable(value)
