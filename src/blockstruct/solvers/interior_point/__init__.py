"""Solve frictional contact with elastic joints by interior points."""

from blockstruct.solvers.interior_point.contact_step import ContactProblem, ContactSolution, ContactState, Step

__all__ = ["ContactProblem", "ContactSolution", "ContactState", "Step"]
