"""The page as text, as a file, and in a cell of a notebook."""

import json
import re
from functools import cached_property
from html import escape
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

from plotly.offline import get_plotlyjs

import blockstruct as bs
from blockstruct.views.output import write_text
from blockstruct.views.page.payload import payload

#: Suffixes of files that are not pages.
_NO_PAGES = (".pdf", ".png", ".svg")
#: Shows the page in a cell and takes over the name of the picked block or interface.
_WIDGET = """
export default { render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.srcdoc = model.get("page");
  frame.sandbox = "allow-scripts allow-downloads";
  frame.style = `width: 100%; height: ${model.get("height")}px; border: 0`;
  const listen = event => {
    if (event.source !== frame.contentWindow || !event.data.blockstruct) return;
    model.set("picked", event.data.blockstruct.name);
    model.save_changes();
  };
  window.addEventListener("message", listen);
  el.append(frame);
  return () => window.removeEventListener("message", listen);
} };
"""


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


class NotebookPage:
    """The interactive page of an analysis, as the value of a cell.

    The page is part of the notebook: it works in a saved notebook, without a kernel and without a network.
    :attr:`widget` shows the same page in a running notebook, and :attr:`picked` is the name picked there.

    Parameters
    ----------
    analysis
        An analysis.
    height
        Height in the cell, pixels.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    """

    def __init__(self, analysis: bs.Analysis, *, height: int = 640) -> None:
        self._name = analysis.model.name
        self._page = page_html(analysis)
        self._height = height

    @cached_property
    def widget(self) -> Any:
        """The page as a widget, which needs ``pip install "blockstruct[notebook]"``.

        Raises
        ------
        MissingExtraError
            If anywidget is not installed.
        """
        return _widget(self._page, self._height)

    @property
    def picked(self) -> str | None:
        """Name of the interface or block picked last in the widget; None before the first pick."""
        return self.widget.picked or None

    def __repr__(self) -> str:
        return f"<page of {self._name!r}>"

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{escape(self._page)}" sandbox="allow-scripts allow-downloads" '
            f'style="width: 100%; height: {self._height}px; border: 0"></iframe>'
        )


def _widget(page: str, height: int) -> Any:
    """Return a widget that shows a page and keeps the name of the picked block or interface."""
    try:
        anywidget, traitlets = import_module("anywidget"), import_module("traitlets")
    except ModuleNotFoundError as error:
        raise bs.errors.MissingExtraError.of(error, "notebook", "picks in a notebook") from error
    contents = {
        "_esm": _WIDGET,
        "page": traitlets.Unicode(page).tag(sync=True),
        "height": traitlets.Int(height).tag(sync=True),
        "picked": traitlets.Unicode("").tag(sync=True),
    }
    return type("Page", (anywidget.AnyWidget,), contents)()
