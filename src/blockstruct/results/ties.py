"""Ties at collapse: force, state, and elongation in the mechanism."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.results.mechanism import largest_motion
from blockstruct.text import tie_sentence
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import TieState

#: Force, relative to the largest, that counts as zero, or as the distance from a limit.
AT_LIMIT = 1e-4
#: Elongation, relative to the largest displacement of the mechanism, that counts as zero within solver tolerances.
AT_REST = 1e-3
#: State of a tie at its governing limit.
OF_LIMIT = {
    "yield": TieState.YIELDING,
    "strength": TieState.YIELDING,
    "punching": TieState.PUNCHING,
    "bond": TieState.SLIPPING,
}


def tie_state(history: xr.Dataset, tolerance: float = AT_LIMIT) -> xr.DataArray:
    """Return the state of every tie in every iteration.

    States are of :class:`blockstruct.vocabulary.TieState`.

    A tie is ``slack`` without force, ``yielding``, ``punching`` or ``slipping`` at its limit, and ``stressed`` in
    between. A stretch of a bonded bar also slips if the force changes by the whole bond in the block at either end.

    Parameters
    ----------
    history
        History of a case with ties, or a selection of its iterations.
    tolerance
        Relative to the capacity of each tie. For slack ties, relative to the capacity or, if it is less, to the largest
        contact force of the iteration.

    Returns
    -------
    xarray.DataArray
        Texts, dimensions (iteration, tie).
    """
    force = history["tie_force"].transpose(..., "tie").to_numpy()
    capacity = history["tie_capacity"].to_numpy()
    bond = history["tie_bond"].transpose("tie", "tie_end").to_numpy()
    change = np.abs(np.diff(force, axis=-1))
    slips = np.zeros(force.shape, dtype=bool)
    # The bond at the end of a stretch equals the bond at the start of the next one; at an anchor it is infinite.
    full = change >= (1 - tolerance) * bond[:-1, 1]
    slips[..., :-1] |= full
    slips[..., 1:] |= full
    limits = [OF_LIMIT[str(name)].value for name in history["tie_governing"].to_numpy()]
    at_limit = np.broadcast_to(np.array(limits, dtype=object), force.shape)
    state = np.full(force.shape, TieState.STRESSED.value, dtype=object)
    state = np.where(slips, TieState.SLIPPING.value, state)
    at_contacts = history["contact_force"].transpose(..., "contact_point", "component").to_numpy()
    contact = np.abs(at_contacts).max(axis=(-2, -1))[..., None]
    state = np.where(force <= tolerance * np.fmin(capacity, contact), TieState.SLACK.value, state)
    state = np.where(force >= (1 - tolerance) * capacity, at_limit, state)
    state = np.where(np.isfinite(force), state, TieState.UNKNOWN.value)
    return history["tie_force"].transpose(..., "tie").copy(data=state).rename("tie_state").drop_attrs()


def tie_forces(history: xr.Dataset) -> NDArray[np.float64]:
    """Return the force (…, tie) of every tie, N; zero for slack ties."""
    force = history["tie_force"].transpose(..., "tie").to_numpy()
    return np.where(tie_state(history) == TieState.SLACK.value, 0.0, force)


def ties_at_collapse(history: xr.Dataset) -> pd.DataFrame:
    """Return force, state and elongation of ties in the last iteration.

    Parameters
    ----------
    history
        History of a case with ties.

    Returns
    -------
    pandas.DataFrame
        Indexed by tie:

        - ``force [newton]``, ``capacity [newton]``, ``governing`` (the limit that sets the capacity), ``state``;
        - ``elongation`` in the mechanism with a largest displacement of a centroid of one;
        - ``elongation limit [meter]``;
        - ``displacement at limit [meter]``: largest displacement of the mechanism at which the tie reaches its limit,
          by the mechanism of small displacements; NaN without a limit, or if the tie does not lengthen.
    """
    last = history.isel(iteration=-1)
    elongation = last["tie_elongation_rate"].to_numpy() / largest_motion(history)
    limit = last["tie_elongation_limit"].to_numpy()
    newton, meter = SI_UNITS["force"], SI_UNITS["length"]
    longer = np.isfinite(limit) & (elongation > AT_REST)
    reached = np.divide(limit, elongation, out=np.full(len(limit), np.nan), where=longer)
    index = pd.Index(last["tie"].to_numpy(), name="tie")
    columns = {
        f"force [{newton}]": tie_forces(last),
        f"capacity [{newton}]": last["tie_capacity"].to_numpy(),
        "governing": last["tie_governing"].to_numpy(),
        "state": tie_state(last).to_numpy(),
        "elongation": elongation,
        f"elongation limit [{meter}]": limit,
        f"displacement at limit [{meter}]": reached,
    }
    return pd.DataFrame(columns, index=index)


def tie_sentences(history: xr.Dataset) -> list[str]:
    """Return a sentence on each tie in the last iteration of a case."""
    newton, meter = SI_UNITS["force"], SI_UNITS["length"]
    return [
        tie_sentence(
            str(name),
            row["state"],
            row[f"force [{newton}]"],
            row[f"capacity [{newton}]"],
            row["governing"],
            lengthens=row["elongation"] if row["elongation"] > AT_REST else 0.0,
            elongation_limit=row[f"elongation limit [{meter}]"],
            at=row[f"displacement at limit [{meter}]"],
        )
        for name, row in ties_at_collapse(history).iterrows()
    ]
