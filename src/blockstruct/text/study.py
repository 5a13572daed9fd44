"""Sentences on studies of samples and of directions."""

from collections.abc import Sequence

import numpy as np

from blockstruct.vocabulary import counted

#: Runs without a finite or settled load factor, and their part in the fractiles.
COUNTED_AS = {
    "unstable": "unstable under their dead load, counted as −∞ in the fractiles",
    "unbounded": "unbounded, counted as ∞ in the fractiles",
    "unknown": "without a load factor: the intervals allow any value for them",
    "drifting": "NOT SETTLED, counted with their last load factor",
}
NOT_INDEPENDENT = "Runs of a Latin hypercube are not independent: the intervals are not exact."


def sample_line(case: str, runs: int, finite: int, mean: float, deviation: float) -> str:
    """Return the line on the runs of a case, with mean and standard deviation of the finite load factors."""
    some = f" of the {finite} with a finite load factor" if finite < runs else ""
    return f"{case}: {counted(runs, 'run')}, mean {_number(mean)}, standard deviation {_number(deviation, 2)}{some}"


def fractile_line(fractile: float, load_factor: float, bounds: tuple[float, float], confidence: float) -> str:
    """Return the line on a fractile, with its confidence interval."""
    low, high = map(_number, bounds)
    return f"{fractile:.0%} fractile {_number(load_factor)} ({confidence:.0%} confidence: {low} to {high})"


def governing_direction(angle: float, load_factor: float) -> str:
    """Return the clause on the direction of the lowest load factor, degrees."""
    return f"governing: {angle:g} deg, load factor {load_factor:.4g}"


def least_between_directions(load_factor: float) -> str:
    """Return the clause on a lower bound in every direction."""
    return f"no direction between them is below {load_factor:.4g}"


def uncovered_directions(gap: float = 0.0, start: float = 0.0, end: float = 0.0) -> str:
    """Return the clause on directions that no case covers; a wide gap is named with its ends, degrees."""
    widest = f": none was run for {gap:g} deg, from {start:g} to {end:g} deg" if gap else ""
    return f"are not covered, and one of them may be lower{widest}"


def between_directions(clause: str) -> str:
    """Return the clause on the directions between those that were run."""
    return f"directions between them {clause}"


def unknown_directions(cases: Sequence[str]) -> str:
    """Return the clause on directions without a load factor."""
    return f"no load factor for {', '.join(cases)}; the envelope may be lower there"


def _number(value: float, digits: int = 4) -> str:
    if np.isinf(value):
        return "∞" if value > 0 else "−∞"
    return "none" if np.isnan(value) else f"{value:.{digits}g}"
