"""Cost of a study: what it adds to each run, what a second worker saves, and the table of its runs.

Prints the overhead per run over a plain run with a store, the ratio of the times of one worker and of two for the same
runs, and the time of a table over many stored runs: of an archive that has been seen before and of one that has not.
All in one go, so that other work on the machine meets both sides. Run it with ``make bench``.
"""

import argparse
import shutil
import tempfile
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import blockstruct as bs

PUSH = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
CASE = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), PUSH)


def build(friction: float, columns: int, rows: int) -> tuple[bs.Model, bs.LimitCase]:
    """A wall in running bond, pushed along itself."""
    tuff = bs.Material("tuff", "12 kN/m^3")
    courses = [[1.0] * columns if k % 2 == 0 else [0.5, *[1.0] * (columns - 1), 0.5] for k in range(rows)]
    blocks = bs.courses(courses, unit_length="0.4 m", unit_height="0.2 m", thickness="0.2 m", material=tuff)
    found = bs.detect_interfaces(blocks, joint_material=bs.JointMaterial("lime", friction))
    return bs.Model("wall", blocks, found), CASE


def timed(step: Any) -> float:
    start = perf_counter()
    step()
    return perf_counter() - start


def overhead(folder: Path, runs: int) -> None:
    """What a study adds to a run of 7 blocks: the same runs one by one, in turns with the study."""
    small = partial(build, columns=2, rows=3)
    plain, studied = [], []
    small_runs = np.linspace(0.5, 0.7, runs).tolist()

    def one_by_one(kept: Path) -> None:
        for k, friction in enumerate(small_runs):
            model, case = small(friction)
            bs.AnalysisManager(model, kept / f"{k}.h5").run([case])

    one_by_one(folder / "warm")
    for turn in range(3):
        plain.append(timed(partial(one_by_one, folder / f"plain-{turn}")))
        study = partial(bs.study, small, {"friction": small_runs}, folder / f"study-{turn}", workers=1)
        studied.append(timed(study))
    more = (min(studied) - min(plain)) / runs
    print(
        f"{runs} runs of 7 blocks: {min(plain) / runs * 1e3:.0f} ms each, in a study {more * 1e3:.0f} more (limit 50)"
    )


def second_worker(folder: Path, runs: int, columns: int, rows: int) -> None:
    """The same runs by one worker, in this process, and by two, their start included."""
    values = {"friction": np.linspace(0.4, 0.8, runs).tolist()}
    wall = partial(build, columns=columns, rows=rows)
    one = timed(lambda: bs.study(wall, values, folder / "one", workers=1))
    two = timed(lambda: bs.study(wall, values, folder / "two", workers=2))
    print(f"{runs} runs of a wall of {columns} × {rows}: one worker {one:.1f} s, {one / runs:.2f} s a run")
    print(f"  two workers {two:.1f} s, {one / two:.2f} times as fast (limit 1.7)")


def tables(folder: Path, files: int) -> None:
    """A table over copies of one run: with its index to be made, then with it, then with a file that has changed."""
    bs.study(partial(build, columns=2, rows=3), {"friction": 0.6}, folder, workers=1)
    (first,) = folder.glob("*.h5")
    for k in range(files - 1):
        shutil.copy(first, folder / f"copy-{k}.h5")
    new = timed(lambda: bs.Archive(folder).table())
    seen = timed(lambda: bs.Archive(folder).table())
    model, case = build(0.7, 2, 3)
    bs.AnalysisManager(model, first).run([case])
    changed = bs.Archive(folder).table(all_columns=True)
    assert (changed["joint_friction_coefficient"] == 0.7).sum() == 1
    print(f"table of {files} runs: {new:.2f} s when first seen, {seen:.2f} s from then on (limit 2)")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=64)
    parser.add_argument("--columns", type=int, default=6)
    parser.add_argument("--rows", type=int, default=6)
    parser.add_argument("--files", type=int, default=1000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        overhead(Path(name, "overhead"), min(given.runs, 16))
        second_worker(Path(name, "workers"), given.runs, given.columns, given.rows)
        tables(Path(name, "table"), given.files)


if __name__ == "__main__":
    main()
