"""Write a file: its name and lock, and the folder next to it that keeps the working data of a run.

The folder ``NAME.partial`` holds ``lock``; ``plan``, an analysis file of every case as it was before the run, without
the histories that are empty; ``target``, the stamps of the files that the run may replace and of the file that it has
made; and ``<k>.journal`` for the case with index k once it has begun. The plan is made last and removed first: without
it the rest counts for nothing. The run has ended once the file that it has made has its name.
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
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic
from types import MappingProxyType
from typing import IO, Any, NamedTuple, Self

import numpy as np
import xarray as xr

from blockstruct.errors import BusyError, FormatError, StorageError, shown
from blockstruct.files import MOST_READ, open_file, read_file, writing
from blockstruct.limit import Outcome
from blockstruct.model import RecordCase
from blockstruct.motion import CurveOutcome
from blockstruct.results import CERTIFICATE_MEASURES
from blockstruct.results.analysis import Analysis
from blockstruct.results.capacity import capacity_of, response_of
from blockstruct.results.case_result import CaseResult
from blockstruct.results.history import HISTORY, Variable
from blockstruct.results.verification import confirm
from blockstruct.storage.file import (
    DAMAGE,
    AnalysisFile,
    Blank,
    ModelImage,
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
#: Attempts to make a lock that another writer removes at the same moment.
_ATTEMPTS = 1000
#: Errors of a lock that somebody else holds; any other error means a file system without locks.
_HELD = (errno.EACCES, errno.EAGAIN, errno.EWOULDBLOCK, errno.EDEADLK)
_LINE = re.compile(rb"(blockstruct record ([a-z]{1,20}) ([0-9]{1,15}) )([0-9a-f]{64})\n")
_LONGEST_LINE = 128


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
        _check_holder(place)
        if place.suffix != SUFFIX:
            msg = f"{path}: the name of an analysis ends in {SUFFIX}, as an Archive wants; write {path}{SUFFIX}"
            raise StorageError(msg)
        place.parent.mkdir(parents=True, exist_ok=True)
        _try_folder(place)
    except StorageError:
        raise
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            msg = f"{place}: the name is too long, with {len(folder_of(place).name)} characters; choose a shorter one"
        else:
            msg = f"{place}: cannot be written ({error.strerror or error}); choose a folder you can write to"
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
    removing = False
    try:
        folder.mkdir()
        removing = True
        folder.rmdir()
    except OSError as error:
        if _is_file(folder):
            raise _in_the_way(place) from error
        # Another writer may have removed the folder in the meantime. A folder that is not found while it is made is
        # in a place that takes none.
        was_there = isinstance(error, FileNotFoundError if removing else FileExistsError) and not folder.exists()
        if not was_there and error.errno != errno.ENOTEMPTY and not os.access(folder, os.W_OK | os.X_OK):
            raise


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


class WriterLock:
    """The right to write a file, from construction to :meth:`release` or the end of the process, however it ends.

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

    def __init__(self, path: Path) -> None:
        self.folder = folder_of(path)
        lock = self.folder / "lock"
        while True:
            self._stream = _opened(lock, path)
            try:
                _take(self._stream)
            except OSError as error:
                self._stream.seek(0)
                holder = self._stream.read().decode(errors="replace").strip() or f"another process ({error.strerror})"
                self._stream.close()
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
                if os.path.samestat(os.fstat(self._stream.fileno()), lock.stat()):
                    break
            self._stream.close()
        now = datetime.now(UTC).isoformat(timespec="seconds")
        with contextlib.suppress(OSError):  # A lock on a full disk does not name its holder.
            self._stream.truncate(0)
            self._stream.write(f"process {os.getpid()} on {platform.node()} since {now}\n".encode())

    def release(self) -> None:
        """Let others write; remove the folder if it holds nothing but the lock."""
        with contextlib.suppress(OSError):  # Another writer may be quicker than these lines.
            if [file.name for file in self.folder.iterdir()] == ["lock"]:
                if sys.platform == "win32":
                    self._stream.close()  # Windows removes no open file, nor one that another writer has opened since.
                (self.folder / "lock").unlink()
                self.folder.rmdir()
        self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def _opened(lock: Path, path: Path) -> IO[bytes]:
    for _ in range(_ATTEMPTS):
        try:
            lock.parent.mkdir(parents=True, exist_ok=True)
            return lock.open("a+b", buffering=0)
        except (FileNotFoundError, FileExistsError) as error:
            if _is_file(lock.parent):
                raise _in_the_way(path) from error
            # Another writer has just removed the folder; but a link may lead nowhere, however often it is followed.
            continue
        except OSError as error:
            msg = f"{path}: cannot be written ({error.strerror}); choose a folder you can write to"
            raise StorageError(msg) from error
    msg = f"{lock}: cannot be made (a link that leads nowhere); remove it, or choose another name"
    raise StorageError(msg)


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
            return read_analysis(AnalysisFile(folder_of(place_of(path)) / "plan"), lambda *_: xr.Dataset())
        except StorageError:
            if is_unfinished(path):
                raise
    return open_analysis(path) if Path(path).exists() else None


def tidy(path: str | Path) -> None:
    """Remove the rest of working data that a killed run was removing, if nobody writes."""
    place = place_of(path)
    with contextlib.suppress(StorageError, OSError):
        if folder_of(place).is_dir() and not is_unfinished(place):
            with WriterLock(place):
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
    with WriterLock(place):
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
    with WriterLock(place):
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

    def with_made(self, made: Stamp) -> Self:
        """Return the target of a run that has made its file."""
        return self._replace(replaces=(*self.replaces, made), made=made)

    def write(self, folder: Path) -> None:
        """Keep the target in the folder of its run."""
        _put(folder / "target", json.dumps({"replaces": self.replaces, "is_made": self.made is not None}).encode())

    def check(self, place: Path, present: Stamp | None) -> None:
        """Refuse to replace a file that was not there when the run began."""
        if present is not None and present not in self.replaces:
            msg = f"{place}: another file has appeared at this name, and is not replaced; move it away, then try again"
            raise StorageError(msg)


@contextlib.contextmanager
def _draft(parts: Iterable[bytes | memoryview], draft: Path, path: Path) -> Iterator[None]:
    """Write bytes to a draft of a file, wait until they are on the disk, and remove it unless it gets another name."""
    try:
        try:
            # Whatever stands there, a pipe too, is the rest of a killed run.
            draft.unlink(missing_ok=True)
            with draft.open("xb") as stream:
                stream.writelines(parts)
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as error:
            moved = isinstance(error, FileNotFoundError | NotADirectoryError)
            remedy = "its folder was moved or removed, move it back" if moved else "free some space"
            msg = f"{draft}: cannot be written ({error.strerror or error}); {remedy} or choose another folder"
            raise StorageError(msg) from error
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
            target.with_made(Stamp.of(draft.stat())).write(folder)
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

    @property
    def is_begun(self) -> bool:
        """Whether records were read or appended."""
        return self._end > 0

    def read(self, accept: Callable[[Record], None]) -> str:
        """Hand every record, in order, to a function, whose ValueError refuses it; later ones are appended after it.

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
                    line = _LINE.fullmatch(stream.readline(_LONGEST_LINE))
                    length = int(line[3]) if line else 0
                    if line is None or length > size - stream.tell():
                        return "is incomplete or damaged"
                    content = stream.read(length)
                    digest = self._chained(line[1], content)
                    if digest.encode() != line[4]:
                        return "does not match its checksum"
                    try:
                        accept(Record(line[2].decode(), content))
                    except ValueError as error:
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


def _packed(arrays: Mapping[str, np.ndarray], more: Mapping[str, Any] = MappingProxyType({})) -> bytes:
    """Return arrays as bytes: a line of JSON with names, types, shapes and anything more, and the values."""
    plain = {name: a.astype("U") if a.dtype.kind == "O" else a for name, a in arrays.items()}
    head = {"arrays": [(name, a.dtype.str, a.shape) for name, a in plain.items()], **more}
    return b"".join([json.dumps(head).encode(), b"\n", *(a.tobytes() for a in plain.values())])


def _unpacked(content: bytes) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Return the arrays of a record, texts as objects, and its line of JSON; raise ValueError for other bytes."""
    line, _, values = content.partition(b"\n")
    arrays, start = dict[str, np.ndarray](), 0
    try:
        head = dict(json.loads(line))
        for name, code, shape in head["arrays"]:
            dtype = np.dtype(str(code))
            if dtype.kind not in "biufU":
                msg = f"{name!r} is of type {dtype}"
                raise ValueError(msg)
            array = np.ndarray(tuple(shape), dtype, values, start).copy()
            arrays[str(name)] = array.astype(object) if dtype.kind == "U" and array.size else array
            start += array.nbytes
    except (*DAMAGE, MemoryError) as error:
        msg = f"it is not a record of arrays: {error}"
        raise ValueError(msg) from error
    return arrays, head


def _packed_history(variables: Mapping[str, Variable], coords: Mapping[str, Variable]) -> bytes:
    every = {**variables, **coords}
    outline = {
        "variables": {name: (dims, attrs) for name, (dims, _, attrs) in every.items()},
        "coords": list(coords),
        "attrs": HISTORY,
    }
    return _packed({name: values for name, (_, values, _) in every.items()}, outline)


def _unpacked_dataset(content: bytes) -> xr.Dataset:
    """Return the Dataset of a record; raise ValueError for other bytes."""
    arrays, head = _unpacked(content)
    try:
        variables = {name: (tuple(dims), arrays[name], attrs) for name, (dims, attrs) in head["variables"].items()}
        coords = {name: variables.pop(name) for name in head["coords"]}
        return xr.Dataset(variables, coords, head["attrs"])
    except (*DAMAGE, AttributeError) as error:
        msg = f"it is not a record of a history: {error}"
        raise ValueError(msg) from error


class Checkpoint:
    """Working data of one run, held by one process.

    The journal of a case holds its history without iterations, each iteration, each step of a pushover, and how it
    ended; and the versions of the packages where they differ from those before. Its records are sealed with the plan:
    a killed process leaves at most one that is half written, and none that was changed is read.

    Use :meth:`begin` or :meth:`reopen`, as a context.
    """

    def __init__(
        self,
        place: Path,
        lock: WriterLock,
        planned: Analysis,
        seal: str,
        target: Target,
        part: ModelImage | None = None,
    ) -> None:
        self.place, self.folder, self.planned = place, folder_of(place), planned
        self._lock, self._target, self._part = lock, target, part
        self._journals = {name: Journal(self.folder / f"{k}.journal", f"{seal} {k}") for k, name in enumerate(planned)}
        self._committed = dict.fromkeys(planned, 0)
        self._steps = dict.fromkeys(planned, 0)
        self._versions = {name: (r.versions or (planned.versions,))[-1] for name, r in planned.items()}

    @classmethod
    def begin(cls, path: str | Path, planned: Analysis) -> Self:
        """Make the working data of a new run.

        Raises
        ------
        StorageError
            If another run writes to the path, or it holds the iterations of a killed one.
        """
        place = place_of(path)
        lock = WriterLock(place)
        try:
            _refuse_killed(place)
            folder = folder_of(place)
            clear(folder)
            target = Target.at(place)
            if target.replaces:
                target.write(folder)
            part = ModelImage.of(planned, folder / "plan")
            image, seal = sealed_image(planned, folder / "plan", part, is_plan=True)
            _put(folder / "plan", image, seal)
        except BaseException:
            with contextlib.suppress(StorageError):
                if not is_unfinished(place):
                    clear(folder_of(place))
            lock.release()
            raise
        return cls(place, lock, planned, seal.decode(), target, part)

    @classmethod
    def reopen(cls, path: str | Path, blank: Blank) -> Self:
        """Open the working data of a run that was killed.

        Parameters
        ----------
        path
            The file that the run would have written.
        blank
            Makes the history of a case that had not begun.

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
        lock = WriterLock(place)
        try:
            target = Target.read(folder)
            # Before anything is solved: a copied run finds a copy of the file that it was to replace.
            target.check(place, Stamp.at(place))
            plan = AnalysisFile(folder / "plan")
            return cls(place, lock, read_analysis(plan, blank), plan.seal, target)
        except BaseException:
            lock.release()
            raise

    def start(
        self,
        case: str,
        versions: Mapping[str, str],
        variables: Mapping[str, Variable],
        coords: Mapping[str, Variable],
    ) -> None:
        """Commit the history of a case without iterations, and the versions that will make them."""
        if not self._journals[case].is_begun:
            self._append(case, "case", _packed_history(variables, coords))
        if versions != self._versions[case]:
            self._append(case, "versions", json.dumps(dict(versions), sort_keys=True).encode())
            self._versions[case] = versions

    def commit(self, case: str, index: int, iteration: Mapping[str, np.ndarray]) -> None:
        """Commit an iteration of a case: its arrays, and whether its certificate holds, ``holds``."""
        # A replayed iteration is committed already.
        if index >= self._committed[case]:
            self._append(case, "iteration", _packed(iteration))
            self._committed[case] += 1

    def commit_step(self, case: str, index: int, step: Mapping[str, np.ndarray]) -> None:
        """Commit the arrays of a state of the pushover of a case."""
        if index >= self._steps[case]:
            self._append(case, "step", _packed(step))
            self._steps[case] += 1

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
        _write(sealed_image(analysis, self.place, self._part), self.place, self._target, note=True)
        clear(self.folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def _append(self, case: str, kind: str, content: bytes) -> None:
        journal = self._journals[case]
        try:
            journal.append(kind, content)
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
        parts = ((planned.capacity, "step"), (planned.response, "time"))
        n_steps = sum(0 if part is None else part.sizes[dim] for part, dim in parts)
        if records.blank is None or len(pieces) < planned.n_iterations or len(records.steps) < n_steps:
            return planned.changed(damage=damage)
        responds = isinstance(planned.case, RecordCase)
        if not pieces and not (responds and (records.steps or records.ending)):
            return replace(planned, history=records.blank, damage=damage)
        history = _joined(records.blank, pieces) if pieces else records.blank
        last = {name: float(history[name][-1]) for name in CERTIFICATE_MEASURES if name != "holds"} if pieces else {}
        killed: dict[str, Any] = {
            "outcome": asdict(Outcome(Status.INTERRUPTED, np.nan, Reason.KILLED)),
            "damage": damage,
            "certificate": {**last, "holds": bool(pieces[-1]["holds"][0])} if pieces else {},
            "started_at": planned.started_at,
            "duration": float(history["solver_time"].sum()),
        }
        steps = {n: np.concatenate([s[n] for s in records.steps]) for n in records.steps[0]} if records.steps else {}
        settings, ending = asdict(planned.settings), dict(records.ending or killed)
        try:
            return CaseResult.restored(
                model=planned.model,
                case=planned.case,
                settings=settings,
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
    """The content of the journal of a case."""

    def __init__(self) -> None:
        self.blank: xr.Dataset | None = None
        self.iterations: list[dict[str, np.ndarray]] = []
        self.steps: list[dict[str, np.ndarray]] = []
        self.ending: dict[str, Any] | None = None
        #: By the number of iterations and steps before them.
        self.versions: dict[int, dict[str, str]] = {}
        self.count = 0

    def take(self, record: Record) -> None:
        """Take the next record; raise ValueError to refuse it."""
        is_open = self.blank is not None and self.ending is None
        match record.kind:
            case "case" if self.blank is None:
                self.blank = _unpacked_dataset(record.content)
            case "versions" if is_open:
                self.versions[len(self.iterations) + len(self.steps)] = json.loads(record.content)
            case "iteration" if self.blank is not None and is_open and not self.steps:
                self.iterations.append(_checked(_unpacked(record.content)[0], self.blank, len(self.iterations)))
            case "step" if is_open:
                self.steps.append(_unpacked(record.content)[0])
            case "end" if is_open:
                self.ending = json.loads(record.content)
            case _:
                msg = f"{record.kind!r} is not what follows"
                raise ValueError(msg)
        self.count += 1


def _checked(iteration: Mapping[str, np.ndarray], blank: xr.Dataset, index: int) -> dict[str, np.ndarray]:
    """Return the arrays of an iteration, of the kinds and shapes of the history of its case."""
    arrays = {}
    expected = {str(name): v for name, v in blank.variables.items() if "iteration" in v.dims}
    for name in (*expected, "holds"):
        dims = expected[name].dims if name in expected else ("iteration",)
        shape = tuple(1 if d == "iteration" else blank.sizes[d] for d in dims)
        if name not in iteration:
            msg = f"{name} is missing"
            raise ValueError(msg)
        values = iteration[name]
        is_text = name in expected and expected[name].dtype.kind in "OU"
        if values.shape != shape or (values.dtype.kind in "OU") != is_text:
            msg = f"{name} is {values.dtype} {values.shape}, not of shape {shape}"
            raise ValueError(msg)
        arrays[name] = np.array([index]) if name == "iteration" else values
    return arrays


def _joined(blank: xr.Dataset, pieces: list[dict[str, np.ndarray]]) -> xr.Dataset:
    """Return the history of the iterations of a case."""
    joined = {
        str(name): (v.dims, np.concatenate([piece[str(name)] for piece in pieces]), v.attrs)
        for name, v in blank.variables.items()
        if "iteration" in v.dims
    }
    coords = {name: joined.pop(name) for name in [name for name in joined if name in blank.coords]}
    return blank.drop_dims("iteration").assign(joined).assign_coords(coords)
