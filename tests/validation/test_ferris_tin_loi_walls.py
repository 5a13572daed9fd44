"""Dry-joint walls of Ferris & Tin-Loi, pushed in their plane.

M. C. Ferris, F. Tin-Loi (2001), "Limit analysis of frictional block assemblies as a mathematical program with
complementarity constraints", Int. J. Mech. Sci. 43: 209–224, examples 1, 3 and 4. Units 0.40 m × 0.175 m, μ = 0.65
on bed and head joints and under the first course; gravity is the weight, the variable load the weight turned to +x.

The associative program is convex: its value is compared with an independent program to 1e-4. The non-associative
answer depends on the path: it may not exceed the lowest value known, found by several schedules of an independent
program, by more than 0.5 %, and it may not fall below it by as much either.
"""

import pytest

import blockstruct as bs
from published import WALLS, blocks
from structures import model_of, push, solve


@pytest.fixture(params=[(wall, depth) for wall in WALLS for depth in ("0.1 m", "1 m")], ids=lambda p: f"{p[0]} {p[1]}")
def wall(request, dry):
    return model_of(blocks(*request.param), dry), *WALLS[request.param[0]][1:]


def test_associative(wall):
    model, units, interfaces, associative, _ = wall
    assert (len(model.blocks) - 1, len(model.interfaces)) == (units, interfaces)
    result = solve(model, push(1, 0, 0))
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(associative, rel=1e-4)


def test_nonassociative(wall):
    model, _, _, associative, lowest = wall
    result = solve(model, push(1, 0, 0), "nonassociative")
    assert result.status == "converged"
    assert result.outcome.procedure is bs.vocabulary.Procedure.LOADING_PATH
    assert result.certificate.holds
    assert result.certificate.flow_rule_gap < 1e-5
    assert result.certificate.interpenetration <= 1e-4
    assert result.load_factor == pytest.approx(lowest, rel=5e-3)
    assert result.load_factor < associative
    # The whole point of the schedule: few programs.
    assert result.n_iterations <= 24
