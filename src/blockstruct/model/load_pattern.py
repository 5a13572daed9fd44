"""Load patterns: named sums of loads."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import get_args

from blockstruct.errors import ModelError
from blockstruct.model.loads import Load
from blockstruct.model.names import checked_name


@dataclass(frozen=True, slots=True, init=False)
class LoadPattern:
    """A named sum of loads.

    Parameters
    ----------
    name
        Unique among the patterns of an analysis.
    loads
        SelfWeight, BodyForce, PointLoad, FaceLoad or Moment, in any number.

    Examples
    --------
    >>> from blockstruct.model.loads import SelfWeight
    >>> LoadPattern("dead", [SelfWeight()]).loads
    (SelfWeight(),)
    """

    name: str
    loads: tuple[Load, ...]

    def __init__(self, name: str, loads: Iterable[Load]) -> None:
        checked_name(name, "load pattern")
        loads = tuple(loads)
        for load in loads:
            if not isinstance(load, get_args(Load)):
                kinds = ", ".join(kind.__name__ for kind in get_args(Load))
                msg = f"load pattern {name!r}: {load!r} is no load; give {kinds}"
                raise ModelError(msg)
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "loads", loads)
