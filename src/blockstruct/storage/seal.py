"""The seal of a file: a checksum of all its bytes behind the end of the HDF5 data, where no reader looks.

It is checked before libhdf5 reads more than the attributes of the root, because on damaged bytes libhdf5 may run for
ever (measured: once in some 3,000 random corruptions).
"""

import hashlib
from pathlib import Path

_MARK = b"\nblockstruct sha256 "
_LENGTH = len(_MARK) + 64 + 1


def seal_of(image: bytes | memoryview) -> bytes:
    """Seal of the bytes of a file, to be put behind them."""
    return _MARK + hashlib.sha256(image).hexdigest().encode() + b"\n"


def is_intact(path: Path) -> bool:
    """Whether a file carries a seal, and the seal is that of its bytes."""
    digest, left = hashlib.sha256(), path.stat().st_size - _LENGTH
    with path.open("rb") as file:
        while left > 0 and (chunk := file.read(min(left, 1 << 22))):
            digest.update(chunk)
            left -= len(chunk)
        return file.read() == _MARK + digest.hexdigest().encode() + b"\n"
