"""Capacity curve of a pushover, as the curve of the equivalent oscillator."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.arrays import SLIGHT, Array, Flags
from blockstruct.assess.capacity import CapacityCurve, components
from blockstruct.assess.lines import Line
from blockstruct.assess.participation import HorizontalForces, Participation
from blockstruct.errors import ModelError
from blockstruct.model import Model
from blockstruct.results import block_rotations
from blockstruct.results.case_result import CaseResult
from blockstruct.results.mechanism import TOGETHER
from blockstruct.text.numbers import shown
from blockstruct.vocabulary import counted


def curve_of_pushover(
    result: CaseResult, capacity: xr.Dataset, push: Array, participation: Participation, a0_star: float
) -> CapacityCurve:
    """Return the capacity curve of a pushover, C8.7.1.2.1.2 and [C8.7.1.4].

    Parameters
    ----------
    result
        Collapse state of a pushover.
    capacity
        ``result.capacity``, used up to the first step whose certificate does not hold.
    push : (3,) array
        Direction of the push, a unit vector.
    participation
        Participation of the macro-blocks.
    a0_star
        Acceleration at the collapse state, m/s².

    Returns
    -------
    CapacityCurve
        Acceleration, m/s², over the displacement of the oscillator, m, from the collapse state on.

    Raises
    ------
    ModelError
        If the control point does not follow the push, rests in the mechanism or turns back, no step is
        certified, or a tie has no elongation limit.
    """
    case: Any = result.case
    block, direction = case.control
    unlimited = [t.name for t in result.model.ties if t.elongation_limit is None]
    if unlimited:
        msg = (
            f"tie {unlimited[0]!r} has no elongation limit, so nothing verifies that it holds until α vanishes "
            "(C8.7.1.2.1.6): give it one"
        )
        raise ModelError(msg)
    if np.linalg.norm(np.cross(direction, push)) > SLIGHT:
        # At a finite rotation, motion across the push is not proportional to motion along it.
        msg = (
            f"the control point at block {block!r} moves along ({components(direction)}), but the oscillator moves "
            "along the push (C8.7.1.2.1.3): run the pushover again with "
            f"control=({block!r}, ({components(push)}))"
        )
        raise ModelError(msg)
    mechanism = result.mechanism.sel(block=block)
    shift, turn = (mechanism[name].transpose("axis").to_numpy() for name in ("translation", "rotation"))
    centroid = result.model.block(block).centroid
    point = centroid if case.control_point is None else np.array(case.control_point)
    delta = float((shift + np.cross(turn, point - centroid)) @ direction) / participation.scale
    if abs(delta) < TOGETHER:
        msg = f"the control point at block {block!r} rests in the mechanism"
        raise ModelError(msg)
    certified = _certified(capacity)
    d_C = capacity["displacement"].transpose("step").to_numpy()[certified]
    side = np.sign(d_C[np.abs(d_C).argmax()])
    d_C = d_C * side
    back = _turns_back(d_C)
    if back.any():
        at = d_C[: int(back.argmax())].max()
        msg = (
            f"the control point at block {block!r} turns back at {shown(float(at), 'm')}, so its displacement no "
            f"longer measures the mechanism: {_instead(capacity, certified, side * np.array(direction), d_C.max())}"
        )
        raise ModelError(msg)
    alpha = capacity["load_factor"].transpose("step").to_numpy()[certified]
    d_C, alpha = _onward(d_C, alpha)
    end = float(abs(capacity["d0"]))
    complete = bool(certified.all()) and np.isfinite(end)
    if complete:
        before = d_C < end
        d_C, alpha = np.append(d_C[before], end), np.append(alpha[before], 0.0)
    # Joints alone deform until the first state, where rounded corners carry less than the interfaces at collapse.
    beyond = d_C > max(d_C[0], 0.0)
    at_rest = min([result.load_factor, *alpha[~beyond]])
    d_C, alpha = np.append(0.0, d_C[beyond]), np.append(at_rest, alpha[beyond])
    if len(d_C) < 3 or np.any(np.diff(d_C) <= 0):
        msg = f"the pushover has {counted(len(d_C) - 1, 'certified step')}, or its control point stands still"
        raise ModelError(msg)
    steps = len(d_C) - 1
    breaks = np.zeros(0, dtype=np.int64)
    if "tie_break_displacement" in capacity:
        broke = np.abs(capacity["tie_break_displacement"].to_numpy())
        breaks = np.unique(np.searchsorted(d_C, broke[broke < d_C[-1]])) - 1
    factor = participation.factor / abs(delta)
    d, a = d_C * factor, a0_star / result.load_factor * alpha
    until = "where α vanishes" if complete else "its end before α vanishes, which counts as d0"
    lines = (
        Line("curve of the pushover", f"{steps} steps, to {shown(float(d_C[-1]), 'm')}, {until}", "C8.7.1.2.1.2"),
        Line(
            "displacement of the oscillator",
            f"d = d_C Σ(P+Q)δ² / (δ_C Σ(P+Q)δ) = d_C · {shown(factor)}; C is on block {block}",
            "C8.7.1.2.1.3 (C8.7.1.4)",
        ),
        Line(
            "capacity curve",
            f"a(d) = α(d_C) g / (e* FC), from {shown(float(a[0]), 'm/s²')}; d0 = {shown(float(d[-1]), 'm')}",
            "C8.7.1.2.1.3 (C8.7.1.3)",
        ),
    )
    # Loss in each step; ties count with the ties that broke before them.
    falls = -np.diff(alpha) / alpha.max()
    falls[breaks] = np.cumsum(falls[breaks])
    return CapacityCurve(d, a, lines, tuple(zip(d[:-1].tolist(), falls.tolist(), strict=True)))


def d0_of_weights(
    model: Model, capacity: xr.Dataset, forces: HorizontalForces, names: Sequence[str], e_star: float
) -> float:
    """Return d0 of a pushover, m, measured by the weights P + Q instead of the control point.

    It is their mean displacement along the push at the last certified step, over e*: [C8.7.1.4] with their mean δ as
    the δ of the control point.

    Parameters
    ----------
    model, capacity
        Model and ``result.capacity`` of the pushover.
    forces
        Weights P + Q, their points and the direction of the push.
    names
        Blocks whose weights count.
    e_star
        Participating share e* of the mass.
    """
    last = int(np.flatnonzero(_certified(capacity))[-1])
    index = model.block_index
    of = np.isin(forces.block, [index[name] for name in names])
    block, weight = forces.block[of], forces.weight[of]
    arm = forces.point[of] - np.array([b.centroid for b in model.blocks])[block]
    position = capacity["position"].transpose("step", "block", "axis").to_numpy()[last, block]
    now = position + np.einsum("nij,nj->ni", block_rotations(capacity)[last, block], arm)
    return float(weight @ ((now - forces.point[of]) @ forces.direction) / weight.sum() / e_star)


def _turns_back(way: Array) -> Flags:
    """Return the states, (state, …), in which displacements are smaller than before."""
    return np.asarray(np.maximum.accumulate(way) - way > SLIGHT * way.max(axis=0))


def _onward(way: Array, alpha: Array) -> tuple[Array, Array]:
    """Return the states below all later displacements, each with the least α since the state before it.

    Of several α at one displacement it keeps the lowest, so that a return motion never raises the curve.
    """
    nearest = np.minimum.accumulate(way[::-1])[::-1]
    on = np.flatnonzero(np.append(way[:-1] < nearest[1:], True))
    return way[on], np.minimum.reduceat(alpha, np.append(0, on[:-1] + 1))


def _instead(capacity: xr.Dataset, certified: Flags, direction: Array, furthest: float) -> str:
    """Return the remedy for a control point that turns back."""
    position = capacity["position"].transpose("step", "block", "axis").to_numpy()[certified]
    way = (position - position[0]) @ direction
    on = np.where(_turns_back(way).any(axis=0), -np.inf, way[-1])
    if not on.max() > furthest:
        return "no block goes further without turning back; look at the states of the pushover (result.capacity)"
    return (
        f"run the pushover again with control= at block {str(capacity['block'].values[int(on.argmax())])!r}, which "
        f"reaches {shown(float(on.max()), 'm')}"
    )


def _certified(capacity: xr.Dataset) -> Flags:
    """Return which steps precede the first one whose certificate does not hold."""
    return np.cumprod(capacity["holds"].transpose("step").to_numpy()).astype(bool)
