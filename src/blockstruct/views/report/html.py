"""The report as text, as a file, and as PDF without a browser."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from traceback import extract_tb
from types import MappingProxyType
from typing import Any

import jinja2
from jinja2 import nodes
from jinja2.compiler import CodeGenerator
from jinja2.exceptions import SecurityError
from jinja2.sandbox import ImmutableSandboxedEnvironment
from markupsafe import Markup, escape

import blockstruct as bs
from blockstruct.files import MOST_READ, read_file
from blockstruct.views.output import target_with, write_bytes
from blockstruct.views.report.contents import contents
from blockstruct.vocabulary import counted

_OWN = "report.html.j2"


def write_report(
    analysis: bs.Analysis,
    path: str | Path,
    *,
    project: Mapping[str, str] = MappingProxyType({}),
    checks: Iterable[bs.assess.LocalMechanismCheck] = (),
    unit_sizes: bs.assess.UnitSizes | None = None,
    template: str | Path | None = None,
) -> Path:
    """Write the report of an analysis and replace an existing file.

    Parameters
    ----------
    analysis
        All its cases are reported, whatever their status.
    path
        ``.html`` or ``.pdf``. Both have A4 pages in print.
    project, checks, unit_sizes, template
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
    target = target_with(path, ".html", ".pdf")
    html = report_html(analysis, project=project, checks=checks, unit_sizes=unit_sizes, template=template)
    return write_bytes(pdf_of(html) if target.suffix.lower() == ".pdf" else html.encode("utf-8"), target)


class _Generator(CodeGenerator):
    """Compiles templates whose loops count their rounds."""

    def visit_Template(self, node: nodes.Template, frame: Any = None) -> None:  # noqa: N802 - the name that Jinja2 calls
        """Pass what each loop goes through to the filter that counts."""
        for loop in node.find_all(nodes.For):
            loop.iter = nodes.Filter(loop.iter, "counted", [], [], None, None, lineno=loop.lineno)
        super().visit_Template(node, frame)


class _Environment(ImmutableSandboxedEnvironment):
    """A sandbox in which rounds of loops and calls of functions are limited, all together.

    A report of 11 or 411 blocks takes 140 rounds for each case.
    """

    code_generator_class = _Generator

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._rounds, self.most_rounds = 0, float(MOST_READ)
        self.filters["counted"] = self._counted

    def call(self, *args: Any, **keywords: Any) -> Any:
        """Call a function or a macro."""
        self._count()
        return super().call(*args, **keywords)

    def _counted(self, items: Iterable[Any]) -> Iterator[Any]:
        for item in items:
            self._count()
            yield item

    def _count(self) -> None:
        self._rounds += 1
        if self._rounds > self.most_rounds:
            msg = f"more than {MOST_READ} rounds of loops and calls of functions"
            raise SecurityError(msg)


def _environment(template: Path | None = None) -> _Environment:
    """Return the sandbox of a template, which sees the report, itself and the standard template."""

    def source(wanted: str) -> tuple[str, str, None] | None:
        if template is not None and wanted == template.name:
            return read_file(template, "a template", MOST_READ).decode("utf-8"), wanted, None
        if wanted == _OWN:
            return files(__package__).joinpath(_OWN).read_text(encoding="utf-8"), _OWN, None
        return None

    environment = _Environment(
        loader=jinja2.FunctionLoader(source),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["counted"] = counted
    environment.filters["css_text"] = _css_text
    environment.filters["formula"] = _formula
    environment.filters["sentence"] = _sentence
    return environment


@cache
def _standard() -> jinja2.Template:
    """Return the standard template, compiled once. Its loops have no limit."""
    environment = _environment()
    environment.most_rounds = math.inf
    return environment.get_template(_OWN)


def report_html(
    analysis: bs.Analysis,
    *,
    project: Mapping[str, str] = MappingProxyType({}),
    checks: Iterable[bs.assess.LocalMechanismCheck] = (),
    unit_sizes: bs.assess.UnitSizes | None = None,
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
    unit_sizes
        Answers with units of other sizes: :func:`blockstruct.assess.unit_sizes`.
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
    name = _OWN
    if template is not None:
        name = Path(template).name
        if name == _OWN:
            msg = f"{template}: this is the name of the standard template; rename the file"
            raise bs.errors.StorageError(msg)

    if not isinstance(project, Mapping):
        msg = f"report: project {bs.errors.shown(project)}; give names and texts, as in {{'client': '…'}}"
        raise bs.errors.ModelError(msg)
    names = contents(analysis, project, checks, unit_sizes)
    if template is None:
        return _standard().render(names)
    try:
        return _environment(Path(template)).get_template(name).render(names)
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


#: Classes of the body for ever less room.
_STYLES = ("", "crowded", "crowded small")
#: Anchor of the page after the summary.
_NEXT = "after-summary"


def pdf_of(html: str) -> bytes:
    """Return the PDF of a report. Needs ``pip install "blockstruct[pdf]"``.

    Raises
    ------
    MissingExtraError
        If WeasyPrint or its drawing libraries are not installed.
    StorageError
        If a template refers to a file or an address: a report contains all its pictures.
    """
    try:
        from weasyprint import HTML
        from weasyprint.urls import FatalURLFetchingError, URLFetcher
    except ModuleNotFoundError as error:
        raise bs.errors.MissingExtraError.of(error, "pdf", "report as PDF") from error
    except OSError as error:
        msg = f"report as PDF: WeasyPrint finds no library to draw with ({error}); install Pango, or write HTML"
        raise bs.errors.MissingExtraError(msg) from error

    class OnlyWithin(URLFetcher):  # type: ignore[misc]
        """Fetch data inside the report, and nothing else."""

        def fetch(self, url: str, headers: Any = None) -> Any:
            if not url.startswith("data:"):
                msg = f"{url[:80]} is not part of the report"
                raise FatalURLFetchingError(msg)
            return super().fetch(url, headers)

    try:
        # The first that keeps the summary on one page is taken.
        for styled in _styled(html) if f'id="{_NEXT}"' in html else [html]:
            document = HTML(string=styled, url_fetcher=OnlyWithin()).render()
            if any(_NEXT in page.anchors for page in document.pages[:2]):
                break
        return document.write_pdf()  # type: ignore[no-any-return]
    except FatalURLFetchingError as error:
        msg = f"report as PDF: {error}; put pictures and styles into the template, as data: addresses"
        raise bs.errors.StorageError(msg) from error


def _styled(html: str) -> Iterator[str]:
    """Yield the report for ever less room on its first page, at last with the notes of that page in the appendix."""
    for style in _STYLES:
        yield html.replace("<body>", f'<body class="{style}">', 1)
    notes, marked = re.compile("<!-- notes -->(.*?)<!-- end of notes -->", re.DOTALL), "<!-- other notes -->"
    found = notes.search(html)
    moved = notes.sub("", html).replace(marked, found[1] if found else marked, 1)
    yield moved.replace("<body>", '<body class="crowded">', 1)
