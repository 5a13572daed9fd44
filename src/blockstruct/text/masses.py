"""Sentences on masses that a push moves and on loads without effect."""

import numpy as np

from blockstruct.model import BodyForce, Case, Model, SelfWeight, SettlementCase, kind_of
from blockstruct.statics import applied_loads, carried_weights
from blockstruct.text.numbers import FEW
from blockstruct.text.ties import kilonewton
from blockstruct.vocabulary import listed

_NAMES = {"weight": "concentrated weights", "line_load": "line loads", "area_load": "area loads", "fill_load": "fill"}


def pushed_masses(model: Model, case: Case) -> str:
    """Return sentences on the acting loads of a case; usually empty.

    For a mass-proportional push they list the weights that it moves and the weights that it does not. Weights on
    supports have no effect. For a settlement they list loads on supports.
    """
    on_supports = _on_supports(model, case) if isinstance(case, SettlementCase) else ""
    return " ".join(filter(None, (_of_push(model, case), on_supports)))


def _of_push(model: Model, case: Case) -> str:
    if not any(isinstance(load, BodyForce) for p in case.patterns for load in p.loads):
        return ""
    free = np.array([not b.fixed for b in model.blocks])
    masonry = sum(b.weight for b in model.blocks if not b.fixed)
    carried = carried_weights(model, case.dead)
    names = np.array([_NAMES.get(kind_of(load), "") for load in case.dead.loads], dtype=object)
    parts = []
    for name in _NAMES.values():
        chosen = free[carried.block] & (names[carried.load] == name)
        weight, pushed = (float(column[chosen].sum()) for column in (carried.weight, carried.pushed))
        if weight:
            share = "" if pushed == weight else f" (of {kilonewton(weight)})"
            parts.append(f"{kilonewton(pushed)} {name}{share}")
    text = f"Pushed weight: {' + '.join([f'{kilonewton(masonry)} masonry', *parts])}."
    on_supports = float(carried.weight[~free[carried.block]].sum())
    if on_supports > 1e-9 * masonry:
        text += f" Weights of {kilonewton(on_supports)} on supports do nothing."
    if not any(isinstance(load, SelfWeight) for load in case.dead.loads):
        text += f" {case.dead.name!r} holds no self-weight: the blocks are pushed, but do not weigh."
    applied = applied_loads(model, case.dead)
    massless = np.array([kind_of(load) in ("point_load", "face_load") for load in case.dead.loads])
    down = -float(applied.force[massless[applied.load] & free[applied.block], 2].sum())
    if down > 1e-9 * max(masonry, 1.0):
        text += f" Forces of {case.dead.name!r}, {kilonewton(down)} downwards, have no mass and are not pushed."
    return text


def _on_supports(model: Model, case: Case) -> str:
    """Return the sentence on dead loads on supports; empty without any.

    The own weight of supports does not count.
    """
    others = np.array([not isinstance(load, SelfWeight | BodyForce) for load in case.dead.loads])
    applied = applied_loads(model, case.dead)
    fixed = np.array([b.fixed for b in model.blocks])
    chosen = fixed[applied.block] & others[applied.load]
    force, couple = (np.linalg.norm(part[chosen], axis=1).sum() for part in (applied.force, applied.couple))
    parts = [f"forces of {kilonewton(force)}"] * bool(force) + [f"moments of {kilonewton(couple)}·m"] * bool(couple)
    if not parts:
        return ""
    names = listed([model.blocks[k].name for k in np.unique(applied.block[chosen])], FEW)
    return (
        f"Loads of {case.dead.name!r} on supports do nothing, {' and '.join(parts)} on {names}: a reaction is what "
        "joints and ties bring to the supports that give way."
    )
