"""Detection of the interfaces, as rows of a table."""

import math
from collections import Counter

import blockstruct as bs
from blockstruct.vocabulary import counted

#: Findings that are listed.
_LISTED = 12


def detection_rows(model: bs.Model) -> list[tuple[str, list[str]]]:
    """Return accepted and rejected contacts, with reasons: names of rows and the lines of each."""
    report = model.detection
    if report is None:
        return [("interfaces", ["given to the model without a report of their detection"])]
    found = [c for c in report.contacts if not c.reason]
    lying = ", ".join(f"{area:.4g} m² {lie} joints" for lie, area in report.area_by_orientation.items())
    rows = [
        ("tolerances", [str(report.tolerances)]),
        ("accepted", [f"{counted(len(found), 'interface')}, {lying}", report.largest_misfit]),
    ]
    by_hand = {i.name for i in model.interfaces} - {c.interface for c in found if not math.isnan(c.gap)}
    if by_hand:
        rows.append(("given, not measured", _listed(sorted(by_hand))))
    why = Counter("blocks between" if c.is_hidden else c.reason for c in report.rejected)
    rows.append(("left out", [", ".join(f"{n} by {reason}" for reason, n in why.items()) or "nothing"]))
    apart = [pair for pair in report.close if pair[2] > report.tolerances.gap]
    if len(apart) < len(report.close):
        rows.append(
            ("touch along a line only", [counted(len(report.close) - len(apart), "pair of blocks", "pairs of blocks")])
        )
    if report.accepted_slivers:
        rows.append(
            ("hint", [f"an area tolerance of {report.sliver_tolerance:.2g} m² leaves the accepted slivers out"])
        )
    return rows + [(kind, _listed(lines)) for kind, lines in report.listing()]


def _listed(lines: list[str]) -> list[str]:
    rest = len(lines) - _LISTED
    return lines[:_LISTED] + ([f"and {rest} more"] if rest > 0 else [])
