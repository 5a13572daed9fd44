"""Ties at collapse: force, state, and elongation in the mechanism."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.results.mechanism import largest_motion
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import TieState

#: Force, relative to the largest, that counts as none, and by which one may be below its limit.
AT_LIMIT = 1e-4
#: Elongation, relative to the largest displacement of the mechanism, that is none: velocities are those of a solver.
AT_REST = 1e-3
#: State of a tie at the limit that governs it.
OF_LIMIT = {
    "yield": TieState.YIELDING,
    "strength": TieState.YIELDING,
    "punching": TieState.PUNCHING,
    "bond": TieState.SLIPPING,
}


def tie_state(history: xr.Dataset, tolerance: float = AT_LIMIT) -> xr.DataArray:
    """State of every tie in every iteration: a :class:`blockstruct.vocabulary.TieState`.

    ``slack`` without force; ``stressed`` in between; at its limit ``yielding``, ``punching`` or ``slipping``. A stretch
    of a bonded bar slips, too, where the force changes by the whole bond in the block before or behind it.

    Parameters
    ----------
    history
        History of a case with ties, or a selection of its iterations.
    tolerance
        Relative to the largest force that each may have; of slack ties to that force or, if it is less, to the largest
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
    # The bond behind a stretch is that before the next one; at an anchor it is infinite.
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
    """Force (…, tie) of every tie, N; of a slack one, of which the solver's rounding is left, zero."""
    force = history["tie_force"].transpose(..., "tie").to_numpy()
    return np.where(tie_state(history) == TieState.SLACK.value, 0.0, force)


def ties_at_collapse(history: xr.Dataset) -> pd.DataFrame:
    """Force, state and elongation of every tie in the last iteration of a case.

    Parameters
    ----------
    history
        History of a case with ties.

    Returns
    -------
    pandas.DataFrame
        Indexed by the tie: ``force [newton]``, ``capacity [newton]``, ``governing`` (which limit the capacity is),
        ``state``, ``elongation`` (in the mechanism whose largest displacement of a centroid is one), ``elongation limit
        [meter]``, and ``displacement at limit [meter]``: the largest displacement of the mechanism at which the tie
        reaches its limit, NaN if it has none or does not get longer. The mechanism is that of small displacements.
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


def tie_title(name: str, what: str = "tie") -> str:
    """A tie in a sentence: by its name alone if that says that it is one.

    >>> tie_title("left"), tie_title("tie left")
    ('tie left', 'tie left')
    """
    return name if name.casefold().startswith("tie") else f"{what} {name}"


def tie_sentences(history: xr.Dataset) -> list[str]:
    """What each tie does in the last iteration of a case, a sentence each."""
    newton, meter = SI_UNITS["force"], SI_UNITS["length"]
    said = []
    for name, row in ties_at_collapse(history).iterrows():
        force, capacity, elongation = row[f"force [{newton}]"], row[f"capacity [{newton}]"], row["elongation"]
        text = (
            f"{tie_title(str(name), 'Tie')}: {row['state']}, {_kilo(force)} of {_kilo(capacity)} ({row['governing']})"
        )
        if elongation > AT_REST:
            text += f"; it gets longer by {elongation:.3g} times the largest displacement of a block"
            reached, limit = row[f"displacement at limit [{meter}]"], row[f"elongation limit [{meter}]"]
            if np.isfinite(reached):
                text += (
                    f": its limit of {limit * 1e3:.4g} mm is reached at {reached * 1e3:.4g} mm of it, to first order"
                )
        said.append(f"{text}.")
    return said


def _kilo(newton: float) -> str:
    return f"{newton / 1e3:.4g} kN"
