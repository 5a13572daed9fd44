"""Limit cases: what is asked of a model."""

from dataclasses import dataclass

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import checked_name
from blockstruct.model.loads import LoadPattern
from blockstruct.vocabulary import Flow


@dataclass(frozen=True, slots=True)
class LimitCase:
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

    name: str
    dead: LoadPattern
    variable: LoadPattern
    flow: Flow = Flow.NONASSOCIATIVE

    def __post_init__(self) -> None:
        checked_name(self.name, "limit case")
        for role in ("dead", "variable"):
            if not isinstance(getattr(self, role), LoadPattern):
                msg = f"limit case {self.name!r}: {role} load is {shown(getattr(self, role))}; give a LoadPattern"
                raise ModelError(msg)
        try:
            object.__setattr__(self, "flow", Flow(self.flow))
        except (ValueError, TypeError, RecursionError):
            msg = f"limit case {self.name!r}: flow {shown(self.flow)}; give one of {', '.join(Flow)}"
            raise ModelError(msg) from None

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Its load patterns."""
        return (self.dead, self.variable)

    @property
    def question(self) -> str:
        """What it asks, in words.

        >>> LimitCase("pushed", LoadPattern("dead", []), LoadPattern("push", [])).question
        'dead + load factor × push, nonassociative flow'
        """
        return f"{self.dead.name} + load factor × {self.variable.name}, {self.flow} flow"

    def renamed(self, name: str, flow: Flow | None = None) -> "LimitCase":
        """The same loads by another name, with another flow rule if one is given; what follows collapse is left out."""
        return LimitCase(name, self.dead, self.variable, flow or self.flow)
