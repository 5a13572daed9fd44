"""Cost of a pushover, as a ratio to one associative solve of the same model.

Prints for walls of several sizes, pushed across, where the wall rocks as one, and in their plane, where units slip and
catch: states of the curve, iterations per state, and the processor time of the curve,
without that of the collapse state it starts from, in associative solves: in those of the conic solver alone, and in
those of an associative case with its assembly and certificates. Run it with ``make bench``.
"""

import argparse
from collections.abc import Callable
from time import process_time

import blockstruct as bs
from blockstruct.limit import ConicProgram, LimitProblem, true_sliding
from blockstruct.solvers import ClarabelSolver
from blockstruct.statics.statics import Statics

TUFF = bs.Material("tuff", unit_weight="12 kN/m^3")
DEAD = bs.LoadPattern("dead", [bs.SelfWeight()])
PUSHES = {"across": (0, 1, 0), "in plane": (1, 0, 0)}
REPEATS = 3
TITLES = {"wall": 8, "push": 10, "blocks": 8, "states": 8, "iterations": 12, "solver": 8, "cases": 8}


def wall(columns: int, rows: int) -> bs.Model:
    bond = [[1] * columns if j % 2 == 0 else [0.5] + [1] * (columns - 1) + [0.5] for j in range(rows)]
    blocks = bs.courses(bond, unit_length="0.4 m", unit_height="0.2 m", thickness="0.2 m", material=TUFF)
    return bs.Model("wall", blocks, bs.detect_interfaces(blocks, bs.JointMaterial("dry", 0.65)))


def seconds(call: Callable[[], object], repeats: int = REPEATS) -> float:
    """Shortest of some repetitions."""
    times = []
    for _ in range(repeats):
        start = process_time()
        call()
        times.append(process_time() - start)
    return min(times)


def measured(model: bs.Model, direction: tuple[int, int, int], steps: int) -> str:
    """Figures of one wall."""
    push = bs.LoadPattern("push", [bs.BodyForce(direction)])
    settings, manager = bs.ProcedureSettings(), bs.AnalysisManager(model)
    bound, limit = bs.LimitCase("bound", DEAD, push, "associative"), bs.LimitCase("limit", DEAD, push)
    control = (model.blocks[-1].name, direction)
    pushover = bs.Pushover("push", dead=DEAD, variable=push, control=control, steps=steps)
    problem = LimitProblem.of(Statics.of(model), bound)
    program = ConicProgram(problem, settings)
    data = program.data(true_sliding(problem))
    solver = seconds(lambda: ClarabelSolver().solve(program, data, settings.numerics.solver_tolerance))
    case = seconds(lambda: manager.run([bound]))
    found: list[bs.CaseResult] = []
    spent = seconds(lambda: found.append(manager.run([pushover])["push"]), 1) - seconds(lambda: manager.run([limit]), 1)
    curve, ended = found[0].capacity, found[0].curve_ended
    iterations = float(curve["solver_iterations"].mean())
    return f"{curve.sizes['step']:>8}{iterations:>12.1f}{spent / solver:>8.1f}{spent / case:>8.1f}  {ended}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--walls", default="4x12,8x24,11x36,16x50", help="columns x rows of walls")
    parser.add_argument("--pushes", default=",".join(PUSHES), help="in plane, across or both")
    parser.add_argument("--steps", type=int, default=60)
    words = parser.parse_args()
    print("".join(f"{title:>{width}}" for title, width in TITLES.items()) + "  ended")
    for columns, rows in (tuple(map(int, size.split("x"))) for size in words.walls.split(",")):
        model = wall(columns, rows)
        for name in words.pushes.split(","):
            figures = measured(model, PUSHES[name], words.steps)
            print(f"{f'{columns} x {rows}':>8}{name:>10}{len(model.blocks):>8}{figures}", flush=True)


if __name__ == "__main__":
    main()
