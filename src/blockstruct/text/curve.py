"""How the curve of a pushover ends, or why there is none."""

from blockstruct.motion import CurveOutcome
from blockstruct.vocabulary import CurveEnd, listed


def curve_end(outcome: CurveOutcome, control: tuple[str, tuple[float, float, float]]) -> str:
    """Return a clause on the end of a curve, with what to do if there is none.

    Parameters
    ----------
    outcome
        Its facts.
    control
        Block and direction of the control point.
    """
    block, direction = control
    names, at = listed(list(outcome.blocks)), f"at a displacement of {outcome.displacement:.6g} m"
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
        case CurveEnd.EARLIER_VERSION:
            return "the file is of an earlier version, whose curves are no longer read: run the case again"
        case CurveEnd.BEGINS_ABOVE:
            where = f"{names}, where the model has no interface" if names else "faces larger than its interfaces"
            return (
                f"no curve: with sharp corners it would begin at a load factor of {outcome.load_factor:.4g}, above "
                f"that of the collapse state, as blocks that move touch wherever faces do: forces at {where}. Give the "
                "interfaces that are there, or blocks whose faces are no larger, and compare the load factors"
            )


def _shown(direction: tuple[float, ...]) -> str:
    return f"({', '.join(f'{round(value, 4) + 0.0:.3g}' for value in direction)})"
