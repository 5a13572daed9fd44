"""A check of a local mechanism, and how it is printed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.assess.capacity import CapacityCurve
from blockstruct.assess.coefficients import Coefficients
from blockstruct.assess.lines import BEYOND, HIGHER, ROUNDED, Line, Section, in_g, section, shown, told_apart
from blockstruct.assess.overturning import Overturning
from blockstruct.assess.participation import Participation
from blockstruct.assess.spectrum import Spectrum
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.results import CaseResult, MacroBlock

g = STANDARD_GRAVITY
#: Share of the mass that does not take part, of rounding.
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
        Acceleration of the ground that it bears, m/s²: at which capacity and demand are equal, or that of SLD.
    ag_site : float
        That of the site, m/s²; without a spectrum of this limit state that of SLV.
    lines : tuple of Line
    of_sld : bool
        Whether ``ag`` is that of SLD, which it counts as no less than (C8.7.1.2.1.8).
    noted : LimitState or None
        The same limit state by what a note of the check says to rely on instead.
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
        """Capacity over demand, or what a note says to rely on instead, if that is less."""
        return self.ratio if self.noted is None else min(self.ratio, self.noted.ratio)

    @property
    def satisfied(self) -> bool:
        """Whether the ground acceleration that it bears is not below that of the site; never without a demand.

        Nor is it where it is not by what a note says to rely on.
        """
        by_note = self.noted is None or self.noted.satisfied
        return bool(self.ag >= self.ag_site and np.isfinite(self.demand) and by_note)

    def ratio_text(self, digits: int = 4) -> str:
        """Capacity over demand to so many digits, or to as many as it takes to tell it from one."""
        return told_apart(self.ratio, 1.0, digits)[0]

    def ag_texts(self, digits: int = 4) -> tuple[str, str]:
        """Ground acceleration that it bears and that of the site, told apart as the ratio is from one."""
        borne, site = told_apart(self.ag / g, self.ag_site / g, digits)
        return f"{borne} g" if np.isfinite(self.ag) else BEYOND, f"{site} g"

    @property
    def outcome(self) -> str:
        """Whether it is satisfied, and why where the ratio does not tell."""
        if np.isnan(self.demand):
            return "not checked: no spectrum of this limit state"
        if self.satisfied and self.ratio < 1:
            return f"below 1, but satisfied: a_g,{self.name[:3]} counts as no less than a_g,SLD (C8.7.1.2.1.8)"
        if self.satisfied:
            return "satisfied"
        if self.noted is not None and self.ag >= self.ag_site:
            return f"not satisfied by the {self.noted.ratio_text()} that a note says to rely on"
        return "not satisfied" + ("" if self.ratio < 1 else ", as a weaker ground motion already demands as much")


@dataclass(frozen=True, slots=True, eq=False)
class LocalMechanismCheck:
    """What :func:`local_mechanism` finds; ``print(check)`` hands in every formula.

    Attributes
    ----------
    result : CaseResult
        The collapse state.
    alpha0 : float
        Multiplier of the weights P + Q that sets the mechanism going.
    direction : (3,) array
        Of the push.
    bodies : tuple of MacroBlock
    participation, participation_of_blocks : Participation
        Of the macro-blocks, which counts, and of the blocks one by one, which does not.
    confidence_factor : float
    confidence_reason : str
    a0_star : float
        Spectral acceleration that activates the mechanism, m/s².
    curve : CapacityCurve or None
    missing_curve : str
        Why there is none.
    spectrum : Spectrum
        Demand at SLV.
    method, relied_on : str
        The method and its limit state.
    limit_states : mapping of str to LimitState
    beside : Overturning or None
    coefficients : Coefficients
    notes : tuple of str
        What one must know before relying on it.
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
    notes: tuple[str, ...]

    @property
    def e_star(self) -> float:
        """Share of the mass that takes part, of macro-blocks."""
        return self.participation.e_star

    @property
    def M_star(self) -> float:
        """Mass that takes part, kg."""
        return self.participation.M_star

    @property
    def limit_state(self) -> LimitState:
        """The one relied on."""
        return self.limit_states[self.relied_on]

    @property
    def ratio(self) -> float:
        """Capacity over demand at the limit state relied on."""
        return self.limit_state.ratio

    @property
    def ag(self) -> float:
        """Acceleration of the ground that it bears, m/s²: at which capacity and demand are equal, or that of SLD."""
        return self.limit_state.ag

    @property
    def satisfied(self) -> bool:
        """Whether the limit state relied on is, from a load factor that settled."""
        return self.result.settled and self.limit_state.satisfied

    @property
    def outcome(self) -> str:
        """Whether it is satisfied, and why where the ratio does not show it."""
        return self.limit_state.outcome if self.result.settled else "NOT SETTLED: the load factor is no answer yet"

    @property
    def verdict(self) -> str:
        """The number relied on, in a sentence."""
        borne, site = self.limit_state.ag_texts()
        in_SI = f"{shown(self.ag, 'm/s²')} = " if np.isfinite(self.ag) else ""
        # Where that of SLD counts, capacity and demand are equal at a smaller one.
        equal = "borne is a_g = a_g,SLD" if self.limit_state.of_sld else "equal at a_g"
        return (
            f"{self.relied_on}: capacity / demand = {self.limit_state.ratio_text()}, {self.outcome}; {equal} = "
            f"{in_SI}{borne} (site {site})."
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
                    Line(f"{name} next to rests along the push", f"{self._body(W, d)}, and takes no part in the sums")
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
                [Line("capacity of any that begins later", self._floor, "e* ≤ 1")] if whole.e_star < 1 - _ONE else [],
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
                    "Beside it, by hand: a mechanism that was named",
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
        """Share of the mass of the blocks one by one, where that is not the one of the bodies."""
        whole, small = self.participation, self.participation_of_blocks
        if len(small.names) == len(whole.names):
            return []
        why = "together they are one" if len(whole.names) == 1 else "those of a body move together"
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
