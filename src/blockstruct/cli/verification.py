"""Checks of local mechanisms on the command line: the site as one text, and the command that prints them."""

from typing import Annotated

import typer

import blockstruct as bs
from blockstruct.cli.app import FileArgument, app, say
from blockstruct.keywords import did_you_mean

#: What the text of a site may state.
_PARTS = ("ag", "F0", "Tc", "soil", "topography")

SpectrumOption = Annotated[
    str | None,
    typer.Option(
        "--spectrum",
        help="Site of NTC 2018, as in 'ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B, topography=T1': check local mechanisms.",
        show_default=False,
    ),
]
FactorOption = Annotated[
    float | None, typer.Option("--confidence-factor", help="FC of the Circolare 7/2019.", show_default=False)
]
LevelOption = Annotated[
    str | None, typer.Option("--knowledge-level", help="LC1, LC2 or LC3, instead of FC.", show_default=False)
]
MethodOption = Annotated[str, typer.Option("--method", help="linear or displacement: what the check relies on.")]


@app.command()
def assess(
    file: FileArgument,
    spectrum: SpectrumOption,
    case: Annotated[
        str | None, typer.Option("--case", help="One case; all that converged otherwise.", show_default=False)
    ] = None,
    confidence_factor: FactorOption = None,
    knowledge_level: LevelOption = None,
    method: MethodOption = "linear",
) -> None:
    """Check local mechanisms after the Circolare 7/2019, C8.7.1.2.1, and print every formula."""
    analysis = bs.open_analysis(file)
    if case is not None and case not in analysis.headlines:
        msg = f"--case {case!r}: {did_you_mean(case, analysis.headlines)}"
        raise bs.errors.UnknownNameError(msg)
    for check in checks_of(analysis, spectrum, confidence_factor, knowledge_level, method, only=case):
        say(f"{check}\n")


def checks_of(
    analysis: bs.Analysis,
    spectrum: str | None,
    factor: float | None,
    level: str | None,
    method: str,
    *,
    only: str | None = None,
) -> list[bs.assess.LocalMechanismCheck]:
    """Checks of the cases with a load factor; none without a spectrum."""
    if spectrum is None:
        if factor is not None or level is not None:
            msg = "--confidence-factor and --knowledge-level belong to a check; give --spectrum, too"
            raise bs.errors.ModelError(msg)
        return []
    site, spreads = site_of(spectrum), analysis.spreads
    names = [
        name for name, head in analysis.headlines.items() if head.status is bs.Status.CONVERGED and only in (None, name)
    ]
    if not names:
        ended = ", ".join(f"{name}: {head.status}" for name, head in analysis.headlines.items())
        msg = f"--spectrum: no case has a load factor to check ({ended})"
        raise bs.errors.ModelError(msg)
    return [
        bs.assess.local_mechanism(spreads.get(name, analysis[name]), factor, site, knowledge_level=level, method=method)
        for name in names
    ]


def site_of(text: str) -> bs.assess.NtcSpectrum:
    """Spectrum of a text such as ``"ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B"``."""
    given: dict[str, str] = {}
    for part in text.split(","):
        name, equals, value = (word.strip() for word in part.partition("="))
        if name not in _PARTS or not equals or name in given:
            msg = f"--spectrum: {part.strip()!r}; {did_you_mean(name, _PARTS)}, each once, as in 'soil=B'"
            raise bs.errors.ModelError(msg)
        given[name] = value
    missing = [name for name in _PARTS[:4] if name not in given]
    if missing:
        msg = f"--spectrum {text!r}: no {', '.join(missing)}; write it as 'ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B'"
        raise bs.errors.ModelError(msg)
    try:
        F0 = float(given["F0"])
    except ValueError:
        msg = f"--spectrum: F0={given['F0']} is no number; write it as 'F0=2.4'"
        raise bs.errors.ModelError(msg) from None
    topography = given.get("topography", "T1")
    return bs.assess.ntc_spectrum(given["ag"], F0, given["Tc"], given["soil"], topography)
