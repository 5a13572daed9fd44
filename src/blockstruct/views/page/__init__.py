"""The interactive page: one HTML file that works offline. Needs ``pip install "blockstruct[viz]"``."""

import blockstruct as bs

try:
    import plotly  # noqa: F401 - its script goes into the page
except ModuleNotFoundError as error:
    raise bs.errors.MissingExtraError.of(error, "viz", "page") from error

from blockstruct.views.page.html import NotebookPage, page_html, write_page

__all__ = ["NotebookPage", "page_html", "write_page"]
