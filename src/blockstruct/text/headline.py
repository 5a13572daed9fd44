"""The number of a case: how the case ended, its range and its bound, and the sentence on them."""

from dataclasses import dataclass, field

import numpy as np

from blockstruct.limit import Outcome
from blockstruct.text.numbers import LOAD_FACTOR, Answer
from blockstruct.vocabulary import FEW, Flow, PathEnd, Procedure, Reason, Status, counted, listed

_FOUND_BY = {
    Procedure.LOADING_PATH: "along its loading path",
    Procedure.FICTITIOUS: "by fictitious sliding conditions",
    Procedure.SHIFTED: "by the shifted objective",
    Procedure.ASSOCIATIVE: "with associative flow",
}
_PATH_ENDS = {
    PathEnd.NO_DEAD_LOAD_STATE: "it found no state under dead load to begin with",
    PathEnd.STEP_NOT_SOLVED: "one of its steps was not solved",
    PathEnd.LIMIT_REACHED: "it reached its largest displacement or number of iterations",
    PathEnd.NOT_CERTIFIED: "no state at its end met the tolerances of the certificate",
}
_REASONS = {
    Reason.CERTIFIED: "the certificate holds",
    Reason.DEAD_LOAD_NOT_CARRIED: "the joints carry at most {carried:.3g} of the dead load",
    Reason.DEAD_LOAD_COLLAPSES: (
        "friction between supports holds {hung} under the dead load in some states of self-stress and not in others"
    ),
    Reason.DEAD_LOAD_UNDECIDED: "the solver found neither forces that carry the dead load nor a mechanism",
    Reason.NEVER_COLLAPSES: "the joints carry any multiple of {load}",
    Reason.CARRIES_ANY_LOAD: (
        "the joints can carry any multiple of {load}, which without dilatancy does not exclude collapse"
    ),
    Reason.GROWS_WITHOUT_LIMIT: "the {number} grows without limit, and the joints can carry any multiple of {load}",
    Reason.NEVER_SETTLES: "from {low} to {high} over the last tenfold displacement, and not settled",
    Reason.JAMS: "still {rising} at {last}, the blocks jam",
    Reason.PROGRAM_NOT_SOLVED: "the solver did not solve the first program",
    Reason.NO_CERTIFICATE: "no certificate in {programs}",
    Reason.NEGATIVE_LOAD_FACTOR: "the only state that was found has a negative load factor",
    Reason.AT_REST: "at rest after the record",
    Reason.BLOCKS_FALLEN: "a block has fallen or turned over",
    Reason.STILL_MOVING: "blocks still move at the end",
    Reason.STEP_NOT_SOLVED: "a step was not solved, and the response ends there",
    Reason.INTERRUPTED: "the user stopped the run",
    Reason.KILLED: "the run was killed",
    Reason.NOT_BEGUN: "no program was solved",
}
_WITHOUT_NUMBER = {
    Status.UNSTABLE: "does not stand under its dead load",
    Status.UNBOUNDED: "never collapses",
    Status.INTERRUPTED: "interrupted",
    Status.STANDS: "stands",
    Status.COLLAPSES: "collapses at {time:.4g} s",
    Status.UNDECIDED: "undecided",
}


@dataclass(frozen=True, slots=True)
class Headline:
    """Load factor of a case, with its range and the associative bound.

    Attributes
    ----------
    outcome : Outcome
        How the case ended.
    flow : Flow
    associative : float
        Load factor with associative flow, an upper bound of every other flow rule; infinite if unbounded, NaN if
        unknown.
    path_range : tuple of float or None
        Lowest and highest load factor of the variants of the loading path; None if they were not run.
    answer : Answer
        Name and unit of the number. The reaction of a settlement is minus its load factor times a force, so the lowest
        load factor is the largest reaction.
    hung : tuple of str
        Blocks whose dead load depends on self-stress.
    """

    outcome: Outcome
    flow: Flow
    associative: float = np.nan
    path_range: tuple[float, float] | None = None
    answer: Answer = field(default=LOAD_FACTOR, repr=False)
    hung: tuple[str, ...] = ()

    @property
    def status(self) -> Status:
        """How the case ended."""
        return self.outcome.status

    @property
    def settled(self) -> bool:
        """Whether the load factor had settled when the procedure ended."""
        return self.outcome.settled

    @property
    def load_factor(self) -> float:
        """Load factor; infinite if unbounded, NaN with any other status."""
        return self.outcome.load_factor

    @property
    def lowest(self) -> float:
        """Load factor, or the lowest of the loading paths if that is lower."""
        return self.load_factor if self.path_range is None else min(self.load_factor, self.path_range[0])

    @property
    def highest(self) -> float:
        """Load factor, or the highest of the loading paths if that is higher."""
        return self.load_factor if self.path_range is None else max(self.load_factor, self.path_range[1])

    @property
    def number(self) -> str:
        """Load factor or reaction to four digits, ``infinite`` or ``none``."""
        return self.answer.text(self.load_factor, 4)

    @property
    def ended(self) -> str:
        """Status in two or three words, such as ``"NOT SETTLED"``."""
        drifts = self.status is Status.CONVERGED and self.flow is Flow.NONASSOCIATIVE and not self.settled
        return "NOT SETTLED" if drifts else self.status.words

    @property
    def why(self) -> str:
        """Why the case ended with its status, without a full stop.

        If a loading path was followed and not closed, the text states why.
        """
        outcome, answer = self.outcome, self.answer
        low, high = answer.ends(outcome.drift or (np.nan, np.nan))
        text = _REASONS[outcome.reason].format(
            carried=outcome.carried,
            hung=listed(self.hung, FEW) or "the structure",
            load="this motion of the supports" if answer.is_reaction else "the variable load",
            number=answer.name,
            rising="falling" if answer.is_reaction else "rising",
            last=low if answer.is_reaction else high,
            low=low,
            high=high,
            programs=counted(outcome.programs, "program"),
        )
        if outcome.path_end not in (None, PathEnd.CLOSED):
            text += f"; the loading path did not finish: {_PATH_ENDS[outcome.path_end]}"
        if np.isfinite(outcome.load_ratio):
            text += (
                f"; the loads of two blocks that touch differ by a factor of {outcome.load_ratio:.1e}, too much for "
                "the solver: give plates and wedges between heavy blocks no weight, or more"
            )
        return text

    @property
    def range(self) -> str:
        """Text of the range; empty without variants of the loading path."""
        if self.path_range is None:
            return ""
        low, high = self.answer.ends(self.path_range)
        if low == high:
            return "unchanged with other steps and joint stiffness"
        return f"{low} to {high} by step length and joint stiffness"

    @property
    def bound(self) -> str:
        """Text of the bound of a non-associative case; empty if unknown."""
        return "" if self.flow is Flow.ASSOCIATIVE else self._bound(4)

    def _bound(self, digits: int) -> str:
        if np.isnan(self.associative):
            return ""
        bounded = np.isfinite(self.associative)
        return f"associative bound {self.answer.text(self.associative, digits)}" if bounded else "no associative bound"

    def text(self, digits: int = 4) -> str:
        """Return how the case ended, its number, how it was found and between which limits it lies.

        Parameters
        ----------
        digits
            Significant digits of the number, its bound and its peak.

        Examples
        --------
        >>> from blockstruct.limit import Outcome
        >>> from blockstruct.vocabulary import Flow, Procedure, Reason, Status
        >>> found = Outcome(Status.CONVERGED, 0.5509, Reason.CERTIFIED, Procedure.LOADING_PATH, settled=True)
        >>> print(Headline(found, Flow.NONASSOCIATIVE, associative=0.7498))
        collapses at load factor 0.5509 along its loading path (certified; associative bound 0.7498)
        """
        outcome, answer = self.outcome, self.answer
        if outcome.status is not Status.CONVERGED:
            text = _WITHOUT_NUMBER.get(outcome.status, f"no {answer.name}").format(time=outcome.collapse_time)
            return f"{text}: {self.why}"
        bounds = [self.range] if self.range else []
        last = "" if outcome.drift is None else "{} to {}".format(*answer.ends(outcome.drift))
        if np.isfinite(outcome.without_crushing):
            bounds.append(f"without crushing; with crushing {last}")
        elif last and not outcome.settled:
            bounds.append(f"its last values are {last}")
        bounds.append("certified")
        if outcome.procedure is Procedure.ASSOCIATIVE:
            bounds.append("a bound of every other flow rule")
        elif bound := self._bound(digits):
            bounds.append(bound)
        verb = "follows its supports at a reaction of" if answer.is_reaction else f"collapses at {answer.name}"
        found_by = "" if outcome.procedure is None else _FOUND_BY[outcome.procedure]
        text = f"{verb} {answer.text(outcome.load_factor, digits)} {found_by} ({'; '.join(bounds)})"
        if np.isfinite(outcome.peak):
            peak = answer.text(outcome.peak, digits)
            text += (
                f" after a least reaction of {peak} on the way"
                if answer.is_reaction
                else f" after a peak of {peak}: a load that is not reduced brings it down at the peak"
            )
        if not outcome.settled:
            text = f"NOT SETTLED, {text}"
        if outcome.stands_in:
            text += f". The loading path did not finish: {_PATH_ENDS[outcome.path_end or PathEnd.NOT_CERTIFIED]}"
        return text

    def __str__(self) -> str:
        return self.text()
