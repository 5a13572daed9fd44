"""How the interfaces were found, as rows of a table."""

import math
from collections import Counter

import blockstruct as bs

#: Findings that are listed one by one.
_LISTED = 12


def detection_rows(model: bs.Model) -> list[tuple[str, list[str]]]:
    """What was accepted, what was left out and why: names of rows and the lines of each."""
    report = model.detection
    if report is None:
        return [("interfaces", ["given to the model without a report of their detection"])]
    limits, found = report.tolerances, [c for c in report.contacts if not c.reason]
    measured = [c for c in found if not math.isnan(c.gap)]
    lying = ", ".join(f"{area:.4g} m² {lie} joints" for lie, area in report.area_by_orientation.items())
    off, turned = (max((abs(getattr(c, name)) for c in measured), default=0.0) for name in ("gap", "angle"))
    limit = f"gap and penetration {_length(limits.gap)}, angle {_angle(limits.angle)}, area {limits.area:.3g} m²"
    accepted = [f"{len(found)} interfaces, {lying}", f"gap or penetration up to {_length(off)}, angle {_angle(turned)}"]
    rows = [("tolerances", [limit]), ("accepted", accepted)]
    by_hand = {i.name for i in model.interfaces} - {c.interface for c in measured}
    if by_hand:
        rows.append(("given, not measured", _listed(sorted(by_hand))))
    why = Counter(c.reason for c in report.rejected)
    rows.append(("left out", [", ".join(f"{n} by {reason}" for reason, n in why.items()) or "nothing"]))
    apart = [pair for pair in report.close if pair[2] > limits.gap]
    if len(apart) < len(report.close):
        rows.append(("touch along a line only", [f"{len(report.close) - len(apart)} pairs of blocks"]))
    rows += [
        (name, _listed(lines))
        for name, lines in (
            (
                f"slivers accepted; an area tolerance of {report.sliver_tolerance:.2g} m² leaves them out",
                [f"{c.minus} | {c.plus}: {c.area:.3g} m²" for c in report.accepted_slivers],
            ),
            ("contacts between supports, left out", [f"{a} | {b}" for a, b in report.between_supports]),
            (
                "near misses, within twice the tolerances",
                [f"{c.minus} | {c.plus}: {c.reason}, gap {_length(c.gap)}" for c in report.near_misses],
            ),
            ("overlapping blocks", [f"{a} | {b}: {_length(depth)} deep" for a, b, depth in report.overlaps]),
            ("close blocks without contact", [f"{a} | {b}: {_length(gap)} apart" for a, b, gap in apart]),
            ("faces that are not plane", [f"{b}, face {f}: {_length(off)}" for b, f, off in report.nonplanar_faces]),
            ("blocks without interface", list(report.untouched)),
        )
        if lines
    ]
    return rows


def _listed(lines: list[str]) -> list[str]:
    rest = len(lines) - _LISTED
    return lines[:_LISTED] + ([f"and {rest} more"] if rest > 0 else [])


def _length(metres: float) -> str:
    # Rounding of coordinates is not a gap.
    return f"{metres * 1e3:.3g} mm" if metres > 1e-9 else "0 mm"


def _angle(radians: float) -> str:
    return f"{math.degrees(radians):.3g}°"
