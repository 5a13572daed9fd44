"""Parts of a capacity curve that may depend on its steps."""

import numpy as np
import pytest
import xarray as xr

from blockstruct.results import doubtful_parts

EVEN = np.linspace(0, 1, 21)
#: Of short and of long steps.
UNEVEN = np.concatenate([[0, 0.001, 0.003, 0.01], np.linspace(0.05, 0.5, 6), [0.5001, 0.503], np.linspace(0.6, 1, 5)])


def parts(d, load_factor, procedure="fictitious", dissipation=0.0, energy_error=0.0, **ties):
    """Doubtful parts of a curve over d, without friction and without error of its energy by default."""
    values = {"load_factor": load_factor, "dissipation": dissipation, "energy_error": energy_error}
    curve = {name: ("step", np.broadcast_to(v, d.shape)) for name, v in values.items()}
    return doubtful_parts(xr.Dataset({**curve, **ties}, coords={"displacement": ("step", d)}), procedure)


@pytest.mark.parametrize("d", [EVEN, UNEVEN])
@pytest.mark.parametrize(
    "of",
    [
        lambda d: 0.3 * (1 - d),
        lambda d: np.tan(np.arctan(0.3) * (1 - d)),
        lambda d: np.minimum(0.3, 0.6 * (1 - d)),
        lambda d: 0.3 - np.maximum(0.0, 0.5 * (d - 0.31)),
        lambda d: np.full_like(d, 0.3),
        lambda d: 0.3 * (1 - d) ** 2,
        lambda d: 0.3 * np.sqrt(1.2 - d),
    ],
    ids=["straight", "tangent", "kink", "another kink", "constant", "bends", "bends back"],
)
def test_neither_curves_nor_kinks_are_jumps(d, of):
    assert parts(d, of(d)) == parts(d[:2], of(d)[:2]) == []


@pytest.mark.parametrize("d", [EVEN, UNEVEN])
@pytest.mark.parametrize("share", [0.05, -0.05])
def test_a_jump_has_its_load_factors_and_its_displacement(d, share):
    load_factor = 0.3 * (1 - d) + 0.3 * share * (d > 0.4)
    (jump,) = parts(d, load_factor)
    k = int((d > 0.4).argmax())
    assert (jump.doubt, jump.displacement, jump.load_factor) == (
        "leaps",
        (*d[k - 1 : k + 1],),
        (*load_factor[k - 1 : k + 1],),
    )
    assert parts(d, 0.3 * (1 - d) + 0.3 * share * (d > 0))[-1].displacement == (0, d[1])
    # Rounding may put a state on its way.
    between = 0.3 * (1 - EVEN) + 0.3 * share * ((EVEN > 0.38) + 1.0 * (EVEN > 0.42)) / 2
    (jump,) = parts(EVEN, between)
    assert jump.load_factor == (between[7], between[9])


@pytest.mark.parametrize(("before", "after", "doubt"), [(0.0, 0.0, "leaps"), (0.3, 0.0, "slips"), (0.0, 0.2, "slips")])
def test_a_jump_slips_only_with_friction(before, after, doubt):
    load_factor = 0.3 * (1 - EVEN) - 0.05 * (EVEN > 0.4)
    (jump,) = parts(EVEN, load_factor, dissipation=np.where(EVEN > 0.4, after, before))
    assert jump.doubt == doubt


@pytest.mark.parametrize(("left", "doubt"), [(0.0, "rocks"), (0.1, "rocks_and_slides")])
def test_sliding_that_gives_way_to_rocking_on_a_long_step(left, doubt):
    """The load factor has a kink there and no jump; how far blocks slid is known to a step."""

    def of(d):
        return parts(d, np.minimum(0.3, 0.6 * (1 - d)), dissipation=np.where(d < 0.5, 0.3, left))

    (change,) = of(EVEN)
    assert (change.doubt, change.displacement) == (doubt, pytest.approx((0.45, 0.5)))
    assert of(np.linspace(0, 1, 401)) == []


def test_missed_work():
    (part,) = parts(EVEN, 0.3 * (1 - EVEN), energy_error=np.where(np.isclose(EVEN, 0.5), 0.02, 1e-3))
    assert (part.doubt, part.displacement, part.missed) == ("misses_work", pytest.approx((0.45, 0.5)), 0.02)


def test_a_rise():
    load_factor = 0.3 + 0.1 * np.sin(np.pi * EVEN) - 0.3 * EVEN**2
    (rise,) = parts(EVEN, load_factor)
    assert (rise.doubt, rise.load_factor) == ("rises", (load_factor[0], load_factor.max()))


@pytest.mark.parametrize("second", [np.nan, 0.44, 0.47, 0.52])
def test_jumps_of_ties_that_break_are_not_jumps(second):
    load_factor = 0.3 * (1 - EVEN) + 0.1 * (EVEN < 0.42) + 0.1 * (second > EVEN)
    assert parts(EVEN, load_factor)
    assert parts(EVEN, load_factor, tie_break_displacement=("tie", [second, 0.42])) == []


def test_a_tie_that_is_pulled_tight_is_no_jump():
    load_factor = 0.3 * (1 - EVEN) + 0.006 * (EVEN > 0.5) + 0.02 * (EVEN > 0.7)
    assert parts(EVEN, load_factor)[0].doubt == "leaps"
    assert parts(EVEN, load_factor, tie_force=(("step", "tie"), 1e3 * (EVEN > 0.7)[:, None])) == []
