"""Torsion that joints carry beyond friction under uniform pressure."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import UniformTorsion
from blockstruct.model import Model
from blockstruct.results.history import division_of
from blockstruct.statics import ContactPoints, multiple_of_uniform_friction, torsion_levers
from blockstruct.text import EFFECT, Note, torsion_note
from blockstruct.vocabulary import Torsion

Array = NDArray[np.float64]

#: Multiple of the torsion and shear under uniform pressure, and share of the weight that presses such joints, from
#: which the forces alone give a note. Measured on 176 cases of walls, frames, arches, domes and a vault: of 27 that
#: only the forces show, uniform pressure takes 2 % to 43 % of the load factor from 24, and under 1 % from three.
_BY_FORCE, _PRESSED = 1.2, 0.01


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
        - ``times_left``, ``share_left``: the same for V and T within the ellipsoid: the excess that remains in
          joints with the torsion of uniform pressure.
    """
    last = history.isel(iteration=-1)
    index, J = last["interface_of_contact_point"].to_numpy(), last.sizes["interface"]
    force = last["contact_force"].transpose("contact_point", "component").to_numpy()
    v = last["relative_velocity"].transpose("contact_point", "component").to_numpy()
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
    lever = torsion_levers(model.interfaces)
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
    v = iteration["relative_velocity"].transpose("contact_point", "component").to_numpy()
    normal = iteration["contact_force"].sel(component="n").to_numpy()
    torsion = UniformTorsion.of(ContactPoints.of(model, division_of(model, cells, iteration)))
    return torsion.slip(v, _resistance(iteration, normal))


def _resistance(iteration: xr.Dataset, normal: Array) -> Array:
    """Return the sliding resistance (K,), N; zero if a joint never slides."""
    friction = iteration["friction_coefficient"].to_numpy()
    friction = np.where(np.isinf(friction), 0.0, friction)
    return np.asarray(iteration["cohesion"].to_numpy() + friction * normal)


def torsion_notes(model: Model, history: xr.Dataset, answer: str, *, limited: bool = False) -> list[Note]:
    """Return the notes on torsion that affects the answer.

    The torsion exceeds that under uniform pressure.

    Joints that limit torsion at their contact points have one note, joints that limit it by an ellipsoid another.
    ``answer`` is ``"load factor"`` or ``"reaction"``. With ``limited`` the notes are on the excess that the torsion
    of uniform pressure would leave in all joints.
    """
    torsion = corner_torsion(model, history)
    if limited:
        torsion = torsion.assign(times=torsion["times_left"], share=torsion["share_left"])
    weight = sum(block.weight for block in model.blocks if not block.fixed)
    at_corners = np.array([not limited and i.joint_material.torsion is Torsion.CORNERS for i in model.interfaces])
    notes = []
    for joints, corners in ((torsion[at_corners], True), (torsion[~at_corners], False)):
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
