"""Notes of a report, each once and numbered."""

from collections.abc import Iterable


class Notes:
    """Texts in the order in which they are first cited."""

    def __init__(self) -> None:
        self._number: dict[str, int] = {}

    def numbers(self, texts: Iterable[str]) -> list[int]:
        """Return the numbers of notes, and list those that are new."""
        return [self._number.setdefault(text, len(self._number) + 1) for text in texts]

    def listed(self) -> list[tuple[int, str]]:
        """Return the number and the text of every note."""
        return [(number, text) for text, number in self._number.items()]
