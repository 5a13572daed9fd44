"""Cost of what surrounds the solver: detection, model checks, storage, the console and Monte Carlo studies.

Prints one table: each measured time, its limit, and whether it is within. Times of one process are processor seconds,
the least of several. Run it with ``make bench``.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from scipy.stats import norm

import blockstruct as bs

TUFF = bs.Material("tuff", unit_weight="12 kN/m^3")
DRY = bs.JointMaterial("dry", friction_coefficient=0.65)
CASE = bs.LimitCase(
    "push", bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
)


def wall(columns: int, rows: int) -> list[bs.Block]:
    bond = [[1] * columns if j % 2 == 0 else [0.5] + [1] * (columns - 1) + [0.5] for j in range(rows)]
    return bs.courses(bond, unit_length="0.4 m", unit_height="0.2 m", thickness="0.2 m", material=TUFF)


def model_of(blocks: list[bs.Block], joint: bs.JointMaterial = DRY) -> bs.Model:
    return bs.Model("model", blocks, bs.detect_interfaces(blocks, joint))


def build(friction: float, columns: int, rows: int) -> tuple[bs.Model, bs.LimitCase]:
    """Return a wall and its case; only the joints differ between the runs of a study."""
    return model_of(wall(columns, rows), bs.JointMaterial("lime", friction)), CASE


def build_45(friction: float) -> tuple[bs.Model, bs.LimitCase]:
    return build(friction, 5, 8)


def build_41(friction: float) -> tuple[bs.Model, bs.LimitCase]:
    return build(friction, 4, 9)


def least(step: Callable[[], Any], repeats: int = 5, clock: Callable[[], float] = process_time) -> float:
    """Return the least time of several, seconds."""
    times = []
    for _ in range(repeats):
        start = clock()
        step()
        times.append(clock() - start)
    return min(times)


def processor() -> float:
    """Return the processor seconds of this process and of the processes that it has ended."""
    return sum(
        u.ru_utime + u.ru_stime for u in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def row(what: str, measured: float, limit: float, unit: str = "ms") -> None:
    note = "" if measured <= limit else "above"
    print(f"{what:<70}{measured:>8.3g} {unit:<6}{limit:>6.3g} {unit:<6}{note}", flush=True)


def vaults(sizes: list[tuple[int, int]]) -> None:
    """Compare domes with walls of as many blocks: detection and model."""
    for courses, units in sizes:
        dome = bs.structures.dome(
            span="8 m", thickness="60 cm", courses=courses, units=units, oculus="1.6 m", material=TUFF
        )
        like = wall(units, round(len(dome) / units))
        # In turns, because the last geometry is remembered.
        times = [
            [least(lambda b=b: model_of(list(b)), 1) for b in (dome, like)] for _ in range(3 if len(dome) < 1000 else 1)
        ]
        curved, straight = np.min(times, axis=0)
        row(
            f"detection and model, dome of {len(dome)} over wall of {len(like)} blocks ({curved:.3g} s)",
            curved / straight,
            2.0,
            "times",
        )


def one_run(folder: Path) -> None:
    """A run of 45 blocks along the path, its storage and its opening."""
    model, _ = build_45(0.65)
    path = folder / "run.h5"
    # In turns and often, because storing is a small difference of two times.
    run, stored = np.min(
        [[least(lambda s=s: bs.AnalysisManager(model, s).run([CASE]), 1) for s in (None, path)] for _ in range(25)],
        axis=0,
    )
    row(f"run of {len(model.blocks)} blocks along the path", 1e3 * run, 70)
    row("  storing it", 1e3 * (stored - run), 30)
    row("  opening it", 1e3 * least(lambda: bs.open_analysis(path)), 40)


def command() -> None:
    """Processor time of the console's help."""
    code = "import sys; sys.argv[1:] = ['--help']; from blockstruct.cli import main; main()"
    seconds = least(
        lambda: subprocess.run([sys.executable, "-c", code], stdout=subprocess.DEVNULL, check=True), 3, processor
    )
    row("blockstruct --help, processor time", seconds, 0.4, "s")


def solves(make: Callable[[float], tuple[bs.Model, bs.LimitCase]], frictions: list[float]) -> float:
    """Return the seconds of the bare solves of runs: no model, no statics, no storage, no certificate of a file."""
    from blockstruct.limit import LimitProblem
    from blockstruct.procedures import solve_limit_case
    from blockstruct.solvers import solver_of
    from blockstruct.statics.statics import Statics

    total, settings = 0.0, bs.ProcedureSettings()
    for friction in frictions:
        model, case = make(friction)
        problem = LimitProblem.of(Statics.of(model), case).at_unit_load
        start = process_time()
        for _ in solve_limit_case(problem, case.flow, settings, solver_of(settings)):
            pass
        total += process_time() - start
    return total


def monte_carlo(folder: Path, runs: int, sample: int) -> None:
    """Stored studies of walls with random joints, beside their bare solves."""
    frictions = norm(0.6, 0.03)
    drawn = bs.study(build_41, {"friction": frictions}, runs=sample, workers=1, seed=1)["friction"].to_numpy().tolist()
    bare = solves(build_41, drawn)
    start = process_time()
    bs.study(build_41, {"friction": frictions}, folder / "one", runs=sample, workers=1, seed=1)
    blocks = len(build_41(0.6)[0].blocks)
    row(
        f"stored Monte Carlo run of {blocks} blocks beside its solves ({1e3 * bare / sample:.3g} ms)",
        1e3 * (process_time() - start - bare) / sample,
        60,
    )
    bare = solves(build_45, drawn) / sample * runs
    start, work = perf_counter(), processor()
    bs.study(build_45, {"friction": frictions}, folder / "two", runs=runs, workers=2, seed=1)
    elapsed, work = perf_counter() - start, processor() - work
    what = f"Monte Carlo of {runs} walls of {len(build_45(0.6)[0].blocks)} on 2 workers"
    row(f"{what} over bare solves on 2", elapsed / (bare / 2), 1.2, "times")
    row("  its processor time over that of the bare solves", work / bare, 1.2, "times")


def large(columns: int, rows: int, flow: str) -> None:
    """A large wall: time, peak memory, and whether its load factor is certified and settled."""
    model, start = model_of(wall(columns, rows)), process_time()
    result = bs.AnalysisManager(model).run([CASE.renamed("push", bs.Flow(flow))])["push"]
    row(f"run of {len(model.blocks)} blocks, {flow}", process_time() - start, np.inf, "s")
    found = f"load factor {result.load_factor:.4f}, {result.status}, {'settled' if result.settled else 'not settled'}"
    row(f"  {found}; peak memory", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, 4, "GB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--domes", default="6x10,12x20,40x125", help="courses x units of domes")
    parser.add_argument("--runs", type=int, default=1000, help="runs of the study on two workers")
    parser.add_argument("--sample", type=int, default=40, help="runs of the study in this process")
    parser.add_argument("--large", default="100x100", help="columns x rows of a large wall")
    parser.add_argument("--flow", default="associative", help="of the large wall")
    parser.add_argument("--only", default="", help="one part: vaults, run, command, study or large")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sizes = [tuple(map(int, size.split("x"))) for size in given.domes.split(",")]
        parts: dict[str, Callable[[], None]] = {
            "vaults": lambda: vaults(sizes),
            "run": lambda: one_run(folder),
            "command": command,
            "large": lambda: large(*map(int, given.large.split("x")), given.flow),
            "study": lambda: monte_carlo(folder, given.runs, given.sample),
        }
        print(f"{'':<70}{'measured':>14} {'limit':>12}")
        for part, measure in parts.items():
            if given.only in ("", part):
                measure()


if __name__ == "__main__":
    main()
