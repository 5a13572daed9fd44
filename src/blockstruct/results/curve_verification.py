"""Verification of capacity curves from model, forces and positions."""

from collections.abc import Iterator
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import LimitProblem, Placement, reaction_unit
from blockstruct.model import SettlementCase, has_curve
from blockstruct.motion import MotionState, MovingProblem, largest_displacement, recomputed
from blockstruct.results.capacity import steps_of
from blockstruct.results.case_result import CaseResult
from blockstruct.results.ties import DECIMALS, break_displacements
from blockstruct.statics import Statics

Array = NDArray[np.float64]

#: Largest elastic displacement of the first state, relative to the mean block size.
ELASTIC = 1e-3
#: Distance of blocks from the positions that their motions give, relative to the mean block size: rotations round.
MOVED = 1e-6
#: Relative difference of two computations, and difference of dimensionless values, that rounding makes.
SAME, ROUNDING = 1e-3, 1e-6
#: Relative difference of d0, and of the work of the variable load in a second from 1 J, that rounding makes.
OF_D0, AT_ONE_WATT = 1e-9, 1e-5
#: Values that follow from the others of a state, and whether they are lengths.
_FOLLOWS = {
    "displacement": True,
    "tie_elongation": True,
    "penetration": True,
    "dissipation": False,
    "work": False,
    "inertia": False,
    "energy_error": False,
    "equilibrium_residual": False,
    "yield_excess": False,
    "interpenetration": False,
    "flow_rule_gap": False,
    "contact_points": False,
}


def curve_contradictions(statics: Statics, problem: LimitProblem, result: CaseResult) -> Iterator[str]:
    """Yield contradictions between a capacity curve and its model and forces.

    All that follows from forces, places and motions is computed again by the function that computed it first.
    """
    if result.capacity is None or not has_curve(result.case):
        return
    curve, moving = result.capacity, MovingProblem(statics, problem, result.case)
    states, names = steps_of(curve), [b.name for b in statics.model.blocks]
    for k, state in enumerate(states):
        for what in _of_state(moving, states[k - 1] if k else None, state, names):
            yield f"state {k} of the capacity curve: {what}"
    for k, (state, again) in enumerate(zip(states, recomputed(moving, result.settings, states), strict=True)):
        for what in _differences(state, again, statics.length):
            yield f"state {k} of the capacity curve: {what}"
    of_states = (np.array([getattr(s, name) for s in states]) for name in ("displacement", "load_factor", "falls"))
    d0 = largest_displacement(result.case, *of_states)
    if not np.isclose(float(curve["d0"]), d0, rtol=OF_D0, atol=0.0, equal_nan=True):
        yield f"d0 is {float(curve['d0']):.6g} m, that of the capacity curve {d0:.6g} m"
    if isinstance(result.case, SettlementCase):
        reaction = -reaction_unit(statics.model, result.case) * curve["load_factor"].to_numpy()
        if not np.allclose(curve["reaction"], reaction, rtol=OF_D0, atol=0.0):
            yield "the reactions of the capacity curve are not those of its load factors"
    if "tie_break_displacement" in curve:
        limit = statics.ties.elongation_limit
        elongation = np.array([state.tie_elongation for state in states])
        broke = break_displacements(np.array([state.displacement for state in states]), elongation, limit)
        for name, expected in (("tie_elongation_limit", limit), ("tie_break_displacement", broke)):
            stored = curve[name].to_numpy()
            off = ~np.isclose(stored, expected, rtol=OF_D0, atol=10.0**-DECIMALS, equal_nan=True)
            if off.any():
                k = int(off.argmax())
                yield (
                    f"{name} of tie {curve['tie'].to_numpy()[k]!r} of the capacity curve is {stored[k]:.6g} m, that of "
                    f"its model and elongations {expected[k]:.6g} m"
                )


def _of_state(moving: MovingProblem, before: MotionState | None, state: MotionState, names: list[str]) -> Iterator[str]:
    """Compare the positions of blocks with the motion that led there, and this motion with its unit."""
    size, at = moving.statics.length, Placement.at(state.position, state.rotation)
    led, most = Placement.of(moving.statics.model), ELASTIC * size
    if before is not None:
        most = MOVED * size
        led = Placement.at(before.position, before.rotation).moved(before.twist * before.motion_time)
    turned = np.abs(at.rotation - led.rotation).max(axis=(1, 2)) * size
    off = np.maximum(np.abs(at.position - led.position).max(axis=1), turned)
    if not off.max() <= most:
        where = "the way that the motion before leads" if before is not None else "its place in the model"
        yield f"block {names[int(off.argmax())]!r} is {off.max():.3g} m off {where}, more than {most:.3g} m"
    power = float((moving.variable.at(at) * state.twist).sum())
    if not abs(power - 1) <= AT_ONE_WATT:
        yield f"its velocities belong to {power:.6g} W of variable load, not to 1 W"
    length = np.linalg.norm(state.normal_of_contact, axis=1)
    if not np.abs(length - 1).max(initial=0.0) <= OF_D0:
        yield f"the normal of one of its contacts has a length of {length[np.abs(length - 1).argmax()]:.6g}, not 1"


def _differences(state: MotionState, again: MotionState, size: float) -> Iterator[str]:
    """Compare the derived values of a state with those that it stores."""
    work = max(abs(again.load_factor), abs(again.dissipation), 1.0)
    for name in (f.name for f in fields(MotionState) if f.name in _FOLLOWS):
        stored, found = (np.atleast_1d(np.asarray(getattr(of, name), dtype=float)) for of in (state, again))
        least = MOVED * size if _FOLLOWS[name] else ROUNDING * work
        # NaN differs from every number.
        off = ~(np.abs(stored - found) <= least + SAME * np.abs(found))
        if off.any():
            k = int(off.argmax())
            yield f"its {name.replace('_', ' ')} is {stored[k]:.6g}, and {found[k]:.6g} by its forces and places"
    if state.holds != again.holds:
        yield f"its certificate {'holds' if state.holds else 'does not hold'}, by its forces the other is true"
