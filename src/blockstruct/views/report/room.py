"""How much room the first page of a report has."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

#: Cases in its table, and warnings of cases, that it has room for.
CASES, WARNINGS = 8, 2
#: Width and height of its picture, inches.
PICTURE = (6.3, 3.1)
#: Largest width of the picture there, mm, and the least at which its texts can be read.
_LARGEST, _LEAST = 122.0, 76.0
#: Lines of text that fit beside its headings and its largest picture in the size of the other pages.
_LINES = 27.0
#: Characters in a line of the title, of a paragraph, of a column of the assumptions, of the remarks on a number on its
#: card and in the table, of the name of a case, and of what the head states.
_TITLE, _WIDE, _COLUMN, _REMARK, _BELOW, _NAME, _STATED = 40, 88, 48, 28, 50, 14, 70
#: Of a page that is set smaller, measured with the widest of its fonts: characters in a line of a paragraph and of a
#: column, and millimetres of what always stands there, of a line of the title, of a paragraph and the space below, of a
#: row of a table, of a remark, and of a line of a column and the space below.
_SMALL_WIDE, _SMALL_COLUMN = 106, 58
_ALWAYS, _TITLE_LINE, _LINE, _SPACE, _ROW, _REMARK_LINE, _COLUMN_LINE, _COLUMN_SPACE = 60, 6, 4, 1.3, 4.8, 3.4, 3.2, 0.7
#: Millimetres of a page between its margins, and of the spaces about a picture.
_PAGE, _ABOUT = 255, 4


@dataclass(frozen=True, slots=True)
class Room:
    """What the first page gives up to stay one page.

    Attributes
    ----------
    crowding : str
        Classes of its style: nothing, smaller texts, or no picture either.
    picture : float
        Width of its picture, mm.
    cases, warnings : int
        How many it shows.
    """

    crowding: str
    picture: float
    cases: int = CASES
    warnings: int = WARNINGS


def room_of(said: Mapping[str, Any], warned: Sequence[Mapping[str, str]]) -> Room:
    """Room for what stands on the first page.

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
    remarks = max(
        (sum(_lines(text, _REMARK) for text in card["more"] if text) for card in relied["figures"]), default=0
    )
    below = [
        (sum(_lines(text, _BELOW) for text in (case["range"], case["begins"])), _lines(case["name"], _NAME))
        for case in said["results"][:CASES]
    ]
    titles = _lines(said["name"], _TITLE) - 1
    stated = sum(_lines(text, _STATED) for text in [*said["project"].values(), *dict(said["parameters"]).values()])
    stated += bool(said["tags"]) + bool(said["document_hash"])
    lines = sum(_lines(text, _WIDE) + 0.6 for text in paragraphs) + 0.8 * remarks + 1.7 * titles + stated
    lines += sum(max(1.3 + 0.9 * more, names) for more, names in below)
    lines += 0.4 * sum(_lines(text, _COLUMN) + 0.3 for text in said["assumptions"])
    if lines <= _LINES:
        return Room("", _LARGEST)
    height = _ALWAYS + _TITLE_LINE * titles + _REMARK_LINE * remarks + _ROW * stated
    height += sum(_LINE * _lines(text, _SMALL_WIDE) + _SPACE for text in paragraphs)
    height += sum(max(_ROW + _REMARK_LINE * more, _ROW * names) for more, names in below)
    items = [_COLUMN_LINE * _lines(text, _SMALL_COLUMN) + _COLUMN_SPACE for text in said["assumptions"]]
    # No item is parted between the two columns.
    height += min(max(sum(items[:k]), sum(items[k:])) for k in range(len(items) + 1))
    caption = relied["picture"]["caption"] if relied["picture"] else ""
    width = (_PAGE - height - _LINE * _lines(caption, _SMALL_WIDE) - _ABOUT) * PICTURE[0] / PICTURE[1]
    return Room("crowded" if width >= _LEAST else "crowded bare", round(min(width, _LARGEST)))


def _lines(text: str, width: int) -> int:
    return ceil(len(text) / width)
