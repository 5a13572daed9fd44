"""What is told of a capacity curve whose load factor rises or jumps."""

import numpy as np
import pytest
import xarray as xr

from blockstruct.results import doubtful_words


def curve(displacement, load_factor, **more):
    return xr.Dataset({"load_factor": ("step", load_factor), **more}, coords={"displacement": ("step", displacement)})


def told_of(capacity, procedure="fictitious"):
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
    assert told_of(curve(d, of(d))) == []


@pytest.mark.parametrize("d", [EVEN, UNEVEN])
@pytest.mark.parametrize("share", [0.05, -0.05])
def test_a_jump_is_told(d, share):
    load_factor = 0.3 * (1 - d) + 0.3 * share * (d > 0.4)
    told = told_of(curve(d, load_factor))
    assert len(told) == 1
    k = int((d > 0.4).argmax())
    assert f"jumps from {load_factor[k - 1]:.4g} to {load_factor[k]:.4g}" in told[0]
    assert f"at a displacement of {1e3 * d[k - 1]:.4g} mm" in told[0]


@pytest.mark.parametrize(("before", "behind", "slides"), [(0.0, 0.0, False), (0.3, 0.0, True), (0.0, 0.2, True)])
def test_a_jump_is_told_by_what_happens(before, behind, slides):
    """Where friction does no work, before nor behind, nothing slips and nothing catches."""
    load_factor = 0.3 * (1 - EVEN) - 0.05 * (EVEN > 0.4)
    rubs = {"dissipation": ("step", np.where(EVEN > 0.4, behind, before))}
    (told,) = told_of(curve(EVEN, load_factor, **rubs))
    assert ("slip and catch" in told) == slides
    assert ("hinge of an arch leaps" in told) != slides
    assert told.endswith("run it with other steps and compare")


@pytest.mark.parametrize(("left", "rock"), [(0.0, "rock"), (0.1, "rock and slide")])
@pytest.mark.parametrize(("d", "told"), [(EVEN, True), (np.linspace(0, 1, 401), False)])
def test_sliding_that_gives_way_to_rocking_on_a_long_step_is_told(d, told, left, rock):
    """The load factor has a kink there and no jump; how far blocks slid is known to a step."""
    rubs = {"dissipation": ("step", np.where(d < 0.5, 0.3, left))}
    words = told_of(curve(d, np.minimum(0.3, 0.6 * (1 - d)), **rubs))
    assert len(words) == told
    assert not told or words[0].startswith(f"blocks slide up to a displacement of 450 mm, and {rock} from 500 mm on")


def test_work_that_is_missed_is_told():
    missed = {"energy_error": ("step", np.where(np.isclose(EVEN, 0.5), 0.02, 1e-3))}
    (told,) = told_of(curve(EVEN, 0.3 * (1 - EVEN), **missed))
    assert told.startswith("2.0% of all work is missed in the step from a displacement of 450 mm")


@pytest.mark.parametrize("share", [0.05, -0.05])
def test_a_jump_with_a_state_on_its_way_is_told(share):
    """Whether there is one is as rounding would have it."""
    load_factor = 0.3 * (1 - EVEN) + 0.3 * share * ((EVEN > 0.38) + 1.0 * (EVEN > 0.42)) / 2
    (told,) = told_of(curve(EVEN, load_factor))
    assert f"jumps from {load_factor[7]:.4g} to {load_factor[9]:.4g} at a displacement of 350 mm" in told


@pytest.mark.parametrize("share", [0.05, -0.05])
def test_a_jump_of_the_first_step_is_told(share):
    load_factor = 0.3 * (1 - EVEN) + 0.3 * share * (EVEN > 0)
    assert "at a displacement of 0 mm" in told_of(curve(EVEN, load_factor))[-1]


def test_a_rise_is_told():
    load_factor = 0.3 + 0.1 * np.sin(np.pi * EVEN) - 0.3 * EVEN**2
    told = told_of(curve(EVEN, load_factor))
    assert len(told) == 1
    assert f"rises from 0.3 to {load_factor.max():.4g} at a displacement of" in told[0]
    assert "procedure='loading path'" in told[0]
    assert told_of(curve(EVEN, load_factor), "loading path") == [told[0].split(", or friction")[0]]


def test_jumps_of_ties_that_break_are_told_elsewhere():
    load_factor = 0.3 * (1 - EVEN) + 0.1 * (EVEN < 0.42)
    broke = {"tie_break_displacement": ("tie", [np.nan, 0.42])}
    assert told_of(curve(EVEN, load_factor))
    assert told_of(curve(EVEN, load_factor, **broke)) == []


@pytest.mark.parametrize("between", [0.44, 0.47, 0.52])
def test_what_stands_between_two_breaks_is_no_jump(between):
    """Neither is what two ties do at once part of what the curve goes on to."""
    load_factor = 0.3 * (1 - EVEN) + 0.1 * (EVEN < 0.42) + 0.1 * (between > EVEN)
    broke = {"tie_break_displacement": ("tie", [between, 0.42])}
    assert told_of(curve(EVEN, load_factor, **broke)) == []


def test_a_tie_that_is_pulled_tight_is_no_jump():
    load_factor = 0.3 * (1 - EVEN) + 0.006 * (EVEN > 0.5) + 0.02 * (EVEN > 0.7)
    force = {"tie_force": (("step", "tie"), 1e3 * (EVEN > 0.7)[:, None])}
    assert "jumps from" in told_of(curve(EVEN, load_factor))[0]
    assert told_of(curve(EVEN, load_factor, **force)) == []


def test_two_states_tell_nothing():
    assert told_of(curve(EVEN[:2], np.array([0.3, 0.1]))) == []
