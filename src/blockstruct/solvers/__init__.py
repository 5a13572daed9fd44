"""Conic solvers: Clarabel directly, or any that CVXPY has.

>>> from blockstruct.limit import ProcedureSettings
>>> type(solver_of(ProcedureSettings())).__name__
'ClarabelSolver'
>>> type(solver_of(ProcedureSettings(solver="cvxpy:SCS"))).__name__
'CvxpySolver'
"""

from blockstruct.solvers.clarabel import ClarabelSolver
from blockstruct.solvers.named import solver_of

__all__ = ["ClarabelSolver", "solver_of"]
