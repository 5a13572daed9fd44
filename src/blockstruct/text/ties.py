"""Sentences on ties, and on supports that hold some motions only."""

from collections.abc import Mapping

import numpy as np


def tie_title(name: str, kind: str = "tie") -> str:
    """Return the name of a tie for a sentence, after the word tie unless it begins with it.

    >>> tie_title("left"), tie_title("tie left")
    ('tie left', 'tie left')
    """
    return name if name.casefold().startswith("tie") else f"{kind} {name}"


def tie_sentence(
    name: str,
    state: str,
    force: float,
    capacity: float,
    governing: str,
    *,
    lengthens: float,
    elongation_limit: float,
    at: float,
) -> str:
    """Return the sentence on a tie at collapse.

    Parameters
    ----------
    name, state, governing
        Its name, its state, and the limit that its capacity is.
    force, capacity
        N.
    lengthens
        Elongation relative to the largest displacement of a block; zero if negligible.
    elongation_limit, at
        Elongation limit, and largest displacement of a block at which it is reached, m; NaN if it is not reached.
    """
    text = f"{tie_title(name, 'Tie')}: {state}, {kilonewton(force)} of {kilonewton(capacity)} ({governing})"
    if lengthens:
        text += f"; it lengthens by {lengthens:.3g} times the largest block displacement"
        if np.isfinite(at):
            text += f" and reaches its limit of {elongation_limit * 1e3:.4g} mm at {at * 1e3:.4g} mm, to first order"
    return f"{text}."


def kilonewton(force: float) -> str:
    """Return a force in N as text in kN."""
    return f"{force / 1e3:.4g} kN"


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
