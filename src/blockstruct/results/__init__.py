"""Histories, case results, interface resultants and states, mechanisms.

The history of a case is a self-contained :class:`xarray.Dataset`. Its coordinates hold the positions, frames and names
of contact points, interfaces and blocks. Every variable carries ``units``. Forces act on the plus block, compression
positive. Velocities belong to a variable load that does work at 1 W (``w_L·u = 1 W``).
"""

from blockstruct.limit import CERTIFICATE_MEASURES
from blockstruct.results.accessor import HistoryAccessor
from blockstruct.results.analysis import Analysis
from blockstruct.results.capacity import block_rotations, capacity_of, doubtful_parts, step_arrays, steps_of
from blockstruct.results.case_result import AdmissibleState, CaseResult, LazyHistory
from blockstruct.results.comparison import Comparison, compare, compared_curves, relative_difference
from blockstruct.results.frame import capacity_frame, history_frame
from blockstruct.results.headline import Headline
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
    interface_resultants,
    is_pressed,
    utilisation,
)
from blockstruct.results.joint_notes import parts_beyond
from blockstruct.results.mechanism import MacroBlock, body_table, macro_blocks, mechanism, with_motion
from blockstruct.results.parameters import (
    checked_parameters,
    checked_tags,
    checked_value,
    plain_value,
    restored_value,
    stored_value,
)
from blockstruct.results.reactions import support_reactions
from blockstruct.results.response import (
    arrays_of_response,
    beginning_of,
    fallen_blocks,
    response_arrays,
    response_of,
    response_words,
)
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
from blockstruct.results.torsion import corner_torsion, sliding_rates
from blockstruct.results.verification import confirm, contradictions, recomputed_certificate
from blockstruct.statics import applied_loads
from blockstruct.text import LOAD_FACTOR, pushed_masses

__all__ = [
    # results
    "CERTIFICATE_MEASURES",
    "LOAD_FACTOR",
    "AdmissibleState",
    "Analysis",
    "CaseResult",
    "Headline",
    "LazyHistory",
    "Spread",
    "run_name",
    "Comparison",
    "relative_difference",
    "compare",
    "compared_curves",
    "confirm",
    "contradictions",
    "recomputed_certificate",
    # parameters
    "checked_parameters",
    "checked_tags",
    "checked_value",
    "plain_value",
    "restored_value",
    "stored_value",
    # capacity curves
    "block_rotations",
    "breaking_words",
    "doubtful_parts",
    "broken_ties",
    "capacity_frame",
    "capacity_of",
    "pushed_tie_state",
    "arrays_of_response",
    "beginning_of",
    "fallen_blocks",
    "response_arrays",
    "response_of",
    "response_words",
    "step_arrays",
    "steps_of",
    # loads
    "applied_loads",
    "pushed_masses",
    # histories
    "HistoryAccessor",
    "active_joints",
    "parts_beyond",
    "contact_state",
    "corner_torsion",
    "sliding_rates",
    "history_frame",
    "division_of",
    "HISTORY",
    "Variable",
    "history_of",
    "history_variables",
    "iteration_variables",
    "FULLY_USED",
    "NO_FORCE",
    "interface_resultants",
    "is_pressed",
    "support_reactions",
    "MacroBlock",
    "body_table",
    "macro_blocks",
    "mechanism",
    "with_motion",
    "tie_forces",
    "tie_sentences",
    "tie_state",
    "ties_at_collapse",
    "utilisation",
]
