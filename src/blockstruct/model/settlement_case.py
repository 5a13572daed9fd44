"""Settlement cases: what is left of the reaction of a support that gives way."""

from collections.abc import Iterable
from copy import copy
from dataclasses import dataclass
from typing import Self

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import checked_direction, checked_name, checked_tuple
from blockstruct.model.loads import LoadPattern, Vector
from blockstruct.units import VectorLike, si_vector
from blockstruct.vocabulary import Flow


@dataclass(frozen=True, slots=True, init=False)
class SettlementCase:
    """Supports that give way under the dead load, as one rigid body and in one direction.

    The answer is the reaction that is left when the structure begins to follow: the least for which forces in
    equilibrium, inside the strength of the joints, are the forces of a mechanism. The reaction is what the joints and
    the ties of the structure bring to the supports along the motion, positive against the motion; the weight of the
    supports themselves is not part of it.

    Parameters
    ----------
    name
        Unique in an analysis.
    dead
        Loads that act in full.
    supports
        Names of the supports that move.
    direction : three floats or str
        Of the motion, of length 1: ``(0, 0, -1)`` and ``"-z"`` are a settlement, a horizontal direction a spreading
        support, whose reaction is its thrust. With ``about`` the axis of a rotation, right-handed.
    about : quantity, length, three components
        A point of the axis, if the supports turn: the reaction is then a moment about the axis.
    flow
        As of a :class:`LimitCase`. With associative flow the reaction is the least that statics allows.

    Attributes
    ----------
    direction : three floats
        Of length 1.
    about : three floats or None
        m.

    Raises
    ------
    ModelError
        If there is no support, one is named twice, or the direction is not of length 1.

    Examples
    --------
    >>> dead = LoadPattern("dead", [])
    >>> SettlementCase("left pier", dead, ["left pier"], "-z").direction
    (0.0, 0.0, -1.0)
    """

    name: str
    dead: LoadPattern
    supports: tuple[str, ...]
    direction: Vector
    about: Vector | None
    flow: Flow

    def __init__(
        self,
        name: str,
        dead: LoadPattern,
        supports: Iterable[str],
        direction: VectorLike,
        *,
        about: VectorLike | None = None,
        flow: Flow | str = Flow.NONASSOCIATIVE,
    ) -> None:
        who = f"settlement case {checked_name(name, 'settlement case')!r}"
        if not isinstance(dead, LoadPattern):
            msg = f"{who}: dead load is {shown(dead)}; give a LoadPattern"
            raise ModelError(msg)
        names = checked_tuple((supports,) if isinstance(supports, str) else supports, str, f"{who}: supports")
        if not names or len(set(names)) < len(names):
            said = "no support" if not names else f"supports {', '.join(names)}, one of them twice"
            msg = f"{who}: {said}; give the name of each support that moves once"
            raise ModelError(msg)
        try:
            flow = Flow(flow)
        except (ValueError, TypeError, RecursionError):
            msg = f"{who}: flow {shown(flow)}; give one of {', '.join(Flow)}"
            raise ModelError(msg) from None
        point = None if about is None else si_vector(about, "length", f"{who}: about")
        for attribute, value in (
            ("name", name),
            ("dead", dead),
            ("supports", names),
            ("direction", checked_direction(direction, f"{who}: direction")),
            ("about", point),
            ("flow", flow),
        ):
            object.__setattr__(self, attribute, value)

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Its load patterns."""
        return (self.dead,)

    @property
    def question(self) -> str:
        """What it asks, in words.

        >>> SettlementCase("left", LoadPattern("dead", []), ["left pier"], "-z").question
        'dead, left pier moves along (0, 0, -1), nonassociative flow'
        """
        return f"{self.dead.name}, {self.motion}, {self.flow} flow"

    @property
    def motion(self) -> str:
        """How the supports move, in words.

        >>> SettlementCase("left", LoadPattern("dead", []), ["left pier"], "-z").motion
        'left pier moves along (0, 0, -1)'
        """
        who, one = ", ".join(self.supports), len(self.supports) == 1
        vector = "({:.4g}, {:.4g}, {:.4g})".format(*self.direction)
        if self.about is None:
            return f"{who} {'moves' if one else 'move'} along {vector}"
        point = "({:.4g}, {:.4g}, {:.4g}) m".format(*self.about)
        return f"{who} {'turns' if one else 'turn'} about {vector} through {point}"

    def renamed(self, name: str, flow: Flow | None = None) -> Self:
        """The same question by another name, with another flow rule if one is given."""
        other = copy(self)
        object.__setattr__(other, "name", checked_name(name, "settlement case"))
        object.__setattr__(other, "flow", flow or self.flow)
        return other
