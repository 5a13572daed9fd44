"""Detection of interfaces between blocks, its report, and rules for joint materials.

>>> from blockstruct.model import Block, JointMaterial, Material
>>> tuff, dry = Material("tuff", "12 kN/m^3"), JointMaterial("dry", 0.65)
>>> ground = Block.box("ground", "0 m, 0 m, -0.2 m".split(", "), ["1 m", "1 m", "0.2 m"], tuff, fixed=True)
>>> block = Block.box("block", ["0 m"] * 3, ["1 m"] * 3, tuff)
>>> [interface.name for interface in detect_interfaces([ground, block], joint_material=dry).interfaces]
['ground|block']
"""

from blockstruct.contacts.detection import CorrectedJoints, corrected_joints, detect_interfaces
from blockstruct.model import Detection, DetectionReport, DetectionTolerances, FoundContact

__all__ = ["Detection", "DetectionReport", "DetectionTolerances", "FoundContact", "detect_interfaces"]
__all__ += ["CorrectedJoints", "corrected_joints"]
