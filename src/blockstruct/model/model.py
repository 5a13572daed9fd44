"""The model: blocks and their interfaces."""

import hashlib
import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstruct.errors import GeometryError, ModelError, UnknownNameError
from blockstruct.geometry import areas_on_bodies, box_pairs, common_areas, overlapping_pairs, unsupported
from blockstruct.keywords import checked_keywords
from blockstruct.model.block import Block
from blockstruct.model.checks import checked_name, checked_tuple
from blockstruct.model.detection_report import DetectionReport
from blockstruct.model.interface import Interface
from blockstruct.model.joint_material import JointMaterial
from blockstruct.model.material import Material

#: Penetration, relative to the mean block size, that is rounding, and that blocks joined by an interface may have.
OVERLAP_TOLERANCE, JOINED_OVERLAP = 1e-5, 1e-2
#: Distance of an interface from the faces it lies on, relative to the smaller block: half of a wide, rough joint.
OFF_FACE = 5e-2
#: Share of the area of an interface that may lie beside the faces of its blocks: rounded corners.
OFF_OUTLINE = 1e-2
#: Share of an interface that another of the same blocks may cover.
AREA_SHARE = 1e-3


@checked_keywords
@dataclass(frozen=True, slots=True, init=False, eq=False)
class Model:
    """Blocks, their interfaces and their materials.

    Parameters
    ----------
    name
        Name of the structure.
    blocks
        Blocks with unique names, at least one of them fixed.
    interfaces
        Interfaces with unique names between blocks of the model, as found by
        :func:`blockstruct.detect_interfaces`.
    detection
        Report on how they were found, as ``found.report``: it is stored and reported with the model, whose
        mechanics and hash it does not touch.

    Raises
    ------
    ModelError
        Duplicate names, different materials of one name, no fixed or no free block, floating blocks.
    GeometryError
        Blocks that overlap (where one is not convex, small overlaps may escape), interfaces that do not lie on
        their blocks or cover each other.
    UnknownNameError
        An interface of a block that the model does not have, a report of blocks or interfaces that it does not have.
    """

    name: str
    blocks: tuple[Block, ...]
    interfaces: tuple[Interface, ...]
    detection: DetectionReport | None

    def __init__(
        self,
        name: str,
        blocks: Iterable[Block],
        interfaces: Iterable[Interface],
        *,
        detection: DetectionReport | None = None,
    ) -> None:
        object.__setattr__(self, "name", checked_name(name, "model"))
        object.__setattr__(self, "blocks", checked_tuple(blocks, Block, f"model {name!r}: blocks"))
        object.__setattr__(self, "interfaces", checked_tuple(interfaces, Interface, f"model {name!r}: interfaces"))
        object.__setattr__(self, "detection", detection)
        self._check()

    @property
    def materials(self) -> dict[str, Material]:
        """Materials of the blocks by name."""
        return {b.material.name: b.material for b in self.blocks}

    @property
    def joint_materials(self) -> dict[str, JointMaterial]:
        """Materials of the interfaces by name."""
        return {i.joint_material.name: i.joint_material for i in self.interfaces}

    @property
    def characteristic_length(self) -> float:
        """Cube root of the mean volume of the free blocks, m."""
        return float(np.mean([b.volume for b in self.blocks if not b.fixed]) ** (1 / 3))

    @property
    def hash(self) -> str:
        """SHA-256 of the content, to the last bit of the SI numbers: kept by storing and reloading."""
        digest = hashlib.sha256()
        header = {
            "name": self.name,
            "materials": [_fields(m) for m in self.materials.values()],
            "joint_materials": [_fields(m) for m in self.joint_materials.values()],
            "blocks": [(b.name, b.material.name, b.fixed, b.shape.faces) for b in self.blocks],
            "interfaces": [(i.name, i.minus, i.plus, i.joint_material.name) for i in self.interfaces],
        }
        digest.update(json.dumps(header, sort_keys=True).encode())
        for points in [b.shape.vertices for b in self.blocks] + [i.polygon for i in self.interfaces]:
            digest.update(np.ascontiguousarray(points, dtype="<f8").tobytes())
        return digest.hexdigest()

    def block(self, name: str) -> Block:
        """Block of a name."""
        for block in self.blocks:
            if block.name == name:
                return block
        msg = f"model {self.name!r}: no block {name!r}; it has {_listed([b.name for b in self.blocks])}"
        raise UnknownNameError(msg)

    def _check(self) -> None:
        who = f"model {self.name!r}"
        for kind, objects in (("block", self.blocks), ("interface", self.interfaces)):
            twice = [n for n, count in Counter(o.name for o in objects).items() if count > 1]
            if twice:
                msg = f"{who}: {kind} names used more than once: {_listed(twice)}; rename them"
                raise ModelError(msg)
        for kind, materials in (
            ("material", {b.material for b in self.blocks}),
            ("joint material", {i.joint_material for i in self.interfaces}),
        ):
            twice = [n for n, count in Counter(m.name for m in materials).items() if count > 1]
            if twice:
                msg = f"{who}: different {kind}s share the names {_listed(twice)}; rename them"
                raise ModelError(msg)
        if not any(b.fixed for b in self.blocks):
            msg = f"{who}: no block is fixed; make at least one a support with fixed=True"
            raise ModelError(msg)
        if all(b.fixed for b in self.blocks):
            msg = f"{who}: every block is fixed, nothing can collapse; leave at least one free"
            raise ModelError(msg)
        known = {b.name: i for i, b in enumerate(self.blocks)}
        for interface in self.interfaces:
            for end in (interface.minus, interface.plus):
                if end not in known:
                    msg = f"{who}: interface {interface.name!r} joins block {end!r}, which is not in the model"
                    raise UnknownNameError(msg)
        self._check_detection(known)
        self._check_interfaces(known)
        # Overlap first: an overlapping block has no interfaces, so it would pass for a floating one.
        self._check_overlap()
        self._check_floating(known)

    def _check_floating(self, known: dict[str, int]) -> None:
        ends = np.array([(known[i.minus], known[i.plus]) for i in self.interfaces], dtype=int)
        floating = [self.blocks[k].name for k in unsupported(np.array([b.fixed for b in self.blocks]), ends)]
        if floating:
            msg = (
                f"model {self.name!r}: floating blocks, {len(floating)} in all, have no way to a support through "
                f"interfaces: {_listed(floating)}; close the gaps, detect interfaces with a larger tolerance or "
                "remove the blocks"
            )
            raise ModelError(msg)

    def _check_detection(self, known: dict[str, int]) -> None:
        if self.detection is None:
            return
        if not isinstance(self.detection, DetectionReport):
            msg = f"model {self.name!r}: detection is a {type(self.detection).__name__}; give found.report"
            raise ModelError(msg)
        found = [c.interface for c in self.detection.contacts if c.interface or not c.reason]
        for kind, unknown in (
            ("block", self.detection.blocks - known.keys()),
            ("interface", set(found) - {i.name for i in self.interfaces}),
        ):
            if unknown:
                msg = (
                    f"model {self.name!r}: detection found with the {kind}s {_listed(sorted(unknown))}, which are not "
                    "in the model; give the report of these blocks and all their interfaces, or none"
                )
                raise UnknownNameError(msg)

    def _check_overlap(self) -> None:
        size = self.characteristic_length
        joined = {frozenset((i.minus, i.plus)) for i in self.interfaces}
        pairs = [
            (self.blocks[i].name, self.blocks[j].name, depth)
            for i, j, depth in overlapping_pairs([b.shape for b in self.blocks], OVERLAP_TOLERANCE * size)
        ]
        # Faces found in contact within a tolerance may penetrate by it.
        pairs = [p for p in pairs if frozenset(p[:2]) not in joined or p[2] > JOINED_OVERLAP * size]
        if pairs:
            named = [f"{a!r} and {b!r} by {d:.3g} m" for a, b, d in pairs]
            msg = (
                f"model {self.name!r}: overlapping blocks, {len(pairs)} pairs in all (limit "
                f"{OVERLAP_TOLERANCE * size:.3g} m): {_listed(named)}; move or cut the blocks, or detect interfaces "
                "with a tolerance above the penetration"
            )
            raise GeometryError(msg)

    def _check_interfaces(self, known: dict[str, int]) -> None:
        """Every polygon lies on faces of its minus block that look along its normal, and on faces of its plus block.

        The faces under a polygon that is not plane may be several, each looking another way.
        """
        if not self.interfaces:
            return
        interfaces, shapes = self.interfaces, [b.shape for b in self.blocks]
        ends = np.array([(known[i.minus], known[i.plus]) for i in interfaces])
        between = np.flatnonzero(np.array([b.fixed for b in self.blocks])[ends].all(axis=1))
        if len(between):
            found = interfaces[between[0]]
            msg = (
                f"model {self.name!r}: interface {found.name!r} joins two supports, {found.minus!r} and "
                f"{found.plus!r}, between which no force can be told; remove it"
            )
            raise ModelError(msg)
        extent = np.array([np.ptp(s.vertices, axis=0).max() for s in shapes])
        limits = OFF_FACE * extent[ends].min(axis=1) + 2 * np.array([i.deviation for i in interfaces])
        if self.detection is not None:
            limits = np.maximum(limits, self.detection.tolerances.gap)
        normals, areas = np.array([i.normal for i in interfaces]), np.array([i.area for i in interfaces])
        # On the minus blocks, then on the plus blocks.
        polygons, along = [i.polygon for i in interfaces] * 2, np.concatenate([normals, -normals])
        on_faces = areas_on_bodies(polygons, along, np.tile(limits, 2), shapes, ends.T.ravel()).reshape(2, -1)
        beside = np.argwhere(on_faces < (1 - OFF_OUTLINE) * areas)
        if len(beside):
            end, k = beside[0]
            msg = (
                f"model {self.name!r}: interface {interfaces[k].name!r} does not lie on a face of block "
                f"{self.blocks[ends[k, end]].name!r} that looks {('along', 'against')[end]} its normal: "
                f"{on_faces[end, k]:.3g} of its {areas[k]:.3g} m^2 do, within {limits[k]:.3g} m; give a polygon on "
                "both blocks, counter-clockwise seen from the plus block, and the report of the detection (detection=) "
                "if its tolerance was larger"
            )
            raise GeometryError(msg)
        self._check_covered(known)

    def _check_covered(self, known: dict[str, int]) -> None:
        """No area of a joint belongs to two interfaces of the same blocks."""
        slack = OFF_FACE * self.characteristic_length
        polygons = [interface.polygon for interface in self.interfaces]
        low, high = (np.array([f(p, axis=0) for p in polygons]) for f in (np.min, np.max))
        i, j = box_pairs(low - slack / 2, high + slack / 2)
        ends = np.sort([(known[interface.minus], known[interface.plus]) for interface in self.interfaces], axis=1)
        same = np.all(ends[i] == ends[j], axis=1)
        i, j = i[same], j[same]
        normals = np.array([interface.normal for interface in self.interfaces])
        parallel = np.abs(np.einsum("ij,ij->i", normals[i], normals[j])) > 0.99
        i, j = i[parallel], j[parallel]
        areas = np.array([interface.area for interface in self.interfaces])
        covered = np.flatnonzero(common_areas(polygons, normals, i, j, slack) > AREA_SHARE * areas[i])
        if len(covered):
            k = covered[0]
            msg = (
                f"model {self.name!r}: interfaces {self.interfaces[i[k]].name!r} and {self.interfaces[j[k]].name!r} "
                "cover the same area of one joint; remove one of them"
            )
            raise GeometryError(msg)


def _fields(material: Material | JointMaterial) -> list[Any]:
    return [getattr(material, slot) for slot in material.__slots__]


def _listed(names: list[str], most: int = 10) -> str:
    rest = len(names) - most
    return ", ".join(names[:most]) + (f" and {rest} more" if rest > 0 else "")
