"""Spectra: by hand at the ends of every branch, consistent with each other, and bad input refused."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.assess.limit_states import _ground_acceleration

g = 9.80665
SITE = {"ag": Q_(0.15, "g_0"), "F0": 2.4, "Tc": Q_(0.3, "s"), "soil": "B"}


def test_the_branches_of_the_spectrum_by_hand():
    """Soil C, T1, ag = 0.2 g, F0 = 2.5, Tc* = 0.35 s, ξ = 5 %.

    S_S = 1.70 − 0.60 · 2.5 · 0.2 = 1.40; C_C = 1.05 · 0.35^−0.33 = 1.484728; T_C = 0.519655 s; T_B = 0.173218 s;
    T_D = 4 · 0.2 + 1.6 = 2.4 s. S_e(0) = 0.2 · 1.4 = 0.28 g; S_e(T_B) = S_e(T_C) = 0.28 · 2.5 = 0.7 g;
    S_e(T_D) = 0.7 · 0.519655 / 2.4 = 0.151566 g; S_e(4 s) = 0.7 · 0.519655 · 2.4 / 16 = 0.0545637 g.
    """
    site = bs.assess.ntc_spectrum(Q_(0.2, "g_0"), 2.5, "0.35 s", "C")
    TC = 1.05 * 0.35**-0.33 * 0.35
    assert pytest.approx((1.4, 1.0, 2.4)) == (site.SS, site.ST, site.TD)
    assert pytest.approx((TC / 3, TC)) == (site.TB, site.TC)
    assert pytest.approx(0.519655, abs=1e-6) == TC
    hand = [0.28, 0.28 * 1.75, 0.7, 0.7, 0.7, 0.7 * TC / 2.4, 0.7 * TC * 2.4 / 16]
    found = site.acceleration([0, TC / 6, TC / 3, 0.4, TC, 2.4, 4.0])
    np.testing.assert_allclose(found / g, hand, rtol=1e-12)
    # ξ = 8 %: η = √(10/13) on all but S_e(0); the displacement is S_e (T/2π)².
    eta = np.sqrt(10 / 13)
    assert site.acceleration(1.0, 0.08) == pytest.approx(eta * site.acceleration(1.0))
    assert site.acceleration(0.0, 0.08) == pytest.approx(0.28 * g)
    assert site.displacement(3.0, 0.08) == pytest.approx(site.acceleration(3.0, 0.08) * (3 / (2 * np.pi)) ** 2)
    # [3.2.4]: √(10 / (5 + 50)) = 0.4264 is below the least, 0.55.
    assert site.acceleration(TC, 0.5) == pytest.approx(0.55 * site.acceleration(TC))


def test_topography():
    flat = bs.assess.ntc_spectrum(**SITE)
    for topography, ST in (("T1", 1.0), ("T2", 1.2), ("T3", 1.2), ("T4", 1.4)):
        steep = bs.assess.ntc_spectrum(**SITE, topography=topography)
        np.testing.assert_allclose(steep.acceleration([0, 0.2, 3]), ST * flat.acceleration([0, 0.2, 3]))
    rock = bs.assess.ntc_spectrum(**SITE | {"soil": "A"})
    assert "S_S = 1.00" in [line.formula for line in rock.lines()]


@pytest.mark.parametrize(
    ("soil", "SS", "CC", "TE"),
    [
        ("A", (1.0, 1.0, 1.0), 1.0, 4.5),
        ("B", (1.2, 1.112, 1.0), 1.10 * 0.3**-0.20, 5.0),
        ("C", (1.5, 1.268, 1.0), 1.05 * 0.3**-0.33, 6.0),
        ("D", (1.8, 1.32, 0.9), 1.25 * 0.3**-0.50, 6.0),
        ("E", (1.6, 1.208, 1.0), 1.15 * 0.3**-0.40, 6.0),
    ],
)
def test_every_row_of_the_tables_of_soils(soil, SS, CC, TE):
    """NTC 2018 Tab. 3.2.IV: S_S at its upper limit for a weak motion, at its lower one for a strong, and in between.

    At F0 ag/g = 2.4 · 0.3 = 0.72: 1.40 − 0.40 · 0.72 = 1.112 on soil B. Tab. 3.2.VII: half-way between T_E and T_F =
    10 s the displacement is dg (F0 + 1) / 2, [3.2.11].
    """
    weak, medium, strong = (bs.assess.ntc_spectrum(Q_(ag, "g_0"), 2.4, "0.3 s", soil) for ag in (0.02, 0.3, 0.6))
    assert pytest.approx(SS) == (weak.SS, medium.SS, strong.SS)
    assert pytest.approx(CC) == weak.CC
    site = bs.assess.ntc_spectrum(**SITE | {"soil": soil})
    dg = 0.025 * 0.15 * g * site.S * site.TC * site.TD
    assert site.displacement((TE + 10) / 2) == pytest.approx(dg * (2.4 + 1) / 2)
    np.testing.assert_allclose(site.displacement([10.0, 30.0], 0.08), dg)
    assert site.displacement(TE) == pytest.approx(site.acceleration(TE) * (TE / (2 * np.pi)) ** 2)
    assert site.displacement(TE + 1e-9) == pytest.approx(site.displacement(TE), rel=0.05)


def test_a_table_of_the_same_ordinates_is_the_same_spectrum():
    site = bs.assess.ntc_spectrum(**SITE)
    periods = np.linspace(0, 4, 4001)
    table = bs.assess.table_spectrum(Q_(periods, "s"), Q_(site.acceleration(periods), "m/s^2"), ag=SITE["ag"])
    assert table.peak == pytest.approx(site.peak)
    np.testing.assert_allclose(table.acceleration([0.1, 1.0, 3.0]), site.acceleration([0.1, 1.0, 3.0]), rtol=1e-4)
    np.testing.assert_allclose(table.displacement([1.0, 2.0], 0.08), site.displacement([1.0, 2.0], 0.08), rtol=1e-4)
    assert table.at(2 * table.ag).peak == pytest.approx(2 * table.peak)


def test_the_displacement_of_a_table_is_largest_between_its_periods():
    """S = 0.469333 − 0.108333 T g from 0.4 to 4 s: S T² is largest at 2 · 0.469333 / (3 · 0.108333) = 2.89 s.

    C8.7.1.2.1.8: the largest displacement up to the period counts, since peaks of a table belong to pulses.
    """
    pulse = bs.assess.table_spectrum(Q_([0, 1, 1.2, 3], "s"), Q_([2, 8, 1, 1], "m/s^2"))
    assert pulse.displacement(1.3) == pytest.approx(8 * (1 / (2 * np.pi)) ** 2)
    table = bs.assess.table_spectrum("[0, 0.1, 0.4, 4] s", "[0.18, 0.43, 0.43, 0.04] g_0")
    dense = np.linspace(0.4, 4, 200001)
    by_hand = np.maximum.accumulate(table.acceleration(dense) * (dense / (2 * np.pi)) ** 2)
    for T in (0.41, 1.0, 2.8, 3.0, 4.0):
        assert table.displacement(T) == pytest.approx(np.interp(T, dense, by_hand), rel=1e-8)
    assert float(table.displacement(4.0)) == pytest.approx(0.332533, rel=1e-5)
    np.testing.assert_allclose(table.displacement([1.0, 4.0]), [table.displacement(1.0), table.displacement(4.0)])


def test_a_floor_spectrum_by_hand():
    """One mode T = 0.4 s, γ ψ = 1.17, ξ = 10 % over the site of 0.15 g on soil B.

    η(10 %) = √(10/15) = 0.816497; T_B < 0.4 s < T_C, so S_e(T_k) = 0.18 g · 2.4 · η = 3.459066 m/s².
    a_Z = 3.459066 · 1.17 · √1.04 = 4.127255 m/s². Peak at ξ = 5 %: 1.1 / √0.1 · a_Z = 14.3567 m/s².
    At T = 0.88 s = 2 b T_k: peak / (1 + (3.478505 − 1) · 1) = a_Z.
    """
    ground = bs.assess.ntc_spectrum(**SITE)
    mode = bs.assess.Mode("0.4 s", participation=1.3, shape=0.9, damping=0.1)
    floor = bs.assess.floor_spectrum(ground, [mode])
    a_Z = 0.18 * g * 2.4 * np.sqrt(10 / 15) * 1.17 * np.sqrt(1.04)
    assert floor.peak == pytest.approx(a_Z)
    np.testing.assert_allclose(floor.acceleration([0, 0.32, 0.4, 0.44]), a_Z * np.array([1, *[1.1 / np.sqrt(0.1)] * 3]))
    assert floor.acceleration(0.88) == pytest.approx(a_Z)
    # Half-way before and behind the peak, [C7.2.6].
    r = 1.1 / np.sqrt(0.1)
    assert floor.acceleration(0.16) == pytest.approx(r * a_Z / (1 + (r - 1) * 0.5**1.6))
    assert floor.acceleration(0.66) == pytest.approx(r * a_Z / (1 + (r - 1) * 0.5**1.2))
    # Beyond T_1 at least the ground, and beyond b T_1 at least the displacement there ([C7.2.5], [C8.7.1.12]).
    weak = bs.assess.floor_spectrum(ground, [bs.assess.Mode("0.4 s", participation=0.1, shape=0.9)])
    assert weak.acceleration(3.0) == pytest.approx(float(ground.acceleration(3.0)))
    assert weak.acceleration(0.3) < ground.acceleration(0.3)
    least = float(floor.acceleration(0.4)) * (0.44 / (2 * np.pi)) ** 2
    assert np.all(floor.displacement(np.linspace(0.45, 4, 20)) >= least)
    sharp = bs.assess.floor_spectrum(ground, [bs.assess.Mode("0.4 s", participation=1.3, shape=0.9, damping=0.02)])
    assert sharp.displacement(0.6) == pytest.approx(float(sharp.acceleration(0.4)) * (0.44 / (2 * np.pi)) ** 2)
    assert floor.at(2 * floor.ag).ag == pytest.approx(2 * floor.ag)


@pytest.mark.parametrize("soil", list("ABCDE"))
@pytest.mark.parametrize("target", [0.05, 0.4, 2.0])
def test_the_ground_acceleration_found_gives_back_the_capacity_and_is_the_least(soil, target):
    """S_S falls with ag: on soil D the demand falls between two ag, so that several give the same."""
    site = bs.assess.ntc_spectrum(Q_(0.1, "g_0"), 2.6, "0.4 s", soil)
    ag = _ground_acceleration(site, lambda s: s.peak, target)
    assert site.at(ag).peak == pytest.approx(target, rel=1e-10)
    below = np.linspace(0.02, 0.999, 200) * ag
    assert all(site.at(a).peak < target for a in below)


def site(**change):
    return bs.assess.ntc_spectrum(**SITE | change)


def table(periods, ordinates, **more):
    return bs.assess.table_spectrum(Q_(periods, "s"), Q_(ordinates, "m/s^2"), **more)


def mode(participation=1.3, shape=0.9, **more):
    return bs.assess.Mode("0.4 s", participation=participation, shape=shape, **more)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: site(ag=0.15), "ag: 0.15 has no unit"),
        (lambda: site(ag="0.15 m"), "does not fit"),
        (lambda: site(ag="200 m/s^2"), "up to 10 g"),
        (lambda: site(F0=1.0), "2.2 at least"),
        (lambda: site(F0=24), "5 at most"),
        (lambda: site(Tc="5 s"), "Tc 5 s"),
        (lambda: site(soil="F"), "known are A, B, C, D, E"),
        (lambda: site(ag="0.01 g_0", Tc="2 s"), r"T_C = C_C Tc\* = 1.915 s is beyond T_D = 1.64 s"),
        (lambda: site().acceleration(1.0, 8), "damping 8; give a ratio"),
        (lambda: table([0, 1], [1, 2, 3]), "as many"),
        (lambda: table([0.1, 1], [1, 2]), "rise from 0"),
        (lambda: table([0, 2, 1], [1, 2, 3]), "period 1 s after 2 s; give periods that rise from 0"),
        (lambda: table([0, 1], [1, 0]), "above zero"),
        (lambda: table([[0, 1]], [[1, 2]]), r"periods of shape \(1, 2\), ordinates of shape \(1, 2\)"),
        (lambda: table([0, 1], [1, 2], ag="-0.15 g_0"), "ag -1.47"),
        (lambda: table([0, 1], [1, 2], damping=5), "damping 5"),
        (lambda: bs.assess.floor_spectrum(site(), []), "0 modes, a ="),
        (lambda: bs.assess.floor_spectrum(site(), [mode()], a=1.2), "1 mode, a ="),
        (lambda: bs.assess.floor_spectrum(site(), [site()]), "floor_spectrum: modes"),
        (lambda: bs.assess.floor_spectrum(site(), [mode(0)]), "every mode is 0"),
        (lambda: bs.assess.floor_spectrum(mode(), [mode()]), "ground is a Mode"),
        (lambda: mode(damping=5), "a ratio such as"),
        (lambda: mode(13, 0.9), "not the share of the mass, nor in per cent"),
    ],
)
def test_a_wrong_spectrum_is_refused(made, words):
    with pytest.raises((bs.errors.ModelError, bs.errors.UnitError, bs.errors.DimensionError), match=words):
        made()


@pytest.mark.parametrize(
    "made", [site, lambda: table([0, 1], [1, 2]), lambda: bs.assess.floor_spectrum(site(), [mode()])]
)
def test_a_period_below_zero_is_refused(made):
    for ordinate in (made().acceleration, made().displacement):
        with pytest.raises(bs.errors.ModelError, match="period -1 s"):
            ordinate(-1.0)


def test_shapes_that_are_scaled_by_the_mass_have_a_large_participation():
    assert mode(316, 0.004).participation == 316
