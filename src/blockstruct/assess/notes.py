"""Which notes a check needs, from the facts of its collapse state, curve, bodies and demand."""

from collections.abc import Callable, Collection, Sequence

import numpy as np
import xarray as xr

from blockstruct.arrays import SLIGHT
from blockstruct.assess.capacity import CapacityCurve
from blockstruct.assess.capacity_of_pushover import d0_of_weights
from blockstruct.assess.floor_spectrum import FloorSpectrum, Spectrum
from blockstruct.assess.limit_states import LimitState
from blockstruct.assess.overturning import Overturning, supporting
from blockstruct.assess.participation import HorizontalForces, Participation, taking_part
from blockstruct.assess.spectrum import NtcSpectrum
from blockstruct.model import Model
from blockstruct.results import MacroBlock, applied_loads
from blockstruct.results.case_result import CaseResult
from blockstruct.results.ties import tie_state
from blockstruct.text import assessment
from blockstruct.text.note import EFFECT, Note, Severity
from blockstruct.vocabulary import Flow, TieState

#: Motion out of the plane of a mechanism, relative to the largest, from which there is a note.
_OUT_OF_PLANE = 0.05
#: Load factor at the end of a capacity curve, relative to the first, from which the curve ends too early.
_LEFT = 0.1
#: Difference of the d0 of two capacity curves of one mechanism, from which they do not describe one motion.
OTHER_CURVE = 0.03
#: Height above the foot of the structure, relative to its own, from which a mechanism needs a floor spectrum.
_HIGH = 0.25


def notes_of(
    result: CaseResult, forces: HorizontalForces, bodies: Sequence[MacroBlock], whole: Participation
) -> list[Note]:
    """Return the notes on the collapse state, its capacity curve, bodies and masses."""
    notes = [assessment.associative_bound()] if result.case.flow is Flow.ASSOCIATIVE else []
    notes += [note for note in result.notes if note.severity is not Severity.INFO]
    if result.capacity is not None:
        notes += _of_curve(result, result.capacity)
    notes += _of_ties(result)
    if _out_of_plane(bodies) > _OUT_OF_PLANE:
        notes.append(assessment.out_of_plane())
    moving = _moving(taking_part(bodies, whole))
    index = result.model.block_index
    dead = applied_loads(result.model, result.case.dead)
    down = float(-dead.force[np.isin(dead.block, [index[name] for name in moving]), 2].sum())
    if abs(down - whole.total) > 1e-6 * max(down, whole.total):
        notes.append(assessment.masses_differ(down, whole.total))
    return notes


def without_small(whole: Participation) -> Participation:
    """Return the participation without bodies that move far less than the others along the push, if they raise a0*."""
    large, _ = whole.parted()
    return whole if whole.e_star >= large.e_star / (1 + EFFECT) else large


def note_of_small(whole: Participation, large: Participation, a0_star: float) -> Note:
    """Return the note on bodies that move far less, with a0* without them, m/s²."""
    _, small = whole.parted()
    return assessment.small_motions(
        small.total,
        whole.total,
        float(np.abs(small.displacement).max()),
        e_star=large.e_star,
        a0_star=a0_star,
    )


def notes_of_parts(
    parts: Sequence[Sequence[MacroBlock]], known: Sequence[Sequence[MacroBlock]], ratios: Sequence[float]
) -> list[Note]:
    """Return the note on several mechanisms at one load factor, with their ratios."""
    if len(parts) == 1:
        return []

    def named(part: Sequence[MacroBlock]) -> str:
        return " with ".join(f"{body.name} ({body.blocks[0]})" for body in part)

    checked = [(named(known[k]), ratios[k]) for k in np.argsort(ratios, kind="stable").tolist()]
    unfollowed = [named(part) for part in parts if part not in known]
    return [assessment.separate_mechanisms(len(parts), checked, unfollowed)]


def _out_of_plane(bodies: Sequence[MacroBlock]) -> float:
    """Return the largest motion out of the plane of the fastest rotation."""
    moving = [body for body in bodies if body.moves]
    turns = np.array([body.rotation for body in moving])
    speeds = np.linalg.norm(turns, axis=1)
    if not speeds.max() > 1e-6:
        return 0.0
    normal = turns[speeds.argmax()] / speeds.max()
    shifts = np.array([body.translation for body in moving])
    tilted = np.linalg.norm(np.cross(turns, normal), axis=1) / speeds.max()
    return float(max(np.abs(shifts @ normal).max(), tilted.max()))


def _moving(bodies: Sequence[MacroBlock]) -> list[str]:
    """Return the names of the moving blocks."""
    return [name for body in bodies if body.moves for name in body.blocks]


def _of_curve(result: CaseResult, capacity: xr.Dataset) -> list[Note]:
    notes, alpha = [], capacity["load_factor"].to_numpy()
    rounding = getattr(result.case, "corner_rounding", 0.0)
    if rounding:
        notes.append(assessment.rounded_corners(rounding, float(alpha[0]), result.load_factor))
    notes += [assessment.curve_doubt(str(part)) for part in result.curve_doubts]
    if not np.isfinite(capacity["d0"]) and alpha[-1] > _LEFT * alpha[0]:
        notes.append(assessment.curve_end(float(alpha[0]), float(alpha[-1])))
    return notes


def _of_ties(result: CaseResult) -> list[Note]:
    if not result.model.ties:
        return []
    last = result.history.isel(iteration=-1)
    gives_way = tie_state(last).isin([TieState.PUNCHING, TieState.SLIPPING]).to_numpy()
    return [assessment.anchorages(last["tie"].to_numpy()[gives_way].tolist())] if gives_way.any() else []


def notes_of_demand(model: Model, bodies: Sequence[MacroBlock], spectrum: Spectrum) -> list[Note]:
    """Return whether the spectrum suits the height at which the mechanism stands."""
    moving = set(_moving(bodies))
    heights = {b.name: b.shape.vertices[:, 2] for b in model.blocks if not b.fixed}
    foot, top = min(z.min() for z in heights.values()), max(z.max() for z in heights.values())
    low = min(heights[name].min() for name in moving) - foot
    stands = _stands(model, moving)
    if isinstance(spectrum, FloorSpectrum) and spectrum.peak < spectrum.ground.peak:
        return [assessment.floor_below_ground(spectrum.peak, spectrum.ground.peak)]
    # A support as high is a terrace of the ground, or a building.
    if isinstance(spectrum, NtcSpectrum) and low > _HIGH * (top - foot):
        return [assessment.ground_at_height(float(low), on_support=stands)]
    if isinstance(spectrum, FloorSpectrum) and stands:
        return [assessment.floor_on_ground(spectrum.peak, spectrum.ground.peak)]
    return []


def _stands(model: Model, moving: Collection[str]) -> bool:
    """Return whether any moving block stands on a support, rather than next to one."""
    fixed = {b.name for b in model.blocks if b.fixed}
    return any(below in fixed and above in moving for below, above in supporting(model))


def notes_of_height(model: Model, beside: Overturning, part: Sequence[MacroBlock]) -> list[Note]:
    """Return whether the mechanism by hand stands higher than the one found, which changes its demand."""
    feet = [min(model.block(n).shape.vertices[:, 2].min() for n in names) for names in (beside.blocks, _moving(part))]
    height = float(feet[0] - feet[1])
    return [assessment.hand_is_higher(height)] if height > SLIGHT * model.characteristic_length else []


def notes_of_control(
    model: Model,
    capacity: xr.Dataset,
    curve: CapacityCurve,
    forces: HorizontalForces,
    bodies: Sequence[MacroBlock],
    whole: Participation,
    slv: Callable[[CapacityCurve], LimitState | None],
) -> tuple[list[Note], LimitState | None]:
    """Return the note on a control point apart from the weights, and SLV by their d0."""
    d0, of_weights = curve.d0, d0_of_weights(model, capacity, forces, _moving(bodies), whole.e_star)
    if -OTHER_CURVE * of_weights <= d0 - of_weights <= EFFECT * of_weights:
        return [], None
    less = slv(curve.with_d0(of_weights)) if 0 < of_weights < d0 else None
    return [assessment.control_point(d0, of_weights)], less
