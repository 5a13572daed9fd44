"""One writer per file: a lock that dies with its process."""

import contextlib
import errno
import os
import platform
import sys
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from blockstruct.errors import StorageError

if sys.platform == "win32":
    import msvcrt

    def _take(stream: IO[bytes]) -> None:
        # Far behind the text: Windows lets nobody read a locked byte.
        os.lseek(stream.fileno(), 1 << 20, os.SEEK_SET)
        msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        stream.seek(0)
else:
    import fcntl

    def _take(stream: IO[bytes]) -> None:
        fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)


#: Ending of the folder of a run.
PARTIAL = ".partial"


def folder_of(path: Path) -> Path:
    """Folder beside a file that holds its lock, and the working data of a run that writes to it."""
    return path.with_name(f"{path.name}{PARTIAL}")


def named_instead(path: Path) -> str:
    """The file to name where the folder of its run was named, as the end of a message; empty for any other path."""
    name = path.name.removesuffix(PARTIAL)
    if name in (path.name, ""):
        return ""
    return f"a folder with the working data of a run; give the name of its file, {path.with_name(name)}"


def in_the_way(path: Path) -> StorageError:
    """Error where a file has the name of that folder."""
    folder = folder_of(path)
    return StorageError(
        f"{folder}: is a file, and {path.name} needs a folder of this name for the working data of its run; move that "
        "file away, or choose another name"
    )


#: How often a lock is made anew that another writer removes at that moment.
_ATTEMPTS = 1000
#: What a lock that somebody else holds fails with; anything else is a file system without locks.
_HELD = (errno.EACCES, errno.EAGAIN, errno.EWOULDBLOCK, errno.EDEADLK)


class WriterLock:
    """The right to write a file, from construction to :meth:`release` or the end of the process, however it ends.

    Parameters
    ----------
    path
        The file; its folder is made if it is missing.

    Raises
    ------
    StorageError
        If another writer holds the file: the message says who. If the file system has no locks.
    """

    def __init__(self, path: Path) -> None:
        self.folder = folder_of(path)
        lock = self.folder / "lock"
        while True:
            self._stream = _opened(lock, path)
            try:
                _take(self._stream)
            except OSError as error:
                if error.errno not in _HELD:
                    self._stream.close()
                    msg = (
                        f"{path}: its file system has no locks ({error.strerror}), so two runs could write to one "
                        "file; choose a folder on a local disk, and copy the file when it is finished"
                    )
                    raise StorageError(msg) from error
                self._stream.seek(0)
                holder = self._stream.read().decode(errors="replace").strip() or f"another process ({error.strerror})"
                self._stream.close()
                msg = f"{path}: is being written by {holder}; wait until it has ended, or choose another name"
                raise StorageError(msg) from error
            if _is_in_place(self._stream, lock):
                break
            self._stream.close()
        now = datetime.now(UTC).isoformat(timespec="seconds")
        with contextlib.suppress(OSError):  # A lock on a full disk does not say whose it is.
            self._stream.truncate(0)
            self._stream.write(f"process {os.getpid()} on {platform.node()} since {now}\n".encode())

    def release(self) -> None:
        """Let others write; remove the folder if it holds nothing but the lock."""
        with contextlib.suppress(OSError):  # Another writer may be quicker than these lines.
            if [file.name for file in self.folder.iterdir()] == ["lock"]:
                (self.folder / "lock").unlink()
                self.folder.rmdir()
        self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()


def _opened(lock: Path, path: Path) -> IO[bytes]:
    for _ in range(_ATTEMPTS):
        try:
            lock.parent.mkdir(parents=True, exist_ok=True)
            return lock.open("a+b", buffering=0)
        except FileNotFoundError:
            # Another writer has just removed the folder; but a link may lead nowhere, however often it is followed.
            continue
        except FileExistsError as error:
            raise in_the_way(path) from error
        except OSError as error:
            msg = f"{path}: cannot be written ({error.strerror}); choose a folder you can write to"
            raise StorageError(msg) from error
    msg = f"{lock}: cannot be made (a link that leads nowhere); remove it, or choose another name"
    raise StorageError(msg)


def _is_in_place(stream: IO[bytes], lock: Path) -> bool:
    """Whether the file that is held is still the one of that name, and not one that its writer has removed."""
    try:
        return os.path.samestat(os.fstat(stream.fileno()), lock.stat())
    except FileNotFoundError:
        return False
