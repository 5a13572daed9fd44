"""Reactions of the supports."""

import numpy as np
import xarray as xr

from blockstruct.model import Case, Model, SettlementCase
from blockstruct.statics import TieTable, wrenches
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import AXES, MOTIONS, Stage


def support_reactions(model: Model, case: Case, history: xr.Dataset) -> xr.Dataset:
    """Return the reactions of all supports in the last iteration.

    They act on the structure, in global axes. A fixed block passes on the forces of its joints and ties; loads on the
    block itself go to the ground. A block that is held in some motions is part of the structure: its loads count, and
    it has a reaction in these motions alone.

    Parameters
    ----------
    model, case, history
        Model, case and history of one result.

    Returns
    -------
    xarray.Dataset
        ``force``, N, and ``moment`` about the centroid of the block, N·m: dims support and axis. NaN without forces at
        a load factor of the case.
    """
    supports = np.flatnonzero([bool(b.held) for b in model.blocks])
    reaction = np.full((len(supports), 6), np.nan)
    if history.sizes["iteration"]:
        last = history.isel(iteration=-1)
        alpha = float(last["load_factor"])
        if np.isfinite(alpha) and not Stage(last["stage"].item()).is_of_dead_load:
            brought, loads = _of_joints(model, last), wrenches(model, case.dead, case.dead)
            if not isinstance(case, SettlementCase):
                loads = loads + alpha * wrenches(model, case.patterns[-1], case.dead)
            loads[[b.fixed for b in model.blocks]] = 0.0
            held = np.array([[motion in model.blocks[i].held for motion in MOTIONS] for i in supports])
            reaction = np.where(held, -(brought + loads)[supports], 0.0) + 0.0
    coords = {
        "support": ("support", np.array([model.blocks[i].name for i in supports], dtype=object)),
        "axis": ("axis", np.array(AXES, dtype=object)),
    }
    units = {"force": SI_UNITS["force"], "moment": SI_UNITS["moment"]}
    variables = {
        name: (("support", "axis"), part, {"units": units[name]})
        for name, part in zip(units, np.split(reaction, 2, axis=1), strict=True)
    }
    return xr.Dataset(variables, coords=coords)


def _of_joints(model: Model, last: xr.Dataset) -> np.ndarray:
    """Return the wrenches (B, 6) of joints and ties on all blocks about their centroids."""
    index = last["interface_of_contact_point"].to_numpy()
    local = last["contact_force"].transpose("contact_point", "component").to_numpy()
    force = np.einsum("kc,kca->ka", local, last["interface_frame"].to_numpy()[index])
    point, number = last["contact_point_position"].to_numpy(), model.block_index
    centroids = np.array([b.centroid for b in model.blocks])
    total = np.zeros((len(centroids), 6))
    for sign, side in ((1.0, "plus"), (-1.0, "minus")):
        block = np.array([number[getattr(i, side)] for i in model.interfaces])[index]
        moment = np.cross(point - centroids[block], force)
        np.add.at(total, block, sign * np.hstack([force, moment]))
    if model.ties:
        columns = TieTable.of(model).columns(centroids, np.arange(len(centroids)), 1.0)
        total += (columns @ last["tie_force"].to_numpy()).reshape(-1, 6)
    return total
