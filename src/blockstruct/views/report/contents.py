"""Names and texts for the template of a report."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import blockstruct as bs
from blockstruct.text import report
from blockstruct.text.assumptions import assumption_sentences
from blockstruct.units import readable
from blockstruct.views import words
from blockstruct.views.console import directions_text, parameter_texts
from blockstruct.views.figures import drawings, overview
from blockstruct.views.report import summary
from blockstruct.views.selection import shown_results
from blockstruct.vocabulary import FEW, counted, shortened

#: Pictures of a case in the appendix, and their width and height, inches: three in a row. Size of the compass.
_DETAILS, _SMALL, _COMPASS = ("forces", "domain", "convergence"), (3.4, 2.7), (2.9, 3.1)
#: Diagrams on the page of a case.
_DIAGRAMS = ("capacity", "response")
#: Loads whose weight follows from their position.
_SPREAD = (bs.LineLoad, bs.AreaLoad, bs.FillLoad)


def contents(
    analysis: bs.Analysis,
    project: Mapping[str, str],
    checks: Iterable[bs.assess.LocalMechanismCheck] = (),
    unit_sizes: bs.assess.UnitSizes | None = None,
) -> dict[str, Any]:
    """Return everything that the template may name, texts with their units."""
    model, spreads, of_case = analysis.model, analysis.spreads, summary.checked(analysis, checks)
    results = list(analysis.values())
    masses = pushed_masses(model, results)
    flows = list(dict.fromkeys(r.case.flow for r in results))
    # The notes on the case relied on come first, and have the first numbers.
    notes = summary.Notes()
    first = summary.relied_on(analysis, of_case, notes)
    checks_of: dict[str, list[dict[str, Any]]] = {}
    for name, check in of_case:
        checks_of.setdefault(name, []).append(summary.verification(name, check, notes))
    every = [check for found in checks_of.values() for check in found]
    drawn = {name: summary.relied_motion(check) for name, check in of_case}
    # The picture of a single case is above the table.
    rows = drawn if len(drawn) > 1 else {}
    page: dict[str, Any] = {
        "project": {str(what): str(text) for what, text in project.items()},
        "name": model.name,
        "created_at": analysis.created_at,
        "model_hash": model.hash,
        "document_hash": analysis.document_hash,
        "tags": list(analysis.tags),
        "parameters": parameter_texts(analysis),
        "directions": directions_text(analysis),
        "overview": [summary.picture(replace(d, size=_COMPASS)) for d in overview(analysis)],
        "model": _model(model),
        "detection": detection_rows(model),
        "materials": [(m.name, quantity(m.unit_weight, "N/m³"), _source(m)) for m in model.materials.values()],
        "ties": [_tie(tie) for tie in model.ties],
        "joint_materials": [_joint(m, flows) for m in model.joint_materials.values()],
        "patterns": _patterns(results),
        "relied_on": first,
        "unit_sizes": "" if unit_sizes is None else str(unit_sizes),
        "answers": " / ".join(dict.fromkeys(map(_title, results))),
        "results": [_headline(r, notes, checks_of.get(r.name, []), rows.get(r.name)) for r in shown_results(analysis)],
        "verification": every,
        "rounded": bs.assess.lines.ROUNDED,
        "shared": summary.shared_sections(every),
        "undemanded": summary.undemanded(analysis),
        "spreads": [_spread(name, spread) for name, spread in spreads.items()],
        "geometry": summary.geometry_picture(model),
        "cases": [_case(r, notes, checks_of.get(r.name, []), drawn.get(r.name, r)) for r in shown_results(analysis)],
        "assumptions": assumptions(model, results, [check for _, check in of_case]),
        # A few stand among the assumptions.
        "masses": masses if len(masses) > FEW else (),
        "settings": list(results[0].settings.flat.items()),
        "versions": dict(analysis.versions),
    }
    # All cases of a note are known now.
    listed, numbers = notes.listed(first["name"]), first["notes"]
    first["notes"] = [item for item in listed if item[0] in numbers]
    return page | {"notes": [item for item in listed if item[0] not in numbers]}


def quantity(value: float, unit: str) -> str:
    """Return a value and its unit as readable text.

    >>> quantity(12000.0, "N/m³")
    '12 kN/m³'
    """
    if not np.isfinite(value):
        return "unlimited"
    factor, unit = readable(value, unit)
    return f"{value * factor:.4g} {unit}"


def _model(model: bs.Model) -> list[tuple[str, str]]:
    free = [b for b in model.blocks if not b.fixed]
    corners = np.concatenate([b.shape.vertices for b in free])
    areas = np.array([i.area for i in model.interfaces])
    ends = " to ".join(dict.fromkeys(f"{area:.4g}" for area in (areas.min(), areas.max())))
    joined = Counter(i.joint_material.name for i in model.interfaces)
    return [
        ("blocks", f"{len(free)} free, {len(model.blocks) - len(free)} fixed (supports)"),
        ("extent of the free blocks along x, y, z", " × ".join(f"{e:.4g}" for e in np.ptp(corners, axis=0)) + " m"),
        ("weight of the free blocks", quantity(model.weight, "N")),
        ("interfaces", f"{len(areas)}: " + ", ".join(f"{n} of {name}" for name, n in joined.items())),
        ("area of an interface", f"{ends} m², {areas.sum():.4g} m² in all"),
    ]


def _joint(m: bs.JointMaterial, flows: Sequence[bs.Flow]) -> list[str]:
    return [
        m.name,
        "infinite (never slides)"
        if np.isinf(m.friction_coefficient)
        else f"{m.friction_coefficient:.4g} ({np.degrees(np.arctan(m.friction_coefficient)):.3g}°)",
        _dilatancy(m, flows),
        quantity(m.cohesion, "Pa"),
        quantity(m.tensile_strength, "Pa"),
        quantity(m.compressive_strength, "Pa"),
        _source(m),
    ]


def _source(m: bs.Material | bs.JointMaterial) -> str:
    return m.source or report.NO_SOURCE


def _tie(tie: Any) -> list[str]:
    """Return name, kind, ends, properties and governing limit of a tie."""
    kind = bs.ties.tie_kind_of(tie)
    ends = [
        _vector(end, "m") if kind == "bonded_bar" else f"{end[0]} at {_vector(end[1], 'm')}"
        for end in (tie.start, tie.end)
    ]
    quantities = bs.ties.given_quantities(tie).items()
    texts = [f"{name.replace('_', ' ')} {_of_tie(value, bs.ties.TIE_QUANTITIES[name])}" for name, value in quantities]
    return [
        tie.name,
        kind.replace("_", " "),
        *ends,
        ", ".join(texts),
        f"{quantity(tie.capacity, 'N')} ({tie.governing})",
    ]


def _of_tie(value: float, dimension: str) -> str:
    if dimension in ("force", "stress"):
        return quantity(value, "N" if dimension == "force" else "Pa")
    return f"{value * 1e6:.4g} mm²" if dimension == "area" else f"{value * 1e3:.4g} mm"


def _dilatancy(m: bs.JointMaterial, flows: Sequence[bs.Flow]) -> str:
    """Return the dilatancy angle of each flow rule of the analysis."""
    if np.isinf(m.friction_coefficient):
        return "none"
    angle = {
        bs.Flow.NONASSOCIATIVE: f"{np.degrees(m.dilatancy_angle):.3g}°",
        bs.Flow.ASSOCIATIVE: f"{np.degrees(np.arctan(m.friction_coefficient)):.3g}°",
    }
    return angle[flows[0]] if len(flows) == 1 else ", ".join(f"{angle[flow]} {flow}" for flow in flows)


def _patterns(results: list[bs.CaseResult]) -> dict[str, list[str]]:
    patterns = {p.name: (p, r) for r in results for p in r.case.patterns}
    listed = {}
    for name, (pattern, r) in patterns.items():
        loads = bs.results.applied_loads(r.model, pattern, r.case.dead)
        down = -np.bincount(loads.load, loads.force[:, 2], minlength=len(pattern.loads))
        shown = [
            _load(load) + (f": {quantity(weight, 'N')} in all" if isinstance(load, _SPREAD) else "") + _mass(load)
            for load, weight in zip(pattern.loads, down, strict=True)
        ]
        listed[name] = shortened(shown, lambda rest: f"and {counted(rest, 'more load')}")
    return listed


def _load(load: Any) -> str:
    match load:
        case bs.SelfWeight():
            return "the weight of every block, along −z"
        case bs.BodyForce(direction=d, share=share):
            times = "" if share == 1 else f"{share:g} × "
            return f"{times}({d[0]:g}, {d[1]:g}, {d[2]:g}) times every block's own weight, and every weight it carries"
        case bs.PointLoad(block=block, point=point, force=force):
            return f"a force {_vector(force, 'N')}{_on(block)} at {_vector(point, 'm')}"
        case bs.FaceLoad():
            return _on_face(load)
        case bs.Moment(block=block, moment=moment):
            return f"a couple {_vector(moment, 'N·m')} on block {block}"
        case bs.Weight(block=block, point=point, weight=weight):
            return f"a weight of {quantity(weight, 'N')}{_on(block)} at {_vector(point, 'm')}"
        case bs.LineLoad(weight_per_length=weight):
            return f"a weight of {quantity(weight, 'N/m')} along a line {_where(load)}"
        case bs.AreaLoad(weight_per_area=weight):
            return f"a weight of {quantity(weight, 'Pa')} in plan {_where(load)}"
        case bs.FillLoad(unit_weight=weight, level=level, lateral_coefficient=k):
            sideways = f", with {k:g} of it as lateral pressure" if k else ""
            return f"fill of {quantity(weight, 'N/m³')} up to z = {level:.4g} m, {_where(load)}{sideways}"
    return str(load)


def _on(block: str | None) -> str:
    return "" if block is None else f" on block {block}"


def _where(load: bs.LineLoad | bs.AreaLoad | bs.FillLoad) -> str:
    """Return where a weight acts: its blocks and corners."""
    on = "on the blocks below" if load.block is None else f"on block {load.block}"
    if load.start is None or load.end is None:
        return f"{on}, on its open upper faces"
    spans = ", which bear all of it" if getattr(load, "spanning", False) else ""
    return f"{on} from {_vector(load.start, 'm')} to {_vector(load.end, 'm')}{spans}"


def _mass(load: Any) -> str:
    """Return the pushed share of the mass of a weight, if it is not all."""
    share = getattr(load, "mass_share", 1.0)
    if share == 1:
        return ""
    pushed = f"{100 * share:.3g} %" if share else "none"
    return f"; its weight acts in full, a mass-proportional push on {pushed} of its mass"


def _on_face(load: bs.FaceLoad) -> str:
    parts = [f"a traction {_vector(load.traction, 'Pa')}"] if any(load.traction) else []
    if load.pressure:
        parts.append(f"a pressure of {quantity(load.pressure, 'Pa')}")
    if load.unit_weight is not None:
        parts.append(f"a pressure that grows by {quantity(load.unit_weight, 'N/m³')} below z = {load.level:.4g} m")
    return f"{' and '.join(parts) or 'nothing'} on face {load.face} of block {load.block}"


def _vector(values: Any, unit: str) -> str:
    factor, unit = readable(values, unit)
    return "(" + ", ".join(f"{v * factor:.4g}" for v in values) + f") {unit}"


def _headline(
    r: bs.CaseResult, notes: summary.Notes, checks: Sequence[Mapping[str, Any]], drawn: bs.CaseResult | None
) -> dict[str, Any]:
    """Return the row of a case, with a picture of the mechanism that its check relies on."""
    head = r.headline
    return _result(r, checks) | {
        "range": head.range,
        "bound": head.bound and (head.answer.text(head.associative) if np.isfinite(head.associative) else "none"),
        "notes": _numbers(r, notes, checks),
        "checks": checks,
        "picture": drawn and summary.small_picture(drawn),
    }


def _numbers(r: bs.CaseResult, notes: summary.Notes, checks: Sequence[Mapping[str, Any]]) -> list[int]:
    """Return the numbers of the notes on a case, or on its checks, which include the notes on the run relied on."""
    if not checks:
        return notes.numbers(r.name, summary.cautions(r))
    return sorted({number for check in checks for number in check["notes"]})


def _result(r: bs.CaseResult, checks: Sequence[Mapping[str, Any]] = ()) -> dict[str, str]:
    """Return the status of a case, and the number that its checks rely on."""
    return {
        "name": r.name,
        "flow": r.case.flow.value,
        "status": r.ended,
        "number": ", ".join(check["alpha"] for check in checks) or r.number()[1],
        "begins": summary.beginning_words(r),
    }


def _title(r: bs.CaseResult) -> str:
    """Return the name of the number of a case, for the title of a column."""
    name = r.number()[0]
    return f"{name} [-]" if name == "load factor" else name


def _spread(name: str, spread: bs.results.Spread) -> dict[str, Any]:
    settings = spread.given.settings.flat
    return {
        "name": name,
        "words": words.spread_words(spread),
        "runs": [
            _result(r)
            | {
                "name": schedule,
                "settings": ", ".join(
                    f"{what.replace('_', ' ')} {f'{value:.4g}' if isinstance(value, float) else value}"
                    for what, value in r.settings.flat.items()
                    if value != settings[what]
                ),
                "holds": "none" if r.certificate is None else "holds" if r.certificate.holds else "does not hold",
            }
            for schedule, r in spread.results.items()
        ],
    }


def _case(
    r: bs.CaseResult, notes: summary.Notes, checks: Sequence[Mapping[str, Any]], drawn: bs.CaseResult
) -> dict[str, Any]:
    """Return the page of a case, with the mechanism drawn that its check relies on."""
    # A case without iterations has nothing to count or draw.
    states = Counter(r.states.isel(iteration=-1).to_numpy().tolist()) if r.n_iterations else Counter()
    return _result(r, checks) | {
        "question": r.case.question,
        "answer": r.answer.name.capitalize(),
        "iterations": r.n_iterations,
        "duration": f"{r.duration:.2f} s",
        "started_at": r.started_at,
        "status_words": " ".join(
            filter(None, (words.status_words(r), words.range_words(r), words.admissible_words(r)))
        ),
        "certificate_words": words.certificate_words(r),
        "ties": [*words.roller_words(r), *words.tie_words(r)],
        "pushover": words.pushover_words(r),
        "response": words.response_words(r),
        "states": sorted(states.items(), key=lambda item: -item[1]),
        "notes": _numbers(r, notes, checks),
        "checks": checks,
        "picture": summary.mechanism_picture(drawn),
        "diagrams": [summary.picture(d) for d in drawings(r) if d.name in _DIAGRAMS],
        "pictures": [summary.picture(replace(d, size=_SMALL)) for d in drawings(r) if d.name in _DETAILS],
    }


def pushed_masses(model: bs.Model, results: Sequence[bs.CaseResult]) -> list[str]:
    """Return the sentences on the masses of every push, each once."""
    return list(dict.fromkeys(filter(None, (bs.results.pushed_masses(model, r.case) for r in results))))


def assumptions(
    model: bs.Model, results: Sequence[bs.CaseResult], checks: Sequence[bs.assess.LocalMechanismCheck] = ()
) -> list[str]:
    """Return the assumptions of the model, the cases and their checks, as sentences."""
    return assumption_sentences(
        model,
        [r.case for r in results],
        words.cells_of(results),
        pushed_masses(model, results),
        has_curve=any(r.capacity is not None for r in results),
        rotates=any(check.curve is not None and check.result.capacity is None for check in checks),
        higher=bs.assess.lines.HIGHER if checks else "",
    )


def detection_rows(model: bs.Model) -> list[tuple[str, list[str]]]:
    """Return accepted and rejected contacts, with reasons: names of rows and the lines of each."""
    report = model.detection
    if report is None:
        return [("interfaces", ["given to the model without a report of their detection"])]
    accepted = [c for c in report.contacts if not c.reason]
    lying = ", ".join(f"{area:.4g} m² {lie} joints" for lie, area in report.area_by_orientation.items())
    rows = [
        ("tolerances", [str(report.tolerances)]),
        ("accepted", [f"{counted(len(accepted), 'interface')}, {lying}", report.largest_misfit]),
    ]
    by_hand = {i.name for i in model.interfaces} - {c.interface for c in accepted if not math.isnan(c.gap)}
    if by_hand:
        rows.append(("given, not measured", shortened(sorted(by_hand))))
    why = Counter("blocks between" if c.is_hidden else c.reason for c in report.rejected)
    rows.append(("left out", [", ".join(f"{n} by {reason}" for reason, n in why.items()) or "nothing"]))
    rows += [("hint", [hint]) for hint in report.hints]
    return rows + [(kind, shortened(lines)) for kind, lines in report.listing()]
