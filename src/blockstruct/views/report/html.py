"""The report as text and as a file."""

from collections.abc import Mapping
from pathlib import Path
from traceback import extract_tb
from types import MappingProxyType

import jinja2
from jinja2.sandbox import ImmutableSandboxedEnvironment
from markupsafe import Markup

import blockstruct as bs
from blockstruct.views.output import write_text
from blockstruct.views.report.contents import contents

_OWN = "report.html.j2"


def write_report(
    analysis: bs.Analysis,
    path: str | Path,
    *,
    project: Mapping[str, str] = MappingProxyType({}),
    template: str | Path | None = None,
) -> Path:
    """Write the report of an analysis; an existing file is replaced.

    Parameters
    ----------
    analysis
        All its cases are reported, whatever their status.
    path
        HTML file. A browser's "print to PDF" gives A4 pages.
    project, template
        As in :func:`report_html`.

    Raises
    ------
    StorageError
        If the path cannot be written, or the template cannot be used.
    """
    return write_text(report_html(analysis, project=project, template=template), path)


def report_html(
    analysis: bs.Analysis,
    *,
    project: Mapping[str, str] = MappingProxyType({}),
    template: str | Path | None = None,
) -> str:
    """Report of an analysis, its pictures within.

    Parameters
    ----------
    analysis
        All its cases are reported, whatever their status.
    project
        What the head of the report states, such as ``{"client": "…", "engineer": "…"}``.
    template
        A Jinja2 template to use instead. One that begins ``{% extends "report.html.j2" %}`` only has to state the
        blocks it changes: ``style``, ``head``, ``project``, ``results``, ``spreads``, ``model``,
        ``detection``, ``loads``, ``cases``, ``assumptions``, ``settings``, ``foot``.

    Raises
    ------
    StorageError
        If the template cannot be read or filled.
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
    environment.filters["css_text"] = _css_text
    said = contents(analysis, project)
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


def _line(error: Exception, name: str) -> int | None:
    """Line of a template at which it failed, None if it was not found or not in it."""
    match error:
        case jinja2.TemplateSyntaxError(lineno=line):
            return line
        case UnicodeDecodeError(object=content, start=start):
            return content.count(b"\n", 0, start) + 1
    # Jinja gives the frames of a template its name and lines.
    return next((f.lineno for f in reversed(extract_tb(error.__traceback__)) if Path(f.filename).name == name), None)
