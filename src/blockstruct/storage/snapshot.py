"""The bytes of a file as they are at one moment, and the seal that tells whether they are as they were written.

The seal is a checksum of all bytes of a file behind the end of its HDF5 data, where no reader of HDF5 looks. It is
checked before libhdf5 sees a byte, because on damaged bytes libhdf5 may run for ever.
"""

import errno
import hashlib
import os
import weakref
from io import SEEK_END, BytesIO, RawIOBase, UnsupportedOperation
from pathlib import Path
from typing import Any, NamedTuple, Self

from blockstruct.errors import FormatError, StorageError
from blockstruct.files import irregular
from blockstruct.storage.lock import named_instead

_MARK = b"\nblockstruct sha256 "
_LENGTH = len(_MARK) + 64 + 1
#: Bytes up to which a file is kept in memory: nothing can change it then, and no descriptor is needed.
_SMALL = 16 << 20
_CHUNK = 1 << 22


def seal_of(image: bytes | memoryview) -> bytes:
    """Seal of the bytes of a file, to be put behind them."""
    return _MARK + hashlib.sha256(image).hexdigest().encode() + b"\n"


class Stamp(NamedTuple):
    """What tells one file, and one state of it, from another."""

    device: int
    inode: int
    size: int
    modified: int

    @classmethod
    def of(cls, status: os.stat_result) -> Self:
        """Stamp of what :func:`os.stat` tells."""
        return cls(status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)

    @classmethod
    def at(cls, path: Path) -> Self | None:
        """Stamp of the file at a path; None without one."""
        try:
            return cls.of(path.stat())
        except FileNotFoundError:
            return None


class Snapshot:
    """One file, opened once: whatever takes its name afterwards, this is what is read.

    Parameters
    ----------
    path
        The file.
    verified
        A stamp at which its seal was found to match: it is not checked again if the file still has it.

    Attributes
    ----------
    sealed : bool
        Whether its seal is that of its bytes.

    Raises
    ------
    StorageError
        If there is no regular file at the path, or it cannot be read.
    """

    def __init__(self, path: Path, verified: Stamp | None = None) -> None:
        self.path = path
        try:
            if what := irregular(path):
                msg = f"{path}: is {named_instead(path) or f'{what}; give the path of a blockstruct analysis'}"
                raise StorageError(msg)
            self._descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        except StorageError:
            raise
        except (OSError, ValueError) as error:
            raise unreadable(path, error) from error
        self._close = weakref.finalize(self, os.close, self._descriptor)
        self.stamp = Stamp.of(os.fstat(self._descriptor))
        self._image: bytes | None = None
        try:
            if self.stamp.size <= _SMALL:
                self._image = self._bytes(0, self.stamp.size)
                self._close()
            self.sealed = self.stamp == verified or self._is_sealed()
        except OSError as error:
            self._close()
            raise unreadable(path, error) from error

    def stream(self) -> RawIOBase | BytesIO:
        """The bytes, for a reader of HDF5.

        Raises
        ------
        FormatError
            If the file was changed after it was opened: not replaced, which does no harm, but written to.
        """
        if self._image is not None:
            return BytesIO(self._image)
        self.check_unchanged()
        return _Window(self)

    def head(self, count: int) -> bytes:
        """First bytes."""
        return self._bytes(0, count)

    @property
    def seal(self) -> bytes:
        """What stands in the place of the seal."""
        return self._bytes(max(self.stamp.size - _LENGTH, 0), _LENGTH)

    def check_unchanged(self) -> None:
        """Refuse a file that was written to since it was opened."""
        if self._image is None and Stamp.of(os.fstat(self._descriptor)) != self.stamp:
            msg = f"{self.path}: was written to by another program while it was open; use the original"
            raise FormatError(msg)

    def _is_sealed(self) -> bool:
        digest, place, end = hashlib.sha256(), 0, self.stamp.size - _LENGTH
        if self._image is not None:
            digest.update(memoryview(self._image)[: max(end, 0)])
        while self._image is None and place < end:
            chunk = self._bytes(place, min(_CHUNK, end - place))
            if not chunk:
                return False
            digest.update(chunk)
            place += len(chunk)
        return end > 0 and self.seal == _MARK + digest.hexdigest().encode() + b"\n"

    def _bytes(self, start: int, count: int) -> bytes:
        if self._image is not None:
            return self._image[start : start + count]
        parts, left = [], count
        while left and (part := _read(self._descriptor, start + count - left, min(left, _CHUNK))):
            parts.append(part)
            left -= len(part)
        return b"".join(parts)


def unreadable(path: Path, error: Exception) -> StorageError:
    """Error of a path that cannot be opened or read."""
    number = getattr(error, "errno", None)
    if isinstance(error, FileNotFoundError | NotADirectoryError):
        return StorageError(f"{path}: no such file; give the path of a blockstruct analysis")
    if isinstance(error, PermissionError):
        return StorageError(f"{path}: cannot be read ({error.strerror}); ask its owner for the right to read it")
    if number in (errno.EMFILE, errno.ENFILE):
        return StorageError(f"{path}: cannot be opened, too many files are; keep fewer analyses at a time")
    return StorageError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error}); give another path")


class _Window(RawIOBase):
    """The bytes of a snapshot that is too large for memory, as a stream."""

    def __init__(self, snapshot: Snapshot) -> None:
        self._snapshot, self._place = snapshot, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._place

    def seek(self, offset: int, whence: int = 0) -> int:
        if whence == SEEK_END:
            offset += self._snapshot.stamp.size
        elif whence:
            raise UnsupportedOperation
        self._place = offset
        return offset

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        part = self._snapshot._bytes(self._place, len(view))
        view[: len(part)] = part
        self._place += len(part)
        return len(part)


if hasattr(os, "pread"):

    def _read(descriptor: int, start: int, count: int) -> bytes:
        return os.pread(descriptor, count, start)
else:

    def _read(descriptor: int, start: int, count: int) -> bytes:
        os.lseek(descriptor, start, os.SEEK_SET)
        return os.read(descriptor, count)
