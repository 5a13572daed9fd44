"""Turn a model into arrays: contact points, equilibrium matrix, wrenches.

>>> import blockstruct as bs
>>> tuff, dry = bs.Material("tuff", "12 kN/m^3"), bs.JointMaterial("dry", 0.65)
>>> blocks = bs.courses([[1, 1]], unit_length="0.4 m", unit_height="0.2 m", thickness="0.1 m", material=tuff)
>>> model = bs.Model("row", blocks, bs.detect_interfaces(blocks, joint_material=dry))
>>> statics = Statics.of(model)
>>> statics.A.shape
(12, 36)
"""

from blockstruct.statics.carried import CarriedWeights, carried_weights
from blockstruct.statics.contacts import ContactPoints, Division
from blockstruct.statics.equilibrium import equilibrium_matrix
from blockstruct.statics.moved import MovedContacts, MovingLoads, MovingStructure, Placement, rotated
from blockstruct.statics.moving_cells import Crushed, MovingCells
from blockstruct.statics.statics import Statics
from blockstruct.statics.ties import TieTable
from blockstruct.statics.uniform_friction import multiple_of_uniform_friction, torsion_levers
from blockstruct.statics.wrenches import AppliedLoads, applied_loads, magnitude, wrenches

__all__ = [
    "AppliedLoads",
    "CarriedWeights",
    "ContactPoints",
    "Crushed",
    "Division",
    "MovedContacts",
    "MovingCells",
    "MovingLoads",
    "MovingStructure",
    "Placement",
    "Statics",
    "TieTable",
    "applied_loads",
    "carried_weights",
    "equilibrium_matrix",
    "magnitude",
    "multiple_of_uniform_friction",
    "rotated",
    "torsion_levers",
    "wrenches",
]
