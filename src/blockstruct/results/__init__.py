"""Histories, case results, interface resultants and states, mechanisms.

The history of a case is a self-contained :class:`xarray.Dataset`. Its coordinates hold the positions, frames and names
of contact points, interfaces and blocks. Every variable carries ``units``. Forces act on the plus block, compression
positive. Velocities belong to a variable load that does work at 1 W (``w_L·u = 1 W``).
"""

from blockstruct.limit.certificate import CERTIFICATE_MEASURES
from blockstruct.results.accessor import HistoryAccessor, capacity_frame, history_frame
from blockstruct.results.analysis import Analysis, Spread, stored_value
from blockstruct.results.capacity import (
    block_rotations,
    capacity_of,
    doubtful_parts,
    fallen_blocks,
    response_of,
    response_words,
)
from blockstruct.results.case_result import AdmissibleState, CaseResult
from blockstruct.results.comparison import Comparison, compare, compared_curves
from blockstruct.results.history import history_of
from blockstruct.results.interfaces import (
    FULLY_USED,
    NO_FORCE,
    active_joints,
    block_pairs,
    contact_forces,
    contact_state,
    corner_torsion,
    interface_resultants,
    is_pressed,
    parts_beyond,
    support_reactions,
    utilisation,
)
from blockstruct.results.mechanism import MacroBlock, body_table, macro_blocks, mechanism, twists, velocities
from blockstruct.results.ties import (
    breaking_words,
    broken_ties,
    pushed_tie_state,
    tie_forces,
    tie_sentences,
    ties_at_collapse,
)
from blockstruct.results.verification import contradictions, recomputed_certificate
from blockstruct.statics.wrenches import applied_loads
from blockstruct.text.case import pushed_masses
from blockstruct.text.headline import Headline
from blockstruct.text.numbers import LOAD_FACTOR

__all__ = ["AdmissibleState", "Analysis", "CaseResult", "Comparison", "Headline", "HistoryAccessor", "MacroBlock"]
__all__ += ["Spread", "compare", "compared_curves", "contradictions", "recomputed_certificate", "stored_value"]
__all__ += ["CERTIFICATE_MEASURES", "LOAD_FACTOR", "applied_loads", "pushed_masses", "history_of", "history_frame"]
__all__ += ["active_joints", "contact_state", "corner_torsion", "interface_resultants", "is_pressed", "parts_beyond"]
__all__ += ["support_reactions", "utilisation", "FULLY_USED", "NO_FORCE", "macro_blocks", "body_table", "mechanism"]
__all__ += ["twists", "velocities", "block_pairs", "contact_forces"]
__all__ += ["breaking_words", "broken_ties", "pushed_tie_state", "tie_forces", "tie_sentences", "ties_at_collapse"]
__all__ += ["block_rotations", "capacity_frame", "capacity_of", "doubtful_parts", "fallen_blocks", "response_of"]
__all__ += ["response_words"]
