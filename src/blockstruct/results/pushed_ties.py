"""Ties in a pushover: states, breaks and loss of load factor."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.model import Model, tie_segments
from blockstruct.results.ties import AT_LIMIT, OF_LIMIT
from blockstruct.text import tie_title
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import TieState

Array = NDArray[np.float64]

#: Decimals of the displacements at which ties break, m.
DECIMALS = 9
#: Largest number of ties that are listed one by one.
LISTED = 5


def break_displacements(displacement: Array, elongation: Array, limit: Array) -> Array:
    """Return the displacements (N,) at which ties break, m; NaN without.

    They are displacements of the control point, at the elongation limit of each tie.

    Parameters
    ----------
    displacement : (S,) array
        Displacements of the control point in the states, m.
    elongation : (S, N) array
        Elongations of the ties in each state, m.
    limit : (N,) array
        Elongation limits of the ties, m; infinite without one.
    """
    found = np.full(len(limit), np.nan)
    for tie, k in _breaking(elongation, limit).items():
        found[tie] = np.interp(limit[tie], elongation[k - 1 : k + 1, tie], displacement[k - 1 : k + 1])
    # Ties that break together break at the same displacement, free of rounding.
    return np.round(found, DECIMALS)


def _breaking(elongation: Array, limit: Array) -> dict[int, int]:
    """Return the first state after the break of each tie that breaks.

    Before the first state only joints and ties deform, so no tie has reached its limit there.
    """
    first = (elongation > limit).argmax(axis=0)
    return {int(tie): int(first[tie]) for tie in np.flatnonzero(first)}


def broken_ties(capacity: xr.Dataset) -> pd.DataFrame:
    """Return the ties that break in a pushover, in order.

    Parameters
    ----------
    capacity
        Capacity curve of the pushover.

    Returns
    -------
    pandas.DataFrame
        Indexed by the tie: ``displacement [meter]`` of the control point at the break, ``elongation [meter]`` at the
        break, ``force [newton]`` before the break, and ``load factor before`` and ``after``. The elongation equals the
        limit of the tie. Load factors belong to the states just before and after the break. Ties that break between
        the same two states share them.
    """
    meter, newton = SI_UNITS["length"], SI_UNITS["force"]
    lengths = [f"{name} [{meter}]" for name in ("displacement", "elongation")]
    columns = [*lengths, f"force [{newton}]", "load factor before", "load factor after"]
    if "tie_break_displacement" not in capacity:
        return pd.DataFrame(columns=columns, index=pd.Index([], name="tie"), dtype=float)
    at, limit = (capacity[name].to_numpy() for name in ("tie_break_displacement", "tie_elongation_limit"))
    force, elongation = (capacity[name].transpose("step", "tie").to_numpy() for name in ("tie_force", "tie_elongation"))
    breaking = _breaking(elongation, limit)
    alpha = capacity["load_factor"].transpose("step").to_numpy()
    rows = [(at[tie], limit[tie], force[k - 1, tie], *alpha[k - 1 : k + 1]) for tie, k in breaking.items()]
    names = pd.Index(capacity["tie"].to_numpy()[list(breaking)], name="tie")
    return pd.DataFrame(rows, columns=columns, index=names, dtype=float).sort_values(lengths[0], kind="stable")


def pushed_tie_state(model: Model, capacity: xr.Dataset) -> xr.DataArray:
    """Return the state of every tie in every state of a pushover.

    States are as in :func:`tie_state`; a tie beyond its limit is ``broken``.

    Parameters
    ----------
    model, capacity
        The structure, with ties, and its capacity curve.

    Returns
    -------
    xarray.DataArray
        Texts, dimensions (step, tie).
    """
    force, elongation = (capacity[name].transpose("step", "tie") for name in ("tie_force", "tie_elongation"))
    tension, segments = force.to_numpy(), tie_segments(model.ties, model.blocks)
    largest = np.array([segment.capacity for segment in segments])
    limits = np.array([OF_LIMIT[segment.governing].value for segment in segments], dtype=object)
    state = np.full(tension.shape, TieState.STRESSED.value, dtype=object)
    state = np.where(tension >= (1 - AT_LIMIT) * largest, limits, state)
    state = np.where(slack(model, tension), TieState.SLACK.value, state)
    state = np.where(np.isfinite(tension), state, TieState.UNKNOWN.value)
    beyond = elongation.to_numpy() > capacity["tie_elongation_limit"].to_numpy()
    state = np.where(np.logical_or.accumulate(beyond), TieState.BROKEN.value, state)
    return force.copy(data=state).rename("tie_state").drop_attrs()


def slack(model: Model, force: Array) -> NDArray[np.bool_]:
    """Return whether ties are slack in a pushover, from forces (…, N), N.

    An unknown force does not count as slack.
    """
    return np.asarray(force <= rounding_of_ties(model))


def rounding_of_ties(model: Model) -> Array:
    """Return the force (N,) below which each tie counts as slack, N.

    It is a share of the capacity or, if less, of the weight of the lighter block at either end.
    """
    segments = tie_segments(model.ties, model.blocks)
    weight = {b.name: np.inf if b.fixed else b.weight for b in model.blocks}
    lighter = np.array([min(weight[name] for name in segment.blocks) for segment in segments])
    return np.asarray(AT_LIMIT * np.fmin(np.array([segment.capacity for segment in segments]), lighter))


def breaking_words(capacity: xr.Dataset) -> list[str]:
    """Return clauses on the ties that break in a pushover.

    Each gives the displacement and the loss of load factor. The last clause counts the remaining ties.
    """
    found = broken_ties(capacity)
    listed = found.head(LISTED)
    said = []
    for (before, after), together in listed.groupby(["load factor before", "load factor after"], sort=False):
        each = [
            f"{tie_title(str(name))} breaks at a displacement of {d * 1e3:.4g} mm, {longer * 1e3:.4g} mm longer"
            for name, d, longer in together.iloc[:, :2].itertuples()
        ]
        said.append(f"{' and '.join(each)}: the load factor falls from {before:.4g} to {after:.4g}")
    rest = len(found) - len(listed)
    return said + [f"{rest} more {'tie breaks' if rest == 1 else 'ties break'}"] * (rest > 0)
