"""Output in notebooks, and detection of notebooks and terminals."""

import sys
import threading
from collections.abc import Iterable, Sequence
from html import escape
from multiprocessing import parent_process


def html_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]], notes: Iterable[str] = ()) -> str:
    """Return a table as HTML, for ``_repr_html_``, with all texts escaped.

    Names may contain any text.

    >>> html_table("a < b", ["value"], [["<1>"]])[:67]
    '<p><b>a &lt; b</b></p><table><thead><tr><th>value</th></tr></thead>'
    """

    def row(cells: Sequence[object], tag: str) -> str:
        return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"

    head, body = row(columns, "th") if any(columns) else "", "".join(row(cells, "td") for cells in rows)
    below = "".join(f"<p>{escape(note)}</p>" for note in notes)
    return f"<p><b>{escape(title)}</b></p><table><thead>{head}</thead><tbody>{body}</tbody></table>{below}"


def in_notebook() -> bool:
    """Return whether this is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


def is_watched() -> bool:
    """Return whether somebody sees printed lines.

    True on a terminal or in a notebook, but not in one of several workers.
    """
    alone = parent_process() is None and threading.current_thread() is threading.main_thread()
    return alone and (in_notebook() or is_terminal(sys.stdout))


def is_terminal(stream: object) -> bool:
    """Return whether a stream is a terminal.

    A substitute for a stream may lack the method ``isatty``; it is then not a terminal.
    """
    return bool(getattr(stream, "isatty", bool)())
