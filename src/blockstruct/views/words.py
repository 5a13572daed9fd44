"""Statuses and certificates in words, as a report says them."""

import blockstruct as bs

_STATUS = {
    bs.Status.CONVERGED: "The structure collapses at this load factor: the state is certified within the tolerances.",
    bs.Status.UNSTABLE: "The structure does not stand under its dead load alone; there is no load factor.",
    bs.Status.SELF_STRESS: (
        "Whether the structure stands under its dead load depends on self-stress, which the model does not determine: "
        "without dilatancy the dead load by itself has a collapse state. There is no load factor to rely on."
    ),
    bs.Status.UNBOUNDED: "The variable load never causes collapse, however large.",
    bs.Status.NOT_CONVERGED: "No state could be certified; the numbers of the last iteration are not a result.",
    bs.Status.INTERRUPTED: "The run was interrupted; the numbers of the last iteration are not a result.",
}


_DRIFTING = (
    "It was still drifting from one such state to the next when the procedure was stopped: another schedule would have "
    "stopped at another load factor."
)

#: Statuses whose history may still hold an admissible state.
_WITHOUT_STATE = (bs.Status.NOT_CONVERGED, bs.Status.INTERRUPTED)


def status_words(result: bs.CaseResult) -> str:
    """Sentences on how a case ended.

    >>> from types import SimpleNamespace
    >>> status_words(SimpleNamespace(status=bs.Status.UNBOUNDED, drifts=False))
    'The variable load never causes collapse, however large.'
    """
    said = _STATUS[result.status]
    return f"{said} {_DRIFTING}" if result.drifts else said


def load_factor_words(result: bs.CaseResult) -> str:
    """The load factor as far as it is one: a number, ``infinite`` or ``none``."""
    return result.headline.number


def headline_words(headline: bs.results.Headline) -> str:
    """The number of a case in a sentence, with its range and the associative bound.

    >>> headline_words(bs.results.Headline(bs.Status.CONVERGED, 0.2637, 0.3069, 4, 5, 0.332, bs.Flow.NONASSOCIATIVE))
    'Load factor 0.2637 (lowest of 4 of 5 schedules certified, up to 0.3069; associative bound 0.332).'
    """
    return f"Load factor {headline}."


def warning_words(found: bs.CaseResult | bs.Spread) -> str:
    """What must stand beside the load factor, as one paragraph; empty as a rule."""
    return " ".join(found.warnings)


def spread_words(spread: bs.Spread) -> str:
    """A sentence on how far the certified answers of several schedules lie apart."""
    h = spread.headline
    said = f"{h.certified} of {h.schedules} schedules found a certified collapse state"
    if h.certified:
        ends = sorted((*h.drifting, h.lowest, h.highest))
        said += f", at load factors from {ends[0]:.4g} to {ends[-1]:.4g}"
    if h.drifting:
        said += f"; {len(h.drifting)} of them still drifting when stopped"
    return " ".join(filter(None, (f"{'; '.join(filter(None, (said, h.bound)))}.", path_words(spread))))


def path_words(found: bs.CaseResult | bs.Spread) -> str:
    """A sentence on what the number along the loading path depends on; empty where it was not asked."""
    ends = found.path_dependence
    if ends is None:
        return ""
    return (
        f"Along the loading path, from the dead load on, it is {ends[0]:.4g} to {ends[1]:.4g}, by the steps and the "
        "shear stiffness of the joints."
    )


def admissible_words(result: bs.CaseResult) -> str:
    """What a case without a load factor leaves behind: its best admissible state, named as a bound; or nothing."""
    state = result.admissible_state if result.status in _WITHOUT_STATE else None
    if state is None:
        return ""
    meaning = (
        "a lower bound of the collapse load factor"
        if result.case.flow is bs.Flow.ASSOCIATIVE
        else "no collapse load factor, and without dilatancy no lower bound of it either"
    )
    return (
        f"Forces in equilibrium that no joint refuses were found at load factor {state.load_factor:.4g} (iteration "
        f"{state.iteration}); they miss the flow rule by {state.certificate.flow_rule_gap:.1e} of load factor. "
        f"It is {meaning}."
    )


def certificate_words(result: bs.CaseResult) -> str:
    """A sentence on why to believe a result, with the measures of its certificate."""
    found, settings = result.certificate, result.settings
    if found is None:
        return "There is no certificate."
    if result.status is bs.Status.UNSTABLE:
        verdict = "is proven" if found.holds else "is not proven"
        return f"A mechanism {verdict} in which the dead load alone does work."
    if result.status is bs.Status.SELF_STRESS:
        verdict = "is certified" if found.holds else "is not certified"
        return f"A collapse state of the dead load alone {verdict} within the tolerances."
    verdict = "holds" if found.holds else "does not hold"
    return (
        f"The certificate {verdict}: equilibrium is met to {found.equilibrium_residual:.1e} "
        f"(tolerance {settings.equilibrium_tolerance:.0e}) of the dead load of a block, "
        f"no joint is loaded beyond its strength by more than {max(found.yield_excess, 0):.1e} "
        f"({settings.yield_tolerance:.0e}), blocks penetrate by at most {found.interpenetration:.1e} "
        f"({settings.interpenetration_tolerance:.0e}) of the largest motion, and the flow rule is missed by "
        f"{found.flow_rule_gap:.1e} ({found.flow_rule_gap_limit:.0e}) of load factor."
    )
