"""Cases of an analysis."""

from blockstruct.model.limit_case import LimitCase
from blockstruct.model.settlement_case import SettlementCase

#: Any case of an analysis.
Case = LimitCase | SettlementCase
