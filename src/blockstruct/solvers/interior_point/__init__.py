"""An interior-point loop of our own for frictional contact with elastic joints, step by step."""

from blockstruct.solvers.interior_point.contact_step import ContactProblem
from blockstruct.solvers.interior_point.state import ContactSolution, ContactState, Step

__all__ = ["ContactProblem", "ContactSolution", "ContactState", "Step"]
