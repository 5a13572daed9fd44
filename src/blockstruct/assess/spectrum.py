"""Elastic response spectra of the ground: by NTC 2018 for a site, or given by their ordinates."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from blockstruct.arrays import NEGLIGIBLE, Array
from blockstruct.assess.lines import Line
from blockstruct.errors import ModelError, check_known
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.text.numbers import in_g, shown
from blockstruct.units import QuantityLike, si, si_array
from blockstruct.vocabulary import counted

g = STANDARD_GRAVITY

#: Largest ground acceleration, in multiples of gravity.
LARGEST = 10.0
#: Least maximum amplification of a horizontal spectrum on rock, NTC 2018 § 3.2; and one that no site reaches.
LEAST_F0, LARGEST_F0 = 2.2, 5.0


@dataclass(frozen=True, slots=True)
class Soil:
    """Row of a soil category: ``S_S = a − b F0 ag/g`` within limits, ``C_C = c Tc*^−e`` and T_E, T_F in s."""

    a: float
    b: float
    low: float
    high: float
    c: float
    e: float
    TE: float
    TF: float


#: Tables 3.2.IV and 3.2.VII of NTC 2018 (D.M. 17 January 2018).
SOILS: Mapping[str, Soil] = MappingProxyType(
    {
        "A": Soil(1.00, 0.00, 1.00, 1.00, 1.00, 0.00, 4.5, 10.0),
        "B": Soil(1.40, 0.40, 1.00, 1.20, 1.10, 0.20, 5.0, 10.0),
        "C": Soil(1.70, 0.60, 1.00, 1.50, 1.05, 0.33, 6.0, 10.0),
        "D": Soil(2.40, 1.50, 0.90, 1.80, 1.25, 0.50, 6.0, 10.0),
        "E": Soil(2.00, 1.10, 1.00, 1.60, 1.15, 0.40, 6.0, 10.0),
    }
)
#: Table 3.2.V of NTC 2018: largest topographic amplification, at the top of the slope or ridge.
TOPOGRAPHY: Mapping[str, float] = MappingProxyType({"T1": 1.0, "T2": 1.2, "T3": 1.2, "T4": 1.4})


def damping_factor(damping: float) -> float:
    """Return η of a damping ratio, [3.2.4] of NTC 2018: √(10 / (5 + ξ)) with ξ in per cent, at least 0.55.

    >>> damping_factor(0.05)
    1.0

    Raises
    ------
    ModelError
        If it is not a ratio, such as a value in per cent.
    """
    check(0 <= damping < 1, f"damping {damping:g}", "a ratio from 0 to below 1, such as 0.05 for 5 %")
    return float(max(np.sqrt(10.0 / (5.0 + 100.0 * damping)), 0.55))


@dataclass(frozen=True, slots=True)
class NtcSpectrum:
    """Horizontal elastic spectrum of NTC 2018 § 3.2.3.2: see :func:`ntc_spectrum`.

    Attributes
    ----------
    ag : float
        m/s².
    F0 : float
    Tc_star : float
        s.
    soil, topography : str
    """

    ag: float
    F0: float
    Tc_star: float
    soil: str
    topography: str

    @property
    def SS(self) -> float:
        """Stratigraphic amplification, Table 3.2.IV; it falls with ag."""
        row = SOILS[self.soil]
        return float(np.clip(row.a - row.b * self.F0 * self.ag / g, row.low, row.high))

    @property
    def CC(self) -> float:
        """Factor of the period, Table 3.2.IV."""
        row = SOILS[self.soil]
        return float(row.c * self.Tc_star**-row.e)

    @property
    def ST(self) -> float:
        """Topographic amplification, Table 3.2.V."""
        return TOPOGRAPHY[self.topography]

    @property
    def S(self) -> float:
        """[3.2.3]."""
        return self.SS * self.ST

    @property
    def TC(self) -> float:
        """[3.2.5], s: end of constant acceleration."""
        return self.CC * self.Tc_star

    @property
    def TB(self) -> float:
        """[3.2.6], s: begin of constant acceleration."""
        return self.TC / 3

    @property
    def TD(self) -> float:
        """[3.2.7], s: begin of constant displacement; it grows with ag."""
        return 4.0 * self.ag / g + 1.6

    @property
    def peak(self) -> float:
        """Largest acceleration of the ground, ag S, m/s²."""
        return self.ag * self.S

    def acceleration(self, period: ArrayLike, damping: float = 0.05) -> Array:
        """Return S_e(T), [3.2.2], m/s²."""
        T, top = checked_periods(period), damping_factor(damping) * self.F0
        long = np.maximum(T, self.TC)
        branches = [1 + T / self.TB * (top - 1), np.full_like(T, top), top * self.TC / long]
        shape = np.select([T < self.TB, T < self.TC, T < self.TD], branches, top * self.TC * self.TD / long**2)
        return np.asarray(self.peak * shape)

    def displacement(self, period: ArrayLike, damping: float = 0.05) -> Array:
        """Return S_De(T), [3.2.10] up to T_E and [3.2.11] beyond, m."""
        T, row = checked_periods(period), SOILS[self.soil]
        top, dg = damping_factor(damping) * self.F0, 0.025 * self.peak * self.TC * self.TD
        beyond = dg * (top + (1 - top) * np.clip((T - row.TE) / (row.TF - row.TE), 0, 1))
        return np.asarray(np.where(row.TE >= T, self.acceleration(T, damping) * (T / (2 * np.pi)) ** 2, beyond))

    def at(self, ag: float) -> Self:
        """Return the same site at another ag, m/s². F0 and Tc* stay; S_S and T_D follow ag."""
        return replace(self, ag=ag)

    def lines(self) -> list[Line]:
        """Return every coefficient with its paragraph."""
        row = SOILS[self.soil]
        SS = f"S_S = {self.SS:.2f}"
        if row.b:
            SS = f"S_S = {row.a:.2f} − {row.b:.2f} F0 a_g/g, from {row.low:.2f} to {row.high:.2f} = {shown(self.SS)}"
        power = f"{row.c:.2f} T_C*^−{row.e:.2f} = " if row.e else ""
        ag = f"a_g = {in_g(self.ag, g)}, F0 = {shown(self.F0)}, T_C* = {shown(self.Tc_star, 's')}"
        return [
            Line("hazard at the site, as given", ag, "NTC 2018 § 3.2"),
            Line(f"amplification of soil {self.soil}", SS, "NTC 2018 Tab. 3.2.IV"),
            Line("topography", f"S_T = {shown(self.ST)}, topography {self.topography}", "NTC 2018 Tab. 3.2.V"),
            Line("amplification", f"S = S_S S_T = {shown(self.S)}", "NTC 2018 (3.2.3)"),
            Line("periods", f"C_C = {power}{shown(self.CC)}", "NTC 2018 Tab. 3.2.IV"),
            Line(
                "",
                f"T_C = C_C T_C* = {shown(self.TC, 's')}, T_B = T_C/3 = {shown(self.TB, 's')}",
                "NTC 2018 (3.2.5), (3.2.6)",
            ),
            Line("", f"T_D = 4.0 a_g/g + 1.6 = {shown(self.TD, 's')}", "NTC 2018 (3.2.7)"),
        ]

    def displacement_line(self, period: float, damping: float, symbol: str) -> Line:
        """Return the line on S_De at a period, with its numbers."""
        found, TE = float(self.displacement(period, damping)), SOILS[self.soil].TE
        eta = f"η = √(10/(5 + ξ)) = {shown(damping_factor(damping))} for ξ = {100 * damping:g} %"
        if period > TE:
            return Line(
                "demand of displacement",
                f"{symbol} beyond T_E = {TE:g} s = {shown(found, 'm')}; {eta}",
                "NTC 2018 (3.2.11), (3.2.4)",
            )
        S = float(self.acceleration(period, damping))
        return Line(
            "demand of displacement",
            f"{symbol} = S_e(T) (T/2π)² = {shown(S, 'm/s²')} · ({shown(period, 's')}/2π)² = {shown(found, 'm')}; {eta}",
            "NTC 2018 (3.2.2), (3.2.4), (3.2.10)",
        )

    @property
    def peak_line(self) -> Line:
        """Line on the ground acceleration, with its numbers."""
        return Line(
            "largest acceleration at the base",
            f"a_Z = a_g S = {shown(self.ag, 'm/s²')} · {shown(self.S)} = {in_g(self.peak, g)}",
            "NTC 2018 (3.2.2) at T = 0",
        )


def ntc_spectrum(ag: QuantityLike, F0: float, Tc: QuantityLike, soil: str, topography: str = "T1") -> NtcSpectrum:
    """Return the horizontal elastic spectrum of a site, NTC 2018 § 3.2.3.2.

    A spectrum with other coefficients, such as of a local site response study, is a :func:`table_spectrum`.

    Parameters
    ----------
    ag : quantity, acceleration
        On rigid level ground, for the limit state and the reference period of the building: ``Q_(0.15, "g_0")``.
    F0 : float
        Largest amplification of the spectrum on rigid level ground; 2.2 at least.
    Tc : quantity, time
        Tc*, where the constant velocity of that spectrum begins.
    soil
        Category A to E, Table 3.2.II.
    topography
        Category T1 to T4, Table 3.2.III, on top of the slope or ridge.

    Raises
    ------
    ModelError
        If a category is unknown, or a value is outside its range.
    UnitError, DimensionError
        If a bare number is given where a unit is due.

    Examples
    --------
    >>> site = ntc_spectrum("0.15 g_0", F0=2.4, Tc="0.3 s", soil="B")
    >>> round(site.S, 6), round(site.TC, 4), round(float(site.acceleration(site.TC)) / 9.80665, 4)
    (1.2, 0.4198, 0.432)
    """
    who = "ntc_spectrum"
    for name, given, table in (("soil", soil, SOILS), ("topography", topography, TOPOGRAPHY)):
        check_known(given, table, f"{who}: {name}")
    acceleration, Tc_star = si(ag, "acceleration", f"{who}: ag"), si(Tc, "time", f"{who}: Tc")
    amplification = si(F0, "dimensionless", f"{who}: F0")
    check_ground(who, acceleration)
    between = f"{LEAST_F0} at least (NTC 2018 § 3.2), and {LARGEST_F0:g} at most"
    check(LEAST_F0 <= amplification <= LARGEST_F0, f"{who}: F0 {amplification:.4g}", between)
    check(0 < Tc_star <= 2, f"{who}: Tc {Tc_star:.4g} s", "a Tc* above 0 s and up to 2 s")
    found = NtcSpectrum(acceleration, amplification, Tc_star, soil, topography)
    check(
        found.TC <= found.TD,
        f"{who}: T_C = C_C Tc* = {shown(found.TC, 's')} is beyond T_D = {shown(found.TD, 's')}",
        "a Tc* that leaves it below",
    )
    return found


def checked_periods(period: ArrayLike) -> Array:
    """Return periods in s, and refuse negative ones."""
    T = np.asarray(period, dtype=float)
    check(bool(np.all(T >= 0)), f"period {T.min(initial=0.0):g} s", "periods from 0 s on")
    return T


def check_ground(who: str, ag: float) -> None:
    """Refuse a number that cannot be a ground acceleration, m/s²."""
    between = f"an ag from {NEGLIGIBLE:g} g and up to {LARGEST:g} g"
    check(NEGLIGIBLE * g <= ag <= LARGEST * g, f"{who}: ag {ag:.4g} m/s²", between)


def check(holds: bool, what: str, remedy: str) -> None:
    """Raise an error unless a condition holds."""
    if not holds:
        msg = f"{what}; give {remedy}"
        raise ModelError(msg)


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
