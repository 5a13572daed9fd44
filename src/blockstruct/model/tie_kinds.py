"""The one table of ties: what documents, files and reports need to know of each kind."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from blockstruct.model.block import Block
from blockstruct.model.bonded_bar import BondedBar
from blockstruct.model.tie_segments import TieSegment
from blockstruct.model.ties import Strip, Tie

AnyTie = Tie | Strip | BondedBar


@dataclass(frozen=True, slots=True)
class TieKind:
    """What documents and files need to know of a kind of tie.

    Parameters
    ----------
    type
        Its class, whose constructor takes ``name``, ``start``, ``end`` and then ``quantities``.
    quantities
        Keys of :data:`TIE_QUANTITIES`.
    anchored
        Whether its ends are points of named blocks.
    """

    type: Callable[..., AnyTie]
    quantities: tuple[str, ...]
    anchored: bool = True


_OF_BAR = ("yield_force", "area", "strength", "punching_force", "bond_force", "prestress", "elongation_limit")
#: Kind of each tie, as documents and files write it.
TIE_KINDS: Mapping[str, TieKind] = MappingProxyType(
    {
        "tie": TieKind(Tie, _OF_BAR),
        "strip": TieKind(Strip, ("area", "strength", "elongation_limit")),
        "bonded_bar": TieKind(
            BondedBar, ("yield_force", "strength", "diameter", "bond_strength", "elongation_limit"), anchored=False
        ),
    }
)
_KINDS = {kind.type: name for name, kind in TIE_KINDS.items()}


def tie_kind_of(tie: AnyTie) -> str:
    """Kind of a tie: a key of :data:`TIE_KINDS`."""
    return _KINDS[type(tie)]


def given_quantities(tie: AnyTie) -> dict[str, float]:
    """What a tie was given, by name, SI."""
    own = {name: getattr(tie, name) for name in TIE_KINDS[tie_kind_of(tie)].quantities}
    # A prestress of zero is none.
    return {name: value for name, value in own.items() if value}


def tie_segments(ties: Iterable[AnyTie], blocks: Iterable[Block]) -> list[TieSegment]:
    """Stretches of ties with one force each, tie by tie.

    Raises
    ------
    UnknownNameError, ModelError
        If the tie does not fit the blocks.
    """
    by_name = {b.name: b for b in blocks}
    return [segment for tie in ties for segment in tie.segments(by_name)]
