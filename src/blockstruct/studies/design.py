"""Designs of studies: the parameters of every run, and study documents."""

import contextlib
import copy
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.documents import document_of, read_content
from blockstruct.errors import (
    BlockstructError,
    DimensionError,
    DocumentError,
    ModelError,
    UnknownNameError,
    did_you_mean,
    shown,
)
from blockstruct.files import MOST_READ
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import Case, Model
from blockstruct.results.analysis import checked_parameters, checked_value, plain_value
from blockstruct.studies.plan import Run
from blockstruct.units import Q_, SI_UNITS, parse

GRID, PAIRED, LATIN, MONTE_CARLO = "grid", "paired", "latin hypercube", "monte carlo"


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
    if count > MOST_READ:
        msg = f"study: a grid of {count:,} runs, more than {MOST_READ:,}; give shorter lists, or distributions"
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
    if isinstance(runs, bool) or not isinstance(runs, int | np.integer) or not 1 <= runs <= MOST_READ:
        msg = f"study: runs={shown(runs)}; give the number of samples of the distributions, 1 to {MOST_READ:,}"
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


@dataclass(frozen=True, slots=True)
class DocumentBuild:
    """Builds the model of a document with some values replaced.

    Attributes
    ----------
    content : dict
        Content of the model document.
    name : str
        Name of the model if the document has none.
    """

    content: dict[str, Any]
    name: str

    def __call__(self, **values: Any) -> tuple[Model, list[Case]]:
        """Return the model and cases with new values at dotted paths.

        Raises
        ------
        DocumentError
            If the document cannot hold these values.
        """
        content = copy.deepcopy(self.content)
        for path, value in values.items():
            holder, key = _place(content, path)
            # Write a quantity as a document does.
            holder[key] = f"{value.magnitude!r} {value.units}" if hasattr(value, "magnitude") else value
        document = document_of(content, self.name)
        return document.model, list(document.cases)


@dataclass(frozen=True, slots=True)
class StudyDocument:
    """Content of a study document, as :func:`blockstruct.study` takes it.

    Attributes
    ----------
    build : DocumentBuild
    parameters : dict
        Parameters by dotted path.
    options : dict
        ``sampling``, ``runs``, ``seed``, ``spread``.
    settings : ProcedureSettings
        Settings of the model document.
    """

    build: DocumentBuild
    parameters: dict[str, Any]
    options: dict[str, Any]
    settings: ProcedureSettings


def read_study(path: str | Path) -> StudyDocument:
    """Read a study document.

    Parameters
    ----------
    path
        A ``.yaml``, ``.yml`` or ``.json`` file that follows ``schemas/study-1.json``.

    Raises
    ------
    StorageError
        If the document, or the model document that it names, cannot be read.
    DocumentError
        If a file violates its schema, a path does not exist in the model document, or the values give no study. The
        message names the place in the document.
    """
    path = Path(path)
    content = read_content(path, "study-1")
    model = path.parent / content["model"]
    of_model = read_content(model, "model-1")
    build = DocumentBuild(of_model, model.stem)
    parameters = {}
    for name, value in content["parameters"].items():
        with _at(where := f"{path}: /parameters/{name}"):
            _place(of_model, name)
            parameters[name] = _parameter(value, where)
    options: dict[str, Any] = {key: content[key] for key in ("sampling", "runs", "seed", "spread") if key in content}
    with _at(str(path)):
        design_of(parameters, options.get("sampling"), options.get("runs"), options.get("seed", 0))
    return StudyDocument(build, parameters, options, ProcedureSettings.of(of_model.get("settings", {})))


@contextlib.contextmanager
def _at(where: str) -> Iterator[None]:
    """Name a place in a document in errors."""
    try:
        yield
    except BlockstructError as error:
        if str(error).startswith(where):
            raise
        msg = f"{where}: {error}"
        raise DocumentError(msg) from error


def _place(content: Any, path: str) -> tuple[Any, Any]:
    """Return the container of the value at a dotted path, and its key.

    A part of a path is a key, a name or an index. Names may contain dots; the longest match counts.
    """
    holder, key, rest = None, "", path
    while rest:
        keys = _keys(content)
        fitting = [k for k in keys if rest == k or rest.startswith(f"{k}.")]
        if not fitting:
            here = path[: len(path) - len(rest)].rstrip(".") or "the document"
            msg = f"{here} has no {rest.partition('.')[0]!r}; {did_you_mean(rest.partition('.')[0], keys)}"
            raise UnknownNameError(msg)
        key = max(fitting, key=len)
        holder, content, rest = content, content[keys[key]], rest[len(key) + 1 :]
    if isinstance(content, dict):
        msg = f"{path} holds {', '.join(content)}; name one of them"
        raise UnknownNameError(msg)
    return holder, _keys(holder)[key]


def _keys(content: Any) -> dict[str, Any]:
    """Return the keys of a part of a document, by name."""
    if isinstance(content, dict):
        return {str(key): key for key in content}
    if isinstance(content, list):
        named = {str(v["name"]): k for k, v in enumerate(content) if isinstance(v, dict) and "name" in v}
        return {str(k): k for k in range(len(content))} | named
    return {}


def _parameter(given: Any, where: str) -> Any:
    """Return a parameter as ``study`` takes it, with quantities parsed."""
    if isinstance(given, Mapping):
        return _distribution(given, where)
    return [_value(v, where) for v in given] if isinstance(given, list) else _value(given, where)


def _value(given: Any, where: str) -> Any:
    """Return a text such as ``"4 MPa"`` as a quantity, others unchanged."""
    if not isinstance(given, str) or not given.lstrip("+-")[:1].isdigit():
        return given
    return parse(given, where)


def _distribution(given: Mapping[str, Any], where: str) -> Any:
    """Return the distribution of scipy by name, parameters and unit."""
    from scipy import stats

    numbers = {key: value for key, value in given.items() if key != "distribution"}
    read = {key: parse(v, f"{where}/{key}") if isinstance(v, str) else v for key, v in numbers.items()}
    with_unit = [v for v in read.values() if hasattr(v, "units")]
    if with_unit and len(with_unit) < len(read):
        msg = f"{where}: {', '.join(f'{k} {v}' for k, v in numbers.items())}; give all of them a unit, or none"
        raise DocumentError(msg)
    unit = str(with_unit[0].units) if with_unit else SI_UNITS["dimensionless"]
    dimensions = {plain_value(v)[1] for v in read.values()}
    if len(dimensions) > 1:
        msg = f"{where}: a {' and a '.join(sorted(dimensions))}; give parameters of one dimension"
        raise DocumentError(msg)
    p = {key: float(v.to(unit).magnitude if with_unit else v) for key, v in read.items()}
    distribution: Any
    match given["distribution"]:
        case "normal":
            distribution = stats.norm(p["mean"], _positive(p["standard_deviation"], where))
        case "lognormal":
            variation = _positive(p["standard_deviation"], where) / _positive(p["mean"], where)
            sigma = float(np.sqrt(np.log1p(variation**2)))
            distribution = stats.lognorm(sigma, scale=p["mean"] / np.sqrt(1 + variation**2))
        case "uniform":
            distribution = stats.uniform(p["low"], _positive(p["high"] - p["low"], where))
        case _:
            width = _positive(p["high"] - p["low"], where)
            distribution = stats.triang((p["mode"] - p["low"]) / width, p["low"], width)
    return Q_(distribution, unit) if with_unit else distribution


def _positive(value: float, where: str) -> float:
    if not value > 0:
        msg = f"{where}: {value:g} where more than zero is due: a mean, a standard deviation, or high less low"
        raise DocumentError(msg)
    return value
