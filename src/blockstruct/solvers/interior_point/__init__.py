"""Solve frictional contact with elastic joints by interior points."""

from blockstruct.solvers.interior_point.contact_step import ContactProblem
from blockstruct.solvers.interior_point.state import ContactSolution, ContactState, Step

__all__ = ["ContactProblem", "ContactSolution", "ContactState", "Step"]
