"""Notes on joints whose conditions approximate crushing or torsion: cells, rectangles, contact points."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import UniformTorsion
from blockstruct.model import Model
from blockstruct.results.history import division_of
from blockstruct.results.interfaces import at_points, beyond_rectangle
from blockstruct.statics import ContactPoints, multiple_of_uniform_friction
from blockstruct.text import EFFECT, Note, biaxial_note, cells_note, torsion_note
from blockstruct.vocabulary import Torsion

Array = NDArray[np.float64]

#: Mean pressures, in multiples of the strength, between which the lost lever is measured.
_LEAST, _MOST = 0.001, 0.5
#: Directions of bending in addition to the normals of the edges; depths of stress blocks relative to the joint's depth.
_ANGLES = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_AROUND = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_DEPTHS = (1 - np.cos(np.linspace(0, np.pi, 101))) / 2
#: Eccentricity, in multiples of the limit of the effective rectangle, from which it is reported.
_BEYOND = 1.005
#: Multiple of the torsion and shear under uniform pressure, and share of the weight that presses such joints, from
#: which the forces alone give a note. Measured on 176 cases of walls, frames, arches, domes and a vault: of 27 that
#: only the forces show, uniform pressure takes 2 % to 43 % of the load factor from 24, and under 1 % from three.
_BY_FORCE, _PRESSED = 1.2, 0.01


def crushing_in_cells(history: xr.Dataset, *, is_reaction: bool = False) -> Note | None:
    """Return the note on joints that crush in cells; None without any.

    Parameters
    ----------
    history
        History of a case.
    is_reaction
        Whether the answer is the least reaction of a support.
    """
    index, is_cell = history["interface_of_contact_point"].to_numpy(), np.isfinite(history["cell_strength"].to_numpy())
    counts = np.bincount(index[is_cell], minlength=history.sizes["interface"])
    in_cells = np.flatnonzero(counts)
    if not len(in_cells):
        return None
    crushing = int(np.isfinite(history["compressive_strength"].to_numpy()).sum())
    lost = max(lost_lever(history, int(j)) for j in in_cells)
    cells = int(counts[in_cells].min()), int(counts[in_cells].max())
    return cells_note(len(in_cells), crushing, cells, lost, is_reaction=is_reaction)


def lost_lever(history: xr.Dataset, interface: int) -> float:
    """Return the largest share of the lever M / N that cells lose.

    All directions are compared.
    """
    axes = history["interface_frame"].to_numpy()[interface, 1:]
    centroid = history["interface_position"].to_numpy()[interface]
    of_corner = history["interface_of_interface_corner"].to_numpy() == interface
    of_point = history["interface_of_contact_point"].to_numpy() == interface
    corners = (history["interface_corner_position"].to_numpy()[of_corner] - centroid) @ axes.T
    cells = (history["contact_point_position"].to_numpy()[of_point] - centroid) @ axes.T
    strength: Array = history["cell_strength"].to_numpy()[of_point]
    edges = np.roll(corners, -1, axis=0) - corners
    across = edges[np.linalg.norm(edges, axis=1) > 0] @ np.array([[0.0, -1], [1, 0]])
    lost = 0.0
    for u in (*across, *-across, *_AROUND):
        area, static = parts_beyond(corners, u, _DEPTHS)
        pressed, moment = area / area[-1], static / area[-1]
        usual = (pressed >= _LEAST) & (pressed <= _MOST)
        order = np.argsort(-(cells @ u))
        borne = np.cumsum(strength[order]) / strength.sum()
        of_cells = np.cumsum((strength * (cells @ u))[order]) / strength.sum()
        found = np.interp(pressed, np.append(0, borne), np.append(0, of_cells))
        lost = max(lost, float((1 - found[usual] / moment[usual]).max(initial=0.0)))
    return lost


def parts_beyond(corners: Array, direction: Array, depths: Array) -> tuple[Array, Array]:
    """Return areas and first moments of the parts of a polygon beyond lines.

    Parameters
    ----------
    corners : (k, 2) array
        Corners of the polygon, convex or not.
    direction : (2,) array
        Its length is the unit of lengths along it.
    depths : (m,) array
        Depths of the parts, relative to the depth of the polygon.

    Returns
    -------
    areas, moments : (m,) arrays
        Moments are taken about the origin.
    """
    along, side = corners @ direction, corners @ np.array([direction[1], -direction[0]])
    lines = along.max() - np.ptp(along) * depths
    y0 = along - lines[:, None]
    y1, dx = np.roll(y0, -1, axis=1), np.roll(side, -1) - side
    p, q = np.maximum(y0, 0), np.maximum(y1, 0)
    # The part of each edge beyond the line.
    part = dx * np.divide(q - p, y1 - y0, out=(p > 0).astype(float), where=y1 != y0)
    area, moment = (part * (p + q)).sum(axis=1) / 2, (part * (p**2 + p * q + q**2)).sum(axis=1) / 6
    turns = np.sign(area[np.abs(area).argmax()])
    return turns * area, turns * (moment + lines * area)


def biaxial_crushing(history: xr.Dataset, *, is_reaction: bool = False) -> Note | None:
    """Return the note on joints beyond their effective rectangle, or None.

    Parameters
    ----------
    history
        History of a case whose rectangles limit crushing about each axis separately.
    is_reaction
        Whether the answer is the least reaction of a support.
    """
    times = beyond_rectangle(history)
    beyond = times[times > _BEYOND].sort_values(ascending=False)
    if beyond.empty:
        return None
    return biaxial_note([str(name) for name in beyond.index], float(beyond.iloc[0]), is_reaction=is_reaction)


def corner_torsion(model: Model, history: xr.Dataset) -> pd.DataFrame:
    """Compare torque and shear of interfaces with uniform pressure.

    Uniform pressure acts on the area of the interface.

    V is the shear force, T the torque about the centre of the sliding resistance R. Shear leaves less of R to the
    torque. The exact amount depends on the outline and the direction of the shear. The ellipsoid ``‖(V, T / r̄)‖ ≤ R``,
    the condition of joints with the torsion of uniform pressure, may exceed it by about 15 %.

    Parameters
    ----------
    model, history
        The structure, and the history of a case with a mechanism.

    Returns
    -------
    pandas.DataFrame
        Indexed by interface:

        - ``normal``: normal force, N;
        - ``torque``: T, N·m; ``uniform``: ``R r̄``, the torque that uniform pressure carries without shear, N·m;
        - ``shear``: V, N;
        - ``times``: V and T as a multiple of the exact limit in these proportions; an upper bound if below one;
        - ``share``: work of friction beyond the exact limit, relative to the load factor or, if it is larger, to the
          work of friction: approximately the share of the load factor that depends on it;
        - ``times_left``, ``share_left``: the same for V and T within the ellipsoid: what is left in joints with the
          torsion of uniform pressure.
    """
    last = history.isel(iteration=-1)
    index, J = last["interface_of_contact_point"].to_numpy(), last.sizes["interface"]
    force, v = (at_points(last, name) for name in ("contact_force", "relative_velocity"))
    resistance = np.maximum(_resistance(last, force[:, 0]), 0.0)

    def total(values: Array) -> Array:
        return np.asarray(np.bincount(index, values, J), dtype=float)

    whole = total(resistance)
    frame = last["interface_frame"].to_numpy()
    arm = last["contact_point_position"].to_numpy() - last["interface_position"].to_numpy()[index]
    x, y = (frame[index, 1:] * arm[:, None]).sum(axis=2).T
    held = np.where(whole > 0, whole, 1.0)
    x, y = (a - (total(resistance * a) / held)[index] for a in (x, y))
    torque = total(x * force[:, 2] - y * force[:, 1])
    lever = np.array([i.torsion_lever for i in model.interfaces])
    carried = np.column_stack([total(force[:, 1]), total(force[:, 2]), torque / lever])
    of_resistance = np.divide(carried, whole[:, None], out=np.zeros((J, 3)), where=whole[:, None] > 0)
    times = multiple_of_uniform_friction(model.interfaces, of_resistance)

    left = times / np.maximum(np.linalg.norm(of_resistance, axis=1), 1.0)

    friction = -(force[:, 1:] * v[:, 1:]).sum(axis=1)
    scale = max(abs(float(last["load_factor"])), float(friction.sum()), np.finfo(float).tiny)
    share = np.maximum(total(friction), 0.0) / scale
    return pd.DataFrame(
        {
            "normal": total(force[:, 0]),
            "torque": torque,
            "uniform": whole * lever,
            "shear": np.hypot(*carried[:, :2].T),
            "times": times,
            "share": (1 - 1 / np.maximum(times, 1.0)) * share,
            "times_left": left,
            "share_left": (1 - 1 / np.maximum(left, 1.0)) * share,
        },
        index=pd.Index(last["interface"].to_numpy(), name="interface"),
    )


def sliding_rates(model: Model, iteration: xr.Dataset, cells: int) -> Array:
    """Return the rate (K,), m/s at 1 W, at which contact points slide.

    It includes the torsion of their joints. ``cells`` is the number of cells of an interface,
    ``settings.crushing_cells``.
    """
    force, v = (at_points(iteration, name) for name in ("contact_force", "relative_velocity"))
    torsion = UniformTorsion.of(ContactPoints.of(model, division_of(model, cells, iteration)))
    return torsion.slip(v, _resistance(iteration, force[:, 0]))


def _resistance(iteration: xr.Dataset, normal: Array) -> Array:
    """Return the sliding resistance (K,), N; zero if a joint never slides."""
    friction = iteration["friction_coefficient"].to_numpy()
    friction = np.where(np.isinf(friction), 0.0, friction)
    return np.asarray(iteration["cohesion"].to_numpy() + friction * normal)


def torsion_notes(model: Model, history: xr.Dataset, answer: str, *, limited: bool = False) -> list[Note]:
    """Return the notes on torsion that affects the answer.

    The torsion exceeds that under uniform pressure.

    Joints that limit torsion at their contact points have one note, joints that limit it by an ellipsoid another.
    ``answer`` is ``"load factor"`` or ``"reaction"``. With ``limited`` the notes are on what the torsion of uniform
    pressure would leave in all joints.
    """
    found = corner_torsion(model, history)
    if limited:
        found = found.assign(times=found["times_left"], share=found["share_left"])
    weight = sum(block.weight for block in model.blocks if not block.fixed)
    at_corners = np.array([not limited and i.joint_material.torsion is Torsion.CORNERS for i in model.interfaces])
    notes = []
    for joints, corners in ((found[at_corners], True), (found[~at_corners], False)):
        share = float(joints["share"].sum())
        if share > EFFECT:
            worst = joints[joints["share"] > 0].sort_values("share", ascending=False)
        else:
            # Joints that do not move do no work, but their torsion may hold the structure all the same.
            worst = joints[joints["times"] > _BY_FORCE].sort_values("times", ascending=False)
            if not float(worst["normal"].sum()) > _PRESSED * weight:
                continue
        names, times = [str(name) for name in worst.index], float(worst["times"].iloc[0])
        moved = share if share > EFFECT else None
        notes.append(torsion_note(names, times, moved, answer, at_corners=corners))
    return notes
