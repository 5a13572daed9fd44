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

#: Suffixes of files that are not pages.
_NO_PAGES = (".pdf", ".png", ".svg")


def write_page(analysis: bs.Analysis, path: str | Path) -> Path:
    """Write the page of an analysis and replace an existing file.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    StorageError
        If the path cannot be written, or has the suffix of another kind of file.
    """
    if Path(path).suffix.lower() in _NO_PAGES:
        msg = f"{path}: a view is a page; give a name that ends in .html"
        raise bs.errors.StorageError(msg)
    return write_text(page_html(analysis), path)


def page_html(analysis: bs.Analysis) -> str:
    """Return the page of an analysis as self-contained HTML.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    """
    # Names are user text: "<" must not end the script element.
    data = json.dumps(payload(analysis), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    parts = {
        "title": escape(analysis.model.name),
        "plotly": get_plotlyjs(),
        "script": _resource("page.js"),
        "data": data,
    }
    # Replace all marks in one pass, so that inserted text is not searched for marks.
    return re.sub(rf"@({'|'.join(parts)})@", lambda mark: parts[mark[1]], _resource("page.html"))


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
