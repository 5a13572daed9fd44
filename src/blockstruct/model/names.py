"""What a name of a model object must be."""

from typing import Any

from blockstruct.errors import ModelError


def checked_name(name: Any, kind: str) -> str:
    """The name, if it is a text that can be printed on one line and is not blank."""
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        msg = f"{kind} {name!r}: a name must be a text of printable characters, not blank"
        raise ModelError(msg)
    return name
