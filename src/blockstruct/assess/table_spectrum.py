"""Elastic response spectra given by their ordinates."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from blockstruct.arrays import Array
from blockstruct.assess.lines import Line
from blockstruct.assess.spectrum import check, check_ground, checked_periods, damping_factor
from blockstruct.errors import ModelError
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.text.numbers import in_g, shown
from blockstruct.units import QuantityLike, si, si_array
from blockstruct.vocabulary import counted

g = STANDARD_GRAVITY


@dataclass(frozen=True, slots=True, eq=False)
class TableSpectrum:
    """Spectrum given by its ordinates: see :func:`table_spectrum`.

    Attributes
    ----------
    ag : float
        Ground acceleration of the table, m/s².
    periods : (n,) array
        Ascending from 0 s, s.
    accelerations : (n,) array
        m/s².
    damping : float
        Damping of the table, as a ratio.
    """

    ag: float
    periods: Array
    accelerations: Array
    damping: float

    @property
    def peak(self) -> float:
        """Ordinate at T = 0, m/s²."""
        return float(self.accelerations[0])

    def acceleration(self, period: ArrayLike, damping: float = 0.05) -> Array:
        """Return ordinates, linear in between, times η(ξ) / η of the table except at T = 0; m/s²."""
        T = checked_periods(period)
        if np.any(self.periods[-1] < T):
            msg = (
                f"table_spectrum: asked for T = {T.max():.4g} s, but its last period is {self.periods[-1]:.4g} s; give "
                "the spectrum up to longer periods"
            )
            raise ModelError(msg)
        factor = damping_factor(damping) / damping_factor(self.damping)
        return np.asarray(np.interp(T, self.periods, self.accelerations) * np.where(T > 0, factor, 1.0))

    def displacement(self, period: ArrayLike, damping: float = 0.05) -> Array:
        """Return the largest S_e(T') (T'/2π)² of the periods up to T, m."""
        T, tried = checked_periods(period), np.sort(np.append(self.periods, self._turning()))
        shorter = tried[tried <= T.max()]
        upto = np.maximum.accumulate(self.acceleration(shorter, damping) * (shorter / (2 * np.pi)) ** 2)
        before = upto[np.searchsorted(shorter, T, side="right") - 1]
        return np.asarray(np.maximum(before, self.acceleration(T, damping) * (T / (2 * np.pi)) ** 2))

    def _turning(self) -> Array:
        """Return the periods between two table rows at which S_e T² is largest: with p + q T there, at −2 p / (3 q)."""
        slope = np.diff(self.accelerations) / np.diff(self.periods)
        falls = slope < 0
        begin, end = self.periods[:-1][falls], self.periods[1:][falls]
        at = -2 / 3 * (self.accelerations[:-1][falls] / slope[falls] - begin)
        return at[(begin < at) & (at < end)]

    def at(self, ag: float) -> Self:
        """Return the whole table scaled to another ag, m/s²."""
        return replace(self, ag=ag, accelerations=self.accelerations * (ag / self.ag))

    def lines(self) -> list[Line]:
        """Return the lines on the table."""
        given = (
            f"{len(self.periods)} ordinates from 0 to {self.periods[-1]:g} s at ξ = {100 * self.damping:g} %, "
            f"S_e(0) = {in_g(self.peak, g)}, a_g = {in_g(self.ag, g)}"
        )
        return [
            Line("spectrum given as a table", given),
            Line("other a_g", "the table scaled as a whole: its soil factors do not follow a_g"),
        ]

    def displacement_line(self, period: float, damping: float, symbol: str) -> Line:
        """Return the line on the displacement at a period, with its numbers."""
        eta = damping_factor(damping) / damping_factor(self.damping)
        found = float(self.displacement(period, damping))
        return Line(
            "demand of displacement",
            f"{symbol} = largest S_e(T) (T/2π)² up to {shown(period, 's')}, times η/η_table = {shown(eta)}: "
            f"{shown(found, 'm')}",
            "C8.7.1.2.1.8; NTC 2018 (3.2.4), (3.2.10)",
        )

    @property
    def peak_line(self) -> Line:
        """Line on the acceleration at T = 0."""
        return Line("largest acceleration at the base", f"a_Z = S_e(0) = {in_g(self.peak, g)}")


def table_spectrum(
    periods: Any, accelerations: Any, *, ag: QuantityLike | None = None, damping: float = 0.05
) -> TableSpectrum:
    """Return the elastic response spectrum with given ordinates.

    Parameters
    ----------
    periods : quantity, time, shape (n,)
        Ascending from zero, where the ordinate is the largest ground acceleration.
    accelerations : quantity, acceleration, shape (n,)
    ag : quantity, acceleration
        Ground acceleration of the table; by default the ordinate at zero. Capacity equals demand at this acceleration
        times the factor that scales the whole table.
    damping
        Damping of the table, as a ratio. Other dampings scale the ordinates by η, [3.2.4] of NTC 2018.

    Raises
    ------
    ModelError
        If an argument is not a list, periods do not ascend from zero, ordinates are not positive or not as many, or ag
        or the damping is out of range.
    """
    who = "table_spectrum"
    T, S = (
        si_array(periods, "time", f"{who}: periods"),
        si_array(accelerations, "acceleration", f"{who}: accelerations"),
    )
    check(T.ndim == S.ndim == 1, f"{who}: periods of shape {T.shape}, ordinates of shape {S.shape}", "a list of each")
    check(
        T.shape == S.shape and T.size >= 2,
        f"{who}: {counted(T.size, 'period')}, {counted(S.size, 'ordinate')}",
        "as many, two at least",
    )
    rising, back = "periods that rise from 0 s", int((np.diff(T) <= 0).argmax())
    check(T[0] == 0, f"{who}: the first period {T[0]:g} s", rising)
    check(bool(np.all(np.diff(T) > 0)), f"{who}: period {T[back + 1]:g} s after {T[back]:g} s", rising)
    check(bool(np.all(S > 0)), f"{who}: an ordinate of {S.min():.4g} m/s²", "ordinates above zero")
    of_ground = S[0] if ag is None else si(ag, "acceleration", f"{who}: ag")
    check_ground(who, of_ground)
    ratio = si(damping, "dimensionless", f"{who}: damping")
    check(0 < ratio < 1, f"{who}: damping {ratio:g}", "a ratio between 0 and 1, such as 0.05")
    return TableSpectrum(of_ground, T, S, ratio)
