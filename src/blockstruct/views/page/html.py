"""The page and its data as text, as a file, and in a cell of a notebook.

The data are the geometry once, and all iterations of every case. Arrays are base64 of deflated little-endian numbers.
Places and forces are float32, and places have an origin near the structure, since survey coordinates exceed float32.
Values that are only drawn, or read to three digits, are float16.
"""

import base64
import json
import re
import zlib
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from plotly.offline import get_plotlyjs

import blockstruct as bs
from blockstruct.arrays import Array
from blockstruct.units import readable
from blockstruct.views import style, words
from blockstruct.views.console import plain
from blockstruct.views.export.motion import motion_of_states
from blockstruct.views.output import target_with, write_text
from blockstruct.views.selection import moving_bodies, shown_results
from blockstruct.views.solids import Patches, Solids, TieLines, eye, load_arrows, triangles
from blockstruct.views.style import parts


def write_page(analysis: bs.Analysis, path: str | Path) -> Path:
    """Write the page of an analysis and replace an existing file.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    StorageError
        If the path does not end in ``.html`` or cannot be written.
    """
    target = target_with(path, ".html", ".htm")
    return write_text(page_html(analysis), target)


def page_html(analysis: bs.Analysis) -> str:
    """Return the page of an analysis as self-contained HTML.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    """
    # Names are user text: "<" must not end the script element.
    data = json.dumps(payload(analysis), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    parts = {
        "title": escape(analysis.model.name),
        "plotly": get_plotlyjs(),
        "script": _resource("page.js"),
        "data": data,
    }
    # Replace all marks in one pass, so that inserted text is not searched for marks.
    return re.sub(rf"@({'|'.join(parts)})@", lambda mark: parts[mark[1]], _resource("page.html"))


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


class NotebookPage:
    """The interactive page of an analysis, as the value of a cell.

    The page is part of the notebook: it works in a saved notebook, without a kernel and without a network.

    Parameters
    ----------
    analysis
        An analysis.
    height
        Height in the cell, pixels.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    """

    def __init__(self, analysis: bs.Analysis, *, height: int = 640) -> None:
        self._name = analysis.model.name
        self._page = page_html(analysis)
        self._height = height

    def __repr__(self) -> str:
        return f"<page of {self._name!r}>"

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{escape(self._page)}" sandbox="allow-scripts allow-downloads" '
            f'style="width: 100%; height: {self._height}px; border: 0"></iframe>'
        )


def payload(analysis: bs.Analysis) -> dict[str, Any]:
    """Return all data of the page, as plain values for JSON.

    Raises
    ------
    ModelError
        If no case of the analysis has an iteration.
    """
    model = analysis.model
    shown = [r for r in analysis.values() if _is_shown(r)]
    if not shown:
        ended = "; ".join(map(str, analysis.values())) or "it has no case"
        msg = f"analysis of {model.name!r}: no case has an iteration to show ({ended}); run it again"
        raise bs.errors.ModelError(msg)
    solids = Solids.of(model)
    origin = _origin(solids)
    # Open a spread with the run as given.
    first = next((r for r in shown_results(analysis) if _is_shown(r)), shown[0])
    return {
        "name": model.name,
        "look": {
            "stone": style.STONE,
            "support": style.SUPPORT,
            "ghost": style.GHOST,
            "edge": style.EDGE,
            "force": style.FORCE,
            "dead": style.ACCENT,
            "amplitude": style.AMPLITUDE,
            "full": bs.results.FULLY_USED,
            "eye": eye(first).tolist(),
            "states": style.STATE_COLOURS,
            "ties": style.TIE_COLOURS,
            "utilisation": style.UTILISATION,
            "bodies": style.BODY_COLOURS,
        },
        "origin": origin.tolist(),
        "blocks": _blocks(model, solids, origin),
        "interfaces": _interfaces(model, shown[0], origin),
        "ties": _ties(model, origin),
        "cases": [
            _record(result, origin)
            if result.response is not None
            else _case(result, _head(analysis, result), solids, origin)
            for result in shown
        ],
        "first": next(k for k, r in enumerate(shown) if r is first),
        "omitted": [f"{r.name}: {r.headline}" for r in analysis.values() if not _is_shown(r)],
    }


def _is_shown(result: bs.CaseResult) -> bool:
    return bool(result.n_iterations) or result.response is not None


def _origin(solids: Solids) -> Array:
    """Return round coordinates (3,) near the middle of a structure, m; zero within about ten times its size."""
    step = 10.0 ** (np.ceil(np.log10(solids.size)) + 1)
    low, high = solids.vertices.min(axis=0), solids.vertices.max(axis=0)
    # Adding zero removes the sign of −0.
    return np.asarray(np.round((low + high) / 2 / step) * step + 0.0)


def _blocks(model: bs.Model, solids: Solids, origin: Array) -> dict[str, Any]:
    corners, _ = triangles(solids.vertices, solids.loops)
    return {
        "name": [b.name for b in model.blocks],
        "material": [b.material.name for b in model.blocks],
        "support": ["support" if b.fixed else f"held in {', '.join(b.held)}" * bool(b.held) for b in model.blocks],
        "weight": [b.weight for b in model.blocks],
        "volume": [b.volume for b in model.blocks],
        "size": solids.size,
        "centroids": _packed(solids.centroids - origin, "<f4"),
        "vertices": _packed(solids.vertices - origin, "<f4"),
        "of_vertex": _packed(solids.block_of_vertex, "<i4"),
        "triangles": _packed(corners, "<i4"),
        "edges": _packed(solids.edges, "<i4"),
    }


def _interfaces(model: bs.Model, result: bs.CaseResult, origin: Array) -> dict[str, Any]:
    patches, pairs = Patches.of(model), bs.results.block_pairs(model)
    return {
        "name": [i.name for i in model.interfaces],
        "joint": [i.joint_material.name for i in model.interfaces],
        "area": [i.area for i in model.interfaces],
        "minus": pairs[:, 0].tolist(),
        "plus": pairs[:, 1].tolist(),
        "centroids": _packed(np.array([i.centroid for i in model.interfaces]) - origin, "<f4"),
        "frames": _packed(result.history["interface_frame"].to_numpy(), "<f4"),
        "vertices": _packed(patches.vertices - origin, "<f4"),
        "of_vertex": _packed(patches.of_vertex, "<i4"),
        "triangles": _packed(patches.corners, "<i4"),
        "of_triangle": _packed(patches.of_triangle, "<i4"),
    }


def _ties(model: bs.Model, origin: Array) -> dict[str, Any]:
    lines = TieLines.of(model)
    return {
        "name": lines.names,
        "of_vertex": _packed(lines.blocks.ravel(), "<i4"),
        "vertices": _packed(lines.ends.reshape(-1, 3) - origin, "<f4"),
    }


def _head(analysis: bs.Analysis, result: bs.CaseResult) -> dict[str, Any]:
    """Return the load factor, of the run as given in a spread, and the sentences below it."""
    spread = next((s for s in analysis.spreads.values() if result in s.results.values()), None)
    plain = result if spread is None else spread.given
    below = [] if result is plain else [words.status_words(plain)]
    below += [] if spread is None else [words.spread_words(spread)]
    below += [words.range_words(result), words.warning_words(plain), words.admissible_words(result)]
    return {"number": plain.headline.number, "below": [text for text in below if text]}


def _case(result: bs.CaseResult, head: dict[str, Any], solids: Solids, origin: Array) -> dict[str, Any]:
    history, resultants = result.history, result.resultants
    force = resultants["force"].transpose("iteration", "interface", "component").to_numpy()
    eccentricity = resultants["eccentricity"].transpose("iteration", "interface", "in_plane").to_numpy()
    pressed = bs.results.is_pressed(history, resultants)[..., None]
    largest = np.nan_to_num(np.abs(force)).max(axis=(1, 2))
    states = result.states.to_numpy()
    texts, index = np.unique(states.astype(str), return_inverse=True)
    motion = [bs.results.mechanism(history.isel(iteration=[i])) for i in range(result.n_iterations)]
    answer = result.answer
    answers = history["load_factor"].to_numpy() * answer.factor
    scale, unit = readable(answers, answer.unit) if answer.is_reaction else (1.0, "")
    velocity = [np.hstack([m["translation"].to_numpy(), m["rotation"].to_numpy()]) for m in motion]
    return {
        "name": result.name,
        "loads": _loads(result),
        "arrows": _arrows(result, origin),
        "answer": {"name": answer.name, "symbol": answer.symbol, "unit": unit or "-"},
        "head": head,
        "status": " ".join([words.status_words(result), *words.pushover_words(result)]),
        "certificate": words.certificate_words(result),
        "stage": [stage.replace("_", " ") for stage in history["stage"].to_numpy().tolist()],
        "answers": plain((answers * scale).tolist()),
        "measures": {label: plain(history[name].to_numpy().tolist()) for name, (label, *_) in style.MEASURES.items()},
        "largest": np.where(largest > 0, largest, 1.0).tolist(),
        "force": _packed(force, "<f4"),
        "eccentricity": _packed(np.where(pressed, eccentricity, np.nan), "<f4"),
        "states": texts.tolist(),
        "gravest": [parts(text)[0] for text in texts],
        "state": _packed(index.reshape(states.shape), "<u2"),
        "velocity": _packed(np.array(velocity), "<f2"),
        "share": [solids.drawn_share(solids.displacement(result, i)) for i in range(result.n_iterations)],
        **_bodies(result),
        "tie": _tie_rows(bs.ties.tie_state(history), bs.results.tie_forces(history)) if result.model.ties else [],
        **_utilisation(history),
        **_states(result, origin),
    }


def _record(result: bs.CaseResult, origin: Array) -> dict[str, Any]:
    """Return the response to a record: its states, and one iteration in which nothing acts or moves."""
    blocks, joints = len(result.model.blocks), len(result.model.interfaces)
    name, number = result.number()
    return {
        "name": result.name,
        "loads": _loads(result),
        "arrows": _arrows(result, origin),
        "answer": {"name": name, "symbol": "", "unit": ""},
        "head": {"number": number, "below": []},
        "status": " ".join([words.status_words(result), *words.response_words(result)]),
        "certificate": "",
        "stage": [""],
        "answers": [None],
        "measures": {"flow-rule gap": [None]},
        "largest": [1.0],
        "force": _packed(np.zeros((joints, 3)), "<f4"),
        "eccentricity": _packed(np.full((joints, 2), np.nan), "<f4"),
        "states": ["sticking"],
        "gravest": ["sticking"],
        "state": _packed(np.zeros(joints), "<u2"),
        "velocity": _packed(np.zeros((blocks, 6)), "<f2"),
        "share": [0.0],
        "body": [-1] * blocks,
        "bodies": [],
        "tie": [],
        **dict.fromkeys(("sliding", "crushing"), _packed(np.zeros(joints), "<f2")),
        **_states(result, origin),
    }


def _bodies(result: bs.CaseResult) -> dict[str, Any]:
    """Return the macro-blocks of the last mechanism: the body of each block, −1 at rest."""
    if not result.moves:
        return {"body": [-1] * len(result.model.blocks), "bodies": []}
    body, moving = moving_bodies(result, result.n_iterations - 1)
    return {
        "body": body.tolist(),
        "bodies": [{"name": one.name, "weight": one.total, "carried": one.carried} for one in moving],
    }


def _tie_rows(states: xr.DataArray, *columns: Array) -> list[list[tuple[Any, ...]]]:
    """Return state, force and elongation of each tie in every iteration or step."""
    values = (plain(column.tolist()) for column in columns)
    return [list(zip(*row, strict=True)) for row in zip(states.to_numpy().tolist(), *values, strict=True)]


def _loads(result: bs.CaseResult) -> str:
    masses = result.masses
    return f"{result.case.question}. {masses}" if masses else result.case.question


def _arrows(result: bs.CaseResult, origin: Array) -> list[dict[str, Any]]:
    """Return the forces of the dead and the variable load, scaled to a largest length of one in each."""
    return [
        {
            "grows": arrows.grows,
            "block": arrows.block.tolist(),
            "point": _packed(arrows.point - origin, "<f4"),
            "vector": _packed(arrows.force / arrows.largest, "<f4"),
        }
        for arrows in load_arrows(result)
    ]


def _utilisation(history: Any) -> Mapping[str, str]:
    used = bs.results.utilisation(history)
    return {kind: _packed(used[kind].transpose("iteration", "interface"), "<f2") for kind in ("sliding", "crushing")}


def _states(result: bs.CaseResult, origin: Array) -> dict[str, Any]:
    """Return the states of a motion, the place of every block in each, (S, B, 12), and the line of its diagram."""
    curve = result.response if result.capacity is None else result.capacity
    if curve is None:
        return {}
    motion = motion_of_states(result)
    placed = np.concatenate([motion.rotation.reshape(*motion.position.shape[:2], 9), motion.position - origin], 2)
    if result.capacity is not None:
        values, along = curve["reaction" if "reaction" in curve else "load_factor"], 1e3 * curve["displacement"]
        texts = "Capacity curve", "displacement", "mm", result.answer.symbol, result.answer.unit or "-"
    else:
        furthest = curve["block"][int(curve["peak_displacement"].isel(time=-1).argmax("block"))]
        values = 1e3 * (curve["displacement"].sel(block=furthest) ** 2).sum("axis") ** 0.5
        texts, along = (f"Displacement of block {furthest.item()}", "time", "s", "u", "mm"), curve["time"]
    ties = {}
    if "tie_force" in curve:
        columns = (curve[name].transpose(..., "tie").to_numpy() for name in ("tie_force", "tie_elongation"))
        ties = {"tie": _tie_rows(bs.results.pushed_tie_state(result.model, curve), *columns)}
    return {
        "motion": dict(zip(("title", "x", "x_unit", "y", "y_unit"), texts, strict=True))
        | {"along": along.to_numpy().tolist(), "values": values.to_numpy().tolist(), "places": _packed(placed, "<f4")}
        | ties
    }


def _packed(values: npt.ArrayLike, kind: str) -> str:
    with np.errstate(over="ignore"):
        raw = np.ascontiguousarray(values, dtype=kind).tobytes()
    return base64.b64encode(zlib.compress(raw)).decode("ascii")
