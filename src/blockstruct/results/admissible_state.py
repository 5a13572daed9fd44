"""The best admissible state of a case without a collapse state."""

from dataclasses import dataclass

from blockstruct.limit import Certificate


@dataclass(frozen=True, slots=True)
class AdmissibleState:
    """Forces in equilibrium within the strength of joints, at a load factor.

    With associative flow the load factor is a lower bound of the collapse load (static theorem). Without dilatancy the
    theorem does not hold: joints may slide at a lower load factor, so it is not a safe bound.

    Attributes
    ----------
    iteration : int
        Position in the history.
    load_factor : float
    certificate : Certificate
        Equilibrium residual and yield excess are within the tolerances. The flow-rule gap separates the state from a
        collapse state.
    """

    iteration: int
    load_factor: float
    certificate: Certificate
