"""Define collapse states: limit problem, conic program and certificate.

The symbols follow F. Portioli, C. Casapulla, L. Cascini, "An efficient solution procedure for crushing
failure in 3D limit analysis of masonry block structures with non-associative frictional joints", Int. J. Solids
Struct. 69–70 (2015) 252–266: contact forces ``x = (n_k, s_k, t_k)``, load factor ``α``, equilibrium
``A x + w_D + α w_L = 0``, block velocities ``u`` with ``w_L·u = 1``, relative velocities ``v = Aᵀu``.

All quantities in this package are non-dimensional. The unit of length is a characteristic block size. The unit of the
wrench of a block is its dead wrench. The unit of a contact force is the dead wrench of the lighter of its two blocks.
"""

from blockstruct.limit.certificate import CERTIFICATE_MEASURES, Certificate, are_admissible, certify
from blockstruct.limit.friction import Sliding, fictitious_sliding, true_sliding
from blockstruct.limit.iteration import Iteration, Outcome
from blockstruct.limit.mirror import Mirror
from blockstruct.limit.motion import block_motion, unit_of_velocity, velocities_of
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, ProgramData, Solution, Solver
from blockstruct.limit.response import Fall, RecordState
from blockstruct.limit.settings import (
    SCHEDULES,
    FictitiousSchedule,
    Numerics,
    ProcedureSettings,
    scheduled,
    schedules_of,
)
from blockstruct.limit.settlement import Settlement, reaction_unit
from blockstruct.limit.ties import Ties
from blockstruct.limit.torsion import UniformTorsion
from blockstruct.statics import ContactPoints, Placement

__all__ = [
    # the limit problem and its settings
    "LimitProblem",
    "Mirror",
    "Settlement",
    "reaction_unit",
    "Ties",
    "UniformTorsion",
    "ProcedureSettings",
    "Fall",
    "RecordState",
    "FictitiousSchedule",
    "Numerics",
    "SCHEDULES",
    "scheduled",
    "schedules_of",
    # the programs
    "ConicProgram",
    "ContactPoints",
    "ProgramData",
    "Objective",
    "Sliding",
    "Solution",
    "Solver",
    "fictitious_sliding",
    "true_sliding",
    # velocities and what moves
    "Placement",
    "block_motion",
    "unit_of_velocity",
    "velocities_of",
    # results
    "CERTIFICATE_MEASURES",
    "Certificate",
    "Iteration",
    "Outcome",
    "are_admissible",
    "certify",
]
