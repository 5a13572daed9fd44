"""Histories, case results, interface resultants and states, mechanisms.

The history of a case is a self-contained :class:`xarray.Dataset`. Its coordinates hold the positions, frames and names
of contact points, interfaces and blocks. Every variable carries ``units``. Forces act on the plus block, compression
positive. Velocities belong to a variable load that does work at 1 W (``w_L·u = 1 W``).
"""

from blockstruct.limit import CERTIFICATE_MEASURES
from blockstruct.results.accessor import HistoryAccessor, capacity_frame, history_frame
from blockstruct.results.analysis import (
    Analysis,
    checked_parameters,
    checked_tags,
    checked_value,
    plain_value,
    restored_value,
    stored_value,
)
from blockstruct.results.capacity import (
    arrays_of_response,
    beginning_of,
    block_rotations,
    capacity_of,
    doubtful_parts,
    fallen_blocks,
    response_of,
    response_words,
    state_arrays,
    steps_of,
)
from blockstruct.results.case_result import AdmissibleState, CaseResult, Headline, LazyHistory
from blockstruct.results.comparison import Comparison, compare, compared_curves, relative_difference
from blockstruct.results.history import (
    HISTORY,
    Variable,
    division_of,
    history_of,
    history_variables,
    iteration_variables,
)
from blockstruct.results.interfaces import (
    FULLY_USED,
    NO_FORCE,
    active_joints,
    contact_state,
    corner_torsion,
    interface_resultants,
    is_pressed,
    parts_beyond,
    sliding_rates,
    support_reactions,
    utilisation,
)
from blockstruct.results.mechanism import MacroBlock, body_table, macro_blocks, mechanism, with_motion
from blockstruct.results.spread import Spread, run_name
from blockstruct.results.ties import (
    breaking_words,
    broken_ties,
    pushed_tie_state,
    tie_forces,
    tie_sentences,
    tie_state,
    ties_at_collapse,
)
from blockstruct.results.verification import confirm, contradictions, recomputed_certificate
from blockstruct.statics import applied_loads
from blockstruct.text import LOAD_FACTOR, pushed_masses

__all__ = ["CERTIFICATE_MEASURES", "LOAD_FACTOR", "AdmissibleState", "Analysis", "CaseResult", "Headline"]
__all__ += ["LazyHistory", "Spread", "run_name", "Comparison", "relative_difference", "compare", "compared_curves"]
__all__ += ["confirm", "contradictions", "recomputed_certificate"]
__all__ += ["checked_parameters", "checked_tags", "checked_value", "plain_value", "restored_value", "stored_value"]
__all__ += ["block_rotations", "breaking_words", "doubtful_parts", "broken_ties", "capacity_frame", "capacity_of"]
__all__ += ["pushed_tie_state", "arrays_of_response", "beginning_of", "fallen_blocks", "response_of", "response_words"]
__all__ += ["state_arrays", "steps_of"]
__all__ += ["applied_loads", "pushed_masses"]
__all__ += ["HistoryAccessor", "active_joints", "parts_beyond", "contact_state", "corner_torsion", "sliding_rates"]
__all__ += ["HISTORY", "history_frame", "division_of", "history_of", "history_variables", "iteration_variables"]
__all__ += ["Variable", "FULLY_USED", "NO_FORCE"]
__all__ += ["interface_resultants", "is_pressed", "support_reactions", "MacroBlock", "body_table", "macro_blocks"]
__all__ += ["mechanism", "with_motion", "tie_forces", "tie_sentences", "tie_state", "ties_at_collapse", "utilisation"]
