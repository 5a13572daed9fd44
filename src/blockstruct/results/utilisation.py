"""Utilisation of the strength of interfaces."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.results.resultants import interface_resultants
from blockstruct.text import Note, biaxial_note
from blockstruct.units import SI_UNITS

Array = NDArray[np.float64]

#: Normal force, in units of ``contact_force_unit``, below which a joint has no utilisation.
_FLOOR = 1e-4
#: Eccentricity, in multiples of the limit of the effective rectangle, from which it is reported.
_BEYOND = 1.005
#: Least share of its strength that a fully pressed joint has left, so that no division by zero occurs.
_FULL = 1e-6


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

        - ``sliding``: ``Σ ‖(s, t)‖ / Σ (c A_k + μ n)`` over the contact points; 1 if all of them slide, whether the
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
    starts, floor = _starts(history), _floor(history)
    f = history["contact_force"].transpose(..., "contact_point", "component").to_numpy()

    def sum_of(values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, starts, axis=-1))

    friction = history["friction_coefficient"].to_numpy()
    never = np.isinf(friction)
    resistance = history["cohesion"].to_numpy() + np.where(never, 0.0, friction) * f[..., 0]
    resistance = sum_of(np.where(never, np.inf, resistance))
    with np.errstate(divide="ignore", invalid="ignore"):
        sliding = sum_of(np.linalg.norm(f[..., 1:], axis=-1))
        if "torsion_lever" in history.coords:
            sliding = np.maximum(sliding, _with_torque(history, f, sum_of))
        sliding = sliding / np.where(resistance > floor, resistance, np.nan)

    resultants = interface_resultants(history)
    coords = resultants["force"].isel(component=0, drop=True).coords
    dims = resultants["force"].isel(component=0, drop=True).dims
    depth = _depth(history, resultants["eccentricity"].transpose(..., "interface", "in_plane").to_numpy())

    def variable(values: Array, dimension: str, long_name: str) -> xr.DataArray:
        return xr.DataArray(
            values, dims=dims, coords=coords, attrs={"units": SI_UNITS[dimension], "long_name": long_name}
        )

    return xr.Dataset(
        {
            "sliding": variable(sliding, "dimensionless", "utilisation of the sliding strength"),
            "crushing": variable(crushing_used(history), "dimensionless", "utilisation of the compressive strength"),
            "neutral_axis_depth": variable(depth, "length", "depth of the compressed zone"),
        }
    )


def crushing_used(history: xr.Dataset) -> Array:
    """Return the use (..., J) of compressive strength: :func:`utilisation`."""
    starts = _starts(history)
    n = history["contact_force"].sel(component="n").transpose(..., "contact_point").to_numpy()
    N = np.add.reduceat(n, starts, axis=-1)
    compressed = np.where(_floor(history) < N, N, np.nan)
    cell = history["cell_strength"].to_numpy()
    in_cells = np.isfinite(cell[starts])
    corners, edges, tension, capacity = _rectangles(history)
    used = np.where(np.isnan(compressed), np.nan, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        used[..., corners] = _of_rectangles(compressed[..., corners], edges, tension, capacity)
        pressed = np.add.reduceat(np.where(np.isfinite(cell) & (n > 1e-6 * cell), cell, 0.0), starts, axis=-1)
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
        rest = np.maximum(1 - total / capacity, _FULL)
        times = (a + b + np.sqrt(np.maximum((a + b) ** 2 - 4 * a * b * rest, 0.0))) / (2 * rest)
    names = pd.Index(last["interface"].to_numpy()[joints], name="interface")
    return pd.Series(np.where(_floor(last)[joints] < N, times, np.nan), index=names)


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


def _starts(history: xr.Dataset) -> NDArray[np.int64]:
    """Return the first contact point of each interface, (J,)."""
    return np.searchsorted(history["interface_of_contact_point"].to_numpy(), np.arange(history.sizes["interface"]))


def _floor(history: xr.Dataset) -> Array:
    """Return forces (J,) below which interfaces have no utilisation."""
    return _FLOOR * np.asarray(np.add.reduceat(history["contact_force_unit"].to_numpy(), _starts(history)))


def _rectangles(history: xr.Dataset) -> tuple[NDArray[np.int64], Array, Array, Array]:
    """Return rectangles, edge forces (..., R, 4), ``f_t A``, ``(f_c+f_t) A``."""
    starts, strength = _starts(history), history["compressive_strength"].to_numpy()
    joints = np.flatnonzero(np.isfinite(strength) & ~np.isfinite(history["cell_strength"].to_numpy()[starts]))
    corners = starts[joints][:, None] + np.arange(4)
    n = history["contact_force"].sel(component="n").transpose(..., "contact_point").to_numpy()[..., corners]
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


def _with_torque(history: xr.Dataset, f: Array, sum_of: Callable[[Array], Array]) -> Array:
    """Return ``‖(V_s, V_t, T / r̄)‖`` of interfaces, T about the centroid."""
    index = history["interface_of_contact_point"].to_numpy()
    arm = (history["contact_point_position"].to_numpy() - history["interface_position"].to_numpy()[index])[:, None]
    x, y = (history["interface_frame"].to_numpy()[index, 1:] * arm).sum(axis=2).T / (
        history["torsion_lever"].to_numpy()[index]
    )
    parts = (f[..., 1], f[..., 2], x * f[..., 2] - y * f[..., 1])
    return np.asarray(np.linalg.norm([sum_of(part) for part in parts], axis=0))


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
