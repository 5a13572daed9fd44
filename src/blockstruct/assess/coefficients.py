"""Coefficients of the check, each with its paragraph."""

from dataclasses import dataclass, fields
from numbers import Real

import numpy as np

from blockstruct.assess.lines import Line
from blockstruct.errors import ModelError, check_known, shown
from blockstruct.text.assessment import changed_coefficients
from blockstruct.text.note import Note

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
        return [changed_coefficients(changed)] if changed else []


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
        msg = f"{who} {shown(factor)}; give a number from 1 to 10"
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
