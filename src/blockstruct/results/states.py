"""States of interfaces: open, hinge, sliding, twisting, crushing."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.results.utilisation import crushing_used
from blockstruct.vocabulary import ContactState, Stage

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Parts of a state, in the order of its text.
_PARTS = (ContactState.HINGE, ContactState.SLIDING, ContactState.TWISTING, ContactState.CRUSHING)
#: Stages whose programs are associative, whatever the flow of the case.
_ASSOCIATIVE = [Stage.DEAD_LOAD.value, Stage.ASSOCIATIVE.value, Stage.LARGEST_REACTION.value]
_AT_REST = (ContactState.STICKING.value, ContactState.UNKNOWN.value)
_NAMES = np.array(
    [
        " + ".join(p.value for bit, p in enumerate(_PARTS) if code >> bit & 1) or ContactState.STICKING.value
        for code in range(2 ** len(_PARTS))
    ],
    dtype=object,
)


#: Relative velocity, relative to the largest, below which a joint is at rest. Solver tolerances move joints outside the
#: mechanism by about a thousandth.
AT_REST = 0.01
#: Relative velocity, relative to the largest velocity of a block, that counts as rounding.
ROUNDING = 1e-6
#: Utilisation of the compressive strength from which a turning joint crushes at its penetrating edge, at any velocity.
FULLY_PRESSED = 0.999


def contact_state(history: xr.Dataset, tolerance: float = AT_REST, *, force_tolerance: float = 1e-4) -> xr.DataArray:
    """Return interface states from forces and motion, in every iteration.

    ``open``: no contact point stays closed, or none carries a force. A joint in compression is never open.
    ``sticking``: no relative motion. ``unknown``: the solver found no forces, or the file does not keep them. Any other
    state has one part or several, joined by `` + ``:

    - ``hinge``: some points open, others do not;
    - ``sliding``: closed points slip, and the mean velocity of the interface along its plane is not zero;
    - ``twisting``: closed points slip, and the interface turns about its normal;
    - ``crushing``: in a joint with a compressive strength, the blocks move into each other faster than the tolerance.
      At a hinge that uses its full strength, the tolerance is relative to the motion of the joint itself.

    A point opens if it separates faster than dilatancy explains. In an associative program, dilatancy follows friction.
    If no contact carries a force, forces do not make a joint open.

    Parameters
    ----------
    history
        History of a case, or a selection of its iterations.
    tolerance
        Relative velocity that counts as zero, relative to the largest of the iteration.
    force_tolerance
        Contact force that counts as zero, in units of ``contact_force_unit``.

    Returns
    -------
    xarray.DataArray
        Texts, dimensions (iteration, interface).
    """
    index = history["interface_of_contact_point"].to_numpy()
    starts = np.searchsorted(index, np.arange(history.sizes["interface"]))
    v = history["relative_velocity"].transpose(..., "contact_point", "component").to_numpy()
    components = history["contact_force"].transpose(..., "contact_point", "component").to_numpy()
    force = np.linalg.norm(components, axis=-1)

    def any_of(points: Flags) -> Flags:
        return np.logical_or.reduceat(points, starts, axis=-1)

    def sum_of(values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, starts, axis=-1))

    zero = np.maximum(tolerance * np.linalg.norm(v, axis=-1).max(axis=-1, keepdims=True), np.finfo(float).tiny)
    # If a structure follows its supports as one body, relative velocities are rounding errors of block velocities.
    speed = np.linalg.norm(history["block_velocity"].transpose(..., "block", "axis"), axis=-1).max(axis=-1)
    zero = np.maximum(zero, ROUNDING * np.asarray(speed)[..., None])
    slip = np.linalg.norm(v[..., 1:], axis=-1)
    dilatancy, friction = (history[name].to_numpy() for name in ("dilatancy", "friction_coefficient"))
    # Joints that never slide do not dilate.
    friction = np.where(np.isinf(friction), 0.0, friction)
    apart = v[..., 0] - np.where(_dilates_by_friction(history), friction, dilatancy) * slip
    nothing = force_tolerance * history["contact_force_unit"].to_numpy()
    carries = any_of(force > nothing)
    # A joint in compression touches at its closest point, so openings count from there.
    pressed = any_of(components[..., 0] > nothing)[..., index]
    least = np.minimum.reduceat(apart, starts, axis=-1)[..., index]
    opening = apart - np.where(pressed, np.maximum(least, 0.0), 0.0) > zero
    soft = np.isfinite(history["compressive_strength"].to_numpy())[index]
    is_open = ~any_of(~opening) | (~carries & carries.any(axis=-1, keepdims=True))
    slips = any_of(~opening & (slip > zero))

    # The in-plane velocity is a rigid motion: a mean velocity and a rotation about the mean point.
    counts = np.diff([*starts, len(index)])
    axes = history["interface_frame"].to_numpy()[:, 1:][index]
    along = np.einsum("kca,ka->ck", axes, history["contact_point_position"].to_numpy())
    s, t = along - (sum_of(along) / counts)[:, index]
    distance = np.hypot(s, t)
    # A single point cannot turn.
    inertia = np.where(counts > 1, sum_of(distance**2), 1.0)
    turn = sum_of(s * v[..., 2] - t * v[..., 1]) / inertia * np.maximum.reduceat(distance, starts)
    mean = np.hypot(sum_of(v[..., 1]), sum_of(v[..., 2])) / counts

    # The edge of a tall structure penetrates slowly compared with the openings at its top.
    own = np.maximum.reduceat(np.linalg.norm(v, axis=-1), starts, axis=-1)
    hinge = any_of(opening)
    enters = hinge[..., index] & (apart < -tolerance * own[..., index]) & _fully_pressed(history)
    crushing = any_of(soft & ((apart < -zero) | enters))
    parts = (hinge, slips & (mean > zero), slips & (np.abs(turn) > zero), crushing)
    code = np.sum([part.astype(int) << bit for bit, part in enumerate(parts)], axis=0)
    state = _NAMES[code]
    state[is_open] = ContactState.OPEN.value
    state[any_of(np.isnan(force))] = ContactState.UNKNOWN.value
    dims = (*(d for d in history["contact_force"].dims if d not in ("contact_point", "component")), "interface")
    coords = {
        name: history[name] for name in ("iteration", "stage", "interface") if set(history[name].dims) <= set(dims)
    }
    return xr.DataArray(state, dims=dims, coords=coords, name="contact_state")


def _dilates_by_friction(history: xr.Dataset) -> Flags:
    """Return whether an iteration belongs to an associative program, (…, 1)."""
    return np.asarray(np.isin(history["stage"].to_numpy(), _ASSOCIATIVE))[..., None]


def _fully_pressed(history: xr.Dataset) -> Flags:
    """Return whether the joint or cell of a contact point is fully pressed."""
    cell = history["cell_strength"].to_numpy()
    of_joint = crushing_used(history)[..., history["interface_of_contact_point"].to_numpy()]
    n = history["contact_force"].sel(component="n").transpose(..., "contact_point").to_numpy()
    return np.asarray(np.where(np.isfinite(cell), n >= FULLY_PRESSED * cell, of_joint >= FULLY_PRESSED))


def active_joints(history: xr.Dataset, tolerance: float = AT_REST) -> pd.DataFrame:
    """Return the joints that move in the last iteration, most active first.

    The order is by decreasing dissipation.

    Parameters
    ----------
    history
        History of a case.
    tolerance
        See :func:`contact_state`. Slower joints are at rest.

    Returns
    -------
    pandas.DataFrame
        Indexed by interface, in this order of rank:

        - ``state``;
        - ``dissipation``: work of the forces on the mechanism, in units of the load factor (W at 1 W of variable load);
        - ``speed``: largest relative velocity, as a share of the largest in the mechanism. It ranks joints that
          dissipate nothing.
    """
    last = history.isel(iteration=[-1])
    force, v = (
        last[name].isel(iteration=0).transpose("contact_point", "component").to_numpy()
        for name in ("contact_force", "relative_velocity")
    )
    index, n = last["interface_of_contact_point"].to_numpy(), last.sizes["interface"]
    speed = np.zeros(n)
    np.maximum.at(speed, index, np.linalg.norm(v, axis=1))
    # Dissipation within rounding counts as zero; otherwise its rank would be random.
    dissipation = np.bincount(index, weights=-(force * v).sum(axis=1), minlength=n)
    scale = np.nanmax([np.abs(dissipation).sum(), np.abs(last["load_factor"].item())])
    dissipation[np.abs(dissipation) <= 1e-6 * scale] = 0.0
    frame = pd.DataFrame(
        {
            "state": contact_state(last, tolerance).to_numpy()[0],
            "dissipation": dissipation,
            "speed": speed / max(speed.max(initial=0.0), np.finfo(float).tiny),
        },
        index=pd.Index(last["interface"].to_numpy(), name="interface"),
    )
    moving = frame[(frame["speed"] > tolerance) & ~frame["state"].isin(_AT_REST)]
    return moving.sort_values(["dissipation", "speed"], ascending=False, kind="stable")
