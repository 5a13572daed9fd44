"""Ties: forces, states and elongations at collapse; states and breaks in motion."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.arrays import SLIGHT, Array
from blockstruct.model import Model, tie_segments
from blockstruct.results.interfaces import NO_FORCE, at_points
from blockstruct.results.mechanism import largest_motion
from blockstruct.text.mechanism import breaking_clause, more_breaks, tie_sentence
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import LISTED, TieState

#: Decimals of the displacements at which ties break, m, and of the times, s.
DECIMALS = 9
_METER, _NEWTON = SI_UNITS["length"], SI_UNITS["force"]
#: State of a tie at its governing limit.
OF_LIMIT = {
    "yield": TieState.YIELDING,
    "strength": TieState.YIELDING,
    "punching": TieState.PUNCHING,
    "bond": TieState.SLIPPING,
}


def tie_state(history: xr.Dataset) -> xr.DataArray:
    """Return the state of every tie in every iteration.

    States are of :class:`blockstruct.vocabulary.TieState`.

    A tie is ``slack`` without force, relative to its capacity or, if it is less, to the largest contact force of the
    iteration. It is ``yielding``, ``punching`` or ``slipping`` at its limit, and ``stressed`` in between. A stretch of
    a bonded bar also slips if the force changes by the whole bond in the block at either end.

    Parameters
    ----------
    history
        History of a case with ties, or a selection of its iterations.

    Returns
    -------
    xarray.DataArray
        Texts, dimensions (iteration, tie).
    """
    force, capacity = history["tie_force"].transpose(..., "tie"), history["tie_capacity"].to_numpy()
    contact = np.abs(at_points(history, "contact_force")).max(axis=(-2, -1))[..., None]
    governing = [str(name) for name in history["tie_governing"].to_numpy()]
    state = _states(force.to_numpy(), capacity, governing, NO_FORCE * np.fmin(capacity, contact))
    bond = history["tie_bond"].transpose("tie", "tie_end").to_numpy()
    # The bond at the end of a stretch equals the bond at the start of the next one; at an anchor it is infinite.
    full = np.abs(np.diff(force.to_numpy(), axis=-1)) >= (1 - NO_FORCE) * bond[:-1, 1]
    slips = np.zeros(force.shape, dtype=bool)
    slips[..., :-1] |= full
    slips[..., 1:] |= full
    state[slips & (state == TieState.STRESSED.value)] = TieState.SLIPPING.value
    return force.copy(data=state).rename("tie_state").drop_attrs()


def _states(force: Array, capacity: Array, governing: Sequence[str], slack: Array) -> NDArray[np.object_]:
    """Return the states of ties by their forces (…, M), N, and the forces of slack ties."""
    limits = np.array([OF_LIMIT[name].value for name in governing], dtype=object)
    state = np.where(force <= slack, TieState.SLACK.value, np.full(force.shape, TieState.STRESSED.value, dtype=object))
    state = np.where(force >= (1 - NO_FORCE) * capacity, limits, state)
    return np.where(np.isfinite(force), state, TieState.UNKNOWN.value)


def tie_forces(history: xr.Dataset) -> Array:
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
    longer = np.isfinite(limit) & (elongation > SLIGHT)
    reached = np.divide(limit, elongation, out=np.full(len(limit), np.nan), where=longer)
    index = pd.Index(last["tie"].to_numpy(), name="tie")
    columns = {
        f"force [{_NEWTON}]": tie_forces(last),
        f"capacity [{_NEWTON}]": last["tie_capacity"].to_numpy(),
        "governing": last["tie_governing"].to_numpy(),
        "state": tie_state(last).to_numpy(),
        "elongation": elongation,
        f"elongation limit [{_METER}]": limit,
        f"displacement at limit [{_METER}]": reached,
    }
    return pd.DataFrame(columns, index=index)


def tie_sentences(history: xr.Dataset) -> list[str]:
    """Return a sentence on each tie in the last iteration of a case."""
    return [tie_sentence(*row) for row in ties_at_collapse(history).itertuples(name=None)]


def break_points(along: Array, elongation: Array, limit: Array) -> Array:
    """Return the displacements or times (N,) at which ties break; NaN without.

    They are displacements of the control point, m, or times, s, at the elongation limit of each tie.

    Parameters
    ----------
    along : (S,) array
        Displacements of the control point in the states, m, or their times, s.
    elongation : (S, N) array
        Elongations of the ties in each state, m.
    limit : (N,) array
        Elongation limits of the ties, m; infinite without one.
    """
    points = np.full(len(limit), np.nan)
    for tie, k in _breaking(elongation, limit).items():
        points[tie] = np.interp(limit[tie], elongation[k - 1 : k + 1, tie], along[k - 1 : k + 1])
    # Ties that break together break at the same point, free of rounding.
    return np.round(points, DECIMALS)


def _breaking(elongation: Array, limit: Array) -> dict[int, int]:
    """Return the first state after the break of each tie that breaks.

    Before the first state only joints and ties deform, so no tie has reached its limit there.
    """
    first = (elongation > limit).argmax(axis=0)
    return {int(tie): int(first[tie]) for tie in np.flatnonzero(first)}


def broken_ties(capacity: xr.Dataset) -> pd.DataFrame:
    """Return the ties that break in a pushover, in a settlement or under a record, in order.

    Parameters
    ----------
    capacity
        Capacity curve of the pushover or settlement, or response to the record.

    Returns
    -------
    pandas.DataFrame
        Indexed by the tie: ``displacement [meter]`` of the control point at the break, ``elongation [meter]`` at the
        break, ``force [newton]`` before the break, and ``load factor before`` and ``after``. The elongation equals the
        limit of the tie. Load factors belong to the states just before and after the break. Ties that break between
        the same two states share them. A settlement has ``reaction before [newton]`` and ``after`` instead. Under a
        record: ``time [second]`` and ``elongation [meter]``.
    """
    if "tie_break_time" in capacity:
        times = {
            "time [second]": capacity["tie_break_time"],
            f"elongation [{_METER}]": capacity["tie_elongation_limit"],
        }
        found = pd.DataFrame({name: values.to_series() for name, values in times.items()})
        return found.dropna().sort_values("time [second]", kind="stable")
    lengths = [f"{name} [{_METER}]" for name in ("displacement", "elongation")]
    answer, number, unit = "load_factor", "load factor", ""
    if "reaction" in capacity:
        answer, number, unit = "reaction", "reaction", f" [{_NEWTON}]"
    columns = [*lengths, f"force [{_NEWTON}]", f"{number} before{unit}", f"{number} after{unit}"]
    if "tie_break_displacement" not in capacity:
        return pd.DataFrame(columns=columns, index=pd.Index([], name="tie"), dtype=float)
    at, limit = (capacity[name].to_numpy() for name in ("tie_break_displacement", "tie_elongation_limit"))
    force, elongation = (capacity[name].transpose("step", "tie").to_numpy() for name in ("tie_force", "tie_elongation"))
    breaking = _breaking(elongation, limit)
    values = capacity[answer].transpose("step").to_numpy()
    rows = [(at[tie], limit[tie], force[k - 1, tie], *values[k - 1 : k + 1]) for tie, k in breaking.items()]
    names = pd.Index(capacity["tie"].to_numpy()[list(breaking)], name="tie")
    return pd.DataFrame(rows, columns=columns, index=names, dtype=float).sort_values(lengths[0], kind="stable")


def pushed_tie_state(model: Model, capacity: xr.Dataset) -> xr.DataArray:
    """Return the state of every tie in every state of a pushover, or of a response to a record.

    States are as in :func:`tie_state`; a tie beyond its limit is ``broken``.

    Parameters
    ----------
    model, capacity
        The structure, with ties, and its capacity curve or response.

    Returns
    -------
    xarray.DataArray
        Texts, dimensions (step, tie) or (time, tie).
    """
    longest = "peak_tie_elongation" if "peak_tie_elongation" in capacity else "tie_elongation"
    force, elongation = (capacity[name].transpose(..., "tie") for name in ("tie_force", longest))
    segments = tie_segments(model.ties, model.blocks)
    largest, governing = np.array([s.capacity for s in segments]), [s.governing for s in segments]
    state = _states(force.to_numpy(), largest, governing, _rounding(model))
    beyond = elongation.to_numpy() > capacity["tie_elongation_limit"].to_numpy()
    state = np.where(np.logical_or.accumulate(beyond), TieState.BROKEN.value, state)
    return force.copy(data=state).rename("tie_state").drop_attrs()


def _rounding(model: Model) -> Array:
    """Return the force (N,) below which each tie counts as slack in a pushover, N.

    It is a share of the capacity or, if less, of the weight of the lighter block at either end.
    """
    weight = {b.name: np.inf if b.fixed else b.weight for b in model.blocks}
    least = [min(s.capacity, *(weight[name] for name in s.blocks)) for s in tie_segments(model.ties, model.blocks)]
    return NO_FORCE * np.array(least)


def breaking_words(capacity: xr.Dataset) -> list[str]:
    """Return clauses on the ties that break in a pushover or in a settlement.

    Each gives the displacement and the change of load factor or reaction. The last clause counts the remaining ties.
    """
    broken, is_reaction = broken_ties(capacity), "reaction" in capacity
    clauses = []
    for _, together in broken.head(LISTED).groupby(broken.columns[-2:].tolist(), sort=False):
        breaks = list(together.iloc[:, :2].itertuples(name=None))
        clauses.append(breaking_clause(breaks, *together.iloc[0, -2:].astype(float), is_reaction=is_reaction))
    rest = len(broken) - LISTED
    return clauses + [more_breaks(rest)] * (rest > 0)
