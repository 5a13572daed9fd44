"""Check of a local mechanism, and its printed calculation."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.assess.capacity import CapacityCurve
from blockstruct.assess.coefficients import Coefficients
from blockstruct.assess.lines import HIGHER, ROUNDED, Line, Section, section
from blockstruct.assess.overturning import Overturning
from blockstruct.assess.participation import Participation
from blockstruct.assess.spectrum import Spectrum
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.results import CaseResult, MacroBlock
from blockstruct.text import Note, assessment, in_g, ratio_text, shown, told_apart

g = STANDARD_GRAVITY
#: Difference of e* from one that counts as rounding.
_ONE = 1e-4
_CODE = "Circolare 21/01/2019 n. 7 C.S.LL.PP., C8.7.1.2.1"


@dataclass(frozen=True, slots=True)
class LimitState:
    """Capacity and demand at a limit state.

    Attributes
    ----------
    name : str
        ``"SLD"``, ``"SLV, linear"``, ``"SLV, by displacement"``, ``"SLC, by displacement"``.
    capacity, demand : float
        In ``unit``; the demand is NaN without a spectrum of this limit state.
    unit : str
        ``"m/s²"`` or ``"m"``.
    ag : float
        Ground acceleration that the structure bears, m/s²: the one at which capacity equals demand, or the one of SLD.
    ag_site : float
        Ground acceleration of the site, m/s²; of SLV without a spectrum of this limit state.
    lines : tuple of Line
    of_sld : bool
        Whether ``ag`` is the one of SLD, which is its lower bound (C8.7.1.2.1.8).
    noted : LimitState or None
        The same limit state by the values that a note relies on instead.
    """

    name: str
    capacity: float
    demand: float
    unit: str
    ag: float
    ag_site: float
    lines: tuple[Line, ...]
    of_sld: bool = False
    noted: Self | None = None

    @property
    def ratio(self) -> float:
        """Capacity over demand."""
        return self.capacity / self.demand

    @property
    def least_ratio(self) -> float:
        """Capacity over demand, or the ratio that a note relies on instead, if that is less."""
        return self.ratio if self.noted is None else min(self.ratio, self.noted.ratio)

    @property
    def satisfied(self) -> bool:
        """Whether the structure bears the ground acceleration of the site; False without a demand.

        It is False, too, if the values that a note relies on do not satisfy the limit state.
        """
        by_note = self.noted is None or self.noted.satisfied
        return bool(self.ag >= self.ag_site and np.isfinite(self.demand) and by_note)

    def ratio_text(self, digits: int = 4) -> str:
        """Return capacity over demand with enough digits to distinguish it from one."""
        return ratio_text(self.ratio, digits)

    def ag_texts(self, digits: int = 4) -> tuple[str, str]:
        """Return both ground accelerations, borne and of the site, with enough digits to distinguish them."""
        borne, site = told_apart(self.ag / g, self.ag_site / g, digits)
        return assessment.acceleration_in_g(self.ag, borne), f"{site} g"

    @property
    def outcome(self) -> str:
        """Whether the limit state is satisfied, and why if its ratio does not show it."""
        return assessment.state_outcome(
            self.name,
            self.ratio,
            satisfied=self.satisfied,
            bears_site=self.ag >= self.ag_site,
            noted=None if self.noted is None else self.noted.ratio,
        )


@dataclass(frozen=True, slots=True, eq=False)
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
        Spectral acceleration that activates the mechanism, m/s².
    curve : CapacityCurve or None
    missing_curve : str
        Why there is no curve.
    spectrum : Spectrum
        Demand at SLV.
    method, relied_on : str
        The method and its limit state.
    limit_states : mapping of str to LimitState
    beside : Overturning or None
    coefficients : Coefficients
    notes : tuple of Note
        Read them before relying on the check.
    """

    result: CaseResult = field(repr=False)
    alpha0: float
    direction: NDArray[np.float64]
    bodies: tuple[MacroBlock, ...] = field(repr=False)
    participation: Participation = field(repr=False)
    participation_of_blocks: Participation = field(repr=False)
    confidence_factor: float
    confidence_reason: str
    a0_star: float
    curve: CapacityCurve | None = field(repr=False)
    missing_curve: str
    spectrum: Spectrum = field(repr=False)
    method: str
    limit_states: Mapping[str, LimitState] = field(repr=False)
    relied_on: str
    beside: Overturning | None = field(repr=False)
    coefficients: Coefficients = field(repr=False)
    notes: tuple[Note, ...]

    @property
    def e_star(self) -> float:
        """Share of the mass that takes part, by macro-blocks."""
        return self.participation.e_star

    @property
    def M_star(self) -> float:
        """Mass that takes part, kg."""
        return self.participation.M_star

    @property
    def limit_state(self) -> LimitState:
        """The limit state that the check relies on."""
        return self.limit_states[self.relied_on]

    @property
    def ratio(self) -> float:
        """Capacity over demand at that limit state."""
        return self.limit_state.ratio

    @property
    def ag(self) -> float:
        """Ground acceleration that the structure bears at that limit state, m/s²."""
        return self.limit_state.ag

    @property
    def satisfied(self) -> bool:
        """Whether that limit state is satisfied, with a load factor that has settled."""
        return self.result.settled and self.limit_state.satisfied

    @property
    def outcome(self) -> str:
        """Whether that limit state is satisfied, and why if its ratio does not show it."""
        return self.limit_state.outcome if self.result.settled else assessment.UNSETTLED

    @property
    def verdict(self) -> str:
        """Sentence on that limit state."""
        state = self.limit_state
        return assessment.verdict(
            self.relied_on, self.ratio, self.outcome, self.ag, state.ag_texts(), of_sld=state.of_sld
        )

    @property
    def sections(self) -> tuple[Section, ...]:
        """Every formula with its numbers, in the order of the calculation."""
        r, whole = self.result, self.participation
        push = ", ".join(f"{value:.4g}" for value in self.direction + 0.0)
        resting = sum(not body.moves for body in self.bodies)
        by_name = {body.name: body for body in self.bodies}
        a0 = (
            f"a0* = α0 g / (e* FC) = {shown(self.alpha0)} · {g:g} m/s² / ({shown(whole.e_star)} · "
            f"{shown(self.confidence_factor)}) = {in_g(self.a0_star, g)}"
        )
        share = (
            "" if abs(self.alpha0 - r.load_factor) < 1e-12 else f" ({shown(r.load_factor)} · share of the BodyForce)"
        )
        flow = f"{r.case.flow} flow"
        found = [
            section(
                "Mechanism",
                Line(
                    "collapse state",
                    f"α0 = {shown(self.alpha0)}{share}, push along ({push}), {flow}",
                    "C8.7.1.2.1.1",
                ),
                [Line(f"{name}, blocks: {len(by_name[name].blocks)}", self._body(W, d)) for name, W, d in whole.each],
                [
                    Line(f"{name} hardly moves along the push", f"{self._body(W, d)}, and takes no part in the sums")
                    for name, W, d in (whole.left_out.each if whole.left_out else [])
                ],
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
                [Line("least capacity of a later mechanism", self._floor, "e* ≤ 1")] if whole.e_star < 1 - _ONE else [],
            ),
            section(
                "Capacity curve",
                list(self.curve.lines) if self.curve else Line("none", self.missing_curve, "C8.7.1.2.1.2"),
            ),
            section("Demand at SLV", self.spectrum.lines(), Line("demand of other mechanisms", HIGHER, "C8.7.1.2.1.8")),
        ]
        found += [section(state.name, list(state.lines)) for state in self.limit_states.values()]
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

    @property
    def _floor(self) -> str:
        return f"at least α0 g / FC = {in_g(self.alpha0 * g / self.confidence_factor, g)}"

    @staticmethod
    def _body(weight: float, displacement: float) -> str:
        return f"P + Q = {shown(weight / 1e3, 'kN')}, δ = {shown(round(displacement, 9) + 0.0)}"

    def __str__(self) -> str:
        head = [
            f"local mechanism of {self.result.name!r} in {self.result.model.name!r}, {_CODE}",
            f"relied on: {self.verdict}",
            *(f"note: {text}" for text in self.notes),
            ROUNDED,
        ]
        return "\n".join(head) + "\n\n" + "\n\n".join(str(part) for part in self.sections)
