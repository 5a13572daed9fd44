"""Sentences on supports that hold some motions only."""

from collections.abc import Mapping

from blockstruct.text.ties import kilonewton


def roller_sentence(name: str, reactions: Mapping[str, float]) -> str:
    """Return the sentence on the reactions of a support, N and N·m, in each motion that it holds.

    >>> roller_sentence("head", {"x": -7200.0, "ry": 0.0})
    'Support head holds x with -7.2 kN and ry with 0 kN·m.'
    """
    parts = [f"{motion} with {kilonewton(value)}{'·m' * ('r' in motion)}" for motion, value in reactions.items()]
    return f"Support {name} holds {' and '.join(filter(None, (', '.join(parts[:-1]), parts[-1])))}."


def more_rollers(number: int) -> str:
    """Return the sentence on supports that are not listed."""
    return f"{number} more such supports have reactions: result.support_reactions."
