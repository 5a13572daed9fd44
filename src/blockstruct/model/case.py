"""Cases of an analysis."""

from typing import TypeGuard

from blockstruct.model.limit_case import LimitCase
from blockstruct.model.pushover import Pushover
from blockstruct.model.record_case import RecordCase
from blockstruct.model.settlement_case import SettlementCase

#: Any case of an analysis.
Case = LimitCase | SettlementCase | RecordCase
#: A case whose blocks may be followed through large displacements.
MovingCase = Pushover | SettlementCase


def has_curve(case: Case) -> TypeGuard[MovingCase]:
    """Return whether the blocks of a case are followed through large displacements."""
    return isinstance(case, Pushover) or (isinstance(case, SettlementCase) and case.displacement is not None)
