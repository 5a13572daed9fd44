"""A journal: records that are appended one by one, each sealed together with all before it.

A record is a line, ``blockstruct record KIND LENGTH SHA-256``, and its bytes. The checksum is that of the one before,
of the line up to it and of the bytes, so that a record that is changed, missing or in another place ends what is read.
"""

import hashlib
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from blockstruct.storage.claim import sync

_LINE = re.compile(rb"(blockstruct record ([a-z]{1,20}) ([0-9]{1,15}) )([0-9a-f]{64})\n")
_LONGEST_LINE = 128


class Record(NamedTuple):
    """What one record holds."""

    kind: str
    content: bytes


class Journal:
    """A file of records.

    Parameters
    ----------
    path
        The file; it is made with the first record.
    seed
        What the chain of checksums begins with: a journal that belongs to something else is not read.
    """

    def __init__(self, path: Path, seed: str) -> None:
        self.path = path
        self._digest = self._seed = hashlib.sha256(seed.encode()).hexdigest()
        self._end = 0

    @property
    def is_begun(self) -> bool:
        """Whether records were read or appended."""
        return self._end > 0

    def read(self, accept: Callable[[Record], None]) -> str:
        """Hand every record, in order, to a function, whose ValueError refuses it; what follows is appended behind.

        Returns
        -------
        str
            What is wrong with the first record that is not as it was written; empty if all are.
        """
        self._digest, self._end = self._seed, 0
        try:
            with self.path.open("rb") as stream:
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
        except FileNotFoundError:
            return ""
        return ""

    def append(self, kind: str, content: bytes, *, wait: bool = True) -> None:
        """Put a record behind those that were read or appended, and wait until all are on the disk, if so told."""
        head = f"blockstruct record {kind} {len(content)} ".encode()
        digest = self._chained(head, content)
        with self.path.open("ab") as stream:
            # What is left of a record that was not finished, or of one that could not be read.
            stream.truncate(self._end)
            stream.write(head + digest.encode() + b"\n" + content)
            stream.flush()
            if wait:
                os.fsync(stream.fileno())
            is_named, self._end = self._end > 0, stream.tell()
        self._digest = digest
        if not is_named:
            sync(self.path.parent)

    def _chained(self, head: bytes, content: bytes) -> str:
        return hashlib.sha256(self._digest.encode() + head + content).hexdigest()
