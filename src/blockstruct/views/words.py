"""Statuses and certificates in words, as a report says them."""

import blockstruct as bs

_STATUS = {
    bs.Status.CONVERGED: "The structure collapses at this load factor: the state is certified within the tolerances.",
    bs.Status.UNSTABLE: "The structure does not stand under its dead load alone; there is no load factor.",
    bs.Status.UNBOUNDED: "The variable load never causes collapse, however large.",
    bs.Status.NOT_CONVERGED: "No state could be certified; the numbers of the last iteration are no result.",
    bs.Status.INTERRUPTED: "The run was interrupted; the numbers of the last iteration are no result.",
}


def status_words(result: bs.CaseResult) -> str:
    """A sentence on how a case ended.

    >>> from types import SimpleNamespace
    >>> status_words(SimpleNamespace(status=bs.Status.UNBOUNDED))
    'The variable load never causes collapse, however large.'
    """
    return _STATUS[result.status]


def load_factor_words(result: bs.CaseResult) -> str:
    """The load factor as far as it is one: a number, ``infinite`` or ``none``."""
    if result.status is bs.Status.CONVERGED:
        return f"{result.load_factor:.4g}"
    return "infinite" if result.status is bs.Status.UNBOUNDED else "none"


def spread_words(spread: bs.Spread) -> str:
    """A sentence on how far the certified answers of several schedules lie apart."""
    certified = sum(r.status is bs.Status.CONVERGED for r in spread.runs.values())
    said = f"{certified} of {len(spread.runs)} schedules found a certified collapse state"
    if spread.lowest and spread.highest:
        said += f", at load factors from {spread.lowest.load_factor:.4g} to {spread.highest.load_factor:.4g}"
    bound = spread.upper_bound
    if bound and bound.status is bs.Status.CONVERGED:
        said += f"; with associative flow {bound.load_factor:.4g}"
    return f"{said}."


def certificate_words(result: bs.CaseResult) -> str:
    """A sentence on why to believe a result, with the measures of its certificate."""
    found, settings = result.certificate, result.settings
    if found is None:
        return "There is no certificate."
    if result.status is bs.Status.UNSTABLE:
        verdict = "is proven" if found.holds else "is not proven"
        return f"A mechanism {verdict} in which the dead load alone does work."
    verdict = "holds" if found.holds else "does not hold"
    return (
        f"The certificate {verdict}: equilibrium is met to {found.equilibrium_residual:.1e} "
        f"(tolerance {settings.equilibrium_tolerance:.0e}) of the dead load of a block, "
        f"no joint is loaded beyond its strength by more than {max(found.yield_excess, 0):.1e} "
        f"({settings.yield_tolerance:.0e}), blocks penetrate by at most {found.interpenetration:.1e} "
        f"({settings.interpenetration_tolerance:.0e}) of the largest motion, and the flow rule is missed by "
        f"{found.flow_rule_gap:.1e} ({found.flow_rule_gap_limit:.0e}) of load factor."
    )
