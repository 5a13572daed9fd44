"""Checks of local mechanisms on the command line."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

import blockstruct as bs
from blockstruct.cli.app import Exit, app, argument, option, say
from blockstruct.errors import check_known, did_you_mean

#: Required and optional entries of a site, and an example.
_SITE = ("ag", "F0", "Tc", "soil"), ("topography",), "ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B"
#: Required and optional entries of a mode of the building, and an example.
_MODE = ("T", "participation", "shape"), ("damping",), "T=0.4 s, participation=1.3, shape=0.9"
_NO_PUSH = "a settlement has no push"

SpectrumOption = Annotated[
    str | None,
    option(
        "Site of NTC 2018, as in 'ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B, topography=T1': check local mechanisms.",
        "--spectrum",
    ),
]
ModeOption = Annotated[
    list[str] | None,
    option(
        "Mode of the building, for a mechanism at a height: 'T=0.4 s, participation=1.3, shape=0.9, damping=0.1'.",
        "--mode",
    ),
]
FactorOption = Annotated[float | None, option("FC of the Circolare 7/2019.", "--confidence-factor")]
LevelOption = Annotated[str | None, option("LC1, LC2 or LC3, instead of FC.", "--knowledge-level")]
MethodOption = Annotated[
    str | None, option("Method that the check relies on: linear or displacement.", "--method", default="linear")
]
CaseOption = Annotated[str | None, option("Check one case; all with a push that converged otherwise.", "--case")]


@app.command()
def assess(
    file: Annotated[Path, argument("An analysis file, or a model document to run.")],
    spectrum: SpectrumOption,
    case: CaseOption = None,
    confidence_factor: FactorOption = None,
    knowledge_level: LevelOption = None,
    method: MethodOption = None,
    mode: ModeOption = None,
    direction: Annotated[
        list[str] | None, option("Direction of a push on a model document.", default="+x, -x, +y and -y")
    ] = None,
    output: Annotated[Path | None, option("Report of a model document, .html or .pdf.", "--output", "-o")] = None,
    store: Annotated[
        Path | None, option("Analysis file that keeps the runs of a model document; to continue them, too.", "--store")
    ] = None,
) -> None:
    """Check local mechanisms after the Circolare 7/2019, C8.7.1.2.1.

    An analysis file gives every formula of its checks. A model document is run in four directions with the dead load of
    its first case, and gives one verdict, a table and a report.
    """
    wanted = {"confidence_factor": confidence_factor, "knowledge_level": knowledge_level, "method": method}
    if file.suffix.lower() in (".yaml", ".yml", ".json"):
        if case is not None:
            msg = f"{file}: --case chooses a case of an analysis file; give --direction for a model document"
            raise bs.errors.ModelError(msg)
        _building(file, demand_of(spectrum or "", mode or ()), direction, output, store, wanted)
        return
    if direction or output or store:
        msg = (
            f"{file}: --direction, --output and --store belong to a model document; report writes the report of an "
            "analysis"
        )
        raise bs.errors.ModelError(msg)
    analysis = bs.open_analysis(file)
    for check in checks_of(analysis, spectrum, mode, case, wanted):
        say(f"{check}\n")
    pushed = _pushed(analysis.headlines)
    # An infinite load factor needs no check.
    missing = [f"{name} ({head.status.words})" for name, head in pushed.items() if math.isnan(head.load_factor)]
    if case is None and missing:
        say(f"not checked without a load factor: {', '.join(missing)}; the checks above do not cover these cases")
        raise typer.Exit(Exit.NO_LOAD_FACTOR)


def _building(
    file: Path,
    demand: bs.assess.NtcSpectrum | bs.assess.FloorSpectrum,
    directions: Sequence[str] | None,
    output: Path | None,
    store: Path | None,
    wanted: Mapping[str, Any],
) -> None:
    """Run and check a model document in several directions, and write its report."""
    document = bs.read_document(file)
    with warnings.catch_warnings():
        # The text of a building contains the warnings of the governing direction only.
        warnings.simplefilter("always", bs.errors.LoadFactorWarning)
        building = bs.assess.building(
            document.model,
            document.cases[0].dead,
            demand,
            store=store,
            directions=directions or bs.assess.DIRECTIONS,
            settings=bs.ProcedureSettings.of(document.settings),
            **_given(wanted),
        )
    say(str(building))
    if output is not None:
        say(f"written: {building.report(output)}")


def checks_of(
    analysis: bs.Analysis,
    spectrum: str | None,
    modes: Sequence[str] | None,
    only: str | None,
    wanted: Mapping[str, Any],
) -> list[bs.assess.LocalMechanismCheck]:
    """Return the checks of one case, or of all with a push and a load factor; none without a spectrum.

    ``wanted`` holds the confidence factor, the level of knowledge and the method; None for each that is not given.
    """
    if spectrum is None:
        options = {**wanted, "mode": modes or None, "case": only}
        if alone := [f"--{name.replace('_', '-')}" for name in _given(options)]:
            verb = "belongs" if len(alone) == 1 else "belong"
            msg = f"{', '.join(alone)} {verb} to a check; give --spectrum, too"
            raise bs.errors.ModelError(msg)
        return []
    demand, spreads = demand_of(spectrum, modes or ()), analysis.spreads
    checks, refused = [], []
    for name in _checked(analysis, only):
        of = spreads.get(name, analysis[name])
        try:
            checks.append(bs.assess.local_mechanism(of, spectrum=demand, **_given(wanted)))
        except bs.errors.ModelError as error:
            refused.append((name, error))
    if refused:
        first = refused[0][1]
        if checks:
            without = ", ".join(name for name, _ in refused)
            with_one = " or ".join(f"--case {check.result.name!r}" for check in checks)
            first.add_note(f"no check of {without}; the other cases have one: {with_one}")
        raise first
    return checks


def _given(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that are given."""
    return {name: value for name, value in options.items() if value is not None}


def _pushed(heads: Mapping[str, bs.results.Headline]) -> dict[str, bs.results.Headline]:
    """Return the headlines of the cases with a push."""
    return {name: head for name, head in heads.items() if not head.answer.is_reaction}


def _checked(analysis: bs.Analysis, only: str | None) -> list[str]:
    """Return the cases to check: one, or all with a push and a load factor."""
    heads = analysis.headlines
    if only is not None:
        # Also one of the runs of a spread, which a verdict may rely on.
        check_known(only, analysis, "--case")
        status = analysis[only].status
        if status is not bs.Status.CONVERGED:
            msg = f"--case {only!r}: {status.words}, without a load factor to check; give one that converged"
            raise bs.errors.ModelError(msg)
        return [only]
    pushed = _pushed(heads)
    names = [name for name, head in pushed.items() if head.status is bs.Status.CONVERGED]
    if not names:
        ended = ", ".join(
            f"{name}: {head.status.words if name in pushed else _NO_PUSH}" for name, head in heads.items()
        )
        remedy = "find out why they have none" if pushed else "run a LimitCase, then check it"
        msg = f"--spectrum: no case has a push and a load factor to check ({ended}); {remedy}"
        raise bs.errors.ModelError(msg)
    settling = [name for name in heads if name not in pushed]
    if settling:
        say(f"not checked: {', '.join(settling)} ({_NO_PUSH})")
    return names


def demand_of(site: str, modes: Sequence[str] = ()) -> bs.assess.NtcSpectrum | bs.assess.FloorSpectrum:
    """Return the spectrum of a site given as text; with modes, at a height."""
    values = _stated("--spectrum", site, *_SITE)
    F0, topography = _number("--spectrum", "F0", values), values.get("topography", "T1")
    ground = bs.assess.ntc_spectrum(values["ag"], F0, values["Tc"], values["soil"], topography)
    shapes = []
    for text in modes:
        of_mode = _stated("--mode", text, *_MODE)
        numbers = {name: _number("--mode", name, of_mode) for name in of_mode if name != "T"}
        shapes.append(bs.assess.Mode(of_mode["T"], **numbers))
    return bs.assess.floor_spectrum(ground, shapes) if shapes else ground


def _stated(option: str, text: str, must: Sequence[str], may: Sequence[str], example: str) -> dict[str, str]:
    """Return the entries of a text by name."""
    entries: dict[str, str] = {}
    for part in text.split(","):
        name, equals, value = (word.strip() for word in part.partition("="))
        if name not in (*must, *may) or not equals or name in entries:
            msg = f"{option}: {part.strip()!r}; {did_you_mean(name, (*must, *may))}, each once, as in {example!r}"
            raise bs.errors.ModelError(msg)
        entries[name] = value
    missing = [name for name in must if name not in entries]
    if missing:
        msg = f"{option} {text!r}: no {', '.join(missing)}; write it as {example!r}"
        raise bs.errors.ModelError(msg)
    return entries


def _number(option: str, name: str, given: Mapping[str, str]) -> float:
    try:
        return float(given[name])
    except ValueError:
        msg = f"{option}: {name}={given[name]} is not a number; write it as '{name}=0.9'"
        raise bs.errors.ModelError(msg) from None
