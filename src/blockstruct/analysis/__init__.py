"""Run the limit cases of a model and keep their results.

>>> import blockstruct as bs
>>> from blockstruct import Q_
>>> stone = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
>>> dry = bs.JointMaterial("dry", friction_coefficient=0.65)
>>> ground = bs.Block.box("ground", Q_([0, 0, -0.2], "m"), Q_([1, 1, 0.2], "m"), stone, fixed=True)
>>> block = bs.Block.box("block", Q_([0, 0, 0], "m"), Q_([0.5, 1, 1], "m"), stone)
>>> found = bs.detect_interfaces([ground, block], joint_material=dry)
>>> model = bs.Model("one block", [ground, block], found)
>>> push = bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
>>> case = bs.LimitCase("rocking", bs.LoadPattern("dead", [bs.SelfWeight()]), push, flow="associative")
>>> round(AnalysisManager(model).run([case])["rocking"].load_factor, 6)
0.5
"""

from blockstruct.analysis.events import (
    CaseFinished,
    CaseStarted,
    Event,
    IterationDone,
    Listener,
    StateDone,
    StepDone,
    print_lines,
)
from blockstruct.analysis.manager import AnalysisManager, kept_analysis, recover, reproduce, run
from blockstruct.analysis.ties import least_tie_force

__all__ = ["AnalysisManager", "kept_analysis", "least_tie_force", "recover", "reproduce", "run"]
__all__ += ["CaseFinished", "CaseStarted", "Event", "IterationDone", "Listener", "StateDone", "StepDone"]
__all__ += ["print_lines"]
