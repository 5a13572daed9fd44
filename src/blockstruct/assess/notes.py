"""What one must know before relying on a check."""

from collections.abc import Callable, Collection, Sequence

import numpy as np
import xarray as xr

from blockstruct.assess.capacity import CapacityCurve
from blockstruct.assess.capacity_of_pushover import d0_of_weights
from blockstruct.assess.check import LimitState
from blockstruct.assess.floor_spectrum import FloorSpectrum
from blockstruct.assess.lines import in_g, shown
from blockstruct.assess.overturning import Overturning
from blockstruct.assess.participation import HorizontalForces, Participation, taking_part
from blockstruct.assess.spectrum import NtcSpectrum, Spectrum
from blockstruct.model import STANDARD_GRAVITY, Model
from blockstruct.results import CaseResult, MacroBlock, applied_loads, doubtful_words, tie_state
from blockstruct.results.macro_blocks import TOGETHER
from blockstruct.vocabulary import Flow, TieState

g = STANDARD_GRAVITY
#: Shortfall, and excess, of d0 by the control point from that by the weights, in multiples of it, for it to be told.
_BELOW, _ABOVE = 0.03, 0.01
#: Displacement of a body, in multiples of the largest, below which it is told that e* counts its whole weight.
_SMALL = 0.1
#: Motion out of the plane of a mechanism, in multiples of the largest.
_OUT_OF_PLANE = 0.05
#: Load factor at the end of a capacity curve, relative to the first, from which what may come behind it is told.
_LEFT = 0.1
#: Height over the foot of the structure, in multiples of its own, from which a mechanism stands on what moves with it.
_HIGH = 0.25
#: Height between two mechanisms that stand on one level, in multiples of the length of the model.
_LEVEL = 1e-3
#: Least vertical part of the normal of a joint whose upper block is upon the lower one.
_UPON = 0.5


def notes_of(
    result: CaseResult, forces: HorizontalForces, bodies: Sequence[MacroBlock], whole: Participation
) -> list[str]:
    """Of the collapse state, its procedure, its capacity curve, its bodies and its masses."""
    said = []
    if result.case.flow is Flow.ASSOCIATIVE:
        said.append(
            "α0 is that of associative flow, an upper bound of every other flow rule: run the case non-associative "
            "before relying on it."
        )
    said += [*result.warnings, *result.owed]
    rounding = getattr(result.case, "corner_rounding", 0.0)
    if rounding and result.capacity is not None:
        said.append(
            f"Corners are rounded by {1e3 * rounding:.4g} mm in the capacity curve alone: at rest it has a load factor "
            f"of {shown(float(result.capacity['load_factor'][0]))}, and α0, {shown(result.load_factor)}, is that of "
            "the joints as the model has them."
        )
    if result.capacity is not None:
        doubtful = doubtful_words(result.capacity, result.settings.procedure)
        said += [f"In the capacity curve {text}." for text in doubtful]
        said += _of_end(result.capacity)
    said += _of_ties(result)
    off = max((body.departure for body in bodies if body.moves), default=0.0)
    if off > TOGETHER:
        said.append(
            f"Blocks that are taken as one body move by up to {off:.2g} of the largest motion relative to it, and e* "
            "hangs on what is one body: compare other values of tolerance=, in Python, and rely on the lowest ratio."
        )
    if _out_of_plane(bodies) > _OUT_OF_PLANE:
        said.append(
            "The bodies do not move parallel to one plane: the procedure is calibrated for mechanisms that do "
            "(C8.7.1.2.1.6)."
        )
    moving = _moving(taking_part(bodies, whole))
    index = result.model.block_index
    dead = applied_loads(result.model, result.case.dead)
    down = float(-dead.force[np.isin(dead.block, [index[name] for name in moving]), 2].sum())
    if abs(down - whole.total) > 1e-6 * max(down, whole.total):
        said.append(
            f"The dead load of the bodies that move is {down / 1e3:.4g} kN, the weight of the masses that the push "
            f"moves {whole.total / 1e3:.4g} kN: masses without a horizontal force, or forces of no weight, are among "
            "the loads."
        )
    if not whole.unique:
        said.append(
            "The joints of this mechanism may open each at a rate of its own, and the motion found is one of several: "
            "e* = 1 counts, which none exceeds. A block in place of what moves as one tells more."
        )
    return said


def notes_of_small(
    whole: Participation, a0_star: float, linear: Callable[[float], LimitState]
) -> tuple[list[str], LimitState | None]:
    """Whether bodies that hardly move along the push raise a0*, m/s², and SLV without them."""
    large, small = (whole.of_displacement(*ends) for ends in ((_SMALL, np.inf), (0.0, _SMALL)))
    share = whole.e_star / large.e_star
    if share >= 1 / (1 + _ABOVE):
        return [], None
    without = linear(share * a0_star)
    text = (
        f"Of what moves {shown(small.total / 1e3)} kN of {shown(whole.total / 1e3)} kN have a δ of at most "
        f"{np.abs(small.displacement).max():.2g} of the largest: e* counts their whole weight, however little they "
        f"move, and a0* grows with it. Without them e* = {shown(large.e_star)}, a0* = {in_g(without.capacity, g)}, "
        f"and capacity / demand of {without.name} = {without.ratio_text()}: rely on that."
    )
    return [text], without


def notes_of_parts(
    parts: Sequence[Sequence[MacroBlock]], known: Sequence[Sequence[MacroBlock]], ratios: Sequence[float]
) -> list[str]:
    """Of mechanisms that begin at one load factor, those that are checked with their ratios."""
    if len(parts) == 1:
        return []

    def named(part: Sequence[MacroBlock]) -> str:
        return " with ".join(f"{body.name} ({body.blocks[0]})" for body in part)

    order = np.argsort(ratios, kind="stable").tolist()
    of_others = ", ".join(f"that of {named(known[k])} {shown(ratios[k])}" for k in order[1:])
    unknown = ", ".join(named(part) for part in parts if part not in known)
    return [
        f"{len(parts)} mechanisms begin at this load factor, between which no work passes: each is checked by itself. "
        f"This is the check of {named(known[order[0]])}"
        + (f", whose capacity / demand is the lowest; {of_others}" if of_others else "")
        + (f". The pushover does not follow {unknown}: that is not checked by displacement" if unknown else "")
        + "."
    ]


def _out_of_plane(bodies: Sequence[MacroBlock]) -> float:
    """Largest motion out of the plane in which most of the turning is, in multiples of the scale of the mechanism."""
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
    """Names of the blocks of the bodies that move."""
    return [name for body in bodies if body.moves for name in body.blocks]


def _of_end(capacity: xr.Dataset) -> list[str]:
    """That a curve ends where its load factor has not come down."""
    alpha = capacity["load_factor"].to_numpy()
    if np.isfinite(capacity["d0"]) or alpha[-1] <= _LEFT * alpha[0]:
        return []
    first, last = (shown(float(alpha[k])) for k in (0, -1))
    text = (
        f"The capacity curve ends at a load factor of {last}, of {first} at first, and nothing behind is relied on: "
        "where blocks come to rest again it may go on with other steps. Compare two."
    )
    return [text]


def _of_ties(result: CaseResult) -> list[str]:
    if not result.model.ties:
        return []
    last = result.history.isel(iteration=-1)
    gives_way = tie_state(last).isin([TieState.PUNCHING, TieState.SLIPPING]).to_numpy()
    names = last["tie"].to_numpy()[gives_way]
    text = (
        f"Anchorages that give way at collapse are taken to hold on ({', '.join(names)}): punching and bond are "
        "brittle. Design them for the strength of the bar, or leave the tie out."
    )
    return [text] if len(names) else []


def notes_of_demand(model: Model, bodies: Sequence[MacroBlock], spectrum: Spectrum) -> list[str]:
    """Whether the spectrum is that of where the mechanism stands."""
    moving = set(_moving(bodies))
    heights = {b.name: b.shape.vertices[:, 2] for b in model.blocks if not b.fixed}
    foot, top = min(z.min() for z in heights.values()), max(z.max() for z in heights.values())
    low = min(heights[name].min() for name in moving) - foot
    if isinstance(spectrum, FloorSpectrum) and spectrum.peak < spectrum.ground.peak:
        text = (
            f"The largest acceleration at the height, {in_g(spectrum.peak, g)}, is less than that of the ground, "
            f"{in_g(spectrum.ground.peak, g)}: the modes that are given leave out what moves with the ground."
        )
    elif isinstance(spectrum, NtcSpectrum) and low > _HIGH * (top - foot):
        # A support as high is a terrace of the ground, or a building.
        upon, where = ("on a support ", "where that is not the ground, ") if _stands(model, moving) else ("", "")
        text = (
            f"What moves stands {upon}{low:.3g} m above the foot of the structure, and the demand is that of the "
            f"ground: {where}what is below amplifies it. Give bs.assess.floor_spectrum(…), or --mode on the command "
            "line (C8.7.1.2.1.8)."
        )
    elif isinstance(spectrum, FloorSpectrum) and _stands(model, moving):
        text = (
            "What moves stands on a support of the model, and the demand is that of a height: "
            f"{in_g(spectrum.peak, g)} at most, and {in_g(spectrum.ground.peak, g)} on the ground. Where the support "
            "is the ground, give the spectrum of the ground, which as a rule demands less."
        )
    else:
        return []
    return [text]


def _stands(model: Model, moving: Collection[str]) -> bool:
    """Whether any of the blocks that move is upon a support, and not only beside one."""
    fixed = {b.name for b in model.blocks if b.fixed}
    return any(
        (i.plus in moving and i.minus in fixed and i.normal[2] > _UPON)
        or (i.minus in moving and i.plus in fixed and -i.normal[2] > _UPON)
        for i in model.interfaces
    )


def notes_of_height(model: Model, beside: Overturning, part: Sequence[MacroBlock]) -> list[str]:
    """Whether what is named by hand stands higher than what was found, whose demand is another one."""
    feet = [min(model.block(n).shape.vertices[:, 2].min() for n in names) for names in (beside.blocks, _moving(part))]
    if feet[0] - feet[1] <= _LEVEL * model.characteristic_length:
        return []
    text = (
        f"The mechanism by hand stands {shown(feet[0] - feet[1], 'm')} higher than the one found: its demand is that "
        "of its own height, as a rule a larger one, and a larger α0 does not make it safer. Check it by itself, with "
        "bs.assess.floor_spectrum(…)."
    )
    return [text]


def notes_of_control(
    model: Model,
    capacity: xr.Dataset,
    curve: CapacityCurve,
    forces: HorizontalForces,
    bodies: Sequence[MacroBlock],
    whole: Participation,
    slv: Callable[[CapacityCurve], LimitState | None],
) -> tuple[list[str], LimitState | None]:
    """Whether the control point of a pushover goes with the weights, and SLV by their d0 if that is less."""
    d0, of_weights = curve.d0, d0_of_weights(model, capacity, forces, _moving(bodies), whole.e_star)
    if -_BELOW * of_weights <= d0 - of_weights <= _ABOVE * of_weights:
        return [], None
    less = slv(curve.with_d0(of_weights)) if 0 < of_weights < d0 else None
    ratio = f", with which capacity / demand of {less.name} = {less.ratio_text()}" if less else ""
    text = (
        f"By its control point the oscillator goes to {shown(d0, 'm')}, by the mean of the weights P + Q to "
        f"{shown(of_weights, 'm')}: what is in proportion at the collapse state is not at the end of the curve. A "
        f"point near the centroid of the weights tells most; rely on the smaller one{ratio}."
    )
    return [text], less
