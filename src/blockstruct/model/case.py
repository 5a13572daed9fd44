"""Cases of an analysis."""

from blockstruct.model.limit_case import LimitCase
from blockstruct.model.record_case import RecordCase
from blockstruct.model.settlement_case import SettlementCase

#: Any case of an analysis.
Case = LimitCase | SettlementCase | RecordCase
