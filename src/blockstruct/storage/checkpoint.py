"""The working data of a run: what it commits while it goes on, beside the file that it will become."""

import contextlib
import json
import os
import zipfile
from dataclasses import asdict, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import xarray as xr

from blockstruct.errors import FormatError, StorageError
from blockstruct.results import CERTIFICATE_MEASURES, Analysis, CaseResult
from blockstruct.storage.lock import WriterLock, folder_of
from blockstruct.storage.reader import DAMAGE, open_analysis
from blockstruct.storage.writer import sync, write_file
from blockstruct.vocabulary import Status

#: What a damaged file of an iteration can make of its reader.
_DAMAGED = (*DAMAGE, OSError, EOFError, MemoryError, zipfile.BadZipFile)


def is_unfinished(path: str | Path) -> bool:
    """Whether a run that writes to a path is under way, or was killed."""
    return (folder_of(Path(path)) / "plan").is_file()


class Checkpoint:
    """Working data of one run, held by one process.

    The folder ``NAME.partial`` holds ``plan``, an analysis file of every case as it was before the run (interrupted,
    as a rule without iterations), ``<case>.<iteration>.npz`` for each iteration of the run and ``<case>.json`` for each
    case that has ended. Each file is put in place by a rename, so that a process killed at any moment leaves none that
    is half written. Without ``plan`` the rest of the folder is rubbish: it is made last and removed first.

    Use :meth:`begin` or :meth:`reopen`, as a context.
    """

    def __init__(self, path: Path, lock: WriterLock, planned: Analysis) -> None:
        self.path, self.folder, self.planned = path, folder_of(path), planned
        self._lock = lock
        self._number = {name: k for k, name in enumerate(planned)}

    @classmethod
    def begin(cls, path: Path, planned: Analysis) -> Self:
        """Working data of a run that begins.

        Raises
        ------
        StorageError
            A path that another run writes to, or that holds the iterations of a killed one.
        """
        folder = folder_of(path)
        lock = WriterLock(path)
        try:
            if is_unfinished(path) and any(folder.glob("*.npz")):
                msg = (
                    f"{path}: {folder} holds the iterations of a run that was killed; go on with it by "
                    f"AnalysisManager.resume, keep what it found by recover, or delete the folder"
                )
                raise StorageError(msg)
            _clear(folder)
            write_file(planned, folder / "plan")
        except BaseException:
            lock.release()
            raise
        return cls(path, lock, planned)

    @classmethod
    def reopen(cls, path: str | Path) -> Self:
        """Working data of a run that was killed.

        Raises
        ------
        StorageError
            No such data, or a run that is still under way.
        FormatError
            Data whose plan is damaged.
        """
        path = Path(path)
        if not is_unfinished(path):
            msg = f"{path}: no working data, {folder_of(path)}: no run that writes to it was killed"
            raise StorageError(msg)
        lock = WriterLock(path)
        try:
            return cls(path, lock, open_analysis(folder_of(path) / "plan"))
        except BaseException:
            lock.release()
            raise

    def commit(self, case: str, index: int, iteration: xr.Dataset) -> None:
        """Commit an iteration of a case: its variables, and whether its certificate holds, ``holds``."""
        arrays: dict[str, Any] = {
            str(name): v.to_numpy().astype("U") if v.dtype.kind == "O" else v.to_numpy()
            for name, v in iteration.variables.items()
            if "iteration" in v.dims
        }
        self._put(f"{self._number[case]}.{index}.npz", lambda stream: np.savez(stream, **arrays))

    def end(self, result: CaseResult) -> None:
        """Commit how a case has ended."""
        text = json.dumps(_ending(result))
        self._put(f"{self._number[result.name]}.json", lambda stream: stream.write(text.encode()))

    def analysis(self) -> Analysis:
        """The analysis as far as it is committed; a case that has not ended is interrupted."""
        results = {name: self._result(result) for name, result in self.planned.items()}
        return self.planned.replaced(results=results)

    def finish(self, analysis: Analysis) -> None:
        """Write the finished file, then remove the working data."""
        write_file(analysis, self.path)
        _clear(self.folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()

    def _put(self, name: str, write: Any) -> None:
        draft = self.folder / f"{name}.draft"
        try:
            with draft.open("wb") as stream:
                write(stream)
                stream.flush()
                os.fsync(stream.fileno())
            draft.replace(self.folder / name)
            sync(self.folder)
        except OSError as error:
            msg = (
                f"{self.folder / name}: cannot be written ({error.strerror or error}); free some space, then go on by "
                f"AnalysisManager.resume({str(self.path)!r})"
            )
            raise StorageError(msg) from error

    def _result(self, planned: CaseResult) -> CaseResult:
        if planned.status is not Status.INTERRUPTED:
            return planned
        number = self._number[planned.name]
        pieces: list[dict[str, np.ndarray]] = []
        damage = ""
        while (file := self.folder / f"{number}.{len(pieces)}.npz").is_file():
            try:
                pieces.append(_iteration(file, planned.history))
            except _DAMAGED as error:
                damage = f"; {file.name} is damaged ({error}), it and what follows is left out"
                break
        if len(pieces) < planned.n_iterations:
            return planned
        if not pieces:
            return replace(planned, message=f"interrupted before its first program was solved{damage}")
        history = _joined(planned.history, pieces)
        last = {name: float(history[name][-1]) for name in CERTIFICATE_MEASURES if name != "holds"}
        found: dict[str, Any] = {
            "status": Status.INTERRUPTED.value,
            "load_factor": np.nan,
            "message": f"interrupted: the run was killed after {len(pieces)} iterations{damage}",
            "certificate": {**last, "holds": bool(pieces[-1]["holds"][0])},
            "started_at": planned.started_at,
            "duration": float(history["solver_time"].sum()),
        }
        ending = self.folder / f"{number}.json"
        if not damage and ending.is_file():
            with contextlib.suppress(*_DAMAGED):
                found = json.loads(ending.read_text(encoding="utf-8"))
        try:
            return CaseResult.restored(
                model=planned.model, case=planned.case, settings=asdict(planned.settings), history=history, **found
            )
        except DAMAGE as error:
            msg = f"{ending}: {error}; delete it, the case then counts as interrupted"
            raise FormatError(msg) from error


def recover(path: str | Path) -> Analysis:
    """Make the analysis file of a run that was killed, with every iteration that it committed.

    Cases that had not ended get the status ``interrupted``. :meth:`blockstruct.AnalysisManager.resume` goes on with
    either, the killed run or the recovered file.

    Parameters
    ----------
    path
        The file that the run would have written. An analysis of that name is replaced, as the run would have done.

    Raises
    ------
    StorageError
        No killed run, one that is still under way, or a path that cannot be written.
    FormatError
        Working data that are damaged at their root.
    """
    with Checkpoint.reopen(path) as working:
        analysis = working.analysis()
        working.finish(analysis)
    return analysis


def _ending(result: CaseResult) -> dict[str, Any]:
    return {
        "status": result.status.value,
        "load_factor": result.load_factor,
        "message": result.message,
        "certificate": asdict(result.certificate) if result.certificate else {},
        "started_at": result.started_at,
        "duration": result.duration,
    }


def _iteration(file: Path, history: xr.Dataset) -> dict[str, np.ndarray]:
    """Arrays of an iteration, each checked against its kind and shape in a history before it is read."""
    expected = {str(name): v for name, v in history.variables.items() if "iteration" in v.dims}
    arrays = {}
    with file.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
        for name in (*expected, "holds"):
            dims = expected[name].dims if name in expected else ("iteration",)
            shape = tuple(1 if d == "iteration" else history.sizes[d] for d in dims)
            size = stored.zip.getinfo(f"{name}.npy").file_size
            if size > 8 * int(np.prod(shape)) + 4096:
                msg = f"{name} is of an absurd size, {size} bytes"
                raise FormatError(msg)
            array = stored[name]
            kind = "U" if name in expected and expected[name].dtype.kind in "OU" else None
            if array.shape != shape or (array.dtype.kind == "U") != (kind == "U"):
                msg = f"{name} is {array.dtype} {array.shape}, not of shape {shape}"
                raise FormatError(msg)
            arrays[name] = array.astype(object) if kind else array
    return arrays


def _joined(history: xr.Dataset, pieces: list[dict[str, np.ndarray]]) -> xr.Dataset:
    """History of the iterations, with everything else of another history of the same case."""

    def variable(name: str, old: xr.Variable) -> xr.Variable:
        if "iteration" not in old.dims:
            return old
        values = np.concatenate([piece[name] for piece in pieces])
        return xr.Variable(old.dims, np.arange(len(pieces)) if name == "iteration" else values, old.attrs)

    data = {str(n): variable(str(n), history.variables[n]) for n in history.data_vars}
    coords = {str(n): variable(str(n), history.variables[n]) for n in history.coords}
    return xr.Dataset(data, coords=coords, attrs=history.attrs)


def _clear(folder: Path) -> None:
    """Remove working data: the plan first, without which the rest counts for nothing."""
    try:
        (folder / "plan").unlink(missing_ok=True)
        for file in folder.iterdir():
            if file.name != "lock":
                file.unlink()
    except OSError as error:
        msg = f"{folder}: cannot be emptied ({error.strerror}); delete it"
        raise StorageError(msg) from error
