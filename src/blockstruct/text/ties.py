"""Sentences on ties, and on supports that hold some motions only."""

from collections.abc import Mapping, Sequence

import numpy as np

from blockstruct.text.numbers import LISTED
from blockstruct.vocabulary import SolverStatus

#: Force of a tie, relative to the sum of all, that counts as zero.
_ROUNDING = 1e-6


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


def least_ties_sentence(
    load_factor: float,
    forces: Mapping[str, float],
    solver_status: SolverStatus,
    governing: str,
    *,
    is_associative: bool,
    proven: bool,
) -> str:
    """Return the sentence on the ties of least total strength that carry a load factor.

    Parameters
    ----------
    load_factor
    forces
        Strength of each tie, N; NaN if no strength is enough.
    solver_status
        How the program ended.
    governing
        ``"load factor"``, ``"dead load"`` or ``"both"``: the requirement that sets the strengths.
    is_associative, proven
        Flow of the case, and whether weaker ties are proven to be too weak.
    """
    total = sum(forces.values())
    if np.isnan(total):
        is_infeasible = solver_status is SolverStatus.INFEASIBLE
        why = "no strength of these is enough" if is_infeasible else f"the solver ended as {solver_status}"
        at = ", under the dead load alone" if governing == "dead load" else ""
        return f"load factor {load_factor:.6g}: none ({', '.join(forces)}: {why}{at})"
    # The residual force of a tie that is not needed is the solver's rounding.
    rounded = {name: force if force > _ROUNDING * total else 0.0 for name, force in forces.items()}
    each = ", ".join(f"{name} {force / 1e3:.5g} kN" for name, force in rounded.items())
    clauses = [f"load factor {load_factor:.6g}: {total / 1e3:.5g} kN in all ({each})"]
    if not is_associative:
        clauses.append("with associative flow: without dilatancy these ties may carry less, run the case with them")
    if governing == "dead load":
        clauses.append("the dead load alone asks for them")
    if not proven and governing == "both":
        clauses.append("not proven, the dead load alone asks for others than the load factor: a smaller sum may do")
    elif not proven:
        clauses.append("not proven, the certificate does not hold")
    return "; ".join(clauses)


def kilonewton(force: float) -> str:
    """Return a force in N as text in kN."""
    return f"{force / 1e3:.4g} kN"


def roller_sentences(reactions: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return a sentence on each support, with its reactions, N and N·m, in the motions that it holds.

    >>> roller_sentences({"head": {"x": -7200.0, "ry": 0.0}})
    ['Support head holds x with -7.2 kN and ry with 0 kN·m.']
    """
    sentences = []
    for name, of_support in list(reactions.items())[:LISTED]:
        parts = [f"{motion} with {kilonewton(value)}{'·m' * ('r' in motion)}" for motion, value in of_support.items()]
        held = " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))
        sentences.append(f"Support {name} holds {held}.")
    more = len(reactions) - LISTED
    return sentences + [f"{more} more such supports have reactions: result.support_reactions."] * (more > 0)


def breaking_clause(breaks: Sequence[tuple[str, float, float]], before: float, after: float) -> str:
    """Return the clause on ties that break together: name, displacement, m, and elongation, m.

    The load factor is ``before`` in the state before, and ``after`` in the state after.
    """
    each = [
        f"{tie_title(str(name))} breaks at a displacement of {at * 1e3:.4g} mm, {longer * 1e3:.4g} mm longer"
        for name, at, longer in breaks
    ]
    return f"{' and '.join(each)}: the load factor falls from {before:.4g} to {after:.4g}"


def more_breaks(count: int) -> str:
    """Return the clause on ties that break and are not listed."""
    return f"{count} more {'tie breaks' if count == 1 else 'ties break'}"


def holding_ties(ties: Sequence[tuple[str, float, float]]) -> list[str]:
    """Return a sentence on each tie that does not break: name, largest elongation, m, and largest force, N."""
    sentences = []
    for name, elongation, force in ties[:LISTED]:
        title = tie_title(name)
        lengthens = f"it lengthens by at most {1e3 * elongation:.4g} mm, under {kilonewton(force)} at most"
        sentences.append(f"{title[:1].upper()}{title[1:]} holds: {lengthens}.")
    more = len(ties) - LISTED
    return sentences + [f"{more} more hold{'s' * (more == 1)}, too."] * (more > 0)
