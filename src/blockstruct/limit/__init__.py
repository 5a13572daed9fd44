"""Define collapse states: limit problem, conic program and certificate.

The symbols follow F. Portioli, C. Casapulla, L. Cascini, "An efficient solution procedure for crushing
failure in 3D limit analysis of masonry block structures with non-associative frictional joints", Int. J. Solids
Struct. 69–70 (2015) 252–266: contact forces ``x = (n_k, s_k, t_k)``, load factor ``α``, equilibrium
``A x + w_D + α w_L = 0``, block velocities ``u`` with ``w_L·u = 1``, relative velocities ``v = Aᵀu``.

All quantities in this package are non-dimensional. The unit of length is a characteristic block size. The unit of the
wrench of a block is its dead wrench. The unit of a contact force is the dead wrench of the lighter of its two blocks.
"""

from blockstruct.limit.certificate import Certificate
from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import Iteration, Outcome
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import SCHEDULES

__all__ = ["SCHEDULES", "Certificate", "ConicProgram", "Iteration", "LimitProblem", "Outcome", "true_sliding"]
