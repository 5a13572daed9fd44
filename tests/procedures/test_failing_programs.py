"""Programs that a solver does not solve."""

import dataclasses

import numpy as np

import blockstruct as bs
from blockstruct.analysis import manager
from blockstruct.results import contradictions, recomputed_certificate
from blockstruct.solvers import ClarabelSolver
from structures import SELF_WEIGHT, model_of, push, single_block


class Failing(ClarabelSolver):
    """Solves the first three programs alone: two of the dead load, and the associative one."""

    def __init__(self):
        super().__init__()
        self.solved = 0

    def solve(self, program, data, tolerance):
        solution = super().solve(program, data, tolerance)
        self.solved += 1
        return (
            solution
            if self.solved <= 3
            else dataclasses.replace(solution, status=bs.vocabulary.SolverStatus.INFEASIBLE)
        )


def test_a_last_program_without_a_solution_has_no_certificate(tmp_path, monkeypatch):
    """A certificate proves a state: without one there is none, and never a certificate of NaN."""
    solver = Failing()
    monkeypatch.setattr(manager, "solver_of", lambda _: solver)
    model = model_of(*single_block(1, 2))
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    analysis = bs.run(model, case, tmp_path / "a.h5", settings=bs.ProcedureSettings(procedure="fictitious"))
    result = analysis["push"]
    assert (result.status, result.certificate) == ("not_converged", None)
    measures = [result.history[name][-1] for name in ("equilibrium_residual", "yield_excess", "interpenetration")]
    assert np.isnan(measures).all(), "nor is a measure of the failed program a number"
    stored = bs.open_analysis(tmp_path / "a.h5")
    assert stored["push"].certificate is None
    assert (contradictions(stored), recomputed_certificate(stored, "push")) == ([], None)
