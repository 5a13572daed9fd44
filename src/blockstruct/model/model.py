"""The model: blocks, their interfaces and ties."""

import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterable
from typing import Any, ClassVar

import attrs
import numpy as np
from attrs import field, frozen

from blockstruct.arrays import SLIGHT
from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.geometry.neighbours import unsupported
from blockstruct.geometry.overlap import bodies_at
from blockstruct.model.block import Block
from blockstruct.model.detection_report import Detection, DetectionReport
from blockstruct.model.fields import ModelObject, changed, check_unrepeated, has_name, items, named_arguments, store
from blockstruct.model.fit import check_interfaces, check_overlaps
from blockstruct.model.interface import Interface
from blockstruct.model.materials import JointMaterial, Material
from blockstruct.model.ties import AnyTie, anchored, given_quantities, tie_kind_of, tie_segments
from blockstruct.notebook import html_table
from blockstruct.units import VectorLike, si_vector
from blockstruct.vocabulary import Torsion, counted, listed


@frozen(repr=False, init=False, eq=False, field_transformer=named_arguments)
class Model(ModelObject):
    """Blocks, their interfaces, their materials and ties.

    Parameters
    ----------
    name
        Name of the structure.
    blocks
        Blocks with unique names. At least one is fixed or on rollers.
    interfaces : Detection or iterable of Interface
        Result of :func:`blockstruct.detect_interfaces`, or interfaces with unique names between blocks of the model.
        The model accepts every interface of a Detection, because it knows the tolerances.
    detection
        Report on how interfaces given one by one were found, as ``found.report``. It is stored and reported with the
        model. It has no effect on the mechanics and the hash.
    ties : iterable of Tie, Strip or BondedBar
        Ties with unique names that pull blocks of the model together; none by default.

    Raises
    ------
    ModelError
        If a name is used twice, different materials share a name, no block is fixed or none is free, blocks float, or a
        tie joins nothing.
    GeometryError
        If blocks overlap, unless both are supports (small overlaps of blocks that are not convex may remain
        undetected), or if interfaces do not lie on their blocks or cover each other.
    UnknownNameError
        If an interface, a tie or the report names a block or an interface that the model does not have.
    """

    computed: ClassVar = {"characteristic_length": "length", "weight": "force"}

    name: str = field(validator=has_name)
    blocks: tuple[Block, ...] = field(converter=items, metadata={"kind": Block})
    interfaces: tuple[Interface, ...] = field(converter=items, metadata={"kind": Interface})
    detection: DetectionReport | None
    ties: tuple[AnyTie, ...] = field(converter=items, metadata={"kind": AnyTie})

    def __init__(
        self,
        name: str,
        blocks: Iterable[Block],
        interfaces: Detection | Iterable[Interface],
        *,
        detection: DetectionReport | None = None,
        ties: Iterable[AnyTie] = (),
    ) -> None:
        if isinstance(interfaces, Detection):
            detection = interfaces.report if detection is None else detection
            interfaces = interfaces.interfaces
        self.__attrs_init__(name, blocks, interfaces, detection, ties)
        self._check()
        self._check_ties()

    def __repr__(self) -> str:
        size = f"{self._size}, {counted(len(self.interfaces), 'interface')}"
        ties = f", {counted(len(self.ties), 'tie')}" if self.ties else ""
        return f"<Model {self.name!r}: {size}{ties}>"

    def _repr_html_(self) -> str:
        return html_table(self.name, ["", ""], self._rows())

    @property
    def _size(self) -> str:
        rollers = sum(b.is_roller for b in self.blocks)
        size = f"{counted(len(self.blocks), 'block')}, {sum(b.fixed for b in self.blocks)} fixed"
        return f"{size}, {rollers} on rollers" if rollers else size

    @property
    def materials(self) -> dict[str, Material]:
        """Materials of the blocks by name."""
        return {b.material.name: b.material for b in self.blocks}

    @property
    def joint_materials(self) -> dict[str, JointMaterial]:
        """Materials of the interfaces by name."""
        return {i.joint_material.name: i.joint_material for i in self.interfaces}

    @property
    def block_index(self) -> dict[str, int]:
        """Index of each block by its name."""
        return {b.name: i for i, b in enumerate(self.blocks)}

    @property
    def characteristic_length(self) -> float:
        """Cube root of the mean volume of the free blocks, m."""
        return float(np.mean([b.volume for b in self.blocks if not b.fixed]) ** (1 / 3))

    @property
    def weight(self) -> float:
        """Weight of the free blocks, N."""
        return math.fsum(b.weight for b in self.blocks if not b.fixed)

    def summary(self) -> str:
        """Return the size, weight, materials and ties of the model, one line each."""
        return "\n".join([self.name, *(f"  {name}: {text}" for name, text in self._rows())])

    def _rows(self) -> list[tuple[str, str]]:
        corners = np.concatenate([b.shape.vertices for b in self.blocks if not b.fixed])
        extent = " × ".join(f"{e:.4g}" for e in np.ptp(corners, axis=0))
        rows = [("blocks", f"{self._size}; the free ones weigh {self.weight / 1e3:.4g} kN and extend over {extent} m")]
        supports = [f"{b.name} (holds {', '.join(b.held)})" if b.is_roller else b.name for b in self.blocks if b.held]
        rows.append(("supports", listed(supports)))
        rows.append(("interfaces", f"{len(self.interfaces)}, {math.fsum(i.area for i in self.interfaces):.4g} m²"))
        rows += [("ties", ", ".join(tie.name for tie in self.ties))] if self.ties else []
        rows += [(f"material {m.name}", f"{m.unit_weight / 1e3:.4g} kN/m³") for m in self.materials.values()]
        return rows + [(f"joint material {j.name}", str(j)) for j in self.joint_materials.values()]

    @property
    def hash(self) -> str:
        """SHA-256 of the content with all bits of the SI numbers, unchanged by storage."""
        digest = hashlib.sha256()
        header: dict[str, Any] = {
            "name": self.name,
            "materials": [_fields(m) for m in self.materials.values()],
            "joint_materials": [_fields(m) for m in self.joint_materials.values()],
            "blocks": [
                (b.name, b.material.name, list(b.held) if b.is_roller else b.fixed, b.shape.faces) for b in self.blocks
            ],
            "interfaces": [(i.name, i.minus, i.plus, i.joint_material.name) for i in self.interfaces],
        }
        if self.ties:
            header["ties"] = [(tie_kind_of(t), t.name, t.start, t.end, given_quantities(t)) for t in self.ties]
        digest.update(json.dumps(header, sort_keys=True).encode())
        for points in [b.shape.vertices for b in self.blocks] + [i.polygon for i in self.interfaces]:
            digest.update(np.ascontiguousarray(points, dtype="<f8").tobytes())
        return digest.hexdigest()

    def block(self, name: str) -> Block:
        """Return the block with a name."""
        block = next((b for b in self.blocks if b.name == name), None)
        if block is None:
            msg = f"model {self.name!r}: no block {name!r}; it has {listed([b.name for b in self.blocks])}"
            raise UnknownNameError(msg)
        return block

    def block_at(self, point: VectorLike) -> Block:
        """Return the block at a point: inside it, or on a face that no other free block shares.

        Parameters
        ----------
        point : quantity, length, three components
            In global coordinates. A free block counts before a support.

        Raises
        ------
        ModelError
            If no block is at the point, or several blocks share it.

        Examples
        --------
        >>> from blockstruct import Q_
        >>> from blockstruct.model import Interface, JointMaterial
        >>> tuff = Material("tuff", "12 kN/m^3")
        >>> base = Block.box("base", "[0, 0, -1] m", "[1, 1, 1] m", tuff, fixed=True)
        >>> top = Block.box("top", "[0, 0, 0] m", "[1, 1, 1] m", tuff)
        >>> bed = Q_([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "m")
        >>> joint = Interface("bed", "base", "top", bed, JointMaterial("dry", 0.6))
        >>> Model("pier", [base, top], [joint]).block_at("[0.5, 0.5, 1] m").name
        'top'
        """
        at = np.array(si_vector(point, "length", f"model {self.name!r}: point"))
        within, on = bodies_at([b.shape for b in self.blocks], at, SLIGHT * self.characteristic_length)
        candidates = [self.blocks[k] for k in within or on]
        candidates = [b for b in candidates if not b.fixed] or candidates
        if len(candidates) == 1:
            return candidates[0]
        where = f"model {self.name!r}: the point ({', '.join(f'{x:.6g}' for x in at)}) m"
        if candidates:
            names = listed([b.name for b in candidates])
            msg = f"{where} is on a joint of {names}; move it into one of them, or name one"
        else:
            msg = f"{where} is in no block; the nearest is {self._nearest(at)}"
        raise ModelError(msg)

    def _nearest(self, point: Any) -> str:
        """Return the block whose box is nearest to a point, and the extent of this box."""
        corners = [(b.shape.vertices.min(axis=0), b.shape.vertices.max(axis=0)) for b in self.blocks]
        away = [float(np.linalg.norm(np.maximum(0, np.maximum(low - point, point - high)))) for low, high in corners]
        k = int(np.argmin(away))
        low, high = (end.round(6).tolist() for end in corners[k])
        return f"{self.blocks[k].name!r}, which extends from {low} to {high} m"

    def with_ties(self, ties: Iterable[AnyTie]) -> "Model":
        """Return the same structure with other ties."""
        other: Model = changed(self, ties=items(ties, AnyTie, f"model {self.name!r}: ties"))
        other._check_ties()
        return other

    def _check_ties(self) -> None:
        self._check_names("tie", self.ties)
        try:
            store(self, ties=tuple(anchored(tie, self.block_at) for tie in self.ties))
            tie_segments(self.ties, self.blocks)
        except ModelError as error:
            error.add_note(f"in model {self.name!r}")
            raise

    def _check_names(self, kind: str, objects: Iterable[Any]) -> None:
        check_unrepeated((o.name for o in objects), f"model {self.name!r}: {kind}")

    def _check(self) -> None:
        who = f"model {self.name!r}"
        self._check_names("block", self.blocks)
        self._check_names("interface", self.interfaces)
        for kind, materials in (
            ("material", {b.material for b in self.blocks}),
            ("joint material", {i.joint_material for i in self.interfaces}),
        ):
            twice = [n for n, count in Counter(m.name for m in materials).items() if count > 1]
            if twice:
                msg = f"{who}: different {kind}s share the names {listed(twice)}; rename them"
                raise ModelError(msg)
        if not any(b.held for b in self.blocks):
            msg = f"{who}: no block is fixed; add the ground as a block with fixed=True (--ground of imports)"
            raise ModelError(msg)
        if all(b.fixed for b in self.blocks):
            msg = f"{who}: every block is fixed, nothing can collapse; leave at least one free"
            raise ModelError(msg)
        known = self.block_index
        for interface in self.interfaces:
            ends = interface.minus, interface.plus
            for end in ends:
                if end not in known:
                    msg = f"{who}: interface {interface.name!r} joins block {end!r}, which is not in the model"
                    raise UnknownNameError(msg)
            if all(self.blocks[known[end]].fixed for end in ends):
                msg = (
                    f"{who}: interface {interface.name!r} joins two supports, {ends[0]!r} and {ends[1]!r}, between "
                    "which forces are indeterminate; remove it"
                )
                raise ModelError(msg)
        self._check_detection(known)
        fit = who, self.blocks, self.interfaces, self.detection, self.characteristic_length
        check_interfaces(*fit)
        # Overlaps come first, because an overlapping block has no interfaces and would count as floating.
        check_overlaps(*fit)
        self._check_floating(known)

    def _check_floating(self, known: dict[str, int]) -> None:
        ends = np.array([(known[i.minus], known[i.plus]) for i in self.interfaces], dtype=int)
        floating = [self.blocks[k].name for k in unsupported(np.array([bool(b.held) for b in self.blocks]), ends)]
        if floating:
            msg = (
                f"model {self.name!r}: floating blocks, {len(floating)} in all, have no path to a support through "
                f"interfaces: {listed(floating)}; close the gaps, detect interfaces with a larger tolerance or "
                "remove the blocks"
            )
            raise ModelError(msg)

    def _check_detection(self, known: dict[str, int]) -> None:
        if self.detection is None:
            return
        if not isinstance(self.detection, DetectionReport):
            msg = f"model {self.name!r}: detection is a {type(self.detection).__name__}; give found.report"
            raise ModelError(msg)
        accepted = {c.interface for c in self.detection.contacts if c.interface or not c.reason}
        for kind, unknown in (
            ("block", self.detection.blocks - known.keys()),
            ("interface", accepted - {i.name for i in self.interfaces}),
        ):
            if unknown:
                msg = (
                    f"model {self.name!r}: the detection names the {kind}s {listed(sorted(unknown))}, which are not in "
                    "the model; give the report of these blocks and all their interfaces, or no report"
                )
                raise UnknownNameError(msg)


def _fields(material: Material | JointMaterial) -> list[Any]:
    """Return the mechanical values of a material."""
    values = (getattr(material, f.name) for f in attrs.fields(type(material)) if f.name != "source")
    # Left out to keep the hash of models from before this choice.
    return [value for value in values if value is not Torsion.CORNERS]
