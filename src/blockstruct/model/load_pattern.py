"""Load patterns: named sums of loads."""

from collections.abc import Iterable
from dataclasses import dataclass

from blockstruct.keywords import checked_keywords
from blockstruct.model.loads import Load
from blockstruct.model.names import checked_name, checked_tuple


@checked_keywords
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
        loads = checked_tuple(loads, Load, f"load pattern {name!r}: loads")
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "loads", loads)
