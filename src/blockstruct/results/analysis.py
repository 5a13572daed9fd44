"""An analysis: a model and the results of its cases, with their spreads, tags and parameters."""

import math
import webbrowser
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from tempfile import mkdtemp
from textwrap import indent
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from attrs import evolve, field, frozen

from blockstruct.arrays import NEGLIGIBLE
from blockstruct.errors import ModelError, UnitError, check_known, made_again, shown
from blockstruct.model import Case, Model, checked_name, checked_text, checked_tuple
from blockstruct.notebook import html_table, in_notebook
from blockstruct.results.case_result import CaseResult
from blockstruct.text.headline import Headline
from blockstruct.units import Q_, in_si, parse
from blockstruct.vocabulary import LISTED, Flow, Procedure, Status, counted

#: Key of the run with the settings of the analysis.
AS_GIVEN = "as given"


def run_name(case: str, schedule: str) -> str:
    """Return the name of the run of a case with a schedule."""
    return f"{case} [{schedule}]"


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Results of a non-associative case with several schedules.

    The associative case is included.

    The load factor of a non-associative structure is not unique. The headline belongs to the run as given, and the
    variants of the loading path give its range. Schedules of the paper's procedure change neither.

    Attributes
    ----------
    runs : mapping of str to CaseResult
        Result of each schedule, ``"as given"`` for the settings of the analysis.
    upper_bound : CaseResult or None
        Result with associative flow, an upper bound for every non-associative load factor (Radenković).
    """

    runs: Mapping[str, CaseResult]
    upper_bound: CaseResult | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "runs", MappingProxyType(dict(self.runs)))

    def __reduce__(self) -> tuple[Any, ...]:
        return made_again(self)

    @property
    def given(self) -> CaseResult:
        """The run with the settings of the analysis."""
        return self.runs[AS_GIVEN]

    @property
    def results(self) -> dict[str, CaseResult]:
        """All results by schedule, the associative one last."""
        bound = {} if self.upper_bound is None else {str(Flow.ASSOCIATIVE): self.upper_bound}
        return {**self.runs, **bound}

    @property
    def lowest(self) -> CaseResult | None:
        """The settled run with the lowest certified load factor; None without one."""
        return min(self._settled, key=lambda r: r.load_factor, default=None)

    @property
    def highest(self) -> CaseResult | None:
        """Settled run with the highest certified load factor; None without one."""
        return max(self._settled, key=lambda r: r.load_factor, default=None)

    @property
    def relied_on(self) -> CaseResult:
        """Run to rely on: the settled loading path of lowest load factor, or the given run if both are equal.

        It has the range of the loading paths.
        """
        paths = [run for run in self._settled if run.outcome.procedure is Procedure.LOADING_PATH]
        low, given = min(paths, key=lambda run: run.load_factor, default=self.given), self.given
        is_lower = given.load_factor - low.load_factor > NEGLIGIBLE * abs(given.load_factor)
        if not is_lower or given not in self._settled:
            return given
        return low.changed(path_dependence=self.path_dependence)

    @property
    def _settled(self) -> list[CaseResult]:
        # A load factor that crushing raised counts as the one without crushing.
        return [run for run in self.runs.values() if run.settled or np.isfinite(run.outcome.without_crushing)]

    @property
    def path_dependence(self) -> tuple[float, float] | None:
        """Lowest and highest load factor of the settled loading paths.

        None with fewer than two such paths.
        """
        load_factors = [r.load_factor for r in self._settled if r.outcome.procedure is Procedure.LOADING_PATH]
        return (min(load_factors), max(load_factors)) if len(load_factors) > 1 else None

    @property
    def headline(self) -> Headline:
        """Load factor of the given run, with its range and associative bound."""
        return self.given.headline

    @property
    def load_factor(self) -> float:
        """Load factor of the run as given."""
        return self.given.load_factor

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the run as given."""
        return self.given.warnings

    def __repr__(self) -> str:
        return f"<Spread of {counted(len(self.runs), 'schedule')}: {self.headline}>"

    def _repr_html_(self) -> str:
        answer = self.given.answer.name
        rows = [(name, r.answer.text(r.load_factor, 4), r.ended) for name, r in self.results.items()]
        return html_table(f"{self.given.name}: {self.headline}", ["schedule", answer, "status"], rows, self.warnings)

    def __str__(self) -> str:
        width = 2 + max(map(len, self.results))
        lines = [f"  {n:<{width}}{r.answer.text(r.load_factor, 4):<12}{r.ended}" for n, r in self.results.items()]
        return "\n".join([str(self.headline), *lines, *(f"  warning: {text}" for text in self.warnings)])


def spreads_of(results: Mapping[str, CaseResult]) -> dict[str, Spread]:
    """Return the spreads of cases with several schedules, by case name."""
    runs: dict[str, dict[str, CaseResult]] = {}
    for result in results.values():
        if result.of_case in results:
            runs.setdefault(result.of_case, {AS_GIVEN: results[result.of_case]})[result.schedule] = result
    bounds = {case: found.pop(str(Flow.ASSOCIATIVE), None) for case, found in runs.items()}
    return {case: Spread(found, bounds[case]) for case, found in runs.items()}


#: A number, a text, a truth value, None or a pint quantity of one number.
Parameter = Any


def checked_parameters(given: Mapping[str, Any], who: str) -> dict[str, Parameter]:
    """Return parameters as plain Python values or quantities of blockstruct.

    Raises
    ------
    ModelError
        If this is not a mapping of names, or a value has another type.
    UnitError
        If a quantity has several numbers.
    """
    if not isinstance(given, Mapping):
        msg = f"{who}: {shown(given)} are not parameters; give a mapping of names to values"
        raise ModelError(msg)
    return {checked_name(name, f"{who}: parameter"): checked_value(v, f"{who}: {name}") for name, v in given.items()}


def checked_tags(tags: Any, who: str) -> tuple[str, ...]:
    """Return tags as a tuple of texts.

    Raises
    ------
    ModelError
        If a tag is not a printable text, or too long to be stored.
    """
    return tuple(checked_text(tag, f"{who}: tag") for tag in checked_tuple(tags, str, f"{who}: tags"))


def checked_value(value: Any, what: str) -> Parameter:
    """Return one parameter as :func:`checked_parameters` does."""
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        magnitude = np.asarray(value.magnitude)
        if magnitude.shape != () or magnitude.dtype.kind not in "fiu":
            msg = f"{what}: {shown(value)} is not a quantity of one number; give one, as in Q_(4, 'MPa')"
            raise UnitError(msg)
        return Q_(_finite(float(magnitude), what), str(value.units))
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return _finite(value, what)
    if isinstance(value, str):
        return checked_text(value, what)
    if value is None or isinstance(value, bool | int):
        return value
    msg = f"{what}: {shown(value)} is not a parameter; give a number, a text, a truth value or a quantity"
    raise ModelError(msg)


def stored_value(value: Parameter) -> Any:
    """Return a parameter as JSON; quantities get the long unit name."""
    return {"value": value.magnitude, "units": str(value.units)} if hasattr(value, "magnitude") else value


def restored_value(stored: Any, what: str) -> Parameter:
    """Return the parameter of a JSON value from :func:`stored_value`."""
    if isinstance(stored, dict):
        if set(stored) != {"value", "units"} or not isinstance(stored["units"], str):
            msg = f"{what}: {shown(stored)} is not a quantity"
            raise ModelError(msg)
        # The unit comes from a file: parse it, never evaluate it as an expression.
        return checked_value(parse(f"{float(stored['value'])!r} {stored['units']}", what), what)
    return checked_value(stored, what)


def plain_value(value: Parameter) -> tuple[Any, str]:
    """Return the value in SI units and its long unit; empty without a unit."""
    if hasattr(value, "magnitude"):
        return in_si(value)
    return value, "dimensionless" if isinstance(value, int | float) and not isinstance(value, bool) else ""


def _finite(value: float, what: str) -> float:
    if not math.isfinite(value):
        msg = f"{what}: {value} is not finite; give a number, or None for an absent value"
        raise ModelError(msg)
    return value


def _frozen(values: Mapping[str, Any]) -> Mapping[str, Any]:
    return MappingProxyType(dict(values))


def _with_spreads(results: Mapping[str, CaseResult]) -> Mapping[str, CaseResult]:
    """Return results of which each case with several schedules has its range."""
    ranges = {name: spread.path_dependence for name, spread in spreads_of(results).items()}
    return _frozen({n: r.changed(path_dependence=ranges[n]) if ranges.get(n) else r for n, r in results.items()})


def _tags(tags: Iterable[str]) -> tuple[str, ...]:
    return checked_tags(tags, "Analysis")


def _parameters(values: Mapping[str, Any]) -> Mapping[str, Any]:
    return _frozen(checked_parameters(values, "Analysis: parameters"))


def _study(text: str) -> str:
    return checked_text(text, "Analysis: study")


@frozen(eq=False, repr=False)
class Analysis(Mapping[str, CaseResult]):
    """A mapping of case names to results, with their model.

    Attributes
    ----------
    model : Model
    created_at : str
        UTC, ISO 8601.
    versions : mapping
        Version of blockstruct and of every package of the run; of the last part if the run was resumed.
        :attr:`CaseResult.versions` holds the versions for each case.
    solver_options : mapping
        Options of each solver beyond the settings of the cases.
    document_hash : str
        SHA-256 of the document that described the model; empty without one.
    tags : tuple of str
    parameters : mapping
        Parameters of the model, if given: numbers, texts and quantities by name.
    study : str
        Study that the analysis belongs to, by its build function and settings; empty without one.
    """

    model: Model
    results: Mapping[str, CaseResult] = field(converter=_with_spreads)
    created_at: str
    versions: Mapping[str, str] = field(converter=_frozen)
    solver_options: Mapping[str, Any] = field(factory=dict, kw_only=True, converter=_frozen)
    document_hash: str = field(default="", kw_only=True)
    tags: tuple[str, ...] = field(default=(), kw_only=True, converter=_tags)
    parameters: Mapping[str, Any] = field(factory=dict, kw_only=True, converter=_parameters)
    study: str = field(default="", kw_only=True, converter=_study)

    def __reduce__(self) -> tuple[Any, ...]:
        return made_again(self)

    @property
    def cases(self) -> tuple[Case, ...]:
        """The cases, ready to run again."""
        return tuple(r.case for r in self.results.values())

    @property
    def status(self) -> str:
        """``"interrupted"`` if any case was interrupted, else ``"finished"``."""
        cut = any(r.status is Status.INTERRUPTED for r in self.results.values())
        return "interrupted" if cut else "finished"

    def spread(self, name: str) -> Spread:
        """Return the results of a case with several schedules.

        Run the case with ``bs.run(model, cases, spread=True)``, or ``spread="steep"``.

        Raises
        ------
        UnknownNameError
            If no case has this name.
        ModelError
            If the case was run with one schedule only.
        """
        case, spreads = self[name], self.spreads
        if name not in spreads:
            msg = f"case {case.name!r}: was run with one schedule; run it again with spread=True"
            raise ModelError(msg)
        return spreads[name]

    @property
    def spreads(self) -> dict[str, Spread]:
        """Spread of every case with several schedules."""
        return spreads_of(self)

    @property
    def headlines(self) -> dict[str, Headline]:
        """Load factor, range and bound of every case, without runs of spreads."""
        return {name: result.headline for name, result in self.items() if result.of_case not in self}

    def view(self, path: str | Path | None = None) -> Any:
        """Show the interactive page of the analysis.

        Parameters
        ----------
        path
            File to write. By default a notebook shows the page in the cell, and otherwise the browser shows a temporary
            file.

        Returns
        -------
        pathlib.Path or blockstruct.views.page.NotebookPage
            The file; in a notebook and without a path, the page as the value of a cell.

        Raises
        ------
        ModelError
            If no case has an iteration.
        MissingExtraError
            Without the extra ``viz``.
        """
        # Views stand above results, and are loaded by name when they are used.
        page = import_module("blockstruct.views.page")
        if path is not None:
            return Path(page.write_page(self, path))
        if in_notebook():
            return page.NotebookPage(self)
        written = Path(page.write_page(self, Path(mkdtemp(prefix="blockstruct-")) / "analysis.html"))
        webbrowser.open(written.as_uri())
        return written

    def replaced(self, **changes: Any) -> Self:
        """Return the same analysis with some attributes replaced."""
        return evolve(self, **changes)

    def __getitem__(self, name: str) -> CaseResult:
        check_known(name, self.results, f"analysis of {self.model.name!r}: no case")
        return self.results[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.results)

    def __len__(self) -> int:
        return len(self.results)

    def __repr__(self) -> str:
        ends = ", ".join(f"{r.name}: {r.number()[1]}" for r in list(self.results.values())[:LISTED])
        more = f", … {len(self)} cases" if len(self) > LISTED else ""
        return f"<Analysis of {self.model.name!r}, {ends}{more}>"

    def _repr_html_(self) -> str:
        rows = [
            (r.name, r.case.flow, r.status.words, r.number(6)[1], r.n_iterations, f"{r.duration:.2f}")
            for r in self.values()
        ]
        answers = " / ".join(dict.fromkeys(r.number()[0] for r in self.values())) or "load factor"
        columns = ["case", "flow", "status", answers, "numerical iterations", "time [s]"]
        notes = [f"{name}: {spread.headline}" for name, spread in self.spreads.items()]
        return html_table(f"Analysis of {self.model.name}", columns, rows, notes)

    def __str__(self) -> str:
        head = (
            f"analysis of {self.model.name!r}: {counted(len(self.model.blocks), 'block')}, "
            f"{counted(len(self.model.interfaces), 'interface')}"
        )
        results = [indent(str(r), "  ") for r in self.results.values()]
        return "\n".join([head, *results])
