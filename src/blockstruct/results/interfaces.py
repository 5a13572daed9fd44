"""Joints of a history: resultants, states, utilisation, reactions of supports, torsion, and crushing in cells."""

from collections.abc import Hashable, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from blockstruct.arrays import NEGLIGIBLE, SLIGHT, Array, Flags, Index
from blockstruct.limit.torsion import UniformTorsion
from blockstruct.model import Case, Model, SettlementCase
from blockstruct.results.history import division_of
from blockstruct.statics.contacts import ContactPoints
from blockstruct.statics.ties import TieTable
from blockstruct.statics.uniform_friction import multiple_of_uniform_friction, torsion_levers
from blockstruct.statics.wrenches import wrenches
from blockstruct.text.note import EFFECT, Note, biaxial_note, cells_note, torsion_note
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import AXES, MOTIONS, ContactState, Stage, Torsion

#: Force that counts as zero, within the tolerance of the certificate, in units of ``contact_force_unit`` or of a
#: strength.
NO_FORCE = 1e-4
#: Relative velocity, relative to the largest, below which a joint is at rest. Solver tolerances move joints outside the
#: mechanism by about a thousandth.
AT_REST = 0.01
#: Utilisation from which a strength counts as fully used.
FULLY_USED = 1 - SLIGHT
#: Parts of a state, in the order of its text.
_PARTS = (ContactState.HINGE, ContactState.SLIDING, ContactState.TWISTING, ContactState.CRUSHING)
#: Text of each combination of parts, by the sum of their bits.
_NAMES = np.array(
    [
        " + ".join(p.value for bit, p in enumerate(_PARTS) if code >> bit & 1) or ContactState.STICKING.value
        for code in range(2 ** len(_PARTS))
    ],
    dtype=object,
)
#: Stages whose programs are associative, whatever the flow of the case.
_ASSOCIATIVE = [Stage.DEAD_LOAD.value, Stage.ASSOCIATIVE.value, Stage.LARGEST_REACTION.value]


def at_points(history: xr.Dataset, name: str) -> Array:
    """Return a vector at contact points, (…, K, 3), components n, s and t."""
    return np.asarray(history[name].transpose(..., "contact_point", "component").to_numpy())


def first_points(history: xr.Dataset) -> Index:
    """Return the first contact point of each interface, (J,)."""
    return np.searchsorted(history["interface_of_contact_point"].to_numpy(), np.arange(history.sizes["interface"]))


def contact_forces(iteration: xr.Dataset) -> Array:
    """Return the forces (K, 3) at the contact points of one iteration, N, in global axes."""
    frame = iteration["interface_frame"].to_numpy()[iteration["interface_of_contact_point"].to_numpy()]
    return np.asarray(np.einsum("kc,kca->ka", at_points(iteration, "contact_force"), frame))


def block_pairs(model: Model) -> Index:
    """Return the minus and plus blocks (J, 2) of the interfaces, by index."""
    index = model.block_index
    return np.array([(index[i.minus], index[i.plus]) for i in model.interfaces], dtype=np.int64).reshape(-1, 2)


def sum_of_points(history: xr.Dataset, values: Array) -> Array:
    """Return the sums (…, J) of values (…, K) at the contact points of each interface."""
    return np.asarray(np.add.reduceat(values, first_points(history), axis=-1), dtype=float)


def is_pressed(history: xr.Dataset, resultants: xr.Dataset) -> Flags:
    """Return whether interfaces with these resultants are in compression beyond rounding, (…, J)."""
    N = resultants["force"].sel(component="n").transpose(..., "interface")
    return np.asarray(N.to_numpy() > _floor(history))


def interface_resultants(history: xr.Dataset) -> xr.Dataset:
    """Return the resultants of every interface in every iteration.

    Forces act on the plus block; moments are about the centroid of the interface.

    Parameters
    ----------
    history
        History of a case, or a selection of its iterations.

    Returns
    -------
    xarray.Dataset
        ``force`` and ``moment``, component (n, s, t): N and V, torsion and bending. ``eccentricity``, component
        (s, t): point of action of N from the centroid; NaN unless N is compression.
    """
    f, starts = history["contact_force"].transpose(..., "contact_point", "component"), first_points(history)
    at_point = np.cross(_arms(history), f.to_numpy())
    force, moment = (np.add.reduceat(values, starts, axis=-2) for values in (f.to_numpy(), at_point))
    N = np.where(force[..., :1] > 0, force[..., :1], np.nan)
    # With r = e_s s + e_t t, r × N n = N (e_t s − e_s t).
    eccentricity = np.concatenate([-moment[..., 2:], moment[..., 1:2]], axis=-1) / N
    dims = (*f.dims[:-2], "interface")
    variables = {
        "force": ("component", force, "force", "N, V_s, V_t on the plus block"),
        "moment": ("component", moment, "moment", "torsion M_n, bending M_s, M_t"),
        "eccentricity": ("in_plane", eccentricity, "length", "e_s, e_t of N"),
    }
    coords = {**_coords(history, (*dims, "component")), "in_plane": np.array(["s", "t"], dtype=object)}
    return xr.Dataset(coords=coords).assign(
        {
            name: ((*dims, last), values, {"units": SI_UNITS[dimension], "long_name": long_name})
            for name, (last, values, dimension, long_name) in variables.items()
        }
    )


def _arms(history: xr.Dataset) -> Array:
    """Return the positions (K, 3) of contact points about the centroids of their interfaces, m, in local axes."""
    index = history["interface_of_contact_point"].to_numpy()
    arm = history["contact_point_position"].to_numpy() - history["interface_position"].to_numpy()[index]
    return np.asarray(np.einsum("kca,ka->kc", history["interface_frame"].to_numpy()[index], arm))


def _coords(history: xr.Dataset, dims: Sequence[Hashable]) -> dict[str, xr.Variable]:
    """Return the names of iterations, interfaces and components, as far as the dimensions have them."""
    names = ("iteration", "stage", "interface", "component")
    return {name: history[name].variable for name in names if set(history[name].dims) <= set(dims)}


def utilisation(history: xr.Dataset) -> xr.Dataset:
    """Return utilisation and neutral-axis depth of every interface.

    Parameters
    ----------
    history
        History of a case, or a selection of its iterations.

    Returns
    -------
    xarray.Dataset
        Dimensions (iteration, interface):

        - ``sliding``: ``Σ ‖(s, t)‖ / Σ (c A_k + μ n)`` over the contact points; 1 if all points slide, whether the
          interface slips or twists. With the torsion of uniform pressure, at least ``‖(V, T / r̄)‖`` over the same sum.
          0 if the joint never slides, NaN if the resistance is negligible.
        - ``crushing``: N over the largest N that the joint carries at the same eccentricity. For rectangles without
          tensile strength, ``N³ / (4 f_c A n_e n_f)`` at the weakest edges e and f of the effective rectangle: above 1
          if uniaxial interaction bears too much. For cells, N over the strength of the cells that are pressed by more
          than 1e-6 of their strength. 0 if the strength is infinite, NaN unless N is compression.
        - ``neutral_axis_depth`` (m): depth of the uniform stress block about the resultant, ``2 (b / 2 − |e|)``, from
          the governing edge; at most the depth of the interface, 0 at a hinge of infinite strength. NaN unless N is
          compression.
    """
    f = at_points(history, "contact_force")
    friction = history["friction_coefficient"].to_numpy()
    never = np.isinf(friction)
    resistance = history["cohesion"].to_numpy() + np.where(never, 0.0, friction) * f[..., 0]
    resistance = sum_of_points(history, np.where(never, np.inf, resistance))
    with np.errstate(divide="ignore", invalid="ignore"):
        sliding = sum_of_points(history, np.linalg.norm(f[..., 1:], axis=-1))
        if "torsion_lever" in history.coords:
            sliding = np.maximum(sliding, _with_torque(history, f))
        sliding = sliding / np.where(resistance > _floor(history), resistance, np.nan)

    force, eccentricity = (interface_resultants(history)[name] for name in ("force", "eccentricity"))
    normal = force.isel(component=0, drop=True)
    variables = {
        "sliding": (sliding, "dimensionless", "utilisation of the sliding strength"),
        "crushing": (crushing_used(history), "dimensionless", "utilisation of the compressive strength"),
        "neutral_axis_depth": (_depth(history, eccentricity.to_numpy()), "length", "depth of the compressed zone"),
    }
    return xr.Dataset(coords=normal.coords).assign(
        {
            name: (normal.dims, values, {"units": SI_UNITS[dimension], "long_name": long_name})
            for name, (values, dimension, long_name) in variables.items()
        }
    )


def crushing_used(history: xr.Dataset) -> Array:
    """Return the use (..., J) of compressive strength: :func:`utilisation`."""
    starts = first_points(history)
    n = at_points(history, "contact_force")[..., 0]
    N = sum_of_points(history, n)
    compressed = np.where(_floor(history) < N, N, np.nan)
    cell = history["cell_strength"].to_numpy()
    in_cells = np.isfinite(cell[starts])
    corners, edges, tension, capacity = _rectangles(history)
    used = np.where(np.isnan(compressed), np.nan, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        used[..., corners] = _of_rectangles(compressed[..., corners], edges, tension, capacity)
        pressed = sum_of_points(history, np.where(np.isfinite(cell) & (n > 1e-6 * cell), cell, 0.0))
        used[..., in_cells] = (compressed / pressed)[..., in_cells]
    return used


def beyond_rectangle(history: xr.Dataset) -> pd.Series:
    """Return eccentricities of crushing rectangles, relative to the limit.

    It takes the normal force and the direction of the eccentricity in the last iteration; NaN unless the joint is in
    compression. If a block rocks on one such joint, its load factor is too large by this factor.
    """
    last = history.isel(iteration=-1)
    joints, edges, tension, capacity = _rectangles(last)
    N = edges[:, 0] + edges[:, 2]
    edges, total = edges + tension[:, None] / 2, N + tension
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (1 - 2 * np.minimum(edges[:, e], edges[:, e + 2]) / total for e in (0, 1))
        # (1 − a s)(1 − b s) = N / F at the share s of the eccentricity. Fully pressed, both sides are rounding.
        rest = np.maximum(1 - total / capacity, NEGLIGIBLE)
        times = (a + b + np.sqrt(np.maximum((a + b) ** 2 - 4 * a * b * rest, 0.0))) / (2 * rest)
    names = pd.Index(last["interface"].to_numpy()[joints], name="interface")
    return pd.Series(np.where(_floor(last)[joints] < N, times, np.nan), index=names)


def _floor(history: xr.Dataset) -> Array:
    """Return the forces (J,) of interfaces that count as zero, N."""
    return NO_FORCE * sum_of_points(history, history["contact_force_unit"].to_numpy())


def _rectangles(history: xr.Dataset) -> tuple[Index, Array, Array, Array]:
    """Return rectangles, edge forces (..., R, 4), ``f_t A``, ``(f_c+f_t) A``."""
    starts, strength = first_points(history), history["compressive_strength"].to_numpy()
    joints = np.flatnonzero(np.isfinite(strength) & ~np.isfinite(history["cell_strength"].to_numpy()[starts]))
    corners = starts[joints][:, None] + np.arange(4)
    n = at_points(history, "contact_force")[..., 0][..., corners]
    tension = history["tensile_strength"].to_numpy()[corners].sum(axis=-1)
    capacity = (strength * history["interface_area"].to_numpy())[joints] + tension
    return joints, n + np.roll(n, -1, axis=-1), tension, capacity


def _of_rectangles(N: Array, edges: Array, tension: Array, capacity: Array) -> Array:
    """Return the utilisation of rectangles.

    ``N`` has shape (..., R), ``edges`` (..., R, 4).

    It is 1 over the factor by which all forces can grow until
    ``(N + f_t A)³ = 4 (f_c + f_t) A (n_e + f_t A / 2) (n_f + f_t A / 2)``.
    """
    p, q = (np.minimum(edges[..., e], edges[..., e + 2]) / N for e in (0, 1))
    phi, full = tension / N, capacity / N
    growth = 4 * full * p * q
    resists = np.isfinite(N) & (tension > 0)
    if resists.any():
        p, q, phi, full = (a[resists] for a in (p, q, phi, full))
        companion = np.zeros((len(p), 3, 3))
        companion[:, 0, 0] = growth[resists] - 3 * phi
        companion[:, 0, 1] = 2 * full * phi * (p + q) - 3 * phi**2
        companion[:, 0, 2] = full * phi**2 - phi**3
        companion[:, [1, 2], [0, 1]] = 1.0
        root = np.linalg.eigvals(companion)
        growth[resists] = np.where((root.imag == 0) & (root.real > 0), root.real, np.inf).min(axis=1)
    return np.asarray(1 / np.maximum(growth, 0.0))


def _with_torque(history: xr.Dataset, f: Array) -> Array:
    """Return ``‖(V_s, V_t, T / r̄)‖`` of interfaces, T about the centroid."""
    lever = history["torsion_lever"].to_numpy()[history["interface_of_contact_point"].to_numpy()]
    x, y = _arms(history)[:, 1:].T / lever
    parts = (f[..., 1], f[..., 2], x * f[..., 2] - y * f[..., 1])
    return np.asarray(np.linalg.norm([sum_of_points(history, part) for part in parts], axis=0))


def _depth(history: xr.Dataset, eccentricity: Array) -> Array:
    """Return twice the distance from N to the governing edge, limited.

    The limit is the depth of the interface.
    """
    index = history["interface_of_interface_corner"].to_numpy()
    J = history.sizes["interface"]
    starts = np.searchsorted(index, np.arange(J))
    counts = np.diff([*starts, len(index)])
    frame, centre = history["interface_frame"].to_numpy()[:, 1:], history["interface_position"].to_numpy()
    corner = np.einsum("kca,ka->kc", frame[index], history["interface_corner_position"].to_numpy() - centre[index])
    following = np.arange(len(index)) + 1
    following[starts + counts - 1] = starts
    edge = corner[following] - corner
    normal = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.linalg.norm(edge, axis=1)[:, None]

    # Compare all corners of an interface with all its edges, in a table as wide as the largest interface.
    width = counts.max(initial=0)
    column = np.minimum(np.arange(width), counts[:, None] - 1)
    table = corner[starts[:, None] + column]
    height = np.einsum("kc,kmc->km", normal, table[index])
    high, low = height.max(axis=1), height.min(axis=1)
    at = np.einsum("kc,...kc->...k", normal, eccentricity[..., index, :])
    depth = np.minimum(2 * (high - at), high - low)
    return np.asarray(np.minimum.reduceat(np.maximum(depth, 0.0), starts, axis=-1))


def contact_state(
    history: xr.Dataset, tolerance: float = AT_REST, *, force_tolerance: float = NO_FORCE
) -> xr.DataArray:
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
    starts = first_points(history)
    v, components = (at_points(history, name) for name in ("relative_velocity", "contact_force"))
    force = np.linalg.norm(components, axis=-1)

    def any_of(points: Flags) -> Flags:
        return np.logical_or.reduceat(points, starts, axis=-1)

    zero = np.maximum(tolerance * np.linalg.norm(v, axis=-1).max(axis=-1, keepdims=True), np.finfo(float).tiny)
    # If a structure follows its supports as one body, relative velocities are rounding errors of block velocities.
    speed = np.linalg.norm(history["block_velocity"].transpose(..., "block", "axis"), axis=-1).max(axis=-1)
    zero = np.maximum(zero, NEGLIGIBLE * np.asarray(speed)[..., None])
    slip = np.linalg.norm(v[..., 1:], axis=-1)
    dilatancy, friction = (history[name].to_numpy() for name in ("dilatancy", "friction_coefficient"))
    # Joints that never slide do not dilate.
    friction = np.where(np.isinf(friction), 0.0, friction)
    follows_friction = np.isin(history["stage"].to_numpy(), _ASSOCIATIVE)[..., None]
    apart = v[..., 0] - np.where(follows_friction, friction, dilatancy) * slip
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
    s, t = along - (sum_of_points(history, along) / counts)[:, index]
    distance = np.hypot(s, t)
    # A single point cannot turn.
    inertia = np.where(counts > 1, sum_of_points(history, distance**2), 1.0)
    turn = sum_of_points(history, s * v[..., 2] - t * v[..., 1]) / inertia * np.maximum.reduceat(distance, starts)
    mean = np.hypot(sum_of_points(history, v[..., 1]), sum_of_points(history, v[..., 2])) / counts

    # The edge of a tall structure penetrates slowly compared with the openings at its top.
    speed_of_joint = np.maximum.reduceat(np.linalg.norm(v, axis=-1), starts, axis=-1)
    hinge = any_of(opening)
    enters = hinge[..., index] & (apart < -tolerance * speed_of_joint[..., index]) & _fully_pressed(history)
    crushing = any_of(soft & ((apart < -zero) | enters))
    parts = (hinge, slips & (mean > zero), slips & (np.abs(turn) > zero), crushing)
    code = np.sum([part.astype(int) << bit for bit, part in enumerate(parts)], axis=0)
    state = _NAMES[code]
    state[is_open] = ContactState.OPEN.value
    state[any_of(np.isnan(force))] = ContactState.UNKNOWN.value
    dims = (*(d for d in history["contact_force"].dims if d not in ("contact_point", "component")), "interface")
    return xr.DataArray(state, dims=dims, coords=_coords(history, dims), name="contact_state")


def _fully_pressed(history: xr.Dataset) -> Flags:
    """Return whether the joint or cell of a contact point is fully pressed."""
    cell = history["cell_strength"].to_numpy()
    of_joint = crushing_used(history)[..., history["interface_of_contact_point"].to_numpy()]
    n = at_points(history, "contact_force")[..., 0]
    return np.asarray(np.where(np.isfinite(cell), n >= FULLY_USED * cell, of_joint >= FULLY_USED))


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
    force, v = (at_points(last, name)[0] for name in ("contact_force", "relative_velocity"))
    index, n = last["interface_of_contact_point"].to_numpy(), last.sizes["interface"]
    speed = np.zeros(n)
    np.maximum.at(speed, index, np.linalg.norm(v, axis=1))
    # Dissipation within rounding counts as zero; otherwise its rank would be random.
    dissipation = sum_of_points(last, -(force * v).sum(axis=1))
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
    moving = frame[(frame["speed"] > tolerance) & ~frame["state"].isin([ContactState.STICKING, ContactState.UNKNOWN])]
    return moving.sort_values(["dissipation", "speed"], ascending=False, kind="stable")


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
    index, force = last["interface_of_contact_point"].to_numpy(), contact_forces(last)
    point = last["contact_point_position"].to_numpy()
    centroids = np.array([b.centroid for b in model.blocks])
    total = np.zeros((len(centroids), 6))
    for sign, block in zip((-1.0, 1.0), block_pairs(model)[index].T, strict=True):
        moment = np.cross(point - centroids[block], force)
        np.add.at(total, block, sign * np.hstack([force, moment]))
    if model.ties:
        columns = TieTable.of(model).columns(centroids, np.arange(len(centroids)), 1.0)
        total += (columns @ last["tie_force"].to_numpy()).reshape(-1, 6)
    return total


#: Multiple of the torsion and shear under uniform pressure from which the forces alone give a note. Measured on 176
#: cases of walls, frames, arches, domes and a vault: of 27 that only the forces show, uniform pressure takes 2 % to
#: 43 % of the load factor from 24, and under 1 % from three.
_BY_FORCE = 1.2


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
    force, v = (at_points(last, name) for name in ("contact_force", "relative_velocity"))
    resistance = np.maximum(_resistance(last, force[:, 0]), 0.0)

    whole = sum_of_points(last, resistance)
    x, y = _arms(last)[:, 1:].T
    held = np.where(whole > 0, whole, 1.0)
    x, y = (a - (sum_of_points(last, resistance * a) / held)[index] for a in (x, y))
    torque = sum_of_points(last, x * force[:, 2] - y * force[:, 1])
    lever = torsion_levers(model.interfaces)
    carried = np.column_stack([sum_of_points(last, force[:, 1]), sum_of_points(last, force[:, 2]), torque / lever])
    of_resistance = np.divide(carried, whole[:, None], out=np.zeros((J, 3)), where=whole[:, None] > 0)
    times = multiple_of_uniform_friction(model.interfaces, of_resistance)

    left = times / np.maximum(np.linalg.norm(of_resistance, axis=1), 1.0)

    friction = -(force[:, 1:] * v[:, 1:]).sum(axis=1)
    scale = max(abs(float(last["load_factor"])), float(friction.sum()), np.finfo(float).tiny)
    share = np.maximum(sum_of_points(last, friction), 0.0) / scale
    return pd.DataFrame(
        {
            "normal": sum_of_points(last, force[:, 0]),
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
    v = at_points(iteration, "relative_velocity")
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
    weight = model.weight
    at_corners = np.array([not limited and i.joint_material.torsion is Torsion.CORNERS for i in model.interfaces])
    notes = []
    for joints, corners in ((torsion[at_corners], True), (torsion[~at_corners], False)):
        share = float(joints["share"].sum())
        if share > EFFECT:
            worst = joints[joints["share"] > 0].sort_values("share", ascending=False)
        else:
            # Joints that do not move do no work, but their torsion may hold the structure all the same.
            # Joints without force have proportions of rounding.
            carry = joints[joints["normal"] > NO_FORCE * weight]
            worst = carry[carry["times"] > _BY_FORCE].sort_values("times", ascending=False)
            if not float(worst["normal"].sum()) > EFFECT * weight:
                continue
        names, times = [str(name) for name in worst.index], float(worst["times"].iloc[0])
        moved = share if share > EFFECT else None
        notes.append(torsion_note(names, times, moved, answer, at_corners=corners))
    return notes


#: Mean pressures, in multiples of the strength, between which the lost lever is measured.
_LEAST, _MOST = 0.001, 0.5
#: Directions of bending in addition to the normals of the edges; depths of stress blocks relative to the joint's depth.
_ANGLES = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_AROUND = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_DEPTHS = (1 - np.cos(np.linspace(0, np.pi, 101))) / 2


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
        of_pressed = np.interp(pressed, np.append(0, borne), np.append(0, of_cells))
        lost = max(lost, float((1 - of_pressed[usual] / moment[usual]).max(initial=0.0)))
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
    beyond = times[times > 1 + EFFECT].sort_values(ascending=False)
    if beyond.empty:
        return None
    return biaxial_note([str(name) for name in beyond.index], float(beyond.iloc[0]), is_reaction=is_reaction)
