"""Find collapse states by procedures, each a generator of iterations.

The procedures are the associative program, the fictitious conditions of F. Portioli, C. Casapulla, L. Cascini (2015),
doi:10.1016/j.ijsolstr.2015.05.025, and the shifted objective of De Saxcé & Feng (1998).
"""

from blockstruct.procedures.dead_load import solve_dead_load
from blockstruct.procedures.least_tie_force import LeastTies, least_ties
from blockstruct.procedures.procedure import load_factor_at, solve_limit_case

__all__ = ["LeastTies", "least_ties", "load_factor_at", "solve_dead_load", "solve_limit_case"]
