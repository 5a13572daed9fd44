"""Spectra at a height of a building, from its modes."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Self

import numpy as np
from attrs import field, frozen
from numpy.typing import ArrayLike

from blockstruct.arrays import NEGLIGIBLE, Array
from blockstruct.assess.lines import Line
from blockstruct.assess.spectrum import NtcSpectrum, TableSpectrum, checked_periods, damping_factor
from blockstruct.errors import ModelError
from blockstruct.model import STANDARD_GRAVITY, checked_tuple
from blockstruct.model.fields import named_arguments, number, scalar
from blockstruct.text.numbers import in_g, shown
from blockstruct.units import si
from blockstruct.vocabulary import counted

g = STANDARD_GRAVITY

#: Relative difference of |γ ψ| of the first mode, from which two heights differ.
_OTHER_HEIGHT = 0.1
#: Largest plausible |γ ψ| of a mode; 85 for a mass of 85 % is not. Tops of buildings have 1.2 to 1.6. An appendage in
#: resonance with the building has 1/(2 √μ), which is 10 for a mass μ of 1/400 of the mode.
_MOST_AMPLIFIED = 10.0
_NUMBER = {"dimension": "dimensionless"}


@frozen(field_transformer=named_arguments)
class Mode:
    """A mode of the building that contains the mechanism, in the direction of the push.

    Parameters
    ----------
    period : quantity, time
        T_k. Masonry that is damaged at the limit state has a period 50 to 100 % longer (C8.7.1.2.1.4).
    participation
        γ_k = φᵀM1 / φᵀMφ, participation factor, about 1.2 to 1.6 for a first mode that is 1 at the top. The share of
        the mass that takes part, 0.85 for instance, is another number.
    shape
        ψ_k(z) at the height and the place in plan of the mechanism, in the same scale as γ_k.
    damping
        ξ_k as a ratio; 0.10 to 0.20 for damaged masonry (C8.7.1.2.1.4).
    """

    period: float = field(converter=scalar, metadata={"dimension": "time"})
    participation: float = field(kw_only=True, converter=number, metadata=_NUMBER)
    shape: float = field(kw_only=True, converter=number, metadata=_NUMBER)
    damping: float = field(default=0.05, kw_only=True, converter=number, metadata=_NUMBER)

    def __attrs_post_init__(self) -> None:
        if not 0 < self.period <= 10 or not 0 < self.damping < 1:
            given = f"period {self.period:.4g} s, damping {self.damping:.4g}"
            msg = f"Mode: {given}; give up to 10 s, and a ratio such as 0.05"
            raise ModelError(msg)
        if abs(self.participation * self.shape) > _MOST_AMPLIFIED:
            msg = (
                f"Mode: participation · shape = {self.participation:.4g} · {self.shape:.4g}; give γ and ψ in one "
                f"scale, up to {_MOST_AMPLIFIED:g} together: γ is not the share of the mass, nor in per cent"
            )
            raise ModelError(msg)


@dataclass(frozen=True, slots=True)
class FloorSpectrum:
    """Spectrum at a height z, Circolare 7/2019 C7.2.3: see :func:`floor_spectrum`.

    Attributes
    ----------
    ground : NtcSpectrum or TableSpectrum
    modes : tuple of Mode
    a, b : float
        Begin and end of the peak of each mode, in multiples of its period.
    """

    ground: NtcSpectrum | TableSpectrum
    modes: tuple[Mode, ...]
    a: float
    b: float

    @property
    def ag(self) -> float:
        """Ground acceleration ag, m/s²."""
        return self.ground.ag

    @property
    def T1(self) -> float:
        """Longest period of the modes, s."""
        return max(mode.period for mode in self.modes)

    @property
    def peak(self) -> float:
        """a_Z(z), [C7.2.8], m/s²."""
        return float(np.linalg.norm([self.modal_peak(mode) for mode in self.modes]))

    def modal_peak(self, mode: Mode) -> float:
        """Return a_Z,k(z), [C7.2.7], m/s²."""
        of_ground = float(self.ground.acceleration(mode.period, mode.damping))
        return float(of_ground * abs(mode.participation * mode.shape) * np.sqrt(1 + 0.0004 * (100 * mode.damping) ** 2))

    def acceleration(self, period: ArrayLike, damping: float = 0.05) -> Array:
        """Return S_eZ(T, ξ, z), [C7.2.5] with [C7.2.6], m/s²."""
        T = checked_periods(period)
        found, beyond = self._of_modes(T, damping), T > self.T1
        # Beyond the first period the building neither amplifies nor filters.
        ground = self.ground.acceleration(np.where(beyond, T, 0.0), damping)
        return np.asarray(np.where(beyond, np.maximum(found, ground), found))

    def _of_modes(self, T: Array, damping: float) -> Array:
        squares = sum((self._of_mode(mode, T, damping) ** 2 for mode in self.modes), np.zeros_like(T))
        return np.sqrt(squares)

    def _of_mode(self, mode: Mode, T: Array, damping: float) -> Array:
        peak, rise = self.modal_peak(mode), 1.1 * mode.damping**-0.5 * damping_factor(damping)
        before = np.maximum(1 - T / (self.a * mode.period), 0) ** 1.6
        behind = np.maximum(T / (self.b * mode.period) - 1, 0) ** 1.2
        return np.asarray(rise * peak / (1 + (rise - 1) * (before + behind)))

    def displacement(self, period: ArrayLike, damping: float = 0.05) -> Array:
        """Return S_eZ T²/4π², beyond b T_1 at least S_eZ(T_1) b² T_1²/4π² ([C8.7.1.12]), m."""
        T = checked_periods(period)
        plain = self.acceleration(T, damping) * (T / (2 * np.pi)) ** 2
        end = self.b * self.T1
        least = float(self.acceleration(self.T1, damping)) * (end / (2 * np.pi)) ** 2
        return np.asarray(np.where(end < T, np.maximum(plain, least), plain))

    def at(self, ag: float) -> Self:
        """Return the spectrum at another ground acceleration, m/s², with the same modes."""
        return replace(self, ground=self.ground.at(ag))

    def lines(self) -> list[Line]:
        """Return the lines on the ground, and on every mode with its numbers."""
        lines = self.ground.lines()
        for k, mode in enumerate(self.modes, 1):
            numbers = (
                f"a_Z,{k} = S_e(T_{k}, ξ_{k}) |γ ψ| √(1 + 0.0004 ξ²) = "
                f"{shown(float(self.ground.acceleration(mode.period, mode.damping)), 'm/s²')} · "
                f"|{shown(mode.participation)} · {shown(mode.shape)}| · "
                f"{shown(float(np.sqrt(1 + 4 * mode.damping**2)))} = {shown(self.modal_peak(mode), 'm/s²')}"
            )
            what = f"mode {k}: T = {shown(mode.period, 's')}, ξ = {100 * mode.damping:g} %"
            lines.append(Line(what, numbers, "C7.2.3 (C7.2.7)"))
        lines.append(
            Line(
                "floor spectrum",
                f"S_eZ of the modes, root of the sum of squares; a = {self.a:g}, b = {self.b:g}; ξ_k of the factor "
                "1.1 ξ_k^−0.5 as a ratio",
                "C7.2.3 (C7.2.5), (C7.2.6)",
            )
        )
        return lines

    def displacement_line(self, period: float, damping: float, symbol: str) -> Line:
        """Return the line on the displacement at a period, with its numbers."""
        S, found = float(self.acceleration(period, damping)), float(self.displacement(period, damping))
        of_modes, plain = float(self._of_modes(np.array(period), damping)), S * (period / (2 * np.pi)) ** 2
        numbers = f"S_eZ T²/4π² = {shown(S, 'm/s²')} · ({shown(period, 's')}/2π)² = {shown(plain, 'm')}"
        if of_modes < S:
            numbers += f", with S_e of the ground beyond T_1, more than the {shown(of_modes, 'm/s²')} of the modes"
        if found > plain * (1 + 1e-12):
            of_first = shown(float(self.acceleration(self.T1, damping)), "m/s²")
            numbers = (
                f"S_eZ(T_1) b² T_1²/4π² = {of_first} · ({self.b:g} · {shown(self.T1, 's')}/2π)² = {shown(found, 'm')}, "
                f"the least beyond b T_1, more than {numbers}"
            )
        return Line(
            "demand of displacement",
            f"{symbol} = {numbers}; η = {shown(damping_factor(damping))} for ξ = {100 * damping:g} %",
            "C8.7.1.2.1.8 (C8.7.1.12)",
        )

    @property
    def peak_line(self) -> Line:
        """Line on the largest acceleration at the height, with its numbers."""
        parts = " + ".join(f"{shown(self.modal_peak(mode))}²" for mode in self.modes)
        return Line("largest acceleration at z", f"a_Z = √({parts}) = {in_g(self.peak, g)}", "C7.2.3 (C7.2.8)")


#: Demand of a check.
Spectrum = NtcSpectrum | TableSpectrum | FloorSpectrum


def floor_spectrum(
    ground: NtcSpectrum | TableSpectrum, modes: Iterable[Mode], *, a: float = 0.8, b: float = 1.1
) -> FloorSpectrum:
    """Return the spectrum at the height of a mechanism, Circolare 7/2019 C7.2.3, [C7.2.5–8].

    The spectrum follows from modes of the building. The Circolare states ξ_k in per cent, and ``√(1 + 0.0004 ξ_k²)``
    uses it so. In the factor ``1.1 ξ_k^−0.5`` of [C7.2.6], a damping of 5 % would then *reduce* the acceleration of the
    floor to half at resonance, although Table C7.2.II states an amplification of 5. There ξ_k is a ratio, ``1.1 ·
    0.05^−0.5 = 4.9``, which is on the safe side.

    Parameters
    ----------
    ground
        Spectrum of the ground.
    modes
        Modes of the building in the direction of the push, often only the first one (C8.7.1.2.1.8).
    a, b
        Begin and end of the peak of each mode, in multiples of its period.

    Raises
    ------
    ModelError
        If there is no mode, an argument has a wrong type, or a and b do not enclose one.
    """
    if not isinstance(ground, NtcSpectrum | TableSpectrum):
        msg = f"floor_spectrum: ground is a {type(ground).__name__}; give ntc_spectrum(…) or table_spectrum(…)"
        raise ModelError(msg)
    given = checked_tuple(modes, Mode, "floor_spectrum: modes")
    begin, end = (si(value, "dimensionless", f"floor_spectrum: {name}") for name, value in (("a", a), ("b", b)))
    if not given or not 0 < begin <= 1 <= end:
        msg = (
            f"floor_spectrum: {counted(len(given), 'mode')}, a = {begin:g}, b = {end:g}; give a mode at least, and "
            "0 < a ≤ 1 ≤ b"
        )
        raise ModelError(msg)
    if not any(mode.participation * mode.shape for mode in given):
        msg = "floor_spectrum: participation · shape of every mode is 0; give a mode that moves at the height"
        raise ModelError(msg)
    return FloorSpectrum(ground, given, begin, end)


def check_one_place(*demands: tuple[str, Spectrum | None]) -> None:
    """Refuse spectra of several limit states, the weakest first, that belong to different places.

    Periods and dampings of the modes may differ, as damage changes them (C8.7.1.2.1.4). A table has no place.

    Raises
    ------
    ModelError
        If one belongs to the ground and another to a height, the heights or the sites differ, or a weaker limit state
        has the larger ag.
    """
    given = [(name, spectrum) for name, spectrum in demands if spectrum is not None]
    for (weaker, one), (stronger, other) in combinations(given, 2):
        who = f"local_mechanism: {weaker} and {stronger}"
        if isinstance(one, FloorSpectrum) and isinstance(other, FloorSpectrum):
            _check_height(who, one, other)
        elif {type(one), type(other)} == {FloorSpectrum, NtcSpectrum}:
            at_height, on_ground = (weaker, stronger) if isinstance(one, FloorSpectrum) else (stronger, weaker)
            msg = (
                f"{who}: {at_height} is a floor spectrum, {on_ground} the spectrum of the ground, for one mechanism; "
                f"give {on_ground} at the height, too, as bs.assess.floor_spectrum(…) of its ground and "
                "the modes, or both of the ground"
            )
            raise ModelError(msg)
        grounds = [s.ground if isinstance(s, FloorSpectrum) else s for s in (one, other)]
        sites = [ground for ground in grounds if isinstance(ground, NtcSpectrum)]
        if len(sites) > 1:
            _check_site(who, *sites)


def _check_height(who: str, one: FloorSpectrum, other: FloorSpectrum) -> None:
    first = [max(spectrum.modes, key=lambda mode: mode.period) for spectrum in (one, other)]
    moves = [abs(mode.participation * mode.shape) for mode in first]
    if abs(moves[0] - moves[1]) > _OTHER_HEIGHT * max(moves):
        numbers = " and ".join(
            f"{shown(mode.participation)} · {shown(mode.shape)} = {shown(mode.participation * mode.shape)}"
            for mode in first
        )
        msg = (
            f"{who}: participation · shape of the first mode is {numbers}, which are two heights or two buildings; "
            "give both at the height of the mechanism: only periods and dampings depend on the limit state"
        )
        raise ModelError(msg)


def _check_site(who: str, weaker: NtcSpectrum, stronger: NtcSpectrum) -> None:
    for what in ("soil", "topography"):
        one, other = getattr(weaker, what), getattr(stronger, what)
        if one != other:
            msg = f"{who}: {what} {one!r} and {other!r}, for one site; give both with the same {what}"
            raise ModelError(msg)
    if weaker.ag > (1 + NEGLIGIBLE) * stronger.ag:
        ag = " and ".join(in_g(spectrum.ag, g) for spectrum in (weaker, stronger))
        msg = f"{who}: ag is {ag}, but it must not fall from SLD to SLV to SLC; give each limit state its own"
        raise ModelError(msg)
