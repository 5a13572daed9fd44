"""The report as text and as a file."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from traceback import extract_tb
from types import MappingProxyType

import jinja2
from jinja2.sandbox import ImmutableSandboxedEnvironment
from markupsafe import Markup, escape

import blockstruct as bs
from blockstruct.views.output import write_bytes
from blockstruct.views.report.contents import contents
from blockstruct.views.report.pdf import pdf_of
from blockstruct.vocabulary import counted

_OWN = "report.html.j2"
#: Suffixes of reports.
_ENDS = (".html", ".pdf")


def write_report(
    analysis: bs.Analysis,
    path: str | Path,
    *,
    project: Mapping[str, str] = MappingProxyType({}),
    checks: Iterable[bs.assess.LocalMechanismCheck] = (),
    template: str | Path | None = None,
) -> Path:
    """Write the report of an analysis and replace an existing file.

    Parameters
    ----------
    analysis
        All its cases are reported, whatever their status.
    path
        ``.html`` or ``.pdf``. Both have A4 pages in print.
    project, checks, template
        See :func:`report_html`.

    Raises
    ------
    StorageError
        If the path cannot be written, has another suffix, or the template cannot be used.
    ModelError
        If a check belongs to another analysis or to another load factor than the report's, or if an argument has a
        wrong type.
    MissingExtraError
        PDF without ``pip install "blockstruct[pdf]"``.
    """
    if Path(path).suffix.lower() not in _ENDS:
        msg = f"{path}: a report is a page or a PDF; give a name that ends in {' or '.join(_ENDS)}"
        raise bs.errors.StorageError(msg)
    html = report_html(analysis, project=project, checks=checks, template=template)
    return write_bytes(pdf_of(html) if Path(path).suffix.lower() == ".pdf" else html.encode("utf-8"), path)


def report_html(
    analysis: bs.Analysis,
    *,
    project: Mapping[str, str] = MappingProxyType({}),
    checks: Iterable[bs.assess.LocalMechanismCheck] = (),
    template: str | Path | None = None,
) -> str:
    """Return the report of an analysis as HTML with its pictures inside.

    Parameters
    ----------
    analysis
        All its cases are reported, whatever their status.
    project
        Entries for the head of the report, such as ``{"client": "…", "engineer": "…"}``.
    checks
        Verifications of its cases: :func:`blockstruct.assess.local_mechanism`. Equal checks are shown once.
    template
        A Jinja2 template to use instead. One that begins with ``{% extends "report.html.j2" %}`` only needs the blocks
        that it changes: ``style``, ``head``, ``project``, ``relied_on``, ``results``, ``assumptions``,
        ``verification``, ``spreads``, ``cases``, ``model``, ``detection``, ``loads``, ``settings``, ``foot``.

    Raises
    ------
    StorageError
        If the template cannot be read or filled.
    ModelError
        If a check belongs to another analysis or to another load factor than the report's, or if an argument has a
        wrong type.
    """
    own = jinja2.PackageLoader("blockstruct.views.report", ".")
    loaders: list[jinja2.BaseLoader] = [own]
    name = _OWN
    if template is not None:
        loaders.append(jinja2.FileSystemLoader(Path(template).parent))
        name = Path(template).name
        if name == _OWN:
            msg = f"{template}: this is the name of the standard template; rename the file"
            raise bs.errors.StorageError(msg)
    # A template may be untrusted: it sees the report and nothing else.
    environment = ImmutableSandboxedEnvironment(
        loader=jinja2.ChoiceLoader(loaders),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["counted"] = counted
    environment.filters["css_text"] = _css_text
    environment.filters["formula"] = _formula
    environment.filters["sentence"] = _sentence
    if not isinstance(project, Mapping):
        msg = f"report: project {bs.errors.shown(project)}; give names and texts, as in {{'client': '…'}}"
        raise bs.errors.ModelError(msg)
    names = contents(analysis, project, checks)
    if template is None:
        return environment.get_template(name).render(names)
    try:
        return environment.get_template(name).render(names)
    except Exception as error:  # expressions in a template may raise anything
        line = _line(error, name)
        where = f", line {line}" if line else ""
        msg = f"{template}: not a usable template ({error}{where}); correct it, or report without it"
        raise bs.errors.StorageError(msg) from error


def _css_text(text: str) -> Markup:
    """Return a text within a CSS string, with code points for special characters."""
    return Markup("".join(c if c.isalnum() or c == " " else f"\\{ord(c):x} " for c in text))


#: Indices and powers in typed formulas: ``d_SLV``, ``a_g,SLV``, ``M_(P+Q)``, ``α0``, ``Tc*^−0.20``.
_INDEX = re.compile(
    r"_(?:\((?P<group>[^)]*)\)|(?P<word>\w+(?:,\w+)*))|(?<=[αθdaFT])(?P<zero>0)\b|\^(?P<power>−?[\d.]+\d)"
)


#: Blanks in formulas where no line may break: before a unit, next to π, around an equals sign after a symbol, in short
#: parentheses, and after the stroke of a unit.
_UNIT = re.compile(
    r"(?<=\d) (?=(?:m/s²|kN/m[²³]?|k?N(?:[· ]m)?|[kM]?Pa|m?m[²³]?|kg|t|s|g|°|%)(?![\w*]))|(?<=N) (?=m\b)"
    r"|(?<=[\d·]) (?=π)|(?<=π) (?=[√\d])"
)
_STROKE = re.compile(r"m/s²|kN/m[²³]?")
_TERM = re.compile(r"\([^()=]{1,24}\)")
_SYMBOL = re.compile(r"((?:^|(?<= ))[^\W\d][^\s=]*) (?==)")
_NO_BREAK = "\u00a0"


def _formula(text: str) -> Markup:
    """Return a formula with indices and powers, and lines that break between its terms."""
    text = _SYMBOL.sub(rf"\1{_NO_BREAK}", _whole(text)).replace("= ", f"={_NO_BREAK}")
    text = _TERM.sub(lambda term: term[0].replace(" ", _NO_BREAK), text)

    def raised(found: re.Match[str]) -> str:
        if found["power"]:
            return f"<sup>{found['power']}</sup>"
        return f"<sub>{found['group'] or found['word'] or found['zero']}</sub>"

    return _with_strokes(Markup(_INDEX.sub(raised, str(escape(text)))))


def _sentence(text: str) -> Markup:
    """Return a sentence whose lines do not break inside quantities."""
    return _with_strokes(escape(_whole(text)))


def _whole(text: str) -> str:
    return _UNIT.sub(_NO_BREAK, text)


def _with_strokes(text: Markup) -> Markup:
    return Markup(_STROKE.sub(r'<span class="unit">\g<0></span>', str(text)))


def _line(error: Exception, name: str) -> int | None:
    """Return the line of a template at which it failed; None if unknown."""
    match error:
        case jinja2.TemplateSyntaxError(lineno=line):
            return line
        case UnicodeDecodeError(object=content, start=start):
            return content.count(b"\n", 0, start) + 1
    # The frames of a template have its name and lines.
    return next((f.lineno for f in reversed(extract_tb(error.__traceback__)) if Path(f.filename).name == name), None)
