"""Report on the contacts that a detection of interfaces accepted and rejected."""

import math
from collections.abc import Iterable
from typing import ClassVar

import numpy as np
import pandas as pd
from attrs import field, frozen

from blockstruct.arrays import SLIGHT
from blockstruct.model.fields import ModelObject
from blockstruct.model.interface import Interface
from blockstruct.notebook import html_table
from blockstruct.vocabulary import JointOrientation, counted, shortened

#: Kinds of findings that the console counts and does not list: there may be thousands.
_COUNTED = ("between supports, left out", "touch along a line only")
#: End of the reason of contacts with other blocks between their faces.
_BETWEEN = " between"


@frozen(repr=False)
class DetectionTolerances(ModelObject):
    """Tolerances of a detection.

    Attributes
    ----------
    gap : float
        Largest gap, and largest penetration, between two faces over their common area, m.
    angle : float
        Largest angle between two faces, radians.
    area : float
        Area up to which a contact is a line or a point, m².
    close : float
        Distance up to which blocks without a contact are reported as close, m.
    """

    gap: float = field(metadata={"dimension": "length"})
    angle: float = field(metadata={"dimension": "angle"})
    area: float = field(metadata={"dimension": "area"})
    close: float = field(metadata={"dimension": "length"})

    def __str__(self) -> str:
        return f"gap and penetration {_length(self.gap)}, angle {_angle(self.angle)}, area {self.area:.3g} m²"


@frozen(repr=False)
class FoundContact(ModelObject):
    """Two faces that look at each other, accepted as a contact or rejected with a reason.

    Attributes
    ----------
    minus, plus : str
        Blocks; the normal points from minus to plus.
    interface : str
        Name of the interface; empty if the contact was rejected.
    reason : str
        Reason of a rejection: ``angle``, ``gap``, ``penetration``, ``area``, ``supports`` (both blocks are fixed) or
        :func:`lies_between`. Empty if accepted.
    gap : float
        Largest gap over the common area, m; negative for a penetration. NaN if the user gave the interface.
    angle : float
        Between the faces, radians. NaN if the user gave the interface.
    area : float
        m².
    orientation : JointOrientation
    near_miss : bool
        Whether it was rejected, but is within twice every tolerance.
    """

    minus: str
    plus: str
    interface: str
    reason: str
    gap: float = field(metadata={"dimension": "length"})
    angle: float = field(metadata={"dimension": "angle"})
    area: float = field(metadata={"dimension": "area"})
    orientation: JointOrientation
    near_miss: bool

    @property
    def is_hidden(self) -> bool:
        """Whether it was rejected because other blocks lie between its two blocks."""
        return self.reason.endswith(_BETWEEN)


def lies_between(names: Iterable[str]) -> str:
    """Return the reason of a rejection by the blocks in between; empty without such blocks."""
    blocks = sorted(names)
    return f"block{'s' * (len(blocks) > 1)} {', '.join(blocks)}{_BETWEEN}" if blocks else ""


@frozen(repr=False)
class DetectionReport(ModelObject):
    """Contacts that a detection accepted or rejected, and defects of the blocks.

    Attributes
    ----------
    tolerances : DetectionTolerances
    contacts : tuple of FoundContact
        All pairs of close faces that look at each other, accepted or rejected.
    overlaps : tuple of (block, block, depth in m)
        Blocks that overlap by more than the gap tolerance plus the deviations of their faces from planes. A model
        refuses them, unless both are supports.
    nonplanar_faces : tuple of (block, face, deviation in m)
        Faces that are not plane. Their contacts are measured on their mean planes.
    floating : tuple of str
        Blocks without a path to a support through interfaces.
    untouched : tuple of str
        Blocks without any interface.
    close : tuple of (block, block, distance in m)
        Blocks without a contact that are close or touch along a line only. The distance is along a face.
    """

    computed: ClassVar = {"total_area": "area", "sliver_tolerance": "area"}

    tolerances: DetectionTolerances
    contacts: tuple[FoundContact, ...]
    overlaps: tuple[tuple[str, str, float], ...]
    nonplanar_faces: tuple[tuple[str, int, float], ...]
    floating: tuple[str, ...]
    untouched: tuple[str, ...]
    close: tuple[tuple[str, str, float], ...]

    @property
    def blocks(self) -> frozenset[str]:
        """Blocks with a finding."""
        pairs = [(c.minus, c.plus) for c in self.contacts] + [p[:2] for p in (*self.overlaps, *self.close)]
        single = [*(f[0] for f in self.nonplanar_faces), *self.floating, *self.untouched]
        return frozenset(single).union(*pairs)

    @property
    def accepted(self) -> int:
        """Number of interfaces found."""
        return sum(not c.reason for c in self.contacts)

    @property
    def total_area(self) -> float:
        """Area of the interfaces, m²."""
        return math.fsum(c.area for c in self.contacts if not c.reason)

    @property
    def rejected(self) -> tuple[FoundContact, ...]:
        """Rejected contacts, without contacts between supports."""
        return tuple(c for c in self.contacts if c.reason not in ("", "supports"))

    @property
    def near_misses(self) -> tuple[FoundContact, ...]:
        """Rejected contacts within twice every tolerance."""
        return tuple(c for c in self.contacts if c.near_miss)

    @property
    def accepted_slivers(self) -> tuple[FoundContact, ...]:
        """Interfaces a thousand times smaller than the largest interface of both of their blocks.

        With rounded coordinates, neighbours that meet along an edge or in a corner share such areas. A sliver carries
        any force, so slivers can raise a load factor by a percent. :attr:`sliver_tolerance` removes them.
        """
        accepted = [c for c in self.contacts if not c.reason]
        largest: dict[str, float] = {}
        for c in accepted:
            for end in (c.minus, c.plus):
                largest[end] = max(largest.get(end, 0.0), c.area)
        return tuple(c for c in accepted if c.area < SLIGHT * min(largest[c.minus], largest[c.plus]))

    @property
    def sliver_tolerance(self) -> float:
        """Area tolerance that rejects the accepted slivers, m²; zero without slivers."""
        area = max((c.area for c in self.accepted_slivers), default=0.0)
        # To two digits, upwards.
        unit = 10.0 ** (math.floor(math.log10(area)) - 1) if area else 0.0
        return unit * math.ceil(1.01 * area / unit) if area else 0.0

    @property
    def slivers(self) -> tuple[tuple[str, str, float], ...]:
        """Contacts rejected as a line or a point: minus, plus, area in m²."""
        return tuple((c.minus, c.plus, c.area) for c in self.contacts if c.reason == "area")

    @property
    def between_supports(self) -> tuple[tuple[str, str], ...]:
        """Contacts rejected because both blocks are fixed."""
        return tuple((c.minus, c.plus) for c in self.contacts if c.reason == "supports")

    @property
    def area_by_orientation(self) -> dict[JointOrientation, float]:
        """Area of the interfaces by the orientation of the joints, m²."""
        return {
            o: math.fsum(c.area for c in self.contacts if not c.reason and c.orientation == o)
            for o in JointOrientation
            if any(c.orientation == o and not c.reason for c in self.contacts)
        }

    @property
    def largest_misfit(self) -> str:
        """Largest gap or penetration, and largest angle, of the measured interfaces, in words."""
        measured = [c for c in self.contacts if not c.reason and not math.isnan(c.gap)]
        gap, angle = (max((abs(getattr(c, name)) for c in measured), default=0.0) for name in ("gap", "angle"))
        return f"gap or penetration up to {_length(gap)}, angle {_angle(angle)}"

    @property
    def hints(self) -> tuple[str, ...]:
        """Tolerances that would accept the rejected contacts, a text per reason, the most frequent reason first."""
        rejected = [c for c in self.rejected if c.reason != "area" and not c.is_hidden]
        turned, apart = ([c for c in rejected if (c.reason == "angle") is by_angle] for by_angle in (True, False))
        hints = []
        if turned:
            alone = sum(abs(c.gap) <= self.tolerances.gap for c in turned)
            angle, gap = (1.01 * max(values) for values in zip(*((c.angle, abs(c.gap)) for c in turned), strict=True))
            rest = "" if alone == len(turned) else f", with a gap tolerance of {gap:.3g} m {len(turned)}"
            taken = f"an angle tolerance of {math.degrees(angle):.3g} deg would take {alone}{rest}"
            hints.append((len(turned), f"{len(turned)} of {len(rejected)} rejected by angle: {taken}"))
        if apart:
            half, most = (f"{1.01 * gap:.3g} m" for gap in np.quantile([abs(c.gap) for c in apart], (0.5, 1.0)))
            taken = f"a gap tolerance of {half} would take half of them, {most} all"
            hints.append((len(apart), f"{len(apart)} of {len(rejected)} rejected by gap or penetration: {taken}"))
        known = {(c.minus, c.plus) for c in rejected}
        if open_joints := [pair for pair in self.close if pair[2] > self.tolerances.gap and pair[:2] not in known]:
            wide = 1.01 * max(distance for *_, distance in open_joints)
            taken = (
                "without contact pass no force, so neither block holds the other: the load factor is of open joints. A "
                f"gap tolerance of {wide:.3g} m would close them where faces are parallel; compare both load factors"
            )
            hints.append((0, f"{counted(len(open_joints), 'pair')} {taken}"))
        if small := self.accepted_slivers:
            taken = f"an area tolerance of {self.sliver_tolerance:.2g} m² leaves them out"
            much = f"{1 / SLIGHT:.0f} times smaller than joints next to them, may raise the load factor"
            hints.append((0, f"{counted(len(small), 'sliver')} among the interfaces, {much}: {taken}"))
        return tuple(text for _, text in sorted(hints, reverse=True))

    def listing(self) -> list[tuple[str, list[str]]]:
        """Return the findings by kind, one text per finding, as console and report print them."""
        untouched, pairs = set(self.untouched), [c for c in self.rejected if c.reason != "area"]
        apart, on_line = (
            [pair for pair in self.close if (pair[2] > self.tolerances.gap) is is_apart] for is_apart in (True, False)
        )
        kinds = {
            "accepted sliver": [f"{c.minus} | {c.plus}: {c.area:.3g} m²" for c in self.accepted_slivers],
            "sliver left out": [f"{a} | {b}: {area:.3g} m²" for a, b, area in self.slivers],
            _COUNTED[0]: [f"{a} | {b}" for a, b in self.between_supports],
            "block without interface": list(self.untouched),
            "rejected": [
                f"{c.minus} | {c.plus}: {c.reason}, gap {_length(c.gap)}, angle {_angle(c.angle)}, "
                f"area {c.area:.3g} m²{' (near miss)' if c.near_miss else ''}"
                for c in pairs
            ],
            "overlap": [f"{a} | {b}: {_length(depth)} deep" for a, b, depth in self.overlaps],
            "face not plane": [f"{b}, face {f}: {_length(off)} off its plane" for b, f, off in self.nonplanar_faces],
            "floating block": [b for b in self.floating if b not in untouched],
            "close without contact": [f"{a} | {b}: {_length(distance)} apart, no force" for a, b, distance in apart],
            _COUNTED[1]: [f"{a} | {b}" for a, b, _ in on_line],
        }
        return [(kind, texts) for kind, texts in kinds.items() if texts]

    def table(self) -> pd.DataFrame:
        """Return all findings as a table, one row per finding.

        Returns
        -------
        DataFrame
            ``finding`` is ``accepted``, ``accepted sliver``, ``rejected``, ``near miss``, ``between supports``,
            ``overlap``, ``close``, ``non-planar face`` or ``floating``; ``gap`` (negative for a penetration),
            ``deviation``, ``angle`` and ``area`` have the units of ``table.attrs["units"]``.
        """
        texts, numbers = ["minus", "plus", "interface", "reason", "orientation"], ["gap", "angle", "area", "deviation"]
        small = {c.interface for c in self.accepted_slivers}
        rows: list[dict[str, object]] = [
            {
                "finding": "accepted sliver" if c.interface in small else _finding(c),
                "orientation": str(c.orientation),
                **{name: getattr(c, name) for name in ("minus", "plus", "interface", "reason", "gap", "angle", "area")},
            }
            for c in self.contacts
        ]
        rows += [{"finding": "overlap", "minus": a, "plus": b, "gap": -depth} for a, b, depth in self.overlaps]
        rows += [{"finding": "close", "minus": a, "plus": b, "gap": distance} for a, b, distance in self.close]
        rows += [
            {"finding": "non-planar face", "minus": block, "face": face, "deviation": deviation}
            for block, face, deviation in self.nonplanar_faces
        ]
        rows += [{"finding": "floating", "minus": block} for block in self.floating]
        rows = [dict.fromkeys(texts, "") | row for row in rows]
        table = pd.DataFrame(rows, columns=["finding", *texts, *numbers, "face"])
        table = table.astype(dict.fromkeys(numbers, float) | {"face": "Int64"})
        table.attrs["units"] = {"gap": "meter", "angle": "radian", "area": "meter ** 2", "deviation": "meter"}
        return table

    def __repr__(self) -> str:
        return (
            f"<DetectionReport: {counted(self.accepted, 'interface')}, "
            f"{counted(len(self.rejected), 'contact')} rejected, "
            f"{counted(len(self.near_misses), 'near miss', 'near misses')}, {counted(len(self.overlaps), 'overlap')}>"
        )

    def _repr_html_(self) -> str:
        groups = self.table().groupby("finding", sort=False)
        rows = [
            (finding, len(rows), f"{rows['area'].sum():.4g}", f"{1e3 * rows['gap'].abs().max():.3g}")
            for finding, rows in groups
        ]
        return html_table(repr(self)[1:-1], ["finding", "number", "area [m²]", "largest gap [mm]"], rows, self.hints)

    def __str__(self) -> str:
        t = self.tolerances
        joints = [f"{orientation} {area:.6g} m^2" for orientation, area in self.area_by_orientation.items()]
        total = f"{counted(self.accepted, 'interface')}, {self.total_area:.6g} m^2"
        lines = [
            f"{total} (gap tolerance {t.gap:.3g} m, angle {math.degrees(t.angle):.3g} deg)",
            f"joints: {', '.join(joints) or 'none'}",
            *self.hints,
        ]
        for kind, texts in self.listing():
            lines.append(f"{kind}: {len(texts)}")
            if kind not in _COUNTED:
                lines += [f"  {text}" for text in shortened(texts, "{} more".format)]
        return "\n".join(lines)


@frozen(repr=False)
class Detection:
    """Interfaces of a set of blocks, and the report on their detection.

    Attributes
    ----------
    interfaces : tuple of Interface
    report : DetectionReport
    """

    interfaces: tuple[Interface, ...]
    report: DetectionReport

    def __repr__(self) -> str:
        return f"<Detection: {self.report!r}>"

    def _repr_html_(self) -> str:
        return self.report._repr_html_()


def _finding(contact: FoundContact) -> str:
    if contact.near_miss:
        return "near miss"
    return {"": "accepted", "supports": "between supports"}.get(contact.reason, "rejected")


def _length(metres: float) -> str:
    """Return a length in mm; rounding of coordinates counts as zero."""
    return f"{metres * 1e3:.3g} mm" if abs(metres) > 1e-9 else "0 mm"


def _angle(radians: float) -> str:
    """Return an angle in degrees."""
    return f"{math.degrees(radians):.3g}°"
