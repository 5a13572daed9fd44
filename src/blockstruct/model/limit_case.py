"""Limit cases."""

from attrs import field, frozen

from blockstruct.model.fields import ModelObject, has_name, instance_of, member, named_arguments
from blockstruct.model.loads import LoadPattern
from blockstruct.vocabulary import Flow


def flow_rule(value: Flow | str, what: str = "") -> Flow:
    """Return the flow rule of a name."""
    return member(value, Flow, what)


@frozen(repr=False, field_transformer=named_arguments)
class LimitCase(ModelObject):
    """A dead load that stays and a variable load that grows until collapse.

    Parameters
    ----------
    name
        Unique in an analysis.
    dead
        Loads that act in full.
    variable
        Loads that act times the load factor.
    flow
        ``"nonassociative"`` (sliding dilates by each joint's dilatancy angle, zero by default) or
        ``"associative"`` (sliding dilates by the friction angle: an upper bound, solved in one program).
    """

    name: str = field(validator=has_name)
    dead: LoadPattern = field(validator=instance_of(LoadPattern))
    variable: LoadPattern = field(validator=instance_of(LoadPattern))
    flow: Flow = field(default=Flow.NONASSOCIATIVE, converter=flow_rule)

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Load patterns of the case."""
        return (self.dead, self.variable)

    @property
    def question(self) -> str:
        """Loads and flow rule in words.

        >>> LimitCase("pushed", LoadPattern("dead", []), LoadPattern("push", [])).question
        'dead + load factor × push, nonassociative flow'
        """
        return f"{self.dead.name} + load factor × {self.variable.name}, {self.flow} flow"

    def renamed(self, name: str, flow: Flow | None = None) -> "LimitCase":
        """Return a limit case with the same loads, another name and, if given, another flow rule."""
        return LimitCase(name, self.dead, self.variable, flow or self.flow)
