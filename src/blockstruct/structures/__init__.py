"""Builders of walls, arches, vaults, domes and columns, as lists of blocks that fit exactly.

>>> from blockstruct.model import Material
>>> tuff = Material("tuff", "12 kN/m^3")
>>> size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "thickness": "0.1 m"}
>>> blocks = courses([[1, 1], [0.5, 1, 0.5]], material=tuff, **size)
>>> len(blocks)
6
"""

from blockstruct.structures.courses import column, courses, stack, tilted
from blockstruct.structures.openings import Opening, RoundOpening
from blockstruct.structures.rubble import Rubble
from blockstruct.structures.vaults import arch, arch_on_piers, barrel_vault, cross_vault, dome
from blockstruct.structures.wall import Buttress, Sidewall, pier_spandrel, room, wall

__all__ = ["courses", "wall", "room", "pier_spandrel", "Opening", "RoundOpening", "Rubble", "Buttress", "Sidewall"]
__all__ += ["arch", "arch_on_piers", "barrel_vault", "cross_vault", "dome", "column", "stack", "tilted"]
