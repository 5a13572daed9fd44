"""Motions of blocks with mass: the response of a structure to a record.

>>> import numpy as np
>>> import blockstruct as bs
>>> from blockstruct import Q_
>>> from blockstruct.statics import Statics
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

from blockstruct.motion.record import check_record, kept_interval, respond, time_step

__all__ = ["check_record", "kept_interval", "respond", "time_step"]
