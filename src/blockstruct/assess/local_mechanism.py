"""Check of a local mechanism, Circolare 21/01/2019 n. 7 C.S.LL.PP., C8.7.1.2.1, and the notes that it needs."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, NoReturn

import numpy as np
import xarray as xr

from blockstruct.arrays import SLIGHT
from blockstruct.assess.capacity import CapacityCurve, curve_of_pushover, curve_of_rotation, d0_of_weights
from blockstruct.assess.check import CODES, LocalMechanismCheck, WayOfChecking
from blockstruct.assess.floor_spectrum import FloorSpectrum, Spectrum, check_one_place
from blockstruct.assess.freedom import is_unique, least_activation, separate_mechanisms
from blockstruct.assess.limit_states import (
    METHODS,
    Coefficients,
    LimitState,
    by_displacement,
    confidence,
    damage,
    linear,
)
from blockstruct.assess.overturning import Overturning, supporting
from blockstruct.assess.participation import HorizontalForces, Participation, of_bodies, taking_part
from blockstruct.assess.rotation import RigidRotation
from blockstruct.assess.spectrum import NtcSpectrum
from blockstruct.errors import ModelError, check_known
from blockstruct.errors import shown as as_given
from blockstruct.model import STANDARD_GRAVITY, LimitCase, Model
from blockstruct.results import MacroBlock, Spread, applied_loads, macro_blocks
from blockstruct.results.case_result import CaseResult
from blockstruct.results.ties import tie_state
from blockstruct.text import assessment
from blockstruct.text.note import EFFECT, EFFECTS, Note, Severity
from blockstruct.vocabulary import Flow, Procedure, Status, TieState, Way, listed

g = STANDARD_GRAVITY
#: Fact of an outcome that has the load factor of each remedy of a note.
REMEDIES = {way: EFFECTS[code] for way, code in CODES.items() if code in EFFECTS}


def local_mechanism(  # noqa: PLR0913
    result: CaseResult | Spread,
    confidence_factor: float | None = None,
    spectrum: Spectrum | None = None,
    *,
    knowledge_level: str | None = None,
    method: str = "linear",
    spectrum_sld: Spectrum | None = None,
    spectrum_slc: Spectrum | None = None,
    beside: Overturning | None = None,
    coefficients: Coefficients | None = None,
) -> LocalMechanismCheck:
    """Check a local mechanism against a spectrum, Circolare 7/2019 C8.7.1.2.1.

    The masses are the ones that the variable load pushes: P of the blocks, Q of point and face loads along the push.
    Blocks that move together form one body (``result.macro_blocks``). Over the small blocks of a wall that turns as
    one, e* would be 0.75 and a0* a third too high. Bodies at rest do not count, nor do bodies with a negligible δ, such
    as a sidewall that turns about a point near its centroid: e* would count their whole weight. Bodies that exchange no
    work, such as façades apart, are separate mechanisms, and the check takes the one with the lowest ratio. The rest of
    the structure is assumed to hold the mechanism; elements that vibrate on their own, such as pinnacles, are not
    covered.

    Parameters
    ----------
    result
        A converged case whose variable load is a horizontal BodyForce. A spread gives the run with the lowest load
        factor of its loading paths. A pushover also gives its capacity curve.
    confidence_factor, knowledge_level
        FC, or the level ``"LC1"`` to ``"LC3"`` that sets it. If joints of the moving bodies have no compressive
        strength, FC is at least the one of LC1.
    spectrum
        Demand at SLV: :func:`ntc_spectrum`, :func:`table_spectrum`, or :func:`floor_spectrum` at a height.
    method
        ``"linear"``: rely on the acceleration with the behaviour factor q (C8.7.1.2.1.7). ``"displacement"``: rely on
        the displacement (C8.7.1.2.1.8), which needs a capacity curve.
    spectrum_sld, spectrum_slc
        Demand at the other limit states, at the same place. Without them, the check gives only their capacities, with
        the site of ``spectrum``.
    beside
        A mechanism named by hand to print with the one found: :func:`overturning`.
    coefficients
        Coefficients of the Circolare, to change them.

    Returns
    -------
    LocalMechanismCheck
        ``print(check)`` gives every formula with its numbers and its paragraph.

    Raises
    ------
    ModelError
        If the case has no collapse state, its push is not horizontal, the confidence factor is too low, the spectra
        belong to different places, the mechanism by hand has other loads, or the method needs a capacity curve that
        does not exist.
    """
    found, case = _converged(result)
    spectrum = _spectrum("spectrum", spectrum)
    for name, one in (("spectrum_sld", spectrum_sld), ("spectrum_slc", spectrum_slc)):
        if one is not None:
            _spectrum(name, one)
    check_one_place(("spectrum_sld", spectrum_sld), ("spectrum", spectrum), ("spectrum_slc", spectrum_slc))
    if beside is not None and not isinstance(beside, Overturning):
        _refuse_kind("beside", beside, "bs.assess.overturning(…)")
    if coefficients is not None and not isinstance(coefficients, Coefficients):
        _refuse_kind("coefficients", coefficients, "bs.assess.Coefficients(…), such as Coefficients(q=1.5)")
    check_known(method, METHODS, "local_mechanism: method")
    forces = HorizontalForces.of(found.model, case)
    if beside is not None:
        _check_same_loads(beside, found, case)
    request = _Request(
        found,
        case,
        forces,
        confidence_factor,
        knowledge_level,
        spectrum,
        spectrum_sld,
        spectrum_slc,
        method,
        beside,
        Coefficients() if coefficients is None else coefficients,
    )
    bodies = macro_blocks(found.model, found.mechanism, case.dead)
    parts = separate_mechanisms(found, forces, bodies)
    # A pushover describes the mechanism of its control point.
    known = parts if found.capacity is None or method == "linear" else [p for p in parts if request.follows(p)] or parts
    resting = [body for body in bodies if not body.moves]
    checks = [request.check([*part, *resting]) for part in known]
    ratios = [one.ratio for one in checks]
    check = checks[int(np.argmin(ratios))]
    notes = [*notes_of_parts(parts, known, ratios), *check.notes]
    if isinstance(result, Spread) and found.settled:
        notes += _unsettled(result, found, min(ratios))
    return replace(check, notes=tuple(notes))


def _unsettled(spread: Spread, found: CaseResult, ratio: float) -> list[Note]:
    """Return the note on the lowest unsettled path of a spread that ended lower than the run with a ratio."""
    ends = {}
    for run in spread.runs.values():
        if run.drifts and run.outcome.procedure is Procedure.LOADING_PATH:
            ends[run.schedule] = run.load_factor
        elif run.status is Status.NOT_CONVERGED and run.outcome.drift is not None:
            ends[run.schedule] = run.outcome.drift[0]
    if not ends or min(ends.values()) > (1 - EFFECT) * found.load_factor:
        return []
    low = min(ends, key=ends.__getitem__)
    number = found.answer.text(ends[low])
    return [assessment.run_unsettled(low, number, ratio * ends[low] / found.load_factor)]


@dataclass(frozen=True, slots=True)
class _Request:
    """Arguments of a check, for any mechanism of the collapse state."""

    found: CaseResult
    case: LimitCase
    forces: HorizontalForces
    confidence_factor: float | None
    knowledge_level: str | None
    spectrum: Spectrum
    spectrum_sld: Spectrum | None
    spectrum_slc: Spectrum | None
    method: str
    beside: Overturning | None
    coefficients: Coefficients

    def follows(self, bodies: Sequence[MacroBlock]) -> bool:
        """Return whether the control point of the pushover belongs to some bodies."""
        control: Any = getattr(self.case, "control", ("",))
        return any(control[0] in body.blocks for body in bodies)

    def _curve(
        self, bodies: Sequence[MacroBlock], whole: Participation, a0_star: float
    ) -> tuple[CapacityCurve | None, str]:
        """Return the capacity curve of a mechanism, or None and why it has none."""
        found, pushed = self.found, self.found.capacity
        try:
            if pushed is None:
                return curve_of_rotation(found, self.case, bodies, self.forces, a0_star), ""
            if not is_unique(found, bodies):
                return None, "no capacity curve: the mechanism is not unique, so its control point does not measure it"
            if self.follows(bodies):
                return curve_of_pushover(found, pushed, self.forces.direction, whole, a0_star), ""
        except ModelError as error:
            # A pushover without a curve states its own remedy, which is not another pushover.
            return None, f"no capacity curve: {found.missing_curve or error}"
        return None, "no capacity curve: the pushover follows another mechanism"

    def check(self, bodies: Sequence[MacroBlock]) -> LocalMechanismCheck:
        """Return the check of one mechanism, of its moving bodies and the bodies at rest."""
        found, forces, c = self.found, self.forces, self.coefficients
        spectrum, sld_site, slc_site = self.spectrum, self.spectrum_sld, self.spectrum_slc
        whole, blocks = of_bodies(found.model, forces, found.mechanism, bodies)
        FC, reason = confidence(
            self.confidence_factor,
            self.knowledge_level,
            crushing=_crushes(found, bodies),
            without_crushing=c.without_crushing,
        )
        alpha0 = found.load_factor * forces.share
        a0_star = alpha0 * g / (whole.e_star * FC)
        pushed = found.capacity
        curve, missing = self._curve(bodies, whole, a0_star)
        if self.method == "displacement" and curve is None:
            msg = f"case {found.name!r}: {missing}, or give method='linear' (--method linear on the command line)"
            raise ModelError(msg)
        of_sld = spectrum if sld_site is None else sld_site
        sld = damage(a0_star, of_sld, with_demand=sld_site is not None)

        def by_q(a0: float) -> LimitState:
            return linear(a0, spectrum, damage(a0, of_sld, with_demand=False).ag, c)

        states = [sld, by_q(a0_star)]
        notes: list[Note] = []
        part = taking_part(bodies, whole)

        def slv(other: CapacityCurve) -> LimitState | None:
            """Return SLV by another curve; None if the spectrum does not cover it."""
            try:
                return by_displacement(other, sld.ag, "SLV", c, spectrum, with_demand=True)
            except ModelError:
                return None

        if curve is not None:
            slc = spectrum if slc_site is None else slc_site
            for state, of, own_site in (("SLV", spectrum, True), ("SLC", slc, slc_site is not None)):
                try:
                    states.append(by_displacement(curve, sld.ag, state, c, of, with_demand=own_site))
                except ModelError as error:
                    if self.method == "displacement" and state == "SLV":
                        raise
                    notes.append(assessment.state_left_out(state, str(error)))
        others, of_ways = self._other_ways(bodies, whole, a0_star, curve, by_q, slv)
        # Damage begins with the first motion that is activated.
        first = min([a0_star, *(way.alpha * g / (way.e_star * FC) for way in others)])
        states[0] = damage(first, of_sld, with_demand=sld_site is not None)
        notes = [*of_ways, *notes_of(found, forces, bodies, whole), *notes, *c.notes()]
        notes += notes_of_demand(found.model, part, spectrum)
        notes += [
            assessment.state_missed(state.name, state.ratio, state.outcome)
            for state in states
            if state.name not in METHODS.values() and np.isfinite(state.demand) and not state.satisfied
        ]
        if curve is not None and pushed is not None:
            of_control, less = notes_of_control(found.model, pushed, curve, forces, part, whole, slv)
            of_one, alone = self._notes_of_one_body(bodies, a0_star, curve, slv)
            notes += [*of_control, *of_one]
            if self.method == "displacement":
                pairs = ((Way.WEIGHTS, less), (Way.ALONE, alone))
                others += [WayOfChecking(way, alpha0, whole.e_star, one) for way, one in pairs if one]
        beside = self.beside
        notes += [] if beside is None else [*notes_of_height(found.model, beside, part), *beside.notes]
        if beside is not None and beside.alpha0 < (1 - SLIGHT) * alpha0:
            notes.append(assessment.hand_is_lower(beside.alpha0, alpha0))
        return LocalMechanismCheck(
            result=found,
            alpha0=alpha0,
            direction=forces.direction,
            bodies=tuple(bodies),
            participation=whole,
            participation_of_blocks=blocks,
            confidence_factor=FC,
            confidence_reason=reason,
            a0_star=a0_star,
            curve=curve,
            missing_curve=missing,
            spectrum=spectrum,
            method=self.method,
            limit_states={state.name: state for state in states},
            others=tuple(others),
            relied_on=METHODS[self.method],
            beside=beside,
            coefficients=c,
            notes=tuple(notes),
        )

    def _other_ways(
        self,
        bodies: Sequence[MacroBlock],
        whole: Participation,
        a0_star: float,
        curve: CapacityCurve | None,
        by_q: Callable[[float], LimitState],
        slv: Callable[[CapacityCurve], LimitState | None],
    ) -> tuple[list[WayOfChecking], list[Note]]:
        """Return the ways to check other motions and the lower end of the range, and their notes.

        Each way has its own a0*, m/s², and the shape of the capacity curve of the collapse mechanism.
        """

        def state(a0: float) -> LimitState | None:
            if self.method == "linear" or curve is None:
                return by_q(a0)
            return slv(replace(curve, acceleration=a0 / a0_star * curve.acceleration))

        found, alpha0 = self.found, self.found.load_factor * self.forces.share
        ways: list[WayOfChecking] = []
        notes: list[Note] = []
        head, large = found.headline, without_small(whole)
        a0, alpha, e_star, motion = a0_star * whole.e_star / large.e_star, alpha0, large.e_star, None
        if large is not whole and (one := state(a0)):
            ways.append(WayOfChecking(Way.WITHOUT_SMALL, alpha, e_star, one))
            notes.append(note_of_small(whole, large, a0))
        other = least_activation(found, self.forces, [body for body in bodies if body.moves], large)
        least = a0_star * other.acceleration / (alpha0 / whole.e_star)
        if other.motion is not None and (one := state(least)):
            a0, alpha, e_star, motion = least, other.alpha, other.e_star, other.motion
            ways.append(WayOfChecking(Way.OTHER_MOTION, alpha, e_star, one, motion))
            notes.append(assessment.other_motion(alpha0, alpha, e_star, other.bodies))
        low = head.lowest / head.load_factor
        if head.answer.text(head.lowest) != head.number and (one := state(low * a0)):
            ways.append(WayOfChecking(Way.LOWER_END, low * alpha, e_star, one, motion, low))
            notes.insert(0, assessment.range_of_load_factor(head.range))
        high = head.highest / head.load_factor
        if head.answer.text(head.highest) != head.number and (one := state(high * a0)):
            ways.append(WayOfChecking(Way.UPPER_END, high * alpha, e_star, one, motion, high))
        # The notes of the case state the effect of these remedies on its load factor.
        outcome = found.outcome
        for way, fact in REMEDIES.items():
            low = getattr(outcome, fact) / found.load_factor
            if abs(low - 1) > EFFECT and (one := state(low * a0)):
                is_estimate = outcome.estimated and way is not Way.OTHER_PROCEDURE
                ways.append(WayOfChecking(way, low * alpha, e_star, one, motion, low, is_estimate))
        return ways, notes

    def _notes_of_one_body(
        self,
        bodies: Sequence[MacroBlock],
        a0_star: float,
        pushed: CapacityCurve,
        slv: Callable[[CapacityCurve], LimitState | None],
    ) -> tuple[list[Note], LimitState | None]:
        """Return the note on a body that overturns alone before the pushover ends, and SLV by its curve."""
        try:
            alone = curve_of_rotation(self.found, self.case, bodies, self.forces, a0_star)
        except ModelError:
            return [], None
        state = slv(alone) if pushed.d0 > (1 + OTHER_CURVE) * alone.d0 else None
        if state is None:
            return [], None
        return [assessment.overturns_alone(pushed.d0, alone.d0)], state


def _check_same_loads(beside: Overturning, found: CaseResult, case: LimitCase) -> None:
    """Refuse a mechanism by hand with other weights or loads than the model and the case."""
    index, turning = found.model.block_index, beside.rotation
    if set(beside.blocks) <= index.keys():
        again = RigidRotation.of(
            found.model, case, [index[name] for name in beside.blocks], turning.hinge, turning.axis
        )
        if all(one.is_close(other) for one, other in ((again.dead, turning.dead), (again.variable, turning.variable))):
            return
    msg = (
        f"local_mechanism: beside has other blocks or loads than case {case.name!r} of model {found.model.name!r}; "
        "give bs.assess.overturning(result.model, result.case, …)"
    )
    raise ModelError(msg)


def _spectrum(name: str, value: object) -> Spectrum:
    if not isinstance(value, Spectrum):
        _refuse_kind(name, value, "bs.assess.ntc_spectrum(…) or another")
    return value


def _refuse_kind(name: str, value: object, remedy: str) -> NoReturn:
    msg = f"local_mechanism: {name} {as_given(value)} is a {type(value).__name__}; give {remedy}"
    raise ModelError(msg)


def _converged(result: Any) -> tuple[CaseResult, LimitCase]:
    """Return the collapse state to check, and its case."""
    if isinstance(result, Spread):
        result = result.relied_on
    if not isinstance(result, CaseResult):
        msg = f"local_mechanism: {type(result).__name__} is not a limit case's result; give analysis['name']"
        raise ModelError(msg)
    if not isinstance(result.case, LimitCase):
        msg = f"case {result.name!r}: a {type(result.case).__name__} has no push; give a LimitCase"
        raise ModelError(msg)
    if result.status is not Status.CONVERGED:
        msg = (
            f"case {result.name!r}: {result.headline}; a check needs a converged collapse state: change the procedure "
            "or the loads and run the case again"
        )
        raise ModelError(msg)
    rollers = [block.name for block in result.model.blocks if block.is_roller]
    if rollers:
        msg = (
            f"case {result.name!r}: {listed(rollers)} held in some motions only, which its finite rotation does not "
            "know: fix a block that touches the structure with a joint of friction 0 instead"
        )
        raise ModelError(msg)
    return result, result.case


def _crushes(result: CaseResult, bodies: Sequence[MacroBlock]) -> bool:
    """Return whether every joint of a moving body with another body has a compressive strength."""
    body = {name: k for k, one in enumerate(bodies) for name in one.blocks}
    moves = {name for one in bodies if one.moves for name in one.blocks}
    strength = result.history["compressive_strength"].to_numpy()
    between = [
        k
        for k, i in enumerate(result.model.interfaces)
        if {i.minus, i.plus} & moves and body.get(i.minus) != body.get(i.plus)
    ]
    return bool(len(between) and np.isfinite(strength[between]).all())


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
