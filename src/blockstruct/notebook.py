"""What a notebook shows of an object, and whether there is a notebook or a terminal to show anything in."""

import sys
import threading
from collections.abc import Iterable, Sequence
from html import escape
from multiprocessing import parent_process


def html_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]], notes: Iterable[str] = ()) -> str:
    """Table as HTML, for ``_repr_html_``; names are anyone's text, so all of it is escaped.

    >>> html_table("a < b", ["value"], [["<1>"]])[:67]
    '<p><b>a &lt; b</b></p><table><thead><tr><th>value</th></tr></thead>'
    """

    def row(cells: Sequence[object], tag: str) -> str:
        return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"

    head, body = row(columns, "th") if any(columns) else "", "".join(row(cells, "td") for cells in rows)
    below = "".join(f"<p>{escape(note)}</p>" for note in notes)
    return f"<p><b>{escape(title)}</b></p><table><thead>{head}</thead><tbody>{body}</tbody></table>{below}"


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


def is_watched() -> bool:
    """Whether somebody sees what is printed: on a terminal or in a notebook, and not by one of several workers."""
    alone = parent_process() is None and threading.current_thread() is threading.main_thread()
    return alone and (in_notebook() or is_terminal(sys.stdout))


def is_terminal(stream: object) -> bool:
    """Whether a stream is one of a terminal; what stands in for a stream may not know."""
    return bool(getattr(stream, "isatty", bool)())
