"""Table of the kinds of ties, as documents, files and reports need it."""

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, get_args

import attrs
from attrs import frozen

from blockstruct.model.block import Block
from blockstruct.model.bonded_bar import BondedBar
from blockstruct.model.fields import Anchor, dimensions, snake_case
from blockstruct.model.tie_segments import TieSegment
from blockstruct.model.ties import Strip, Tie

AnyTie = Tie | Strip | BondedBar


def _quantities(kind: Any) -> dict[str, str]:
    return {name: dimension for name, dimension in dimensions(kind).items() if name not in ("start", "end")}


@frozen
class TieKind:
    """A kind of tie, as documents and files need it.

    Parameters
    ----------
    type
        Class of the tie. Its constructor takes ``name``, ``start``, ``end`` and then ``quantities``.
    quantities
        Keys of :data:`TIE_QUANTITIES`.
    anchored
        Whether its ends are points of named blocks.
    """

    type: Callable[..., AnyTie]
    quantities: tuple[str, ...]
    anchored: bool


#: Row of each kind of tie, by its name in documents and files.
TIE_KINDS: Mapping[str, TieKind] = MappingProxyType(
    {
        snake_case(kind.__name__): TieKind(kind, tuple(_quantities(kind)), attrs.fields(kind).start.type == Anchor)
        for kind in get_args(AnyTie)
    }
)
#: Dimension of each quantity of ties, a key of :data:`blockstruct.units.SI_UNITS`.
TIE_QUANTITIES: Mapping[str, str] = MappingProxyType(
    {name: dimension for kind in get_args(AnyTie) for name, dimension in _quantities(kind).items()}
)


def tie_kind_of(tie: AnyTie) -> str:
    """Return the kind of a tie, a key of :data:`TIE_KINDS`."""
    return snake_case(type(tie).__name__)


def given_quantities(tie: AnyTie) -> dict[str, float]:
    """Return the SI quantities that define a tie, by name."""
    values = {name: getattr(tie, name) for name in TIE_KINDS[tie_kind_of(tie)].quantities}
    # A prestress of zero is the same as no prestress.
    return {name: value for name, value in values.items() if value}


def tie_segments(ties: Iterable[AnyTie], blocks: Iterable[Block]) -> list[TieSegment]:
    """Return the segments of ties, tie by tie; each segment has one force.

    Raises
    ------
    UnknownNameError, ModelError
        If a tie does not fit the blocks.
    """
    by_name = {b.name: b for b in blocks}
    return [segment for tie in ties for segment in tie.segments(by_name)]
