"""Torsion that corners carry, and a uniformly pressed joint would not."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import UniformTorsion
from blockstruct.model import Model, listed
from blockstruct.statics import ContactPoints
from blockstruct.vocabulary import Torsion

Array = NDArray[np.float64]

#: Share of the resistance from which on the torsion of corners is told, and names of joints that are listed.
WORTH_TELLING, LISTED = 0.02, 3


def corner_torsion(model: Model, history: xr.Dataset) -> pd.DataFrame:
    """Torque and shear of each interface in the last iteration, and what uniform pressure on its whole area carries.

    With the shear force V, the torque T about the centre of the sliding resistance R and the mean distance r̄ of the
    area from its centroid, uniform pressure carries ``‖(V, T / r̄)‖ ≤ R``: shear leaves less of R to the torque.

    Parameters
    ----------
    model, history
        The structure, and the history of a case with a mechanism.

    Returns
    -------
    pandas.DataFrame
        Indexed by interface: ``torque`` (N·m), T; ``uniform`` (N·m), ``R r̄``, what is carried without shear;
        ``shear`` (N), V; ``times``, the multiple of R that ``‖(V, T / r̄)‖`` is; and ``share``, the work that friction
        does beyond R in the mechanism, relative to the load factor or, if it is larger, the work of friction: about
        what the load factor owes to it.
    """
    last = history.isel(iteration=-1)
    index, J = last["interface_of_contact_point"].to_numpy(), last.sizes["interface"]
    force = last["contact_force"].transpose("contact_point", "component").to_numpy()
    v = last["relative_velocity"].transpose("contact_point", "component").to_numpy()
    resistance = np.maximum(last["cohesion"].to_numpy() + last["friction_coefficient"].to_numpy() * force[:, 0], 0.0)

    def total(values: Array) -> Array:
        return np.asarray(np.bincount(index, values, J), dtype=float)

    whole = total(resistance)
    frame = last["interface_frame"].to_numpy()
    arm = last["contact_point_position"].to_numpy() - last["interface_position"].to_numpy()[index]
    x, y = (frame[index, 1:] * arm[:, None]).sum(axis=2).T
    held = np.where(whole > 0, whole, 1.0)
    x, y = (a - (total(resistance * a) / held)[index] for a in (x, y))
    torque = total(x * force[:, 2] - y * force[:, 1])
    shear = np.hypot(total(force[:, 1]), total(force[:, 2]))
    uniform = whole * np.array([i.torsion_lever for i in model.interfaces])
    of_torque = np.divide(np.abs(torque), uniform, out=np.zeros(J), where=uniform > 0)
    times = np.hypot(np.divide(shear, whole, out=np.zeros(J), where=whole > 0), of_torque)

    friction = -(force[:, 1:] * v[:, 1:]).sum(axis=1)
    beyond = (1 - 1 / np.maximum(times, 1.0)) * np.maximum(total(friction), 0.0)
    scale = max(abs(float(last["load_factor"])), float(friction.sum()), np.finfo(float).tiny)
    return pd.DataFrame(
        {"torque": torque, "uniform": uniform, "shear": shear, "times": times, "share": beyond / scale},
        index=pd.Index(last["interface"].to_numpy(), name="interface"),
    )


def sliding_rates(model: Model, iteration: xr.Dataset, cells: int) -> Array:
    """Rate (K,), m/s at 1 W, at which contact points slide, by themselves and with the torsion of their joints.

    ``cells`` are those that interfaces are divided into, ``settings.crushing_cells``.
    """
    v = iteration["relative_velocity"].transpose("contact_point", "component").to_numpy()
    normal = iteration["contact_force"].sel(component="n").to_numpy()
    torsion = UniformTorsion.of(ContactPoints.of(model, cells))
    return torsion.slip(v, iteration["cohesion"].to_numpy() + iteration["friction_coefficient"].to_numpy() * normal)


def torsion_words(model: Model, history: xr.Dataset, answer: str) -> str:
    """What the number of a case owes to torsion at corners, in a sentence; empty if it is little.

    ``answer`` is what the number is called.
    """
    # By the torsion of uniform pressure no joint carries more.
    of_corners = [i.joint_material.torsion is Torsion.CORNERS for i in model.interfaces]
    found = corner_torsion(model, history)[of_corners]
    share = float(found["share"].sum())
    if not share > WORTH_TELLING:
        return ""
    worst = found[found["share"] > 0].sort_values("share", ascending=False)
    times = float(worst["times"].iloc[0])
    names = listed([str(name) for name in worst.index], LISTED)
    return (
        "Friction at corners resists torsion, with the shear beside it, by more than uniform pressure would, "
        f"{times:.3g} times as much ({names}): some {share:.0%} of the {answer} is due to it. Joint materials with "
        'torsion="uniform pressure" limit it.'
    )
