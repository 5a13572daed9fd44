"""Random structures of all kinds by every procedure: nothing fails, nothing passes what bounds it.

The structures are those of ``tests/support/random_structures.py``; ``make validation`` prints the same figures.
"""

import math

import pytest

import campaign
from random_structures import names, structure

#: Structures of which a run does not converge, or differs from the independent path, as the page on validation shows.
MISSES = {
    "crushing 10": "the mirrored structure ends 1.8 % off: its path depends on rounding",
    "crushing 14": "the rotated structure ends 2.8 % off: its path depends on rounding",
    "dome 5": "the path is not solved; the associative load factor is 117",
    "dome 8": "the path in half steps is not solved; the associative load factor is 342",
    "front 16": "the path ends at 0.389, in half steps at 0.404, the independent one at 0.407",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_structure(name, request):
    if name in MISSES:
        request.applymarker(pytest.mark.xfail(raises=AssertionError, strict=True, reason=MISSES[name]))
    found = campaign.findings(structure(name))
    bound = found.associative.load_factor

    for run in (found.path, found.fictitious, *found.variants.values()):
        assert run.status in ("converged", "unstable_under_dead_load", "unbounded")
        if run.status == "converged":
            assert run.certified
            assert run.load_factor <= bound * (1 + 1e-6)
    if found.kind == "falls":
        assert found.path.status == "unstable_under_dead_load"
    if found.exact is not None:
        for run in (found.associative, found.path, found.fictitious):
            assert run.load_factor == pytest.approx(found.exact, rel=1e-4)
    if not math.isnan(found.without_crushing):
        assert found.path.load_factor <= found.without_crushing * 1.005
    if found.path.settled:
        for variant in campaign.SAME:
            assert found.differs(variant) < 0.01, variant
        if found.exact is None and not math.isnan(found.reference):
            assert abs(found.error(found.path)) < campaign.NEAR
