"""Solve conic programs by Clarabel directly, or by any solver in CVXPY.

>>> from blockstruct.limit.settings import Numerics, ProcedureSettings
>>> type(solver_of(ProcedureSettings())).__name__
'ClarabelSolver'
>>> type(solver_of(ProcedureSettings(numerics=Numerics(solver="cvxpy:SCS")))).__name__
'CvxpySolver'
"""

from blockstruct.errors import SolverError, shown
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.solvers.conic import ClarabelSolver, RememberingSolver

__all__ = ["ClarabelSolver", "RememberingSolver", "solver_of"]


def solver_of(settings: ProcedureSettings) -> Solver:
    """Return the solver of the settings: ``"clarabel"`` or ``"cvxpy:NAME"``.

    Raises
    ------
    SolverError
        If no solver has the name, or the solver is not installed.
    """
    if settings.numerics.solver == "clarabel":
        return ClarabelSolver()
    layer, _, name = settings.numerics.solver.partition(":")
    if layer == "cvxpy" and name:
        # CVXPY takes as long to import as everything else together.
        from blockstruct.solvers.cvxpy import CvxpySolver

        return CvxpySolver(name)
    msg = f"solver {shown(settings.numerics.solver)}: give 'clarabel', or 'cvxpy:NAME' such as 'cvxpy:SCS'"
    raise SolverError(msg)
