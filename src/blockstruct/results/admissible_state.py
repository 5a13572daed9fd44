"""What a case without a collapse state leaves behind."""

from dataclasses import dataclass

from blockstruct.limit import Certificate


@dataclass(frozen=True, slots=True)
class AdmissibleState:
    """Forces in equilibrium that no joint refuses, at some load factor: a bound, and no collapse load by itself.

    With associative flow the structure collapses at no lower load factor (static theorem). Without dilatancy the
    theorem does not hold: joints may slide at a lower one, so that this is not a safe bound.

    Attributes
    ----------
    iteration : int
        Where in the history.
    load_factor : float
    certificate : Certificate
        Equilibrium residual and yield excess are within the tolerances; by how much the flow rule is missed is what
        separates the state from a collapse state.
    """

    iteration: int
    load_factor: float
    certificate: Certificate
