"""Cost of a pushover, as a ratio to one associative solve of the same model.

Prints for walls of several sizes, pushed in their plane: states of the curve, programs and interior-point iterations a
state, and the whole time of the curve, without that of the collapse state it starts from, in associative solves: in
those of the conic solver alone, and in those of an associative case with its assembly and certificates. Run it with
``make bench``.
"""

import argparse
from collections.abc import Callable
from time import perf_counter

import blockstruct as bs
from blockstruct.limit import ConicProgram, LimitProblem, true_sliding
from blockstruct.solvers import ClarabelSolver
from blockstruct.statics import Statics

TUFF = bs.Material("tuff", unit_weight="12 kN/m^3")
DEAD, PUSH = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
REPEATS = 3


def wall(columns: int, rows: int) -> bs.Model:
    bond = [[1] * columns if j % 2 == 0 else [0.5] + [1] * (columns - 1) + [0.5] for j in range(rows)]
    blocks = bs.courses(bond, unit_length="0.4 m", unit_height="0.2 m", depth="0.2 m", material=TUFF)
    return bs.Model("wall", blocks, bs.detect_interfaces(blocks, bs.JointMaterial("dry", 0.65)))


def seconds(call: Callable[[], object]) -> float:
    """Shortest of some repetitions."""
    times = []
    for _ in range(REPEATS):
        start = perf_counter()
        call()
        times.append(perf_counter() - start)
    return min(times)


def measured(model: bs.Model, steps: int) -> str:
    """Figures of one wall."""
    plain, settings, manager = (
        bs.LimitCase("bound", DEAD, PUSH, "associative"),
        bs.ProcedureSettings(),
        bs.AnalysisManager(model),
    )
    problem = LimitProblem.of(Statics.of(model), plain)
    program = ConicProgram(problem, settings)
    data = program.data(true_sliding(problem))
    solver = seconds(lambda: ClarabelSolver().solve(program, data, settings.solver_tolerance))
    cases = seconds(lambda: manager.run([plain]))
    control = (model.blocks[-1].name, (1, 0, 0))
    result = manager.run([bs.Pushover("push", dead=DEAD, variable=PUSH, control=control, steps=steps)])["push"]
    curve = result.capacity
    spent, n = float(curve["solver_time"].sum()), curve.sizes["step"]
    programs, iterations = (float(curve[name].mean()) for name in ("programs", "solver_iterations"))
    ended = result.message.split("pushover: ")[1]
    return f"{n:>8}{programs:>10.2f}{iterations:>12.1f}{spent / solver:>8.1f}{spent / cases:>8.1f}  {ended}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--walls", default="3x10,6x20,12x40", help="columns x rows of walls")
    parser.add_argument("--steps", type=int, default=60)
    words = parser.parse_args()
    print(f"{'wall':>8}{'blocks':>8}{'states':>8}{'programs':>10}{'iterations':>12}{'solver':>8}{'cases':>8}  ended")
    for columns, rows in (tuple(map(int, size.split("x"))) for size in words.walls.split(",")):
        model = wall(columns, rows)
        print(f"{f'{columns} x {rows}':>8}{len(model.blocks):>8}{measured(model, words.steps)}")


if __name__ == "__main__":
    main()
