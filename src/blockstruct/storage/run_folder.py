"""Write a file: its name and lock, and the folder next to it that keeps the working data of a run.

The folder ``NAME.partial`` holds ``lock``; ``plan``, an analysis file of every case as it was before the run;
``target``, the stamps of the files that the run may replace and of the file that it has made; and ``<k>.journal`` for
the case with index k once it has begun. The plan is made last and removed first: without it the rest counts for
nothing. The run has ended once the file that it has made has its name.
"""

import contextlib
import errno
import hashlib
import json
import os
import platform
import re
import stat
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic
from typing import IO, Any, NamedTuple, Self

import numpy as np
import xarray as xr

from blockstruct.errors import BusyError, FormatError, StorageError, shown
from blockstruct.files import MOST_READ, open_file, read_file, writing
from blockstruct.limit import Outcome
from blockstruct.model import RecordCase
from blockstruct.motion.state import CurveOutcome
from blockstruct.results import CERTIFICATE_MEASURES
from blockstruct.results.analysis import Analysis
from blockstruct.results.capacity import capacity_of, response_of
from blockstruct.results.case_result import CaseResult
from blockstruct.results.verification import confirm
from blockstruct.storage.file import (
    DAMAGE,
    AnalysisFile,
    Snapshot,
    Stamp,
    folder_of,
    named_instead,
    open_analysis,
    read_analysis,
    sealed_image,
)
from blockstruct.vocabulary import Reason, Status

if sys.platform == "win32":
    import msvcrt

    def _take(stream: IO[bytes]) -> None:
        # Far after the text: Windows lets nobody read a locked byte.
        os.lseek(stream.fileno(), 1 << 20, os.SEEK_SET)
        msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        stream.seek(0)
else:
    import fcntl

    def _take(stream: IO[bytes]) -> None:
        fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)


SUFFIX = ".h5"
#: Seconds between two waits for the disk: the most work that a power cut can take.
FLUSHED = 1.0
#: Errors of a lock that somebody else holds; any other error means a file system without locks.
_HELD = (errno.EACCES, errno.EAGAIN, errno.EWOULDBLOCK, errno.EDEADLK)
_LINE = re.compile(rb"(blockstruct record ([a-z]{1,20}) ([0-9]{1,15}) )([0-9a-f]{64})\n")


def place_of(path: str | Path) -> Path:
    """Return the absolute path of a file, with all symbolic links resolved.

    Raises
    ------
    StorageError
        If the text cannot be a path, or the working folder that it is relative to is gone.
    """
    try:
        return Path(os.path.realpath(path))
    except FileNotFoundError as error:
        msg = f"{path}: the working folder has been deleted; change to another one, or give an absolute path"
        raise StorageError(msg) from error
    except (TypeError, ValueError, OSError) as error:
        msg = f"{shown(path)}: is not a path ({error}); give that of a file, such as 'analysis.h5'"
        raise StorageError(msg) from error


def claim(path: str | Path) -> Path:
    """Check, before any work is done, that a file can be written at a path; make its folder if it is missing.

    Returns
    -------
    pathlib.Path
        Absolute, with all symbolic links resolved.

    Raises
    ------
    StorageError
        If the name does not end in ``.h5`` or is too long, or the path holds something other than an intact analysis,
        or is in a folder that cannot be made or written to.
    """
    place = place_of(path)
    try:
        with writing(place, "choose a folder you can write to"):
            _check_holder(place)
            if place.suffix != SUFFIX:
                msg = f"{path}: the name of an analysis ends in {SUFFIX}, as an Archive wants; write {path}{SUFFIX}"
                raise StorageError(msg)
            place.parent.mkdir(parents=True, exist_ok=True)
            _try_folder(place)
    except StorageError as error:
        if getattr(error.__cause__, "errno", None) != errno.ENAMETOOLONG:
            raise
        msg = f"{place}: the name is too long, with {len(folder_of(place).name)} characters; choose a shorter one"
        raise StorageError(msg) from error
    return place


def _check_holder(place: Path) -> None:
    """Refuse a path whose holder must not be replaced."""
    try:
        mode = place.stat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISDIR(mode):
        msg = f"{place}: is a folder; give the path of a file, such as {place / 'analysis.h5'}"
        raise StorageError(msg)
    if not stat.S_ISREG(mode) or not Snapshot(place).sealed:
        what = "exists and is not a blockstruct analysis, or a damaged one"
        msg = f"{place}: {what}, so it is not replaced; choose another name"
        raise StorageError(msg)


def _try_folder(place: Path) -> None:
    """Make and remove the folder of the working data, whose name is the longest of all that are needed."""
    folder = folder_of(place)
    try:
        folder.mkdir()
    except FileExistsError as error:
        if _is_file(folder):
            raise _in_the_way(place) from error
        # Another writer may remove the folder meanwhile.
        if not os.access(folder, os.W_OK | os.X_OK) and folder.exists():
            raise
    else:
        with contextlib.suppress(OSError):  # Another writer may have taken the folder.
            folder.rmdir()


def _is_file(folder: Path) -> bool:
    """Return whether something other than a folder is at a path; a folder may come and go at any moment."""
    try:
        return not stat.S_ISDIR(folder.stat().st_mode)
    except FileNotFoundError:
        return folder.is_symlink()


def _in_the_way(path: Path) -> StorageError:
    folder = folder_of(path)
    return StorageError(
        f"{folder}: is a file, and {path.name} needs a folder of this name for the working data of its run; move that "
        "file away, or choose another name"
    )


@contextlib.contextmanager
def writer_lock(path: Path) -> Iterator[None]:
    """Hold the right to write a file, in a context, or to the end of the process, however it ends.

    Parameters
    ----------
    path
        The file; its folder is made if it is missing.

    Raises
    ------
    BusyError
        If another writer, named in the message, holds the file.
    StorageError
        If the file system has no locks.
    """
    lock = folder_of(path) / "lock"
    while True:
        stream = _opened(lock, path)
        try:
            _take(stream)
        except OSError as error:
            stream.seek(0)
            holder = stream.read().decode(errors="replace").strip() or f"another process ({error.strerror})"
            stream.close()
            if error.errno in _HELD:
                msg = f"{path}: is being written by {holder}; wait until it has ended, or choose another name"
                raise BusyError(msg) from error
            msg = (
                f"{path}: its file system has no locks ({error.strerror}), so two runs could write to one "
                "file; choose a folder on a local disk, and copy the file when it is finished"
            )
            raise StorageError(msg) from error
        with contextlib.suppress(FileNotFoundError):
            # The last holder may have removed the file between the two lines above.
            if os.path.samestat(os.fstat(stream.fileno()), lock.stat()):
                break
        stream.close()
    now = datetime.now(UTC).isoformat(timespec="seconds")
    with contextlib.suppress(OSError):  # A lock on a full disk does not name its holder.
        stream.truncate(0)
        stream.write(f"process {os.getpid()} on {platform.node()} since {now}\n".encode())
    try:
        yield
    finally:
        with contextlib.suppress(OSError):  # Another writer may be quicker than these lines.
            if [file.name for file in lock.parent.iterdir()] == ["lock"]:
                if sys.platform == "win32":
                    stream.close()  # Windows removes no open file, nor one that another writer has opened since.
                lock.unlink()
                lock.parent.rmdir()
        stream.close()


def _opened(lock: Path, path: Path) -> IO[bytes]:
    """Return the file of a lock, made with its folder if it is missing; other writers remove both when they end."""
    with writing(path, "choose a folder you can write to"):
        while True:
            with contextlib.suppress(FileExistsError):
                lock.parent.mkdir(parents=True, exist_ok=True)
            if _is_file(lock.parent):
                raise _in_the_way(path)
            if lock.is_symlink() and not lock.exists():
                msg = f"{lock}: cannot be made (a link that leads nowhere); remove it, or choose another name"
                raise StorageError(msg)
            with contextlib.suppress(FileNotFoundError):
                return lock.open("a+b", buffering=0)


def is_unfinished(path: str | Path) -> bool:
    """Return whether a run that writes to a path is under way, or was killed.

    Raises
    ------
    StorageError
        If the folder cannot be looked into.
    """
    place = place_of(path)
    # The plan is removed before the target.
    made = Target.read(folder_of(place)).made
    return _has_plan(folder_of(place)) and (made is None or made != Stamp.at(place))


def _has_plan(folder: Path) -> bool:
    try:
        return (folder / "plan").is_file()
    except OSError as error:
        msg = f"{folder}: cannot be looked into ({error.strerror}); ask its owner for the right to read it"
        raise StorageError(msg) from error


def planned_analysis(path: str | Path) -> Analysis | None:
    """Return the analysis that a path holds; None if it holds nothing.

    Of a run that is under way or was killed it is the analysis as planned, without histories.
    """
    if is_unfinished(path):
        try:
            return read_analysis(AnalysisFile(folder_of(place_of(path)) / "plan"))
        except StorageError:
            if is_unfinished(path):
                raise
    return open_analysis(path) if Path(path).exists() else None


def tidy(path: str | Path) -> None:
    """Remove the rest of working data that a killed run was removing, if nobody writes."""
    place = place_of(path)
    with contextlib.suppress(StorageError, OSError):
        if folder_of(place).is_dir() and not is_unfinished(place):
            with writer_lock(place):
                clear(folder_of(place))


def clear(folder: Path) -> None:
    """Remove working data, the plan first."""
    try:
        (folder / "plan").unlink(missing_ok=True)
        for file in folder.iterdir():
            if file.name != "lock":
                file.unlink()
    except OSError as error:
        msg = f"{folder}: cannot be emptied ({error.strerror}); delete it"
        raise StorageError(msg) from error


def _refuse_killed(place: Path) -> None:
    """Refuse a path for which a killed run has iterations, which would be lost or mixed up with others."""
    folder = folder_of(place)
    if is_unfinished(place) and any(folder.glob("*.journal")):
        msg = (
            f"{place}: {folder} holds the iterations of a run that was killed; go on with it by AnalysisManager.resume "
            "(blockstruct resume), keep what it found by recover (blockstruct recover), or delete the folder"
        )
        raise StorageError(msg)


def save_analysis(analysis: Analysis, path: str | Path) -> Path:
    """Write an analysis to one file in one step: readers see the old file or the whole new one.

    Parameters
    ----------
    analysis
        Model and results.
    path
        The name ends in ``.h5``. An existing analysis is replaced, any other existing file is refused.

    Returns
    -------
    pathlib.Path
        Absolute, with all symbolic links resolved.

    Raises
    ------
    StorageError
        If the path cannot be written, another process is writing it, or a killed run has iterations for it.
    ModelError
        If load patterns of the cases share a name but not their loads.
    FormatError
        If results contradict each other.
    CertificateError
        If results contradict their own forces and velocities: :func:`blockstruct.results.contradictions`.
    """
    place = claim(path)
    confirm(analysis)
    with writer_lock(place):
        _refuse_killed(place)
        clear(folder_of(place))
        _write(sealed_image(analysis, place), place, Target.at(place))
    return place


def save_image(image: bytes, path: str | Path) -> Path:
    """Write the bytes of an analysis file that was made elsewhere.

    Unlike :func:`save_analysis` it discards the iterations of a killed run at this path: the new file is complete.

    Raises
    ------
    StorageError
        If the path cannot be written, or another process is writing it.
    """
    place = claim(path)
    with writer_lock(place):
        clear(folder_of(place))
        _write([image], place, Target.at(place))
    return place


class Target(NamedTuple):
    """Stamps of the files that a run may replace, and of the file that it has made."""

    replaces: tuple[Stamp, ...] = ()
    made: Stamp | None = None

    @classmethod
    def at(cls, place: Path) -> Self:
        """Return the target of a new file at a path: it replaces the file that is there."""
        present = Stamp.at(place)
        return cls(() if present is None else (present,))

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Return the target of the run of a folder; empty if it cannot be read."""
        try:
            stored = json.loads(read_file(folder / "target", "a record of the files a run replaces", MOST_READ))
            replaces = tuple(Stamp(*map(int, stamp)) for stamp in stored["replaces"])
            return cls(replaces, replaces[-1] if stored.get("is_made") else None)
        except (*DAMAGE, OSError):
            return cls()

    def write(self, folder: Path) -> None:
        """Keep the target in the folder of its run."""
        _put(folder / "target", json.dumps({"replaces": self.replaces, "is_made": self.made is not None}).encode())

    def check(self, place: Path, present: Stamp | None) -> None:
        """Refuse to replace a file that was not there when the run began."""
        if present is not None and present not in self.replaces:
            msg = f"{place}: another file has appeared at this name, and is not replaced; move it away, then try again"
            raise StorageError(msg)


@contextlib.contextmanager
def _keeping(path: Path, remedy: str) -> Iterator[None]:
    """Turn an error of the system while working data are written into a StorageError with a remedy."""
    try:
        yield
    except OSError as error:
        moved = isinstance(error, FileNotFoundError | NotADirectoryError)
        first = "its folder was moved or removed; move it back" if moved else "free some space"
        msg = f"{path}: cannot be written ({error.strerror or error}); {first}, {remedy}"
        raise StorageError(msg) from error


@contextlib.contextmanager
def _draft(parts: Iterable[bytes | memoryview], draft: Path, path: Path) -> Iterator[None]:
    """Write bytes to a draft of a file, wait until they are on the disk, and remove it unless it gets another name."""
    try:
        with _keeping(draft, "or choose another folder"):
            # Whatever stands there, a pipe too, is the rest of a killed run.
            draft.unlink(missing_ok=True)
            with draft.open("xb") as stream:
                stream.writelines(parts)
                stream.flush()
                os.fsync(stream.fileno())
        with writing(path, "choose another folder"):
            yield
            sync(path.parent)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


def _put(path: Path, *parts: bytes | memoryview) -> None:
    """Write a file of the working data by a rename, and wait until its name is on the disk."""
    draft = path.with_name(f"{path.name}.draft")
    with _draft(parts, draft, path):
        draft.replace(path)


def _write(parts: Iterable[bytes | memoryview], place: Path, target: Target, *, note: bool = False) -> None:
    """Write a file to a claimed and locked place, and replace nothing but the files of a target.

    If wanted, a note of the file is made before it takes its name: a kill may come just after.
    """
    folder = folder_of(place)
    draft = folder / "draft"
    with _draft(parts, draft, place):
        if note:
            made = Stamp.of(draft.stat())
            Target((*target.replaces, made), made).write(folder)
        while (present := Stamp.at(place)) is None:
            try:
                # Unlike a rename, this fails if a file appears between the line above and this one.
                os.link(draft, place)
            except FileExistsError:
                continue
            except OSError:  # A file system without hard links.
                break
            return
        target.check(place, present)
        draft.replace(place)


def sync(folder: Path) -> None:
    """Wait until the names in a folder are on the disk."""
    if os.name == "nt":
        return  # Windows opens no folders.
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


#: Errors of a record that is not as it was written.
_UNREADABLE = (*DAMAGE, AttributeError, MemoryError)


class Record(NamedTuple):
    """One record of a journal."""

    kind: str
    content: bytes


class Journal:
    """A file of records, appended one by one, each sealed together with all before it.

    A record is a line, ``blockstruct record KIND LENGTH SHA-256``, and its bytes. The checksum covers the checksum
    before, the line up to it and the bytes. A record that is changed, missing or in another place ends the reading.
    The system has each record at once, and the disk all but the records of the last ``FLUSHED`` seconds of work.

    Parameters
    ----------
    path
        The file; it is made with the first record.
    seed
        Start of the chain of checksums: a journal that belongs to something else is not read.
    """

    def __init__(self, path: Path, seed: str) -> None:
        self.path = path
        self._digest = self._seed = hashlib.sha256(seed.encode()).hexdigest()
        self._end = 0
        self._flushed = monotonic()

    def read(self, accept: Callable[[Record], None]) -> str:
        """Hand every record, in order, to a function, whose error refuses it; later ones are appended after it.

        Returns
        -------
        str
            The fault of the first record that is not as it was written; empty if all are.
        """
        self._digest, self._end = self._seed, 0
        if self.path.exists():
            with open_file(self.path, "a journal of a run") as stream:
                size = os.fstat(stream.fileno()).st_size
                while self._end < size:
                    line = _LINE.fullmatch(stream.readline(MOST_READ))
                    length = int(line[3]) if line else 0
                    if line is None or length > size - stream.tell():
                        return "is incomplete or damaged"
                    content = stream.read(length)
                    digest = self._chained(line[1], content)
                    if digest.encode() != line[4]:
                        return "does not match its checksum"
                    try:
                        accept(Record(line[2].decode(), content))
                    except _UNREADABLE as error:
                        return f"cannot be read ({error})"
                    self._digest, self._end = digest, stream.tell()
        return ""

    def append(self, kind: str, content: bytes) -> None:
        """Put a record after those that were read or appended."""
        head = f"blockstruct record {kind} {len(content)} ".encode()
        digest = self._chained(head, content)
        with self.path.open("ab") as stream:
            # The rest of a record that was not finished, or could not be read.
            stream.truncate(self._end)
            stream.write(head + digest.encode() + b"\n" + content)
            stream.flush()
            if is_due := monotonic() - self._flushed >= FLUSHED:
                os.fsync(stream.fileno())
            self._end = stream.tell()
        self._digest = digest
        if is_due:
            sync(self.path.parent)
            self._flushed = monotonic()

    def _chained(self, head: bytes, content: bytes) -> str:
        return hashlib.sha256(self._digest.encode() + head + content).hexdigest()


def _packed(arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return arrays as bytes: a line of JSON with names, types and shapes, and the values."""
    plain = {name: a.astype("U") if a.dtype.kind == "O" else a for name, a in arrays.items()}
    head = [(name, a.dtype.str, a.shape) for name, a in plain.items()]
    return b"".join([json.dumps(head).encode(), b"\n", *(a.tobytes() for a in plain.values())])


def _unpacked(content: bytes) -> dict[str, np.ndarray]:
    """Return the arrays of a record, texts as objects; raise one of ``_UNREADABLE`` without."""
    line, _, values = content.partition(b"\n")
    arrays, start = dict[str, np.ndarray](), 0
    for name, code, shape in json.loads(line):
        dtype = np.dtype(str(code))
        if dtype.kind not in "biufU":
            msg = f"{name!r} is of type {dtype}"
            raise ValueError(msg)
        array = np.ndarray(tuple(shape), dtype, values, start).copy()
        arrays[str(name)] = array.astype(object) if dtype.kind == "U" and array.size else array
        start += array.nbytes
    return arrays


class Checkpoint:
    """Working data of one run, held by one process.

    The journal of a case holds each iteration, each step of a pushover, and how it ended; and the versions of the
    packages if they differ from those before. Its records are sealed with the plan: a killed process leaves at most one
    that is half written, and none that was changed is read.

    :meth:`begin` and :meth:`reopen` are contexts, in which nobody else may write the file.
    """

    def __init__(self, place: Path, planned: Analysis, seal: str, target: Target) -> None:
        self.place, self.folder, self.planned, self._target = place, folder_of(place), planned, target
        self._journals = {name: Journal(self.folder / f"{k}.journal", f"{seal} {k}") for k, name in enumerate(planned)}
        #: Number of iterations and steps in the journal, by case and kind.
        self._committed = Counter[tuple[str, str]]()
        self._versions = {name: (r.versions or (planned.versions,))[-1] for name, r in planned.items()}

    @classmethod
    @contextlib.contextmanager
    def begin(cls, path: str | Path, planned: Analysis) -> Iterator[Self]:
        """Make the working data of a new run.

        Raises
        ------
        StorageError
            If another run writes to the path, or it holds the iterations of a killed one.
        """
        place = place_of(path)
        folder = folder_of(place)
        with writer_lock(place):
            _refuse_killed(place)
            clear(folder)
            try:
                target = Target.at(place)
                if target.replaces:
                    target.write(folder)
                image, seal = sealed_image(planned, folder / "plan")
                _put(folder / "plan", image, seal)
            except BaseException:
                with contextlib.suppress(StorageError):
                    clear(folder)
                raise
            yield cls(place, planned, seal.decode(), target)

    @classmethod
    @contextlib.contextmanager
    def reopen(cls, path: str | Path) -> Iterator[Self]:
        """Open the working data of a run that was killed, by the path of the file that it would have written.

        Raises
        ------
        StorageError
            If there are no such data, the run is still under way, or the path holds a file that was not there when the
            run began.
        FormatError
            If the plan of the run is damaged.
        """
        place = place_of(path)
        folder = folder_of(place)
        if not _has_plan(folder):
            reason = (
                "its run begins or has ended before it kept anything; wait, or run it again"
                if folder.is_dir()
                else "no run that writes to it was killed"
            )
            instead = named_instead(Path(path))
            msg = f"{path}: {f'is {instead}' if instead else f'no working data, {folder}: {reason}'}"
            raise StorageError(msg)
        with writer_lock(place):
            target = Target.read(folder)
            # Before anything is solved: a copied run finds a copy of the file that it was to replace.
            target.check(place, Stamp.at(place))
            plan = AnalysisFile(folder / "plan")
            yield cls(place, read_analysis(plan), plan.seal, target)

    def start(self, case: str, versions: Mapping[str, str]) -> None:
        """Commit the versions that will make the numbers of a case, if they differ from those before."""
        if versions != self._versions[case]:
            self._append(case, "versions", json.dumps(dict(versions), sort_keys=True).encode())
            self._versions[case] = versions

    def commit(self, case: str, kind: str, index: int, arrays: Mapping[str, np.ndarray]) -> None:
        """Commit the arrays of an ``iteration`` of a case, or of a ``step``, a state of its motion.

        An iteration has ``holds``, too: whether its certificate holds.
        """
        # A replayed iteration is committed already.
        if index >= self._committed[case, kind]:
            self._append(case, kind, _packed(arrays))
            self._committed[case, kind] += 1

    def end(self, result: CaseResult) -> None:
        """Commit how a case has ended."""
        ending = {
            "outcome": asdict(result.outcome),
            "certificate": result.certificate.measures if result.certificate else {},
            "started_at": result.started_at,
            "duration": result.duration,
            "curve_ended": result.curve_outcome.text if result.curve_outcome else "",
        }
        self._append(result.name, "end", json.dumps(ending).encode())

    def analysis(self) -> Analysis:
        """Return the analysis as far as it is committed; a case that has not ended is interrupted."""
        results = {name: self._result(result) for name, result in self.planned.items()}
        return self.planned.replaced(results=results)

    def finish(self, analysis: Analysis) -> None:
        """Write the finished file, then remove the working data."""
        _write(sealed_image(analysis, self.place), self.place, self._target, note=True)
        clear(self.folder)

    def _append(self, case: str, kind: str, content: bytes) -> None:
        journal = self._journals[case]
        remedy = f"then go on by AnalysisManager.resume({str(self.place)!r}), or blockstruct resume"
        with _keeping(journal.path, remedy):
            journal.append(kind, content)

    def _result(self, planned: CaseResult) -> CaseResult:
        if planned.status is not Status.INTERRUPTED:
            return planned
        journal, records = self._journals[planned.name], _Records(planned.history)
        damage = journal.read(records.take)
        if damage:
            damage = f"{journal.path.name} {damage} in record {records.count}, which is left out with all after it"
        known = {-1: planned.versions[-1]} if planned.n_iterations else {0: self.planned.versions}
        made_by = (*planned.versions[:-1], *(known | records.versions).values())
        self._versions[planned.name] = made_by[-1]
        pieces, states = records.iterations, records.steps
        self._committed |= {(planned.name, "iteration"): len(pieces), (planned.name, "step"): len(states)}
        motion = planned.response if planned.capacity is None else planned.capacity
        kept = 0 if motion is None else len(motion["displacement"])
        responds = isinstance(planned.case, RecordCase)
        is_begun = bool(pieces or (responds and (states or records.ending)))
        if not is_begun or len(pieces) < planned.n_iterations or len(states) < kept:
            return planned.changed(damage=damage)
        history, certificate = planned.history, dict[str, Any]()
        if pieces:
            history = _joined(history, pieces)
            certificate = {name: float(history[name][-1]) for name in CERTIFICATE_MEASURES if name != "holds"}
            certificate["holds"] = bool(pieces[-1]["holds"][0])
        killed: dict[str, Any] = {
            "outcome": asdict(Outcome(Status.INTERRUPTED, np.nan, Reason.KILLED)),
            "damage": damage,
            "certificate": certificate,
            "started_at": planned.started_at,
            "duration": float(history["solver_time"].sum()),
        }
        steps = {name: np.concatenate([s[name] for s in states]) for name in states[0]} if states else {}
        ending = dict(records.ending or killed)
        try:
            return CaseResult.restored(
                model=planned.model,
                case=planned.case,
                settings=asdict(planned.settings),
                history=history,
                capacity=capacity_of(planned.model, planned.case, steps) if steps and not responds else None,
                curve_outcome=CurveOutcome.read(ending.pop("curve_ended", "")),
                response=response_of(planned.model, steps) if responds and steps else None,
                schedule=planned.schedule,
                of_case=planned.of_case,
                versions=made_by,
                **ending | {"outcome": Outcome.of(ending["outcome"])},
            )
        except DAMAGE as error:
            msg = f"{journal.path}: {error}; delete it, the case then counts as interrupted"
            raise FormatError(msg) from error


class _Records:
    """The content of the journal of a case, whose history is planned."""

    def __init__(self, planned: xr.Dataset) -> None:
        self._planned = planned
        self.iterations: list[dict[str, np.ndarray]] = []
        self.steps: list[dict[str, np.ndarray]] = []
        self.ending: dict[str, Any] | None = None
        #: By the number of iterations and steps before them.
        self.versions: dict[int, dict[str, str]] = {}
        self.count = 0

    def take(self, record: Record) -> None:
        """Take the next record; raise one of ``_UNREADABLE`` to refuse it."""
        is_open = self.ending is None
        match record.kind:
            case "versions" if is_open:
                self.versions[len(self.iterations) + len(self.steps)] = json.loads(record.content)
            case "iteration" if is_open and not self.steps:
                self.iterations.append(_checked(_unpacked(record.content), self._planned, len(self.iterations)))
            case "step" if is_open:
                self.steps.append(_unpacked(record.content))
            case "end" if is_open:
                self.ending = json.loads(record.content)
            case _:
                msg = f"{record.kind!r} is not what follows"
                raise ValueError(msg)
        self.count += 1


def _checked(iteration: Mapping[str, np.ndarray], planned: xr.Dataset, index: int) -> dict[str, np.ndarray]:
    """Return the arrays of an iteration, of the kinds and shapes of the history of its case."""
    expected = {str(name): v for name, v in planned.variables.items() if "iteration" in v.dims}
    expected["holds"] = expected["iteration"]
    for name, v in expected.items():
        values, shape = iteration[name], tuple(1 if dim == "iteration" else n for dim, n in v.sizes.items())
        if values.shape != shape or (values.dtype.kind in "OU") != (v.dtype.kind in "OU"):
            msg = f"{name} is {values.dtype} {values.shape}, not of shape {shape}"
            raise ValueError(msg)
    return {name: iteration[name] for name in expected} | {"iteration": np.array([index])}


def _joined(planned: xr.Dataset, pieces: list[dict[str, np.ndarray]]) -> xr.Dataset:
    """Return the history of the iterations of a case."""
    joined = {
        str(name): (v.dims, np.concatenate([piece[str(name)] for piece in pieces]), v.attrs)
        for name, v in planned.variables.items()
        if "iteration" in v.dims
    }
    coords = {name: joined.pop(name) for name in [name for name in joined if name in planned.coords]}
    return planned.drop_dims("iteration").assign(joined).assign_coords(coords)
