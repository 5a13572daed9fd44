"""Find where blocks drop in a pushover until they meet others."""

from dataclasses import replace

import numpy as np

from blockstruct.procedures.attempts import Attempts
from blockstruct.procedures.pushover_state import Found, State

#: Blocks may have begun to drop in a step above both limits. The first is the rise of the dead load's work rate, in
#: multiples of the work rate at collapse. The second is the change of velocity, relative to the fastest.
BEGINS, CHANGES = 0.005, 0.07
#: Length of a trial step with the drop alone, as a share of a step. Least rise in the trial step, in multiples of the
#: rise in the whole step, that proves a drop. Least rise at an earlier point, in multiples of the rise in the trial
#: step, that proves a drop there. Halvings of the way.
SHORT, ALONE, AS_FAR, HALVINGS = 1 / 32, 4.0, 0.2, 4
#: Way, in mean block sizes, beyond the last motion up to which no block drops. Blocks that turn in a step push
#: penetrations out after it, and close gaps. Both are of second order in the step's length.
NO_DROP = 2e-3


def drop_on(tried: Attempts, state: State, following: Found, time: float) -> Found | None:
    """Find the state just before blocks drop, or the drop itself.

    Return the drop if blocks drop at once, and None if no block drops in the step. The work of the push is proportional
    to the step's length. Blocks that drop go all of their way in a step of any length. In a long step they would seem
    to drop for as much time.
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
            # The way of this state ends at the point of the drop.
            left = min(holds.state.time, behind - before)
            return replace(holds, state=replace(holds.state, time=left, drops_next=True))
    return found
