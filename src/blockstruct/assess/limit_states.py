"""Limit states of a mechanism: capacity, demand and coefficients, C8.7.1.2.1.5 to C8.7.1.2.1.8."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any

import numpy as np

from blockstruct.arrays import NEGLIGIBLE
from blockstruct.assess.capacity import CapacityCurve
from blockstruct.assess.floor_spectrum import Spectrum
from blockstruct.assess.lines import Line
from blockstruct.assess.rotation import first_reached
from blockstruct.assess.spectrum import LARGEST
from blockstruct.errors import ModelError, check_known
from blockstruct.errors import shown as as_given
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.text import assessment
from blockstruct.text.note import Note
from blockstruct.text.numbers import in_g, ratio_text, shown, told_apart

#: Confidence factor of each level of knowledge, Circolare 7/2019 Tab. C8.5.IV.
KNOWLEDGE_LEVELS = {"LC1": 1.35, "LC2": 1.20, "LC3": 1.00}

_SOURCES = {
    "q": ("behaviour factor q", "C8.7.1.2.1.7"),
    "slv_share": ("d_SLV / d0", "C8.7.1.2.1.6"),
    "slc_share": ("d_SLC / d0", "C8.7.1.2.1.6"),
    "slv_loss": ("loss of a(d) by broken ties that ends SLV", "C8.7.1.2.1.6"),
    "slv_period": ("factor of T_SLV, in multiples of π", "C8.7.1.2.1.8 (C8.7.1.10)"),
    "slc_period": ("factor of T_SLC, in multiples of π", "C8.7.1.2.1.8 (C8.7.1.11)"),
    "slv_damping": ("damping ξ at SLV", "C8.7.1.2.1.8"),
    "slc_damping": ("damping ξ at SLC", "C8.7.1.2.1.8"),
    "without_crushing": ("FC where α0 ignores crushing", "C8.7.1.2.1.3"),
}


@dataclass(frozen=True, slots=True)
class Coefficients:
    """Coefficients of the Circolare for local mechanisms; every check prints them.

    Parameters
    ----------
    q
        Behaviour factor of the linear check at SLV, C8.7.1.2.1.7.
    slv_share, slc_share
        Displacement at SLV and SLC over d0, C8.7.1.2.1.6.
    slv_loss
        Loss of acceleration by all broken ties, relative to the largest, at which SLV ends, C8.7.1.2.1.6.
    slv_period, slc_period
        Factors of the equivalent periods, in multiples of π, [C8.7.1.10] and [C8.7.1.11].
    slv_damping, slc_damping
        Equivalent damping of the mechanism as a ratio, C8.7.1.2.1.8.
    without_crushing
        Confidence factor if α0 ignores the compressive strength: the factor of LC1, C8.7.1.2.1.3.
    """

    q: float = 2.0
    slv_share: float = 0.4
    slc_share: float = 0.6
    slv_loss: float = 0.5
    slv_period: float = 1.68
    slc_period: float = 1.56
    slv_damping: float = 0.08
    slc_damping: float = 0.10
    without_crushing: float = 1.35

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            most = 1.0 if field.name.endswith(("share", "loss", "damping")) else 10.0
            # At d0 the acceleration is zero and the period infinite.
            below = field.name.endswith(("share", "damping"))
            # A confidence factor below one would raise the capacity.
            least = 1.0 if field.name == "without_crushing" else np.finfo(float).tiny
            if not _is_number(value) or not least <= value <= most or (below and value == most):
                wanted = "from 1 up to" if least == 1 else "above 0 and below" if below else "above 0 and up to"
                msg = f"Coefficients: {field.name} {value!r}; give a number {wanted} {most:g}"
                raise ModelError(msg)
        if self.slc_share < self.slv_share:
            msg = (
                f"Coefficients: slc_share {self.slc_share:g} is below slv_share {self.slv_share:g}, but SLC follows "
                "SLV; give an slc_share of at least that"
            )
            raise ModelError(msg)

    def lines(self) -> list[Line]:
        """Return a line on every coefficient, which shows whether it differs from the Circolare."""
        lines = []
        for field in fields(self):
            value = getattr(self, field.name)
            what, source = _SOURCES[field.name]
            given = "" if value == field.default else f" (given; the Circolare has {field.default:g})"
            lines.append(Line(what, f"{value:g}{given}", source))
        return lines

    def notes(self) -> list[Note]:
        """Return the note on coefficients that differ from the Circolare, if any do."""
        plain = Coefficients()
        values = {name: (getattr(self, name), getattr(plain, name)) for name in _SOURCES}
        changed = [(_SOURCES[n][0], *pair, _SOURCES[n][1]) for n, pair in values.items() if pair[0] != pair[1]]
        return [assessment.changed_coefficients(changed)] if changed else []


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def confidence(
    factor: float | None, level: str | None, *, crushing: bool, without_crushing: float
) -> tuple[float, str]:
    """Return the confidence factor and the reason for it, C8.7.1.2.1.3 and Tab. C8.5.IV.

    Raises
    ------
    ModelError
        If the level is unknown or contradicts the factor, both are missing although α0 counts crushing, or the
        factor is below the least one without crushing.
    """
    who = "local_mechanism: confidence_factor"
    if level is not None:
        check_known(level, KNOWLEDGE_LEVELS, "local_mechanism: knowledge_level")
    if factor is not None and not (_is_number(factor) and 1 <= factor <= 10):
        msg = f"{who} {as_given(factor)}; give a number from 1 to 10"
        raise ModelError(msg)
    given = KNOWLEDGE_LEVELS[level] if level is not None else None
    if factor is not None and given is not None and factor != given:
        msg = f"{who} {factor:g}, but knowledge level {level} has {given:g}; give one of the two"
        raise ModelError(msg)
    value = given if factor is None else float(factor)
    if not crushing:
        if factor is not None and factor < without_crushing:
            msg = (
                f"{who} {factor:g}: α0 does not count the compressive strength, so FC is at least "
                f"{without_crushing:g}, the factor of LC1 (C8.7.1.2.1.3); give the joints a "
                "compressive_strength, or this factor"
            )
            raise ModelError(msg)
        least = f"α0 ignores the compressive strength: at least the factor of LC1, {without_crushing:g}"
        return max(without_crushing, value or 0.0), least
    if value is None:
        msg = f"{who}: α0 counts the compressive strength; give the factor, or knowledge_level='LC1', 'LC2' or 'LC3'"
        raise ModelError(msg)
    reason = f"the factor of level {level} (Tab. C8.5.IV)" if level is not None else "as given"
    return value, f"α0 counts the compressive strength: {reason}"


g = STANDARD_GRAVITY
#: Limit state that each method relies on.
METHODS = {"linear": "SLV, linear", "displacement": "SLV, by displacement"}
#: Ground accelerations that bracket the one at which capacity equals demand.
_TRIED = g * np.geomspace(NEGLIGIBLE, LARGEST, 400)


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
    """

    name: str
    capacity: float
    demand: float
    unit: str
    ag: float
    ag_site: float
    lines: tuple[Line, ...]
    of_sld: bool = False

    @property
    def ratio(self) -> float:
        """Capacity over demand."""
        return self.capacity / self.demand

    @property
    def satisfied(self) -> bool:
        """Whether the structure bears the ground acceleration of the site; False without a demand."""
        return bool(self.ag >= self.ag_site and np.isfinite(self.demand))

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
        return assessment.state_outcome(self.name, self.ratio, satisfied=self.satisfied)


def damage(a0_star: float, spectrum: Spectrum, *, with_demand: bool) -> LimitState:
    """Return SLD of an acceleration a0*, m/s², with a spectrum, or with its site alone."""
    ag = _ground_acceleration(spectrum, lambda s: s.peak, a0_star)
    lines = [Line("capacity", f"a_Z,SLD = α0 g / (e* FC) = a0* = {in_g(a0_star, g)}", "C8.7.1.2.1.5 (C8.7.1.8)")]
    if with_demand:
        lines += [*spectrum.lines(), spectrum.peak_line, _ratio(a0_star, spectrum.peak, "m/s²")]
    lines.append(_equal("a_g,SLD", "a_Z(a_g) = a0*", spectrum, ag, "C8.7.1.2.1.5", own_site=with_demand))
    demand = spectrum.peak if with_demand else np.nan
    return LimitState("SLD", a0_star, demand, "m/s²", ag, spectrum.ag, tuple(lines))


def linear(a0_star: float, spectrum: Spectrum, ag_sld: float, c: Coefficients) -> LimitState:
    """Return SLV by the behaviour factor q, of an acceleration a0*, m/s²."""
    demand = spectrum.peak / c.q
    ag = _ground_acceleration(spectrum, lambda s: s.peak / c.q, a0_star)
    lines = (
        Line("capacity", f"a0* = {in_g(a0_star, g)}", "C8.7.1.2.1.5 (C8.7.1.8)"),
        spectrum.peak_line,
        Line("demand", f"a_Z / q = {shown(spectrum.peak, 'm/s²')} / {c.q:g} = {shown(demand, 'm/s²')}", "C8.7.1.2.1.7"),
        _ratio(a0_star, demand, "m/s²"),
        _equal("a_g,SLV", "a_Z(a_g) / q = a0*", spectrum, ag, "C8.7.1.2.1.7"),
        Line(
            "the same, S kept at a_g,SLD",
            f"q a_g,SLD = {c.q:g} · {shown(ag_sld, 'm/s²')} = {in_g(c.q * ag_sld, g)}",
            "C8.7.1.2.1.7",
        ),
    )
    return LimitState(METHODS["linear"], a0_star, demand, "m/s²", ag, spectrum.ag, lines)


def by_displacement(
    curve: CapacityCurve, ag_sld: float, state: str, c: Coefficients, spectrum: Spectrum, *, with_demand: bool
) -> LimitState:
    """Return SLV or SLC by displacement; its ground acceleration is at least the one of SLD, m/s².

    Raises
    ------
    ModelError
        If the curve loses too much before its first displacement, or a table ends before the period.
    """
    share, loss, factor, damping = {
        "SLV": (c.slv_share, c.slv_loss, c.slv_period, c.slv_damping),
        "SLC": (c.slc_share, np.inf, c.slc_period, c.slc_damping),
    }[state]
    d = min([share * curve.d0, *(at for at, lost in curve.losses if lost > loss)])
    if d <= 0:
        msg = (
            f"d_{state} is 0: the capacity curve loses more than {loss:g} of its largest acceleration before its first "
            "state at a displacement; run the pushover with more steps, or give method='linear'"
        )
        raise ModelError(msg)
    capacity = f"d_{state} = {share:g} d0 = {share:g} · {shown(curve.d0, 'm')} = {shown(d, 'm')}"
    if d < share * curve.d0:
        capacity = f"d_{state} = {shown(d, 'm')}, where a tie breaks, less than {share:g} d0"
    a = curve.at(d)
    T = factor * np.pi * np.sqrt(d / a)
    ag = _ground_acceleration(spectrum, lambda s: float(s.displacement(T, damping)), d)
    number = {"SLV": "(C8.7.1.10)", "SLC": "(C8.7.1.11)"}[state]
    lines = [
        Line("capacity", capacity, "C8.7.1.2.1.6"),
        Line("acceleration there", f"a(d_{state}) = {shown(a, 'm/s²')}", "C8.7.1.2.1.3"),
        Line(
            "equivalent period",
            f"T_{state} = {factor:g} π √(d/a) = {factor:g} π √({shown(d, 'm')} / {shown(a, 'm/s²')}) = {shown(T, 's')}",
            f"C8.7.1.2.1.8 {number}",
        ),
    ]
    demand = float(spectrum.displacement(T, damping))
    if with_demand:
        # The spectrum of SLV has its own section.
        lines += spectrum.lines() if state != "SLV" else []
        lines += [spectrum.displacement_line(T, damping, f"S_De(T_{state})"), _ratio(d, demand, "m")]
    equation = f"S_De(T_{state}; a_g) = d_{state}"
    lines.append(_equal(f"a_g,{state}", equation, spectrum, ag, "C8.7.1.2.1.8", own_site=with_demand))
    of_sld = ag < ag_sld
    if of_sld:
        lines.append(Line("not below that of SLD", f"a_g,{state} = a_g,SLD = {in_g(ag_sld, g)}", "C8.7.1.2.1.8"))
    ag = max(ag, ag_sld)
    return LimitState(
        f"{state}, by displacement", d, demand if with_demand else np.nan, "m", ag, spectrum.ag, tuple(lines), of_sld
    )


def _ground_acceleration(spectrum: Spectrum, demand: Callable[[Any], float], capacity: float) -> float:
    """Return the least ground acceleration that exceeds a capacity, m/s²; infinite beyond 10 g."""
    # Several exist if S_S falls faster than ag rises: the least counts.
    return first_reached(lambda ag: demand(spectrum.at(ag)) - capacity, _TRIED)


def _site(spectrum: Spectrum, ag: float) -> str:
    S = getattr(spectrum.at(ag), "S", None) if np.isfinite(ag) else None
    return f", where S = {shown(S)}" if S is not None else ""


def _equal(state: str, equation: str, spectrum: Spectrum, ag: float, source: str, *, own_site: bool = True) -> Line:
    site = _site(spectrum, ag) + ("" if own_site else "; site of SLV")
    return Line(f"ground acceleration, {state}", f"{equation} at {in_g(ag, g)}{site}", source)


def _ratio(capacity: float, demand: float, unit: str) -> Line:
    (borne, demanded), (ratio, _) = told_apart(capacity, demand), told_apart(capacity / demand, 1.0)
    return Line("capacity / demand", f"{borne} {unit} / {demanded} {unit} = {ratio}")
