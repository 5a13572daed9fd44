"""Friction angles of dry joints between plane, clean stone surfaces."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from blockstruct.library.entry import Entry, Range, looked_up
from blockstruct.model import JointMaterial

_BARTON = (
    "N. Barton, V. Choubey, The shear strength of rock joints in theory and practice, Rock Mechanics 10 (1977) 1–54: "
    "basic friction angles of plane, unweathered surfaces"
)
_BARTON_READ = (
    "the table of these values in a textbook (Mechanics of Asphalt: Microstructure and Micromechanics, Table 2.5)"
)
_TRB = "Transportation Research Board (1990), typical friction angles of rock joints without infill"
_TRB_READ = (
    "B. Look, Handbook of Geotechnical Investigation and Design Tables, Table 9.15, and the project Statics of "
    "drystone walls (stonewalls.ch), which gives the same angles for dry surfaces of stones in walls"
)
_PLANE = "Roughness adds to the basic friction angle, wear takes from it: test the joint where it governs."


@dataclass(frozen=True, slots=True, kw_only=True)
class DryJoint(Entry):
    """A kind of dry joint with its friction angle."""

    def joint_material(self, name: str | None = None, *, friction_angle: Any, **others: Any) -> JointMaterial:
        """Return a joint material with a friction angle of the library.

        Parameters
        ----------
        name
            Name of the material; the name of the entry by default.
        friction_angle
            ``"min"``, ``"mean"`` or ``"max"``, or an angle within the range.
        others
            Further arguments of :class:`blockstruct.JointMaterial`, which do not come from the library.
        """
        angle, words = self.choose("friction_angle", friction_angle)
        source = self.cited([words]) + (f"; given by the author: {', '.join(others)}" if others else "")
        return JointMaterial(name or self.name, friction_angle=angle, **{"source": source, **others})


def _joint(name: str, original: str, low: float, high: float, source: str, verified: str) -> DryJoint:
    angle = Range(low, high, "deg", "angle", "friction angle")
    return DryJoint(
        name=name,
        original=original,
        ranges={"friction_angle": angle},
        source=source,
        verified=verified,
        notes=(_PLANE,),
    )


_BASIC = {
    "sandstone": ((26, 35), (25, 34)),
    "limestone": ((31, 37), (27, 35)),
    "basalt": ((35, 38), (31, 36)),
    "fine-grained granite": ((31, 35), (29, 31)),
    "coarse-grained granite": ((31, 35), (31, 33)),
    "gneiss": ((26, 29), (23, 26)),
}
_CLASSES = {
    "low-friction stone": ("schist, shale", 20, 27),
    "medium-friction stone": ("sandstone, siltstone, chalk, gneiss, slate", 27, 34),
    "high-friction stone": ("basalt, granite, limestone, conglomerate", 34, 40),
}
_TABLE = [
    _joint(f"{stone}, {state}", f"plane {state} joint of {stone}", *ends, _BARTON, _BARTON_READ)
    for stone, states in _BASIC.items()
    for state, ends in zip(("dry", "wet"), states, strict=True)
] + [_joint(name, stones, low, high, _TRB, _TRB_READ) for name, (stones, low, high) in _CLASSES.items()]
#: All kinds of dry joints, by name.
JOINTS: Mapping[str, DryJoint] = MappingProxyType({entry.name: entry for entry in _TABLE})


def joint(name: str) -> DryJoint:
    """Return the kind of dry joint with a name.

    Raises
    ------
    UnknownNameError
        If no kind has this name.

    Examples
    --------
    >>> limestone = joint("limestone, dry")
    >>> print(limestone.ranges["friction_angle"])
    31 to 37 deg
    >>> round(limestone.joint_material("dry joints", friction_angle="min").friction_coefficient, 3)
    0.601
    """
    return looked_up(name, JOINTS, "joint")
