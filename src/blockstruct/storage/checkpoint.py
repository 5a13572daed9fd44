"""The working data of a run: what it commits while it goes on, beside the file that it will become."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import xarray as xr

from blockstruct.errors import FormatError, StorageError
from blockstruct.limit import Outcome
from blockstruct.model import Model
from blockstruct.results import CERTIFICATE_MEASURES, Analysis, CaseResult, capacity_of
from blockstruct.storage.analysis_file import AnalysisFile
from blockstruct.storage.claim import place_of, sync
from blockstruct.storage.journal import Journal, Record
from blockstruct.storage.lock import WriterLock, folder_of, named_instead
from blockstruct.storage.packing import packed, packed_dataset, unpacked, unpacked_dataset
from blockstruct.storage.reader import DAMAGE, Blank, read_analysis
from blockstruct.storage.snapshot import Stamp
from blockstruct.storage.unfinished import clear, is_unfinished, refuse_killed
from blockstruct.storage.writer import sealed_image, write_draft, write_file
from blockstruct.vocabulary import Reason, Status


class Checkpoint:
    """Working data of one run, held by one process.

    The folder ``NAME.partial`` holds ``plan``, an analysis file of every case as it was before the run, without the
    histories that are empty; ``target``, which tells what the file of that name was before the run; and, for each case
    that has begun, ``<case>.journal``: its history without iterations, each iteration, each step of a pushover, and how
    it has ended; and, where they are not those of the plan, the versions that make what follows. A record of a journal
    is sealed together with those before it and with the plan, so that a process killed at any moment
    leaves at most one that is half written, and none that is changed is read. Without ``plan`` the rest of the folder
    is rubbish: it is made last and removed first.

    Use :meth:`begin` or :meth:`reopen`, as a context.
    """

    def __init__(self, place: Path, lock: WriterLock, planned: Analysis, seal: str, replaced: Sequence[Stamp]) -> None:
        self.place, self.folder, self.planned = place, folder_of(place), planned
        self._lock, self._replaced = lock, tuple(replaced)
        self._journals = {name: Journal(self.folder / f"{k}.journal", f"{seal} {k}") for k, name in enumerate(planned)}
        self._committed = dict.fromkeys(planned, 0)
        self._steps = dict.fromkeys(planned, 0)
        self._versions = {name: (r.versions or (planned.versions,))[-1] for name, r in planned.items()}

    @classmethod
    def begin(cls, path: str | Path, planned: Analysis) -> Self:
        """Working data of a run that begins.

        Raises
        ------
        StorageError
            If another run writes to the path, or it holds the iterations of a killed one.
        """
        place = place_of(path)
        lock = WriterLock(place)
        try:
            refuse_killed(place)
            folder = folder_of(place)
            clear(folder)
            stamp = Stamp.at(place)
            replaced = () if stamp is None else (stamp,)
            _put(folder / "target", _target(replaced))
            image, seal = sealed_image(planned, folder / "plan", is_plan=True)
            _put(folder / "plan", image, seal)
        except BaseException:
            lock.release()
            raise
        return cls(place, lock, planned, seal.decode(), replaced)

    @classmethod
    def reopen(cls, path: str | Path, blank: Blank) -> Self:
        """Working data of a run that was killed.

        Parameters
        ----------
        path
            The file that the run would have written.
        blank
            Makes the history of a case that had not begun.

        Raises
        ------
        StorageError
            If there are no such data, or the run is still under way.
        FormatError
            If the plan of the run is damaged.
        """
        place = place_of(path)
        if not is_unfinished(place):
            kept = (
                "its run begins or has ended before it kept anything; wait, or run it again"
                if folder_of(place).is_dir()
                else "no run that writes to it was killed"
            )
            none = f"no working data, {folder_of(place)}: {kept}"
            msg = f"{path}: {f'is {found}' if (found := named_instead(Path(path))) else none}"
            raise StorageError(msg)
        lock = WriterLock(place)
        try:
            plan = AnalysisFile(folder_of(place) / "plan")
            return cls(place, lock, read_analysis(plan, blank), plan.seal, _aimed(folder_of(place) / "target"))
        except BaseException:
            lock.release()
            raise

    def start(self, case: str, history: xr.Dataset, versions: Mapping[str, str]) -> None:
        """Commit what the history of a case looks like, without iterations, and the versions that make them."""
        # Both are on the disk with the first iteration.
        if not self._journals[case].is_begun:
            self._append(case, "case", packed_dataset(history), wait=False)
        if versions != self._versions[case]:
            self._append(case, "versions", json.dumps(dict(versions), sort_keys=True).encode(), wait=False)
            self._versions[case] = versions

    def commit(self, case: str, index: int, iteration: Mapping[str, np.ndarray]) -> None:
        """Commit an iteration of a case: its arrays, and whether its certificate holds, ``holds``."""
        if index < self._committed[case]:
            return  # It is replayed.
        self._append(case, "iteration", packed(iteration))
        self._committed[case] += 1

    def commit_step(self, case: str, index: int, step: Mapping[str, np.ndarray]) -> None:
        """Commit a state of the pushover of a case: its arrays."""
        if index < self._steps[case]:
            return  # It is known already.
        self._append(case, "step", packed(step))
        self._steps[case] += 1

    def end(self, result: CaseResult) -> None:
        """Commit how a case has ended."""
        self._append(result.name, "end", json.dumps(_ending(result)).encode())

    def analysis(self) -> Analysis:
        """The analysis as far as it is committed; a case that has not ended is interrupted."""
        results = {name: self._result(result) for name, result in self.planned.items()}
        return self.planned.replaced(results=results)

    def finish(self, analysis: Analysis) -> None:
        """Write the finished file, then remove the working data."""
        write_file(analysis, self.place, self._replaced, self._tell)
        clear(self.folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()

    def _tell(self, draft: Stamp) -> None:
        """Note that the finished file is the run's own, before it takes the name: a kill may come just behind."""
        self._replaced = (*self._replaced, draft)
        _put(self.folder / "target", _target(self._replaced))

    def _append(self, case: str, kind: str, content: bytes, *, wait: bool = True) -> None:
        journal = self._journals[case]
        try:
            journal.append(kind, content, wait=wait)
        except OSError as error:
            go_on = f"AnalysisManager.resume({str(self.place)!r}), or blockstruct resume"
            if isinstance(error, FileNotFoundError | NotADirectoryError):
                remedy = f"its folder was moved or removed; move it back, then go on by {go_on}, or by it where it is"
            else:
                remedy = f"free some space, then go on by {go_on}"
            msg = f"{journal.path}: cannot be written ({error.strerror or error}); {remedy}"
            raise StorageError(msg) from error

    def _result(self, planned: CaseResult) -> CaseResult:
        if planned.status is not Status.INTERRUPTED:
            return planned
        journal, records = self._journals[planned.name], _Records()
        damage = journal.read(records.take)
        if damage:
            damage = f"{journal.path.name} {damage} in record {records.count}, which is left out with all after it"
        known = {-1: planned.versions[-1]} if planned.n_iterations else {0: self.planned.versions}
        made_by = (*planned.versions[:-1], *(known | records.versions).values())
        self._versions[planned.name] = made_by[-1]
        pieces = records.iterations
        self._committed[planned.name], self._steps[planned.name] = len(pieces), len(records.steps)
        n_steps = 0 if planned.capacity is None else planned.capacity.sizes["step"]
        if records.blank is None or len(pieces) < planned.n_iterations or len(records.steps) < n_steps:
            return planned.changed(damage=damage)
        if not pieces:
            return replace(planned, history=records.blank, damage=damage)
        history = _joined(records.blank, pieces)
        last = {name: float(history[name][-1]) for name in CERTIFICATE_MEASURES if name != "holds"}
        found: dict[str, Any] = {
            "outcome": asdict(Outcome(Status.INTERRUPTED, np.nan, Reason.KILLED)),
            "damage": damage,
            "certificate": {**last, "holds": bool(pieces[-1]["holds"][0])},
            "started_at": planned.started_at,
            "duration": float(history["solver_time"].sum()),
        }
        settings, ending = asdict(planned.settings), dict(records.ending or found)
        try:
            return CaseResult.restored(
                model=planned.model,
                case=planned.case,
                settings=settings,
                history=history,
                capacity=_capacity(planned.model, records.steps, ending.get("curve_ended", "")),
                schedule=planned.schedule,
                of_case=planned.of_case,
                versions=made_by,
                **ending | {"outcome": Outcome.of(ending["outcome"])},
            )
        except DAMAGE as error:
            msg = f"{journal.path}: {error}; delete it, the case then counts as interrupted"
            raise FormatError(msg) from error


class _Records:
    """What the journal of a case holds."""

    def __init__(self) -> None:
        self.blank: xr.Dataset | None = None
        self.iterations: list[dict[str, np.ndarray]] = []
        self.steps: list[dict[str, np.ndarray]] = []
        self.ending: dict[str, Any] | None = None
        # By how much of the case was there before what they made.
        self.versions: dict[int, dict[str, str]] = {}
        self.count = 0

    def take(self, record: Record) -> None:
        """Take the next record; a ValueError tells what is wrong with it."""
        match record.kind:
            case "case" if self.blank is None:
                self.blank = unpacked_dataset(record.content)
            case "versions" if self.blank is not None and self.ending is None:
                self.versions[len(self.iterations) + len(self.steps)] = json.loads(record.content)
            case "iteration" if self.blank is not None and self.ending is None and not self.steps:
                self.iterations.append(_arrays(unpacked(record.content), self.blank, len(self.iterations)))
            case "step" if self.blank is not None and self.iterations and self.ending is None:
                self.steps.append(unpacked(record.content))
            case "end" if self.blank is not None and self.ending is None:
                self.ending = json.loads(record.content)
            case _:
                msg = f"{record.kind!r} is not what follows"
                raise ValueError(msg)
        self.count += 1


def _arrays(iteration: Mapping[str, np.ndarray], blank: xr.Dataset, index: int) -> dict[str, np.ndarray]:
    """Arrays of an iteration, of the kinds and shapes that the history of the case has."""
    arrays = {}
    expected = {str(name): v for name, v in blank.variables.items() if "iteration" in v.dims}
    for name in (*expected, "holds"):
        dims = expected[name].dims if name in expected else ("iteration",)
        shape = tuple(1 if d == "iteration" else blank.sizes[d] for d in dims)
        if name not in iteration:
            msg = f"{name} is missing"
            raise ValueError(msg)
        values = iteration[name]
        if values.shape != shape or (values.dtype.kind in "OU") != (name in expected and _is_text(expected[name])):
            msg = f"{name} is {values.dtype} {values.shape}, not of shape {shape}"
            raise ValueError(msg)
        arrays[name] = np.array([index]) if name == "iteration" else values
    return arrays


def _capacity(model: Model, steps: list[dict[str, np.ndarray]], ended: str) -> xr.Dataset | None:
    """Capacity curve of the steps of a case, and how it ended; None without any."""
    if not steps:
        return None
    return capacity_of(model, {name: np.concatenate([s[name] for s in steps]) for name in steps[0]}, ended)


def _is_text(variable: xr.Variable) -> bool:
    return variable.dtype.kind in "OU"


def _joined(blank: xr.Dataset, pieces: list[dict[str, np.ndarray]]) -> xr.Dataset:
    """History of the iterations of a case."""

    def variable(name: str, old: xr.Variable) -> xr.Variable:
        if "iteration" not in old.dims:
            return old
        return xr.Variable(old.dims, np.concatenate([piece[name] for piece in pieces]), old.attrs)

    data = {str(n): variable(str(n), blank.variables[n]) for n in blank.data_vars}
    coords = {str(n): variable(str(n), blank.variables[n]) for n in blank.coords}
    return xr.Dataset(data, coords=coords, attrs=blank.attrs)


def _ending(result: CaseResult) -> dict[str, Any]:
    return {
        "outcome": asdict(result.outcome),
        "certificate": result.certificate.measures if result.certificate else {},
        "started_at": result.started_at,
        "duration": result.duration,
        "curve_ended": result.curve_ended,
    }


def _put(path: Path, *parts: bytes | memoryview) -> None:
    """Write a file of the working data by a rename, and wait until its name is on the disk."""
    draft = path.with_name(f"{path.name}.draft")
    write_draft(parts, draft)
    try:
        draft.replace(path)
        sync(path.parent)
    except OSError as error:
        msg = f"{path}: cannot be written ({error.strerror or error}); choose another folder"
        raise StorageError(msg) from error


def _target(replaced: Sequence[Stamp]) -> bytes:
    return json.dumps({"replaces": replaced}).encode()


def _aimed(path: Path) -> list[Stamp]:
    """What a run may replace; nothing if that cannot be read."""
    try:
        return [Stamp(*map(int, stamp)) for stamp in json.loads(path.read_bytes())["replaces"]]
    except (*DAMAGE, OSError):
        return []
