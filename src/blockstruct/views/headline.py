"""The one load factor of a case that report and page show first."""

from dataclasses import dataclass

import numpy as np

import blockstruct as bs
from blockstruct.views.words import load_factor_words


@dataclass(frozen=True, slots=True)
class Headline:
    """A number, how far several schedules lie apart, and the associative bound, as texts."""

    number: str
    range: str
    bound: str
    status: bs.Status


def headline(analysis: bs.Analysis, name: str) -> Headline:
    """Headline of a case: of its spread the lowest certified load factor."""
    result, spread = analysis[name], analysis.spreads.get(name)
    stages, found = result.history["stage"].to_numpy(), result.history["load_factor"].to_numpy()
    associative = found[stages == bs.Stage.ASSOCIATIVE]
    bound = ""
    if result.case.flow is bs.Flow.NONASSOCIATIVE and len(associative) and np.isfinite(associative[-1]):
        bound = f"associative bound {associative[-1]:.4g}"
    if spread is None or spread.lowest is None or spread.highest is None:
        return Headline(load_factor_words(result), "", bound, result.status)
    certified = sum(r.status is bs.Status.CONVERGED for r in spread.runs.values())
    words = f"lowest of {certified} of {len(spread.runs)} schedules certified, up to {spread.highest.load_factor:.4g}"
    return Headline(load_factor_words(spread.lowest), words, bound, spread.lowest.status)
