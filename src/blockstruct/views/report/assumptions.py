"""Assumptions that a report states."""

from collections.abc import Sequence

import blockstruct as bs
from blockstruct.text import Scope, assumption_sentences, masses_below
from blockstruct.views.words import cells_of

#: Sentences on masses that the first page of a report has room for.
_FEW = 2


def pushed_masses(model: bs.Model, results: Sequence[bs.CaseResult]) -> list[str]:
    """Return the sentences on the masses of every push, each once."""
    return list(dict.fromkeys(filter(None, (bs.results.pushed_masses(model, r.case) for r in results))))


def below_loads(masses: Sequence[str]) -> Sequence[str]:
    """Return the sentences on masses that the assumptions leave to the loads."""
    return masses if len(masses) > _FEW else ()


def assumptions(
    model: bs.Model, results: Sequence[bs.CaseResult], checks: Sequence[bs.assess.LocalMechanismCheck] = ()
) -> list[str]:
    """Return the assumptions of the model, the cases and their checks, as sentences."""
    limit = [r for r in results if isinstance(r.case, bs.LimitCase)]
    flows = {r.case.flow for r in limit}
    scope = Scope(
        settles=any(isinstance(r.case, bs.SettlementCase) for r in results),
        moves=any(isinstance(r.case, bs.RecordCase) for r in results),
        pushes=bool(limit),
        is_associative=bs.Flow.ASSOCIATIVE in flows,
        is_nonassociative=bs.Flow.NONASSOCIATIVE in flows,
        has_curve=any(r.capacity is not None for r in results),
        rotates=any(check.curve is not None and check.result.capacity is None for check in checks),
        is_checked=bool(checks),
        corners={r.name: r.case.corner_rounding for r in results if isinstance(r.case, bs.Pushover)},
    )
    masses = pushed_masses(model, results)
    if len(masses) > _FEW:
        masses = [masses_below(len(masses))]
    return assumption_sentences(model, scope, cells_of(results), masses, bs.assess.lines.HIGHER)
