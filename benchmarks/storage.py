"""Cost of the archive: committing while a run goes on, writing, reloading, tables and single values.

Prints the share of a run on a wall of 2,400 blocks that recording takes, the time to write and reload a history of 30
iterations of 40,000 contact points, its size against raw floats, the time of a table over 1,000 files and of one value
among them. Run it with ``make bench``.
"""

import argparse
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr
from wall_40x60 import peak_memory, wall

import blockstruct as bs
from blockstruct.analysis.recorder import Recorder
from blockstruct.limit import LimitProblem
from blockstruct.results import history_of
from blockstruct.statics import Statics
from blockstruct.storage import Checkpoint

PUSH = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
CASE = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), PUSH)


def timed(step: Callable[[], Any]) -> tuple[float, Any]:
    start = perf_counter()
    value = step()
    return perf_counter() - start, value


def model_of(columns: int, rows: int) -> bs.Model:
    blocks = wall(columns, rows)
    found = bs.detect_interfaces(blocks, joint_material=bs.JointMaterial("dry", friction_coefficient=0.65))
    return bs.Model("wall", blocks, found.interfaces)


def recording(folder: Path, columns: int, rows: int, programs: int) -> None:
    """Share of a run that its recorder takes: each part of it is timed, for its noise is less than that of a run."""
    model, spent = model_of(columns, rows), {"plan": 0.0, "iterations": 0.0, "finished file": 0.0}

    def clocked(kind: type, method: str, part: str) -> None:
        plain = getattr(kind, method)

        def measured(*words: Any) -> Any:
            seconds, value = timed(lambda: plain(*words))
            spent[part] += seconds
            return value

        setattr(kind, method, measured)

    begin = Checkpoint.begin.__func__  # type: ignore[attr-defined]

    def begun(cls: type, *words: Any) -> Any:
        seconds, value = timed(lambda: begin(cls, *words))
        spent["plan"] += seconds
        return value

    Checkpoint.begin = classmethod(begun)  # type: ignore[assignment,method-assign]
    clocked(Recorder, "__call__", "iterations")
    clocked(Checkpoint, "finish", "finished file")
    settings = bs.ProcedureSettings(max_programs=programs)
    manager = bs.AnalysisManager(model, folder / "recorded.h5", settings=settings)
    whole, analysis = timed(lambda: manager.run([CASE]))
    n = analysis["push"].n_iterations
    print(
        f"{len(model.blocks)} blocks, {analysis['push'].history.sizes['contact_point']} contact points, {n} iterations"
    )
    print(f"  run {whole:.1f} s, {analysis['push'].status}")
    for part, seconds in spent.items():
        print(f"  {part:<14}{seconds:7.3f} s   {100 * seconds / whole:5.2f} %")
    recorder = spent["plan"] + spent["iterations"]
    print(f"  recorder, that is plan and iterations: {100 * recorder / whole:.2f} % of the run (limit 2)")


def large_history(folder: Path, columns: int, rows: int, iterations: int) -> None:
    model = model_of(columns, rows)
    statics = Statics.of(model)
    history = history_of(statics, LimitProblem.of(statics, CASE), [])
    chance = np.random.default_rng(0)

    def filled(variable: xr.Variable) -> xr.Variable:
        if "iteration" not in variable.dims:
            return variable
        shape = (iterations, *variable.shape[1:])
        texts = np.full(shape, "solved", dtype=object)
        return xr.Variable(
            variable.dims, chance.normal(size=shape) if variable.dtype.kind == "f" else texts, variable.attrs
        )

    whole = {"iteration": np.arange(iterations), "solver_iterations": ("iteration", np.arange(iterations))}
    data = {n: filled(v.variable) for n, v in history.data_vars.items() if n not in whole}
    coords = {n: filled(v.variable) for n, v in history.coords.items() if n not in whole}
    units = history["solver_iterations"].attrs
    solver_iterations = xr.Variable("iteration", np.arange(iterations), units)
    history = xr.Dataset(
        {**data, "solver_iterations": solver_iterations}, {**coords, "iteration": whole["iteration"]}, history.attrs
    )
    result = bs.CaseResult(
        model=model,
        case=CASE,
        settings=bs.ProcedureSettings(),
        status=bs.Status.INTERRUPTED,
        load_factor=np.nan,
        certificate=None,
        message="made up",
        history=history,
        started_at="",
        duration=0.0,
    )
    path = folder / "large.h5"
    writing, _ = timed(lambda: bs.save_analysis(bs.Analysis(model, {"push": result}, "", {}), path))
    reading, found = timed(lambda: bs.open_analysis(path))
    same = found["push"].history.identical(history)
    raw, size = sum(v.nbytes for v in history.variables.values()), path.stat().st_size
    print(f"\n{iterations} iterations of {history.sizes['contact_point']} contact points, {len(model.blocks)} blocks")
    print(f"  write {writing:.2f} s, reload {reading:.2f} s with all checks and the model built, identical: {same}")
    print(f"  file {size / 1e6:.1f} MB, raw floats {raw / 1e6:.1f} MB: {size / raw:.3f}")
    with xr.open_dataset(path, group="/cases/push/history", engine="h5netcdf") as ds:
        variable, _ = timed(lambda: ds["contact_force"].load())
    print(f"  one variable (contact_force) {variable:.3f} s; peak memory {peak_memory():.2f} GB")


def table(folder: Path, files: int) -> None:
    model = model_of(6, 6)
    bs.AnalysisManager(model, folder / "0000.h5").run([CASE, replace(CASE, name="bound", flow="associative")])
    for k in range(1, files):
        shutil.copy(folder / "0000.h5", folder / f"{k:04d}.h5")
    archive = bs.Archive(folder)
    first, rows = timed(archive.table)
    again, _ = timed(archive.table)

    def one_value() -> float:
        tree = archive.history(rows[(rows["path"] == f"{files // 2:04d}.h5") & (rows["case"] == "push")])
        (node,) = tree.leaves
        return float(node["contact_force"].isel(iteration=3, contact_point=5, component=0))

    value, _ = timed(one_value)
    print(f"\n{files} files")
    print(f"  table {first:.1f} s (limit 20), again {again:.1f} s, {len(rows)} rows")
    print(f"  one contact force of one iteration of one case {value:.3f} s, its file checked")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--columns", type=int, default=40)
    parser.add_argument("--rows", type=int, default=60)
    parser.add_argument("--programs", type=int, default=120, help="programs of the run at most")
    parser.add_argument("--files", type=int, default=1000)
    size = parser.parse_args()
    for part, words in (
        (table, (size.files,)),
        (large_history, (50, 67, 30)),
        (recording, (size.columns, size.rows, size.programs)),
    ):
        with tempfile.TemporaryDirectory() as folder:
            part(Path(folder), *words)


if __name__ == "__main__":
    main()
