"""Turn a model into arrays: contact points, equilibrium matrix, wrenches.

>>> import blockstruct as bs
>>> from blockstruct.statics.statics import Statics
>>> tuff, dry = bs.Material("tuff", "12 kN/m^3"), bs.JointMaterial("dry", 0.65)
>>> blocks = bs.courses([[1, 1]], unit_length="0.4 m", unit_height="0.2 m", thickness="0.1 m", material=tuff)
>>> model = bs.Model("row", blocks, bs.detect_interfaces(blocks, joint_material=dry))
>>> statics = Statics.of(model)
>>> statics.A.shape
(12, 36)
"""
