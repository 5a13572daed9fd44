"""Where blocks drop in a pushover: nothing holds them any more, until they meet others."""

from dataclasses import replace

import numpy as np

from blockstruct.procedures.attempts import Attempts
from blockstruct.procedures.pushover_state import Found, State

#: Rise of the rate of the dead load's work, in multiples of what drives the collapse, and change of velocity, relative
#: to the fastest, in a step on which blocks may have begun to drop.
BEGINS, CHANGES = 0.005, 0.07
#: Share of a step in which what drops is alone; the least rise in it, in multiples of that of the whole step, if blocks
#: do; the least rise elsewhere on the way, in multiples of that one, if they do there as well; and halvings of the way.
SHORT, ALONE, AS_FAR, HALVINGS = 1 / 32, 4.0, 0.2, 4
#: Way, in mean block sizes, beyond that of the motion before, up to which none drops: blocks that turn in a step close
#: gaps behind it, as they push penetrations out, and those are of its square.
NO_DROP = 2e-3


def drop_on(tried: Attempts, state: State, following: Found, time: float) -> Found | None:
    """The state just before blocks drop on a step, or the drop itself where they do at once; None if none do.

    What the push drives goes with its step. What drops until it meets others goes all of that way in a step
    however short; on a step as long as others it would seem to hold for so long.
    """
    short, alpha = SHORT * following.state.time, following.solved.load_factor
    if state.drops_next:
        return tried.alone(state, following.moved, short, alpha)
    rise = following.solved.falling - state.falling
    velocity = state.carried(following.state.placement)[:, :3]
    change = np.abs(following.state.twist[:, :3] - velocity).max() / np.abs(velocity).max()
    if state.dropped or tried.drops(state.falling) or rise < BEGINS * tried.driving or change < CHANGES:
        return None
    found = tried.alone(state, following.moved, short, alpha)
    if found is None or found.solved.falling - state.falling < ALONE * rise:
        return None
    further = (found.state.twist[:, :3] - velocity) * short
    if np.abs(further).max() < NO_DROP * tried.problem.statics.length:
        return None
    least = state.falling + AS_FAR * (found.solved.falling - state.falling)
    before, behind = 0.0, time
    for _ in range(HALVINGS):
        half = (before + behind) / 2
        earlier = tried.alone(state, tried.after(state, half), short, alpha)
        if earlier is None:
            break
        if earlier.solved.falling > least:
            behind, found = half, earlier
        else:
            before = half
    if before:
        tried.go_on()
        holds = tried.reached(tried.after(state, before), state)
        if holds is not None and tried.goes_on(holds.solved):
            # Where the drop is on its way already, that way ends with it.
            left = min(holds.state.time, behind - before)
            return replace(holds, state=replace(holds.state, time=left, drops_next=True))
    return found
