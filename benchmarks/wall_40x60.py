"""Cost of everything around the solver on a 40 × 60 brick wall, as ratios to one associative solve.

Prints the time of the model, the detection, the statics, the conic build, the history and the file beside that of
the conic solver, the peak memory, the cost of a whole non-associative analysis in associative solves, and the same
steps written naively: a CVXPY problem built anew for every program. Run it with ``make bench``.
"""

import argparse
import resource
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import blockstruct as bs
from blockstruct.limit import ConicProgram, LimitProblem, true_sliding
from blockstruct.procedures import solve_limit_case
from blockstruct.results import history_of
from blockstruct.solvers import ClarabelSolver
from blockstruct.solvers.cvxpy import CvxpySolver
from blockstruct.statics.statics import Statics


class Clock:
    """Times steps by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def __call__(self, name: str, step: Callable[[], Any]) -> Any:
        """Run a step and add its time to its name."""
        start = perf_counter()
        value = step()
        self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - start
        return value


def wall(columns: int, rows: int) -> list[bs.Block]:
    tuff = bs.Material("tuff", unit_weight="12 kN/m^3")
    bond = [[1] * columns if j % 2 == 0 else [0.5] + [1] * (columns - 1) + [0.5] for j in range(rows)]
    size = {"unit_length": "0.4 m", "unit_height": "0.175 m", "thickness": "0.2 m"}
    return bs.courses(bond, **size, material=tuff)


def peak_memory() -> float:
    """Peak resident memory of this process, GB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--columns", type=int, default=40)
    parser.add_argument("--rows", type=int, default=60)
    parser.add_argument("--naive", type=int, default=2, help="programs also solved the naive way")
    size = parser.parse_args()
    clock, settings = Clock(), bs.ProcedureSettings()
    dry = bs.JointMaterial("dry", friction_coefficient=0.65)
    push = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
    case = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push, bs.Flow.NONASSOCIATIVE)

    blocks = clock("blocks", lambda: wall(size.columns, size.rows))
    found = clock("detection", lambda: bs.detect_interfaces(blocks, joint_material=dry))
    model = clock("model checks", lambda: bs.Model("wall", blocks, found.interfaces))
    statics = clock("statics", lambda: Statics.of(model))
    problem = clock("statics", lambda: LimitProblem.of(statics, case))
    print(f"{len(model.blocks)} blocks, {len(model.interfaces)} interfaces, {problem.n_points} contact points")

    program = clock("conic build", lambda: ConicProgram(problem, settings))
    numbers = clock("conic build", lambda: program.data(true_sliding(problem)))
    solver = ClarabelSolver()
    first = clock("associative solve", lambda: solver.solve(program, numbers, settings.numerics.solver_tolerance))
    solve = clock.seconds["associative solve"]
    print(f"associative: {first.status}, load factor {-(numbers.q @ first.y) / program.total:.8f}, {solve:.1f} s")

    steps = solve_limit_case(problem, case.flow, settings, ClarabelSolver())
    iterations = []
    start = perf_counter()
    while True:
        try:
            iterations.append(next(steps))
        except StopIteration as stop:
            outcome = stop.value
            break
    whole = perf_counter() - start
    in_solver = sum(i.solver_time for i in iterations)
    history = clock("history", lambda: history_of(statics, problem, iterations))
    result = bs.CaseResult(
        model=model,
        case=case,
        settings=settings,
        outcome=outcome,
        certificate=iterations[-1].certificate,
        history=history,
        started_at="",
        duration=whole,
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wall.h5"
        analysis = bs.Analysis(model, {case.name: result}, "", {})
        clock("HDF5", lambda: bs.save_analysis(analysis, path))
        stored = path.stat().st_size / 1e6
    around = sum(t for name, t in clock.seconds.items() if name != "associative solve")

    print("\neverything around the solver")
    for name, seconds in clock.seconds.items():
        if name != "associative solve":
            print(f"  {name:<14}{seconds:7.2f} s   {seconds / solve:6.3f} associative solves")
    print(f"  {'total':<14}{around:7.2f} s   {around / solve:6.3f}   (limit {0.1 + 2 / solve:.3f}: 10 % and 2 s)")
    print(f"  file {stored:.1f} MB, raw history {history.nbytes / 1e6:.1f} MB")
    print(f"  peak memory {peak_memory():.2f} GB (limit 1.5)")
    print("\nwhole non-associative analysis")
    print(f"  {outcome.status}, {outcome.reason}; load factor {outcome.load_factor:.6f}")
    print(f"  {len(iterations)} iterations and the dead-load program, {whole:.1f} s, {in_solver:.1f} s in their solver")
    print(f"  {whole / solve:.1f} associative solves (limit 20)")

    naive, same = CvxpySolver("CLARABEL"), 0.0
    start = perf_counter()
    for _ in range(size.naive):
        solution = naive.solve(ConicProgram(problem, settings), numbers, settings.numerics.solver_tolerance)
        same = abs(float(solution.y[0]) / float(first.y[0]) - 1)
    if size.naive:
        each = (perf_counter() - start) / size.naive
        print("\nthe same program, built anew with CVXPY")
        print(f"  {each / solve:.2f} associative solves a program, load factor differs by {same:.1e}")


if __name__ == "__main__":
    main()
