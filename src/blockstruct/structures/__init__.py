"""Builders of walls, arches, vaults, domes and columns, as lists of blocks that fit exactly.

>>> from blockstruct.model import Material
>>> tuff = Material("tuff", "12 kN/m^3")
>>> size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "thickness": "0.1 m"}
>>> blocks = courses([[1, 1], [0.5, 1, 0.5]], material=tuff, **size)
>>> len(blocks)
6
"""

from blockstruct.structures.arch import arch, arch_on_piers, barrel_vault
from blockstruct.structures.column import column, stack, tilted
from blockstruct.structures.courses import courses
from blockstruct.structures.cross_vault import cross_vault
from blockstruct.structures.dome import dome
from blockstruct.structures.openings import Opening, RoundOpening
from blockstruct.structures.pier_spandrel import pier_spandrel
from blockstruct.structures.room import room
from blockstruct.structures.rubble import Rubble
from blockstruct.structures.sides import Buttress, Sidewall
from blockstruct.structures.wall import wall

__all__ = ["courses", "wall", "room", "pier_spandrel", "Opening", "RoundOpening", "Rubble", "Buttress", "Sidewall"]
__all__ += ["arch", "arch_on_piers", "barrel_vault", "cross_vault", "dome", "column", "stack", "tilted"]
