"""Sentences on studies of samples."""

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


def _number(value: float, digits: int = 4) -> str:
    if np.isinf(value):
        return "∞" if value > 0 else "−∞"
    return "none" if np.isnan(value) else f"{value:.{digits}g}"
