"""Sentences on capacity curves: their ends, why they are missing, and doubts."""

from blockstruct.model import MovingCase, Pushover
from blockstruct.motion import CurveOutcome
from blockstruct.vocabulary import CurveDoubt, CurveEnd, listed

_OTHER_STEPS = ", so run it with other steps and compare"
_BEGUN = (
    ", or friction leaves more than one collapse state, and procedure='loading path' in the settings finds the one "
    "that loading leads to"
)


def curve_end(outcome: CurveOutcome, case: MovingCase) -> str:
    """Return a clause on the end of a curve, with the remedy if it is missing.

    Parameters
    ----------
    outcome
        Its facts.
    case
        The pushover or settlement.
    """
    if outcome.end is CurveEnd.EARLIER_VERSION:
        return "the file is of an earlier version, whose curves are no longer read: run the case again"
    names, at = listed(list(outcome.blocks)), f"at a displacement of {outcome.displacement:.6g} m"
    if isinstance(case, Pushover):
        return _end_of_pushover(outcome, case, names, at)
    match outcome.end:
        case CurveEnd.DISPLACEMENT_REACHED:
            return f"the structure follows its supports up to a displacement of {outcome.displacement:.6g} m"
        case CurveEnd.FALLS:
            return f"the supports move by {outcome.displacement:.6g} m at most, then blocks fall ({names})"
        case CurveEnd.LIMIT_REACHED:
            return f"no end after {outcome.states} states: ask for more steps, or a smaller displacement"
        case CurveEnd.BEGINS_ABOVE:
            return (
                "no curve: it would begin at a smaller reaction than that of the case, as blocks that move touch "
                f"wherever faces do: forces at {names or 'faces larger than its interfaces'}. Give the interfaces that "
                "are there, and compare the reactions"
            )
        case _:
            return f"no forces that hold the blocks are found {at}, and the method ends"


def _end_of_pushover(outcome: CurveOutcome, case: Pushover, names: str, at: str) -> str:
    block, direction = case.control
    moves = f"block {outcome.blocks[0]!r} moves furthest, along {_shown(outcome.direction)}" if outcome.blocks else ""
    match outcome.end:
        case CurveEnd.ZERO:
            stands = f", where the control point at block {block!r} stands still or goes back: {moves}"
            return f"the load factor is zero {at}{stands if outcome.stands else ''}"
        case CurveEnd.FALLS:
            return f"blocks fall under the dead load alone {at} ({names}), and the method ends"
        case CurveEnd.NOT_SOLVED:
            return (
                f"no load factor is found {at}: no forces carry the dead load, and blocks fall, or the push meets what "
                "it cannot move; and the method ends"
            )
        case CurveEnd.LIMIT_REACHED:
            return (
                f"no end after {outcome.states} states: ask for more steps, or follow a point and a direction that the "
                "mechanism goes along"
            )
        case CurveEnd.RESTS:
            return (
                f"the control point at block {block!r} does not move along {_shown(direction)} in the collapse "
                f"mechanism, and there is no curve over its displacement; {moves}"
            )
        case _:
            where = f"{names}, where the model has no interface" if names else "faces larger than its interfaces"
            return (
                f"no curve: with sharp corners it would begin at a load factor of {outcome.load_factor:.4g}, above "
                f"that of the collapse state, as blocks that move touch wherever faces do: forces at {where}. Give the "
                "interfaces that are there, or blocks whose faces are no larger, and compare the load factors"
            )


def _shown(direction: tuple[float, ...]) -> str:
    return f"({', '.join(f'{round(value, 4) + 0.0:.3g}' for value in direction)})"


def doubtful_part(
    doubt: CurveDoubt,
    displacement: tuple[float, float],
    load_factor: tuple[float, float],
    missed: float,
    procedure: str,
    *,
    has_ties: bool,
) -> str:
    """Return a clause on a part of a capacity curve that may depend on its steps.

    Parameters
    ----------
    doubt
    displacement, load_factor
        Of the control point, m, and of the states between which the part lies.
    missed
        Share of all work so far that the forces miss.
    procedure
        Procedure that found the collapse state.
    has_ties
        Whether the structure has ties.
    """
    before, after = (f"{1e3 * d:.4g} mm" for d in displacement)
    changes = f"from {load_factor[0]:.4g} to {load_factor[1]:.4g} at a displacement of"
    match doubt:
        case CurveDoubt.RISES:
            tight = ", or ties are pulled tight" if has_ties else ""
            begun = "" if procedure == "loading path" else _BEGUN
            return f"the load factor rises {changes} {after}: blocks meet, interlock or jam{tight}{begun}"
        case CurveDoubt.SLIPS:
            why = "where units slip and catch a curve depends on its steps"
            return f"the load factor jumps {changes} {before}: {why}{_OTHER_STEPS}"
        case CurveDoubt.LEAPS:
            why = "another mechanism takes over, as where the hinge of an arch leaps, or a block tips after it slid"
            return f"the load factor jumps {changes} {before}: {why}{_OTHER_STEPS}"
        case CurveDoubt.MISSES_WORK:
            work = f"{missed:.1%} of all work is missed in the step from a displacement of {before}"
            return f"{work}: blocks drop or meet, or hinges leap there{_OTHER_STEPS}"
        case CurveDoubt.ROCKS | CurveDoubt.ROCKS_AND_SLIDES:
            rock = "rock" if doubt is CurveDoubt.ROCKS else "rock and slide"
            where = f"up to a displacement of {before}, and {rock} from {after} on"
            return f"blocks slide {where}: that is known to a step{_OTHER_STEPS}"
