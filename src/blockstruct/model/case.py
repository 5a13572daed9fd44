"""Cases: the questions that an analysis answers."""

from blockstruct.model.limit_case import LimitCase
from blockstruct.model.settlement_case import SettlementCase

#: Any question to a model.
Case = LimitCase | SettlementCase
