"""Expected errors: their class, and the names, fields and values in their message."""

import re
from typing import Any

import pytest


def refused(error: type[Exception], words: str = "") -> Any:
    """Context that expects an error whose message has all words, in any order."""
    return pytest.raises(error, match="(?s)" + "".join(f"(?=.*{re.escape(word)})" for word in words.split()))
