"""Blocks that move: pushovers and settlements to large displacements, and responses to records.

Each step of a pushover or a settlement is one of :func:`blockstruct.solvers.step.solve_step` on the moved geometry, and
prescribes the work of the variable load. A record moves blocks with their mass:

>>> import numpy as np
>>> import blockstruct as bs
>>> from blockstruct import Q_
>>> from blockstruct.motion.record import respond
>>> from blockstruct.statics.statics import Statics
>>> stone, dry = bs.Material("stone", "20 kN/m^3"), bs.JointMaterial("dry", 0.3)
>>> ground = bs.Block.box("ground", Q_([-1, -1, -0.2], "m"), Q_([3, 3, 0.2], "m"), stone, fixed=True)
>>> block = bs.Block.box("block", Q_([0, 0, 0], "m"), Q_([0.5, 0.5, 0.5], "m"), stone)
>>> model = bs.Model("one block", [ground, block], bs.detect_interfaces([ground, block], joint_material=dry))
>>> dead = bs.LoadPattern("dead", [bs.SelfWeight()])
>>> case = bs.RecordCase("pulse", dead, Q_([0.6, 0.6], "g_0"), "0.2 s", "+x")
>>> *_, last = respond(Statics.of(model), case)
>>> print(f"{1e3 * last.displacement[1, 0]:.1f} mm")
-117.7 mm
"""
