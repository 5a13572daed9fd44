"""Cost of the archive: committing while a run goes on, writing, reloading, tables and single values.

Prints what a store costs a run on 6 blocks, what a case more costs a file, the share of a run on a wall of 2,400 blocks
that recording takes, the time to open 24 cases of 300 MB, to write and reload a history of 30 iterations of 40,000
contact points, its size against raw floats, the time of a table over 1,000 files and of one value among them. Seconds
are those of the processor where it says so, which other work on the machine changes little. Run it with ``make bench``.
"""

import argparse
import hashlib
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
import xarray as xr
from wall_40x60 import peak_memory, wall

import blockstruct as bs
from blockstruct.analysis.manager import Recorder
from blockstruct.limit import LimitProblem, Outcome
from blockstruct.results import history_of
from blockstruct.statics.statics import Statics
from blockstruct.storage import Checkpoint, save_image
from blockstruct.storage.file import sealed_image

PUSH = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
CASE = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), PUSH)


def timed(step: Callable[[], Any]) -> tuple[float, Any]:
    start = perf_counter()
    value = step()
    return perf_counter() - start, value


def worked(step: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of the processor."""
    start = process_time()
    value = step()
    return process_time() - start, value


def six_blocks(folder: Path, repeats: int) -> None:
    """What a store adds to a short run: seconds of both, the least of several, for other work only adds to them."""
    model = model_of(3, 2)
    cases = [CASE, CASE.renamed("bound", bs.Flow.ASSOCIATIVE)]
    bs.AnalysisManager(model, folder / "first.h5").run(cases)
    plain = min(timed(lambda: bs.AnalysisManager(model).run(cases))[0] for _ in range(repeats))
    stored = min(timed(lambda k=k: bs.AnalysisManager(model, folder / f"{k}.h5").run(cases))[0] for k in range(repeats))
    print(f"{len(model.blocks)} blocks, {len(cases)} cases")
    print(f"  run {plain:.3f} s, with a store {stored:.3f} s: {stored - plain:.3f} s more (limit 0.2)")


def many_cases(folder: Path, cases: int) -> None:
    """What a case more costs a file."""
    model = model_of(1, 1)
    one = bs.AnalysisManager(model).run([CASE])
    result = one["push"]

    def several(n: int) -> bs.Analysis:
        named = {f"{k}": replace(result, case=CASE.renamed(f"{k}")) for k in range(n)}
        return one.replaced(results=named)

    print(f"\ncases of {len(model.blocks)} blocks, {result.n_iterations} iterations")
    for n in (cases // 4, cases):
        analysis, path = several(n), folder / f"{n}.h5"
        saving, _ = worked(lambda a=analysis, p=path: bs.save_analysis(a, p))
        opening, found = worked(lambda p=path: bs.open_analysis(p))
        reading, _ = worked(lambda f=found: [r.history for r in f.values()])
        each = [f"{1e3 * seconds / n:.1f} ms" for seconds in (saving, opening, reading)]
        print(f"  {n:4d} cases, processor: save {each[0]} a case (limit 20), open {each[1]}, histories {each[2]}")


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

    @contextmanager
    def begun(cls: type, *words: Any) -> Iterator[Any]:
        with ExitStack() as stack:
            seconds, value = timed(lambda: stack.enter_context(begin(cls, *words)))
            spent["plan"] += seconds
            yield value

    Checkpoint.begin = classmethod(begun)  # type: ignore[assignment,method-assign]
    clocked(Recorder, "__call__", "iterations")
    clocked(Checkpoint, "finish", "finished file")
    settings = bs.ProcedureSettings(schedule=bs.FictitiousSchedule(max_programs=programs))
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


def made_up(model: bs.Model, iterations: int) -> bs.CaseResult:
    """An interrupted case with a history of random numbers."""
    statics = Statics.of(model)
    history = history_of(statics, LimitProblem.of(statics, CASE), [])
    chance = np.random.default_rng(0)

    def filled(name: str, variable: xr.Variable) -> xr.Variable:
        if "iteration" not in variable.dims:
            return variable
        shape = (iterations, *variable.shape[1:])
        if name in ("iteration", "solver_iterations"):
            values: Any = np.arange(iterations)
        elif variable.dtype.kind == "f":
            values = chance.normal(size=shape)
        else:
            values = np.full(shape, "associative" if name == "stage" else "solved", dtype=object)
        return xr.Variable(variable.dims, values, variable.attrs)

    data = {str(n): filled(str(n), v.variable) for n, v in history.data_vars.items()}
    coords = {str(n): filled(str(n), v.variable) for n, v in history.coords.items()}
    return bs.CaseResult(
        model=model,
        case=CASE,
        settings=bs.ProcedureSettings(),
        outcome=Outcome(bs.Status.INTERRUPTED, np.nan, bs.vocabulary.Reason.NOT_BEGUN),
        certificate=None,
        history=xr.Dataset(data, coords, history.attrs),
        started_at="",
        duration=0.0,
    )


def written(model: bs.Model, results: dict[str, bs.CaseResult], path: Path) -> None:
    """Write an analysis whose numbers are made up, which save_analysis would refuse."""
    save_image(b"".join(sealed_image(bs.Analysis(model, results, "", {}), path)), path)


def opening(folder: Path, columns: int, rows: int, iterations: int, cases: int) -> None:
    """A file of many large cases: nothing of a history is read until it is looked at."""
    model, path = model_of(columns, rows), folder / "cases.h5"
    result = made_up(model, iterations)
    named = {f"{k}": replace(result, case=CASE.renamed(f"{k}")) for k in range(cases)}
    written(model, named, path)
    read, _ = worked(path.read_bytes)
    hashed, _ = worked(lambda: hashlib.sha256(path.read_bytes()))
    elapsed, _ = timed(lambda: bs.open_analysis(path))
    seconds, found = worked(lambda: bs.open_analysis(path))
    first, _ = worked(lambda: found["0"].history)
    checked, _ = worked(lambda: bs.check_file(path))
    print(f"\n{cases} cases, {path.stat().st_size / 1e6:.0f} MB, {len(model.blocks)} blocks; processor:")
    print(f"  read {read:.2f} s, hash {hashed - read:.2f} s, open {seconds:.2f} s (limit 1; {elapsed:.2f} s in all)")
    print(f"  the history of a case {first:.3f} s, everything checked {checked:.2f} s")


def large_history(folder: Path, columns: int, rows: int, iterations: int) -> None:
    model, path = model_of(columns, rows), folder / "large.h5"
    result = made_up(model, iterations)
    history = result.history
    writing, _ = timed(lambda: written(model, {"push": result}, path))
    reading, found = timed(lambda: bs.open_analysis(path))
    looking, _ = timed(lambda: found["push"].history)
    same = found["push"].history.identical(history)
    raw, size = sum(v.nbytes for v in history.variables.values()), path.stat().st_size
    print(f"\n{iterations} iterations of {history.sizes['contact_point']} contact points, {len(model.blocks)} blocks")
    print(f"  write {writing:.2f} s, open {reading:.2f} s, its history {looking:.2f} s, identical: {same}")
    print(f"  file {size / 1e6:.1f} MB, raw floats {raw / 1e6:.1f} MB: {size / raw:.3f}")
    with xr.open_dataset(path, group="/cases/push/history", engine="h5netcdf") as ds:
        variable, _ = timed(lambda: ds["contact_force"].load())
    print(f"  one variable (contact_force) {variable:.3f} s; peak memory {peak_memory():.2f} GB")


def table(folder: Path, files: int) -> None:
    model = model_of(6, 6)
    bs.AnalysisManager(model, folder / "0000.h5").run([CASE, CASE.renamed("bound", bs.Flow.ASSOCIATIVE)])
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
    parser.add_argument("--cases", type=int, default=24)
    size = parser.parse_args()
    for part, words in (
        (six_blocks, (5,)),
        (many_cases, (size.cases,)),
        (opening, (size.columns // 2, size.rows // 3, 30, size.cases)),
        (table, (size.files,)),
        (large_history, (size.columns + 10, size.rows + 7, 30)),
        (recording, (size.columns, size.rows, size.programs)),
    ):
        with tempfile.TemporaryDirectory() as folder:
            part(Path(folder), *words)


if __name__ == "__main__":
    main()
