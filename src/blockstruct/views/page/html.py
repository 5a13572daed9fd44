"""The page as text and as a file."""

import json
import re
from html import escape
from importlib.resources import files
from pathlib import Path

from plotly.offline import get_plotlyjs

import blockstruct as bs
from blockstruct.views.output import write_text
from blockstruct.views.page.payload import payload

#: Endings of files that a page would not be opened as.
_NO_PAGES = (".pdf", ".png", ".svg")


def write_page(analysis: bs.Analysis, path: str | Path) -> Path:
    """Write the page of an analysis; an existing file is replaced.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    StorageError
        If the path cannot be written, or is named as another kind of file.
    """
    if Path(path).suffix.lower() in _NO_PAGES:
        msg = f"{path}: a view is a page; give a name that ends in .html"
        raise bs.errors.StorageError(msg)
    return write_text(page_html(analysis), path)


def page_html(analysis: bs.Analysis) -> str:
    """Page of an analysis: its bodies, its cases and all their iterations, with everything that draws them.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    """
    # Names are anyone's text: "<" must not end the script element.
    data = json.dumps(payload(analysis), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    parts = {
        "title": escape(analysis.model.name),
        "plotly": get_plotlyjs(),
        "script": _resource("page.js"),
        "data": data,
    }
    # In one pass: what is put in is not searched for marks again.
    return re.sub(rf"@({'|'.join(parts)})@", lambda mark: parts[mark[1]], _resource("page.html"))


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
