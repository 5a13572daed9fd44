"""Check of a local mechanism, its verdict, and its printed calculation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from blockstruct.arrays import SLIGHT, Array
from blockstruct.assess.capacity import CapacityCurve
from blockstruct.assess.floor_spectrum import Spectrum
from blockstruct.assess.limit_states import METHODS, Coefficients, LimitState
from blockstruct.assess.lines import HIGHER, ROUNDED, Line, Section, section
from blockstruct.assess.overturning import Overturning
from blockstruct.assess.participation import Participation
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.notebook import html_table
from blockstruct.results import MacroBlock
from blockstruct.results.case_result import CaseResult
from blockstruct.results.mechanism import with_motion
from blockstruct.text import assessment
from blockstruct.text.mechanism import SMALL, direction_text, smaller_bodies
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.text.numbers import in_g, shown
from blockstruct.vocabulary import LISTED, Way, listed


@dataclass(frozen=True, slots=True, eq=False)
class WayOfChecking:
    """One way to find capacity over demand.

    Attributes
    ----------
    way : Way
    alpha : float
        Multiplier of the weights P + Q.
    e_star : float
        Share of the mass that takes part.
    state : LimitState
        The limit state that the method relies on.
    motion : (blocks, 6) array or None
        Velocity of the centroids and angular velocity, SI; None for the collapse mechanism.
    load_factor : float
        Load factor of this way, relative to the one of the collapse state.
    is_estimate : bool
        Whether the first steps of a loading path give this load factor.
    """

    way: Way
    alpha: float
    e_star: float
    state: LimitState
    motion: Array | None = None
    load_factor: float = 1.0
    is_estimate: bool = False

    @property
    def name(self) -> str:
        """Name of the way."""
        return f"{self.way}{', estimated' * self.is_estimate}"

    def effect(self, ratio: float) -> float:
        """Return the relative change of a ratio, by the load factor or by the motion of this way."""
        return abs(1 - self.load_factor) if self.load_factor != 1 else abs(1 - self.state.ratio / ratio)


@dataclass(frozen=True, slots=True)
class Verdict:
    """The outcome of a check; ``print(verdict)`` gives the sentence that every output shows.

    Attributes
    ----------
    case : str
        Name of the case.
    direction : str
        Direction of its push, such as ``"+x"``.
    ways : tuple of WayOfChecking
        All ways that have a ratio, the lowest first. The verdict relies on the first.
    floor : float
        Ratio of a motion with e* = 1 that begins at the lowest load factor of the ways; no motion has less. NaN by
        displacement.
    open : tuple of Note
        Warnings to settle first. The check is not satisfied while there is one.
    settled : bool
        Whether the load factor has settled.
    run : str
        The variant of the path, or the remedy, that is relied on; empty for the case as given.
    """

    case: str
    direction: str
    ways: tuple[WayOfChecking, ...] = field(repr=False)
    floor: float
    open: tuple[Note, ...]
    settled: bool
    run: str = ""

    @property
    def governing(self) -> WayOfChecking:
        """The way with the lowest ratio."""
        return self.ways[0]

    @property
    def relied_on(self) -> str:
        """Name of that way, and of its run."""
        return f"{self.governing.name} [{self.run}]" if self.run else self.governing.name

    @property
    def state(self) -> LimitState:
        """Limit state of that way."""
        return self.governing.state

    @property
    def ratio(self) -> float:
        """Capacity over demand to rely on: the lowest."""
        return self.state.ratio

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest ratio over the load factors, each with the motion that needs the least acceleration."""
        least = {way.load_factor: way.state.ratio for way in reversed(self.ways)}
        return self.ratio, max(least.values())

    @property
    def alphas(self) -> tuple[float, float]:
        """Lowest and highest multiplier of all ways."""
        return min(way.alpha for way in self.ways), max(way.alpha for way in self.ways)

    @property
    def ag(self) -> float:
        """Ground acceleration that the structure bears in every way, m/s²."""
        return min(one.state.ag for one in self.ways)

    @property
    def satisfied(self) -> bool:
        """Whether every way satisfies the limit state, and no warning is open."""
        return self.settled and not self.open and all(one.state.satisfied for one in self.ways)

    @property
    def share(self) -> float:
        """Ground acceleration borne over the one of the site."""
        return self.ag / self.state.ag_site

    @property
    def outcome(self) -> str:
        """Whether the check is satisfied, and why if its ratio does not show it."""
        if not self.settled:
            return assessment.UNSETTLED
        state = self.state
        if self.open and state.satisfied:
            return assessment.open_warnings(len(self.open))
        return state.outcome

    @property
    def figures(self) -> str:
        """Clause on the motion that governs: its multiplier, its e* and the range of the ratio."""
        return assessment.governing_way(
            self.governing.way,
            self.governing.alpha,
            self.governing.e_star,
            run=self.run,
            ends=self.range,
            floor=self.floor if np.isfinite(self.floor) and self.floor < (1 - SLIGHT) * self.ratio else None,
            is_estimate=self.governing.is_estimate,
        )

    def __str__(self) -> str:
        state = self.state
        sentence = assessment.verdict(
            state.name, self.ratio, self.outcome, state.ag, state.ag_texts(), of_sld=state.of_sld
        )
        return " ".join(filter(None, [sentence, self.figures]))


g = STANDARD_GRAVITY
_CODE = "Circolare 21/01/2019 n. 7 C.S.LL.PP., C8.7.1.2.1"
#: Codes of the notes on the ways to check.
CODES = {
    Way.WITHOUT_SMALL: NoteCode.SMALL_MOTIONS,
    Way.OTHER_MOTION: NoteCode.OTHER_MOTION,
    Way.LOWER_END: NoteCode.RANGE,
    Way.UPPER_END: NoteCode.RANGE,
    Way.UNIFORM_TORSION: NoteCode.CORNER_TORSION,
    Way.LOWERED_FRICTION: NoteCode.ELLIPSOID_TORSION,
    Way.BIAXIAL: NoteCode.BIAXIAL_CRUSHING,
    Way.OTHER_PROCEDURE: NoteCode.JAMMED_PART,
    Way.WEIGHTS: NoteCode.CONTROL_POINT,
    Way.ALONE: NoteCode.OVERTURNS_ALONE,
}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LocalMechanismCheck:
    """Result of :func:`local_mechanism`; ``print(check)`` shows every formula.

    Attributes
    ----------
    result : CaseResult
        The collapse state.
    alpha0 : float
        Multiplier of the weights P + Q that activates the mechanism.
    direction : (3,) array
        Direction of the push.
    bodies : tuple of MacroBlock
    participation, participation_of_blocks : Participation
        By macro-blocks, which the check uses, and by single blocks, for comparison.
    confidence_factor : float
    confidence_reason : str
    a0_star : float
        Spectral acceleration that activates the collapse mechanism, m/s².
    curve : CapacityCurve or None
    missing_curve : str
        Why there is no curve.
    spectrum : Spectrum
        Demand at SLV.
    method, relied_on : str
        The method and its limit state.
    limit_states : mapping of str to LimitState
        Of the collapse mechanism, and SLD of the motion that the least acceleration activates.
    others : tuple of WayOfChecking
        Other ways that have a ratio at the limit state relied on.
    beside : Overturning or None
    coefficients : Coefficients
    notes : tuple of Note
        Read them before relying on the check. Warnings come first, then notes with the largest effect on the ratio.
    """

    result: CaseResult
    alpha0: float
    direction: Array
    bodies: tuple[MacroBlock, ...]
    participation: Participation
    participation_of_blocks: Participation
    confidence_factor: float
    confidence_reason: str
    a0_star: float
    curve: CapacityCurve | None
    missing_curve: str
    spectrum: Spectrum
    method: str
    limit_states: Mapping[str, LimitState]
    others: tuple[WayOfChecking, ...]
    relied_on: str
    beside: Overturning | None
    coefficients: Coefficients
    notes: tuple[Note, ...]

    def __post_init__(self) -> None:
        ratio = self.limit_states[self.relied_on].ratio
        effects = {CODES[way.way]: way.effect(ratio) for way in self.others}
        ranks = {note: (note.severity is not Severity.WARNING, -effects.get(note.code, 0.0)) for note in self.notes}
        object.__setattr__(self, "notes", tuple(sorted(self.notes, key=ranks.__getitem__)))

    @property
    def verdict(self) -> Verdict:
        """The verdict of the check, over all ways that have a ratio."""
        state = self.limit_states[self.relied_on]
        collapse = WayOfChecking(Way.COLLAPSE, self.alpha0, self.participation.e_star, state)
        ways = (collapse, *self.others)
        floor = state.ratio * self.participation.e_star * min(way.load_factor for way in ways)
        return Verdict(
            self.result.name,
            direction_text(self.direction),
            tuple(sorted(ways, key=lambda way: way.state.ratio)),
            floor if self.relied_on == METHODS["linear"] else np.nan,
            tuple(note for note in self.notes if note.severity is Severity.WARNING),
            self.result.settled,
            self.result.schedule,
        )

    @property
    def governing(self) -> CaseResult:
        """The case with the motion that governs, to draw and to describe."""
        motion = self.verdict.governing.motion
        if motion is None:
            return self.result
        return self.result.changed(history=with_motion(self.result.model, self.result.history, motion))

    @property
    def e_star(self) -> float:
        """Share of the mass that takes part in the motion that governs."""
        return self.verdict.governing.e_star

    @property
    def acceleration(self) -> float:
        """Spectral acceleration that activates the motion that governs, m/s²."""
        way = self.verdict.governing
        return way.alpha * g / (way.e_star * self.confidence_factor)

    @property
    def M_star(self) -> float:
        """Mass that takes part in the collapse mechanism, kg."""
        return self.participation.M_star

    @property
    def ratio(self) -> float:
        """Capacity over demand to rely on."""
        return self.verdict.ratio

    @property
    def ag(self) -> float:
        """Ground acceleration that the structure bears, m/s²."""
        return self.verdict.ag

    @property
    def satisfied(self) -> bool:
        """Whether every way satisfies that limit state, and nothing is left to settle."""
        return self.verdict.satisfied

    @property
    def sections(self) -> tuple[Section, ...]:
        """Every formula with its numbers, in the order of the calculation."""
        r, whole = self.result, self.participation
        push = ", ".join(f"{value:.4g}" for value in self.direction + 0.0)
        resting = sum(not body.moves for body in self.bodies)
        by_name = {body.name: body for body in self.bodies}
        a0 = self._activation("α0", self.alpha0, whole.e_star, self.a0_star)
        share = (
            "" if abs(self.alpha0 - r.load_factor) < 1e-12 else f" ({shown(r.load_factor)} · share of the BodyForce)"
        )
        flow = f"{r.case.flow} flow"
        least = SMALL * sum(W for _, W, _ in whole.each)
        # As many as the legend of the mechanism lists.
        heaviest = sorted(whole.each, key=lambda each: -each[1])[:LISTED]
        large = [each for each in whole.each if each in heaviest and each[1] >= least]
        small = [each for each in whole.each if each not in large]
        found = [
            section(
                "Mechanism",
                Line(
                    "collapse state",
                    f"α0 = {shown(self.alpha0)}{share}, push along ({push}), {flow}",
                    "C8.7.1.2.1.1",
                ),
                [Line(f"{name}, blocks: {len(by_name[name].blocks)}", self._body(W, d)) for name, W, d in large],
                [self._summed(smaller_bodies(len(small)), small)] if small else [],
                [self._summed("not in the sums, hardly moving", whole.left_out.each)] if whole.left_out else [],
                [Line("bodies at rest", f"{resting}, which take{'s' * (resting == 1)} no part")] if resting else [],
            ),
            section(
                "Mass that takes part",
                whole.lines("by macro-blocks"),
                self._by_single_blocks(),
                Line(
                    "confidence factor",
                    f"FC = {shown(self.confidence_factor)}: {self.confidence_reason}",
                    "C8.7.1.2.1.3",
                ),
                Line("acceleration that activates it", a0, "C8.7.1.2.1.5 (C8.7.1.8)"),
                [Line("least capacity of a later mechanism", self._floor, "e* ≤ 1")]
                if whole.e_star < 1 - SLIGHT
                else [],
            ),
            section(
                "Capacity curve",
                list(self.curve.lines) if self.curve else Line("none", self.missing_curve, "C8.7.1.2.1.2"),
                is_detail=self.relied_on == METHODS["linear"],
            ),
            section("Demand at SLV", self.spectrum.lines(), Line("demand of other mechanisms", HIGHER, "C8.7.1.2.1.8")),
        ]
        found += [self._state(state) for state in self.limit_states.values()]
        if self.beside is not None:
            ratio = self.beside.alpha0 / self.alpha0
            found.append(
                section(
                    "Mechanism by hand, for comparison",
                    list(self.beside.lines),
                    Line(
                        "compared with the one found",
                        f"{shown(self.beside.alpha0)} / {shown(self.alpha0)} = {shown(ratio)}",
                    ),
                )
            )
        found.append(section("Coefficients", self.coefficients.lines()))
        return tuple(found)

    def _by_single_blocks(self) -> list[Line]:
        """Return the line on e* by single blocks, if it differs from e* by bodies."""
        whole, small = self.participation, self.participation_of_blocks
        if len(small.names) == len(whole.names):
            return []
        why = "together they are one" if len(whole.names) == 1 else "blocks of a body move together"
        numbers = f"e* = {shown(small.e_star)}, M* = {shown(small.M_star / 1e3, 't')}"
        return [Line("by single blocks, not used", f"{numbers}: {why}", "C8.7.1.2.1.3")]

    def _state(self, of_collapse: LimitState) -> Section:
        """Return the lines on a limit state. The one relied on is of the way that governs, and lists the others."""
        if of_collapse.name != self.relied_on:
            return section(of_collapse.name, list(of_collapse.lines), is_detail=True)
        ways = self.verdict.ways
        first = ways[0]
        a0 = self._activation("α", first.alpha, first.e_star, self.acceleration)
        own = [Line("acceleration of this way", a0, "C8.7.1.2.1.1, C8.7.1.2.1.5")]
        each = [
            Line(*assessment.way_line(way.name, way.alpha, way.e_star, way.state.ratio, governs=way is first))
            for way in ways
        ]
        if first.way is Way.COLLAPSE:
            return section(first.state.name, list(first.state.lines), each if len(ways) > 1 else [])
        return section(f"{first.state.name}, {first.name}", own, list(first.state.lines), each)

    def _activation(self, symbol: str, alpha: float, e_star: float, a0: float) -> str:
        """Return the formula of the acceleration a0*, m/s², that activates a motion."""
        divisor = f"{shown(e_star)} · {shown(self.confidence_factor)}"
        return f"a0* = {symbol} g / (e* FC) = {shown(alpha)} · {g:g} m/s² / ({divisor}) = {in_g(a0, g)}"

    @property
    def _floor(self) -> str:
        return f"at least α0 g / FC = {in_g(self.alpha0 * g / self.confidence_factor, g)}"

    @staticmethod
    def _body(weight: float, displacement: float) -> str:
        return f"P + Q = {shown(weight / 1e3, 'kN')}, δ = {shown(round(displacement, 9) + 0.0)}"

    @staticmethod
    def _summed(what: str, each: Sequence[tuple[str, float, float]]) -> Line:
        """Return one line for several bodies."""
        names, weights, delta = zip(*each, strict=True)
        ends = " to ".join(dict.fromkeys(shown(round(d, 9) + 0.0) for d in (min(delta), max(delta))))
        return Line(what, f"{listed(names)}: P + Q = {shown(sum(weights) / 1e3, 'kN')}, δ = {ends}")

    def __repr__(self) -> str:
        return f"<LocalMechanismCheck of {self.result.name!r}: {self.verdict}>"

    def _repr_html_(self) -> str:
        rows = [(line.what, line.formula, line.source) for part in self.sections for line in part.lines]
        return html_table(f"{self.result.name}: {self.verdict}", ["", "", ""], rows, map(str, self.notes))

    def __str__(self) -> str:
        head = [
            f"local mechanism of {self.result.name!r} in {self.result.model.name!r}, {_CODE}",
            f"relied on: {self.verdict}",
            *(f"note: {text}" for text in self.notes),
            ROUNDED,
        ]
        return "\n".join(head) + "\n\n" + "\n\n".join(str(part) for part in self.sections)
