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
#: How the names of the files that it writes end.
_ENDS = (".html", ".pdf")


def write_report(
    analysis: bs.Analysis,
    path: str | Path,
    *,
    project: Mapping[str, str] = MappingProxyType({}),
    checks: Iterable[bs.assess.LocalMechanismCheck] = (),
    template: str | Path | None = None,
) -> Path:
    """Write the report of an analysis; an existing file is replaced.

    Parameters
    ----------
    analysis
        All its cases are reported, whatever their status.
    path
        A page, or PDF: its name ends in ``.html`` or ``.pdf``. Both have A4 pages when printed.
    project, checks, template
        As in :func:`report_html`.

    Raises
    ------
    StorageError
        If the path cannot be written, or is named as another kind of file, or the template cannot be used.
    ModelError
        If a check is of another analysis, or of another load factor than the report relies on; if something else
        than checks, or than names and texts of the project, is given.
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
    """Report of an analysis, its pictures within.

    Parameters
    ----------
    analysis
        All its cases are reported, whatever their status.
    project
        What the head of the report states, such as ``{"client": "…", "engineer": "…"}``.
    checks
        Verifications of its cases: :func:`blockstruct.assess.local_mechanism`. Checks alike are shown once.
    template
        A Jinja2 template to use instead. One that begins ``{% extends "report.html.j2" %}`` only has to state the
        blocks it changes: ``style``, ``head``, ``project``, ``relied_on``, ``results``, ``assumptions``,
        ``verification``, ``spreads``, ``cases``, ``model``, ``detection``, ``loads``, ``settings``, ``foot``.

    Raises
    ------
    StorageError
        If the template cannot be read or filled.
    ModelError
        If a check is of another analysis, or of another load factor than the report relies on; if something else
        than checks, or than names and texts of the project, is given.
    """
    own = jinja2.PackageLoader("blockstruct.views.report", ".")
    loaders: list[jinja2.BaseLoader] = [own]
    name = _OWN
    if template is not None:
        loaders.append(jinja2.FileSystemLoader(Path(template).parent))
        name = Path(template).name
        if name == _OWN:
            msg = f"{template}: this name is that of the standard template; rename the file"
            raise bs.errors.StorageError(msg)
    # A template may come from anywhere: it sees the report, and nothing behind it.
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
    said = contents(analysis, project, checks)
    if template is None:
        return environment.get_template(name).render(said)
    try:
        return environment.get_template(name).render(said)
    except Exception as error:  # the expressions of a template may raise anything
        line = _line(error, name)
        where = f", line {line}" if line else ""
        msg = f"{template}: not a usable template ({error}{where}); correct it, or report without it"
        raise bs.errors.StorageError(msg) from error


def _css_text(text: str) -> Markup:
    """A text within a CSS string: whatever is not a letter, digit or blank becomes its code point."""
    return Markup("".join(c if c.isalnum() or c == " " else f"\\{ord(c):x} " for c in text))


#: Indices and powers of formulas as they are typed: ``d_SLV``, ``a_g,SLV``, ``M_(P+Q)``, ``α0``, ``Tc*^−0.20``.
_INDEX = re.compile(
    r"_(?:\((?P<group>[^)]*)\)|(?P<word>\w+(?:,\w+)*))|(?<=[αθdaFT])(?P<zero>0)\b|\^(?P<power>−?[\d.]+\d)"
)


#: Blanks of formulas at which no line ends: of a number and its unit, beside π, between a symbol and what it equals,
#: and of short terms in parentheses. Nor does one after the stroke of a unit.
_UNIT = re.compile(
    r"(?<=\d) (?=(?:m/s²|kN/m[²³]?|k?N(?:[· ]m)?|[kM]?Pa|m?m[²³]?|kg|t|s|g|°|%)(?![\w*]))|(?<=N) (?=m\b)"
    r"|(?<=[\d·]) (?=π)|(?<=π) (?=[√\d])"
)
_STROKE = re.compile(r"m/s²|kN/m[²³]?")
_TERM = re.compile(r"\([^()=]{1,24}\)")
_SYMBOL = re.compile(r"((?:^|(?<= ))[^\W\d][^\s=]*) (?==)")
_NO_BREAK = "\u00a0"


def _formula(text: str) -> Markup:
    """A formula with its indices below the line and its powers above it, and lines that end between its terms."""
    text = _SYMBOL.sub(rf"\1{_NO_BREAK}", _whole(text)).replace("= ", f"={_NO_BREAK}")
    text = _TERM.sub(lambda term: term[0].replace(" ", _NO_BREAK), text)

    def raised(found: re.Match[str]) -> str:
        if found["power"]:
            return f"<sup>{found['power']}</sup>"
        return f"<sub>{found['group'] or found['word'] or found['zero']}</sub>"

    return _with_strokes(Markup(_INDEX.sub(raised, str(escape(text)))))


def _sentence(text: str) -> Markup:
    """A sentence with quantities at whose blanks and strokes no line ends."""
    return _with_strokes(escape(_whole(text)))


def _whole(text: str) -> str:
    return _UNIT.sub(_NO_BREAK, text)


def _with_strokes(text: Markup) -> Markup:
    return Markup(_STROKE.sub(r'<span class="unit">\g<0></span>', str(text)))


def _line(error: Exception, name: str) -> int | None:
    """Line of a template at which it failed, None if it was not found or not in it."""
    match error:
        case jinja2.TemplateSyntaxError(lineno=line):
            return line
        case UnicodeDecodeError(object=content, start=start):
            return content.count(b"\n", 0, start) + 1
    # Jinja gives the frames of a template its name and lines.
    return next((f.lineno for f in reversed(extract_tb(error.__traceback__)) if Path(f.filename).name == name), None)
