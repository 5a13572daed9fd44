"""Study documents in YAML or JSON: a model document with varied values."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blockstruct.documents import document_of, read_content
from blockstruct.errors import BlockstructError, DocumentError, UnknownNameError
from blockstruct.keywords import did_you_mean
from blockstruct.limit import ProcedureSettings
from blockstruct.model import Case, Model
from blockstruct.results import plain_value
from blockstruct.studies.design import design_of
from blockstruct.units import Q_, SI_UNITS, parse


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
    for dotted in content["parameters"]:
        try:
            _place(of_model, dotted)
        except BlockstructError as error:
            msg = f"{path}: /parameters/{dotted}: {error}"
            raise DocumentError(msg) from error
    values = content["parameters"]
    parameters = {name: _parameter(value, f"{path}: /parameters/{name}") for name, value in values.items()}
    options: dict[str, Any] = {key: content[key] for key in ("sampling", "runs", "seed", "spread") if key in content}
    try:
        design_of(parameters, options.get("sampling"), options.get("runs"), options.get("seed", 0))
    except BlockstructError as error:
        msg = f"{path}: {error}"
        raise DocumentError(msg) from error
    return StudyDocument(build, parameters, options, ProcedureSettings.of(of_model.get("settings", {})))


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
    try:
        if isinstance(given, Mapping):
            return _distribution(given, where)
        return [_value(v, where) for v in given] if isinstance(given, list) else _value(given, where)
    except BlockstructError as error:
        if str(error).startswith(where):
            raise
        msg = f"{where}: {error}"
        raise DocumentError(msg) from error


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
