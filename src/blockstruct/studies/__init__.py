"""Many analyses of one structure: parameters, samples and directions.

>>> import blockstruct as bs
>>> from blockstruct import Q_
>>> stone = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
>>> def build(friction_coefficient):
...     ground = bs.Block.box("ground", Q_([0, 0, -0.2], "m"), Q_([1, 1, 0.2], "m"), stone, fixed=True)
...     block = bs.Block.box("block", Q_([0, 0, 0], "m"), Q_([0.5, 1, 1], "m"), stone)
...     dry = bs.JointMaterial("dry", friction_coefficient)
...     model = bs.Model("block", [ground, block], bs.detect_interfaces([ground, block], dry))
...     push = bs.LoadPattern("push", [bs.BodyForce("+x")])
...     return model, bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")
>>> data = study(build, {"friction_coefficient": [0.4, 0.6]}, workers=1)
>>> data.load_factor.sel(case="push").round(4).values.tolist()
[0.4, 0.5]
"""

from blockstruct.model import direction_cases
from blockstruct.studies.by_direction import Directions, directions
from blockstruct.studies.design import StudyDocument, read_study
from blockstruct.studies.running import StudyProgress, print_progress, study
from blockstruct.studies.summary import cases_with_load_factors, first_order, fragility, frame_of, summary

__all__ = ["StudyProgress", "print_progress", "read_study", "study", "StudyDocument"]
__all__ += ["cases_with_load_factors", "first_order", "fragility", "frame_of", "summary"]
__all__ += ["Directions", "direction_cases", "directions"]
