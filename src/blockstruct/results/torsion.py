"""Torsion that joints carry by the conditions of a program, and friction under uniform pressure would not."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import UniformTorsion
from blockstruct.model import Model
from blockstruct.results.history import division_of
from blockstruct.statics import ContactPoints, multiple_of_uniform_friction
from blockstruct.vocabulary import Torsion, listed

Array = NDArray[np.float64]

#: Share of the resistance from which on the torsion of corners is told, and names of joints that are listed.
WORTH_TELLING, LISTED = 0.02, 3
#: Multiple of what is carried under uniform pressure, and share of the weight that presses the joints beyond it, from
#: which on torsion is told by the forces. Measured on 176 cases of walls, frames, arches, domes and a vault: of 27
#: where it tells more than the mechanism, uniform pressure takes 2 % to 43 % of the load factor from 24, and under 1 %
#: from three.
BY_FORCE, PRESSED = 1.2, 0.01
_OF_CORNERS = (
    "Friction at corners resists torsion, with the shear beside it,",
    'Joint materials with torsion="uniform pressure" limit it, in narrow joints hardly.',
)
_OF_CONE = (
    'Joints with torsion="uniform pressure" resist torsion and shear together, which an ellipse bounds,',
    "Lower the friction coefficient of these joints by as much where it counts.",
)


_BY_FORCE = (
    'The state found does not tell how much, as the joints hardly turn in its mechanism: check with torsion="uniform '
    'pressure".'
)


def corner_torsion(model: Model, history: xr.Dataset) -> pd.DataFrame:
    """Torque and shear of each interface in the last iteration, and what uniform pressure on its whole area carries.

    With the shear force V and the torque T about the centre of the sliding resistance R: shear leaves less of R to the
    torque. How much depends on the outline and on the direction of the shear, and is found exactly; the ellipsoid
    ``‖(V, T / r̄)‖ ≤ R``, the condition of joints with the torsion of uniform pressure, may lie outside by some 15 %.

    Parameters
    ----------
    model, history
        The structure, and the history of a case with a mechanism.

    Returns
    -------
    pandas.DataFrame
        Indexed by interface: ``normal`` (N), its normal force; ``torque`` (N·m), T; ``uniform`` (N·m), ``R r̄``, what is
        carried without shear; ``shear`` (N), V; ``times``, the multiple that the two are of what is carried in these
        proportions, at most if it is below one; and ``share``, the work that friction does beyond that in the
        mechanism, relative to the load factor or, if it is larger, the work of friction: about what the load factor
        owes to it.
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
    lever = np.array([i.torsion_lever for i in model.interfaces])
    carried = np.column_stack([total(force[:, 1]), total(force[:, 2]), torque / lever])
    of_resistance = np.divide(carried, whole[:, None], out=np.zeros((J, 3)), where=whole[:, None] > 0)
    times = multiple_of_uniform_friction(model.interfaces, of_resistance)

    friction = -(force[:, 1:] * v[:, 1:]).sum(axis=1)
    beyond = (1 - 1 / np.maximum(times, 1.0)) * np.maximum(total(friction), 0.0)
    scale = max(abs(float(last["load_factor"])), float(friction.sum()), np.finfo(float).tiny)
    return pd.DataFrame(
        {
            "normal": total(force[:, 0]),
            "torque": torque,
            "uniform": whole * lever,
            "shear": np.hypot(*carried[:, :2].T),
            "times": times,
            "share": beyond / scale,
        },
        index=pd.Index(last["interface"].to_numpy(), name="interface"),
    )


def sliding_rates(model: Model, iteration: xr.Dataset, cells: int) -> Array:
    """Rate (K,), m/s at 1 W, at which contact points slide, by themselves and with the torsion of their joints.

    ``cells`` are those that interfaces are divided into, ``settings.crushing_cells``.
    """
    v = iteration["relative_velocity"].transpose("contact_point", "component").to_numpy()
    normal = iteration["contact_force"].sel(component="n").to_numpy()
    torsion = UniformTorsion.of(ContactPoints.of(model, division_of(model, cells, iteration)))
    return torsion.slip(v, iteration["cohesion"].to_numpy() + iteration["friction_coefficient"].to_numpy() * normal)


def torsion_words(model: Model, history: xr.Dataset, answer: str) -> str:
    """What the number of a case owes to torsion beyond uniform pressure, in sentences; empty if it is little.

    ``answer`` is what the number is called.
    """
    found = corner_torsion(model, history)
    weight = sum(block.weight for block in model.blocks if not block.fixed)
    of_corners = np.array([i.joint_material.torsion is Torsion.CORNERS for i in model.interfaces])
    said = []
    for joints, (resists, remedy) in ((found[of_corners], _OF_CORNERS), (found[~of_corners], _OF_CONE)):
        share = float(joints["share"].sum())
        if share > WORTH_TELLING:
            worst = joints[joints["share"] > 0].sort_values("share", ascending=False)
            times, names = float(worst["times"].iloc[0]), listed([str(name) for name in worst.index], LISTED)
            said.append(
                f"{resists} by more than friction under uniform pressure would, {times:.3g} times as much ({names}): "
                f"some {share:.0%} of the {answer} is due to it. {remedy}"
            )
            continue
        # Work is done in the joints that move alone; what the others carry may hold them all the same.
        beyond = joints[joints["times"] > BY_FORCE].sort_values("times", ascending=False)
        if float(beyond["normal"].sum()) > PRESSED * weight:
            times, names = float(beyond["times"].iloc[0]), listed([str(name) for name in beyond.index], LISTED)
            said.append(
                f"{resists} by more than friction under uniform pressure would, up to {times:.3g} times as much "
                f"({names}), and the {answer} may be due to it. {_BY_FORCE}"
            )
    return " ".join(said)
