"""How much room the first page of a report has."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

#: Cases in its table, and warnings of cases, that it has room for.
CASES, WARNINGS = 8, 2
#: Lines of text that fit beside its headings and its picture, and beside those set smaller.
_LINES, _SMALLER = 27.0, 42.0
#: Characters in a line of the title, of a paragraph, of a column of the assumptions, of the remarks on a number on its
#: card and in the table, and of the name of a case.
_TITLE, _WIDE, _COLUMN, _REMARK, _BELOW, _NAME = 40, 88, 48, 28, 50, 14


def crowding(said: Mapping[str, Any], warned: Sequence[Mapping[str, str]]) -> str:
    """What the first page gives up to stay one page, as classes of its style: nothing, size, or its picture, too.

    Parameters
    ----------
    said
        Everything that the template may name, of which the page has some.
    warned
        Cases with warnings.
    """
    relied = said["relied_on"]
    paragraphs = [f"{relied['sentence']} {relied['between']}", *relied["curves"], *relied["notes"]]
    paragraphs += [f"{case['name']}: {case['warning']}" for case in warned[:WARNINGS]]
    remarks = [sum(_lines(text, _REMARK) for text in figure["more"] if text) for figure in relied["figures"]]
    lines = sum(_lines(text, _WIDE) + 0.6 for text in paragraphs) + 0.8 * max(remarks, default=0)
    for case in said["results"][:CASES]:
        below = sum(_lines(text, _BELOW) for text in (case["range"], case["begins"]))
        lines += max(1.3 + 0.9 * below, _lines(case["name"], _NAME))
    lines += 1.7 * (_lines(said["name"], _TITLE) - 1)
    lines += len(said["project"]) + len(said["parameters"]) + bool(said["tags"]) + bool(said["document_hash"])
    lines += 0.4 * sum(_lines(text, _COLUMN) + 0.3 for text in said["assumptions"])
    if lines <= _LINES:
        return ""
    return "crowded" if lines <= _SMALLER else "crowded bare"


def _lines(text: str, width: int) -> int:
    return ceil(len(text) / width)
