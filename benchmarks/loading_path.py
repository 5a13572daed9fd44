"""Cost and accuracy of the loading path, as ratios to one associative solve of the same model.

Prints for walls of several sizes, the façade with sidewalls and a dome: load factor, flow-rule gap over it,
iterations of the path, its time and that of the whole case in associative Clarabel solves, that of the whole case in
fictitious iterations, how iterations and times grow with the number of blocks, and the peak memory. Run it with
``make bench``.
"""

import argparse
import resource
from time import process_time

import numpy as np

import blockstruct as bs
from blockstruct.limit import ConicProgram, Iteration, LimitProblem, Outcome, true_sliding
from blockstruct.procedures import solve_limit_case
from blockstruct.solvers import ClarabelSolver
from blockstruct.statics.statics import Statics

TUFF = bs.Material("tuff", unit_weight="12 kN/m^3")


def wall(columns: int, rows: int) -> bs.Model:
    bond = [[1] * columns if j % 2 == 0 else [0.5] + [1] * (columns - 1) + [0.5] for j in range(rows)]
    size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "thickness": "0.2 m"}
    return model(bs.courses(bond, **size, material=TUFF), bs.JointMaterial("dry", 0.65))


def facade(*, bonded: bool) -> bs.Model:
    joints = {"base|*": bs.JointMaterial("ground", 0.6), "*": bs.JointMaterial("lime mortar", 0.65)}
    door = bs.structures.Opening(start="1.2 m", sill="0 m", width="0.8 m", height="1.6 m")
    sides = [bs.structures.Sidewall(n, at, "1.6 m", bonded=bonded) for n, at in (("left", "0 m"), ("right", "3 m"))]
    size = {"length": "3.2 m", "unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm"}
    return model(bs.wall(**size, courses=12, openings=[door], sidewalls=sides, material=TUFF), joints)


def dome() -> bs.Model:
    stone = bs.Material("limestone", unit_weight="22 kN/m^3")
    blocks = bs.structures.dome(span="8 m", thickness="60 cm", courses=6, units=10, oculus="1.6 m", material=stone)
    return model(blocks, bs.JointMaterial("dry joint", 0.7))


def model(blocks: list[bs.Block], joints: object) -> bs.Model:
    return bs.Model("model", blocks, bs.detect_interfaces(blocks, joints).interfaces)


def problem_of(structure: bs.Model, direction: tuple[float, float, float]) -> LimitProblem:
    push = bs.LoadPattern("push", [bs.BodyForce(direction)])
    case = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push, bs.Flow.NONASSOCIATIVE)
    return LimitProblem.of(Statics.of(structure), case)


def run(problem: LimitProblem, procedure: str) -> tuple[Outcome, list[Iteration], float, float]:
    """Outcome, iterations, and processor seconds of the case and of the steps of its path."""
    start, along, iterations = process_time(), 0.0, []
    settings = bs.ProcedureSettings(procedure=procedure)
    steps = solve_limit_case(problem, bs.Flow.NONASSOCIATIVE, settings, ClarabelSolver())
    while True:
        before = process_time()
        try:
            iterations.append(next(steps))
        except StopIteration as stop:
            return stop.value, iterations, process_time() - start, along
        if iterations[-1].stage is bs.vocabulary.Stage.LOADING_PATH:
            # The state under dead load is found before it is shown.
            at_rest = iterations[-1].displacement == 0
            along += iterations[-1].solver_time if at_rest else process_time() - before


def associative(problem: LimitProblem) -> float:
    """Processor seconds of one associative program."""
    settings = bs.ProcedureSettings()
    program = ConicProgram(problem, settings)
    start = process_time()
    ClarabelSolver().solve(program, program.data(true_sliding(problem)), settings.numerics.solver_tolerance)
    return process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--walls", default="10x20,20x40,40x60", help="columns x rows of walls")
    parser.add_argument("--without", default="", help="leave out 'others' (façade and dome) or 'fictitious'")
    words = parser.parse_args()
    sizes = [tuple(map(int, size.split("x"))) for size in words.walls.split(",")]
    cases = [(f"wall {c} x {r}", wall(c, r), (1.0, 0.0, 0.0)) for c, r in sizes]
    if "others" not in words.without:
        cases.append(("façade, bonded", facade(bonded=True), (0.0, -1.0, 0.0)))
        cases.append(("façade, butted", facade(bonded=False), (0.0, -1.0, 0.0)))
        cases.append(("dome", dome(), (1.0, 0.0, 0.0)))
    heads = {"blocks": 7, "factor": 10, "gap": 9, "iterations": 12, "path": 8, "whole": 8, "fictitious": 12}
    print(" " * 16 + "".join(f"{head:>{width}}" for head, width in heads.items()))
    growth = []
    # What is loaded late is no part of the first case.
    run(problem_of(wall(2, 2), (1.0, 0.0, 0.0)), "loading path")
    for name, structure, direction in cases:
        problem = problem_of(structure, direction)
        once = associative(problem)
        outcome, iterations, seconds, along = run(problem, "loading path")
        gap = iterations[-1].certificate.flow_rule_gap / abs(iterations[-1].load_factor)
        path = [i for i in iterations if i.stage is bs.vocabulary.Stage.LOADING_PATH]
        count = sum(i.solver_iterations for i in path)
        other = "" if "fictitious" in words.without else f"{seconds / run(problem, 'fictitious')[2]:.2f}"
        blocks = len(problem.w_D) // 6
        print(
            f"{name:<16}{blocks:>7}{outcome.load_factor:>10.5f}{gap:>9.0e}{count:>12}{along / once:>8.1f}"
            f"{seconds / once:>8.1f}{other:>12}"
        )
        if name.startswith("wall"):
            growth.append((blocks, count, along, seconds))
        if outcome.stands_in or not outcome.settled:
            print(f"{'':<16}{outcome}")
    if len(growth) > 1:
        logs = np.log(growth)
        exponents = (logs[-1] - logs[0])[1:] / (logs[-1] - logs[0])[0]
        said = zip(("iterations", "time of the path", "time of the case"), exponents, strict=True)
        print("over the walls:", ", ".join(f"{what} ~ blocks^{exponent:.2f}" for what, exponent in said))
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB (limit 1.5)")


if __name__ == "__main__":
    main()
