"""Cautions on a capacity curve whose load factor rises or jumps."""

import numpy as np
import pytest
import xarray as xr

from blockstruct.results import doubtful_words


def curve(displacement, load_factor, **more):
    return xr.Dataset({"load_factor": ("step", load_factor), **more}, coords={"displacement": ("step", displacement)})


def doubts(capacity, procedure="fictitious"):
    return doubtful_words(capacity, procedure)


EVEN = np.linspace(0, 1, 21)
#: Of short and of long steps.
UNEVEN = np.concatenate([[0, 0.001, 0.003, 0.01], np.linspace(0.05, 0.5, 6), [0.5001, 0.503], np.linspace(0.6, 1, 5)])


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
    assert doubts(curve(d, of(d))) == []
    assert doubts(curve(d[:2], of(d)[:2])) == []


@pytest.mark.parametrize("d", [EVEN, UNEVEN])
@pytest.mark.parametrize("share", [0.05, -0.05])
def test_a_jump_has_its_load_factors_and_its_displacement(d, share):
    load_factor = 0.3 * (1 - d) + 0.3 * share * (d > 0.4)
    (words,) = doubts(curve(d, load_factor))
    k = int((d > 0.4).argmax())
    assert f"from {load_factor[k - 1]:.4g} to {load_factor[k]:.4g} at a displacement of {1e3 * d[k - 1]:.4g}" in words
    first = 0.3 * (1 - d) + 0.3 * share * (d > 0)
    assert "at a displacement of 0 mm" in doubts(curve(d, first))[-1]
    # Rounding may put a state on its way.
    between = 0.3 * (1 - EVEN) + 0.3 * share * ((EVEN > 0.38) + 1.0 * (EVEN > 0.42)) / 2
    (words,) = doubts(curve(EVEN, between))
    assert f"from {between[7]:.4g} to {between[9]:.4g} at a displacement of 350 mm" in words


@pytest.mark.parametrize(("before", "behind", "slides"), [(0.0, 0.0, False), (0.3, 0.0, True), (0.0, 0.2, True)])
def test_a_jump_slips_only_with_friction(before, behind, slides):
    load_factor = 0.3 * (1 - EVEN) - 0.05 * (EVEN > 0.4)
    (words,) = doubts(curve(EVEN, load_factor, dissipation=("step", np.where(EVEN > 0.4, behind, before))))
    assert ("slip and catch" in words) == slides


@pytest.mark.parametrize(("left", "rock"), [(0.0, "rock"), (0.1, "rock and slide")])
@pytest.mark.parametrize(("d", "count"), [(EVEN, 1), (np.linspace(0, 1, 401), 0)])
def test_sliding_that_gives_way_to_rocking_on_a_long_step(d, count, left, rock):
    """The load factor has a kink there and no jump; how far blocks slid is known to a step."""
    friction = ("step", np.where(d < 0.5, 0.3, left))
    words = doubts(curve(d, np.minimum(0.3, 0.6 * (1 - d)), dissipation=friction))
    assert len(words) == count
    assert not count or f"450 mm, and {rock} from 500 mm" in words[0]


def test_missed_work():
    missed = ("step", np.where(np.isclose(EVEN, 0.5), 0.02, 1e-3))
    (words,) = doubts(curve(EVEN, 0.3 * (1 - EVEN), energy_error=missed))
    assert words.startswith("2.0% of all work is missed in the step from a displacement of 450 mm")


def test_a_rise():
    load_factor = 0.3 + 0.1 * np.sin(np.pi * EVEN) - 0.3 * EVEN**2
    (words,) = doubts(curve(EVEN, load_factor))
    assert f"rises from 0.3 to {load_factor.max():.4g} at a displacement of" in words
    assert doubts(curve(EVEN, load_factor), "loading path") == [words.split(", or friction")[0]]


@pytest.mark.parametrize("second", [np.nan, 0.44, 0.47, 0.52])
def test_jumps_of_ties_that_break_are_not_jumps(second):
    load_factor = 0.3 * (1 - EVEN) + 0.1 * (EVEN < 0.42) + 0.1 * (second > EVEN)
    assert doubts(curve(EVEN, load_factor))
    assert doubts(curve(EVEN, load_factor, tie_break_displacement=("tie", [second, 0.42]))) == []


def test_a_tie_that_is_pulled_tight_is_no_jump():
    load_factor = 0.3 * (1 - EVEN) + 0.006 * (EVEN > 0.5) + 0.02 * (EVEN > 0.7)
    assert "jumps from" in doubts(curve(EVEN, load_factor))[0]
    force = (("step", "tie"), 1e3 * (EVEN > 0.7)[:, None])
    assert doubts(curve(EVEN, load_factor, tie_force=force)) == []
