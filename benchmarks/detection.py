"""Time of building, detecting and checking walls of 1,000 to 10,000 blocks, and how it grows.

Prints the times of blocks, detection and model checks, and the exponents of their growth with the number of blocks,
for walls along the axes, the largest of them turned in space, a solid of cubes and a wall under one long beam. The last
line sets model and detection of 2,400 blocks beside one associative solve of that wall. Run it with ``make bench``.
"""

import argparse
import math
from time import perf_counter

import blockstruct as bs
from blockstruct.limit import ConicProgram, LimitProblem, true_sliding
from blockstruct.solvers import ClarabelSolver
from blockstruct.statics.statics import Statics

TUFF, DRY = bs.Material("tuff", unit_weight="12 kN/m^3"), bs.JointMaterial("dry", friction_coefficient=0.65)
LIMIT, EXPONENT = 10.0, 1.2


def wall(columns: int, rows: int) -> list[bs.Block]:
    bond = [[1] * columns if j % 2 == 0 else [0.5] + [1] * (columns - 1) + [0.5] for j in range(rows)]
    return bs.courses(bond, unit_length="0.4 m", unit_height="0.175 m", thickness="0.2 m", material=TUFF)


def cubes(n: int) -> list[bs.Block]:
    """Solid of n³ cubes on a fixed layer."""
    return [
        bs.Block.box(f"{x}.{y}.{z}", bs.Q_([x, y, z], "m"), bs.Q_([1, 1, 1], "m"), TUFF, fixed=z == 0)
        for x in range(n)
        for y in range(n)
        for z in range(n)
    ]


def timed(name: str, blocks: list[bs.Block], building: float) -> tuple[float, float]:
    """Print one line; give the times of detection and of the model."""
    start = perf_counter()
    found = bs.detect_interfaces(blocks, joint_material=DRY)
    detection = perf_counter() - start
    start = perf_counter()
    bs.Model(name, blocks, found.interfaces)
    checks = perf_counter() - start
    print(
        f"{name:<24}{len(blocks):>7}{len(found.interfaces):>9}{building:>9.2f} s{detection:>9.2f} s{checks:>9.2f} s",
        flush=True,
    )
    return detection, checks


def associative_solve(columns: int, rows: int) -> tuple[float, float]:
    """Seconds of detection and model, and of one associative solve of a wall."""
    start = perf_counter()
    blocks = wall(columns, rows)
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint_material=DRY).interfaces)
    building = perf_counter() - start
    case = bs.LimitCase(
        "push", bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
    )
    problem = LimitProblem.of(Statics.of(model), case)
    settings = bs.ProcedureSettings()
    program = ConicProgram(problem, settings)
    numbers = program.data(true_sliding(problem))
    start = perf_counter()
    ClarabelSolver().solve(program, numbers, settings.numerics.solver_tolerance)
    return building, perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--sizes", type=int, nargs="+", default=[25, 50, 100], help="columns of the walls, as many rows and at least 40"
    )
    sizes = parser.parse_args().sizes
    print(f"{'structure':<24}{'blocks':>7}{'interfaces':>11}{'blocks':>9}{'detection':>13}{'checks':>8}")
    times = []
    for columns in sizes:
        start = perf_counter()
        blocks = wall(columns, columns if columns > 40 else 40)
        building = perf_counter() - start
        times.append((len(blocks), *timed("wall", blocks, building)))
    start = perf_counter()
    turned = bs.structures.tilted(blocks, "35 deg", axis=(1, 2, 3))
    timed("the last, turned", turned, perf_counter() - start)
    start = perf_counter()
    solid = cubes(round(len(blocks) ** (1 / 3)))
    timed("solid of cubes", solid, perf_counter() - start)
    (small, *first), (large, *last) = times[0], times[-1]
    for name, one, other in zip(("detection", "model checks"), first, last, strict=True):
        exponent = math.log(other / one) / math.log(large / small)
        print(f"{name} grows with the number of blocks to the power of {exponent:.2f} (limit {EXPONENT})")
    print(f"detection of {large} blocks {last[0]:.1f} s (limit {LIMIT:.0f} s)")
    building, solve = associative_solve(40, 60)
    print(f"2,400 blocks: model and detection {building:.2f} s, one associative solve {solve:.2f} s")


if __name__ == "__main__":
    main()
