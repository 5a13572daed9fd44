"""The report as PDF, without a browser."""

import re
from collections.abc import Iterator
from typing import Any

import blockstruct as bs

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
