"""Settlement cases."""

from collections.abc import Iterable
from typing import Any, Self

from attrs import field, frozen

from blockstruct.errors import ModelError
from blockstruct.model.checks import checked_tuple
from blockstruct.model.fields import (
    ModelObject,
    Vector,
    changed,
    has_name,
    instance_of,
    label,
    named_arguments,
    optional_scalar,
    optional_vector,
    positive,
    steps,
    unit_vector,
)
from blockstruct.model.limit_case import flow_rule
from blockstruct.model.loads import LoadPattern
from blockstruct.units import quantity_text
from blockstruct.vocabulary import Flow


def _names(value: Iterable[str], what: str = "") -> tuple[str, ...]:
    return checked_tuple((value,) if isinstance(value, str) else value, str, what)


def _each_once(case: Any, _: Any, supports: tuple[str, ...]) -> None:
    if not supports or len(set(supports)) < len(supports):
        problem = f"supports {', '.join(supports)} repeat a name" if supports else "there is no support"
        msg = f"{label(case)}: {problem}; name each support that moves once"
        raise ModelError(msg)


@frozen(repr=False, field_transformer=named_arguments)
class SettlementCase(ModelObject):
    """Supports that give way under the dead load, as one rigid body and in one direction.

    The result is the reaction that remains when the structure begins to follow: the least reaction for which forces in
    equilibrium, within the strength of the joints, are the forces of a mechanism. The reaction is the force of the
    joints and the ties on the supports along the motion, positive against the motion. It does not include the weight of
    the supports.

    With a ``displacement`` the supports move on, and the structure is followed through large displacements: see
    :attr:`CaseResult.capacity`.

    Parameters
    ----------
    name
        Unique in an analysis.
    dead
        Loads that act in full.
    supports
        Names of the supports that move.
    direction : three floats or str
        Direction of the motion, of length 1. ``(0, 0, -1)`` and ``"-z"`` are a settlement. A horizontal direction is a
        spreading support, and the reaction is its thrust. With ``about``, the axis of a right-handed rotation.
    about : quantity, length, three components
        A point of the axis, if the supports turn. The reaction is then a moment about the axis.
    flow
        As for :class:`LimitCase`. With associative flow the reaction is the least that statics allows.
    displacement : quantity, length
        Displacement up to which the structure is followed. Without it, the case ends when the structure begins to
        follow.
    steps
        Approximate number of steps in which the supports reach this displacement.

    Attributes
    ----------
    direction : three floats
        Of length 1.
    about : three floats or None
        m.
    displacement : float or None
        m.

    Raises
    ------
    ModelError
        If there is no support, a support is repeated, or the direction is not of length 1. If supports turn or flow is
        associative, and there is a displacement.

    Examples
    --------
    >>> dead = LoadPattern("dead", [])
    >>> SettlementCase("left pier", dead, ["left pier"], "-z").direction
    (0.0, 0.0, -1.0)
    """

    name: str = field(validator=has_name)
    dead: LoadPattern = field(validator=instance_of(LoadPattern))
    supports: tuple[str, ...] = field(converter=_names, validator=_each_once)
    direction: Vector = field(converter=unit_vector, metadata={"dimension": "dimensionless"})
    about: Vector | None = field(
        default=None, kw_only=True, converter=optional_vector, metadata={"dimension": "length"}
    )
    flow: Flow = field(default=Flow.NONASSOCIATIVE, kw_only=True, converter=flow_rule)
    displacement: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata={"dimension": "length"}
    )
    steps: int = field(default=60, kw_only=True, converter=steps)

    def __attrs_post_init__(self) -> None:
        if self.displacement is None:
            return
        if self.about is not None:
            msg = f"{label(self)}: supports that turn have no displacement; leave out about or displacement"
            raise ModelError(msg)
        if self.flow is Flow.ASSOCIATIVE:
            msg = f"{label(self)}: associative flow would lift blocks without end; leave out flow or displacement"
            raise ModelError(msg)

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Load patterns of the case."""
        return (self.dead,)

    @property
    def question(self) -> str:
        """Load, motion and flow rule in words.

        >>> SettlementCase("left", LoadPattern("dead", []), ["left pier"], "-z").question
        'dead, left pier moves along (0, 0, -1), nonassociative flow'
        """
        return f"{self.dead.name}, {self.motion}, {self.flow} flow"

    @property
    def motion(self) -> str:
        """Motion of the supports in words.

        >>> SettlementCase("left", LoadPattern("dead", []), ["left pier"], "-z").motion
        'left pier moves along (0, 0, -1)'
        """
        who, one = ", ".join(self.supports), len(self.supports) == 1
        axis = "({:.4g}, {:.4g}, {:.4g})".format(*self.direction)
        if self.about is None:
            by = "" if self.displacement is None else f" by {quantity_text(self.displacement, 'length')}"
            return f"{who} {'moves' if one else 'move'} along {axis}{by}"
        point = "({:.4g}, {:.4g}, {:.4g}) m".format(*self.about)
        return f"{who} {'turns' if one else 'turn'} about {axis} through {point}"

    def renamed(self, name: str, flow: Flow | None = None) -> Self:
        """Return the case without a displacement, with another name and, if given, another flow rule."""
        other: Self = changed(self, name=name, flow=flow or self.flow, displacement=None)
        return other
