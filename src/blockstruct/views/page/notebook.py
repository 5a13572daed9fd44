"""The page in a cell of a notebook."""

from functools import cached_property
from html import escape
from importlib import import_module
from typing import Any

import blockstruct as bs
from blockstruct.views.page.html import page_html

#: Height of the page in a cell, pixels.
_HEIGHT = 640

#: Shows the page in a cell and takes over the name of what is picked in it.
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


class NotebookPage:
    """The interactive page of an analysis, as the value of a cell.

    The page is part of the notebook: it works in a saved notebook, without a kernel and without a network.
    :attr:`widget` shows the same page in a running notebook, and :attr:`picked` is then what is picked in it.

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

    def __init__(self, analysis: bs.Analysis, *, height: int = _HEIGHT) -> None:
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
    """Return a widget that shows a page and knows what is picked in it."""
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
