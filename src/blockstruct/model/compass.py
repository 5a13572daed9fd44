"""Limit cases for pushes in many horizontal directions."""

import math
from typing import Any

import numpy as np

from blockstruct.errors import ModelError, shown
from blockstruct.model.cases import Case, LimitCase
from blockstruct.model.fields import checked_count, checked_name
from blockstruct.model.loads import BodyForce, LoadPattern
from blockstruct.units import si, si_array
from blockstruct.vocabulary import Flow


def direction_cases(
    dead: LoadPattern, directions: Any = 8, *, vertical: Any = 0.0, flow: Flow = Flow.NONASSOCIATIVE, name: str = "push"
) -> list[LimitCase]:
    """Return limit cases whose variable load is the weight as a horizontal push.

    Parameters
    ----------
    dead
        Loads that act in full, in each case.
    directions : int, or quantity of angles
        Number of directions, evenly spread from +x; or the angles from +x towards +y, as ``Q_([0, 45], "deg")``.
    vertical : float
        Vertical part of the variable load in multiples of the horizontal one, upwards if positive.
    flow
        As for :class:`LimitCase`.
    name
        First word of the names of the cases.

    Raises
    ------
    ModelError
        If there is no direction, a direction is repeated, or there are too many.
    UnitError
        If angles have no unit.
    """
    checked_name(name, "directions")
    share = si(vertical, "dimensionless", "directions: vertical")
    angles = np.degrees(_angles(directions))
    cases = []
    for angle in angles:
        x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        # Rounding keeps opposite directions symmetric to the last digit.
        loads = [BodyForce((round(x, 15) + 0.0, round(y, 15) + 0.0, 0.0))]
        title = f"{name} {angle:g} deg"
        if share:
            loads.append(BodyForce("+z", share))
            title += f", {abs(share):g} {'up' if share > 0 else 'down'}"
        cases.append(LimitCase(title, dead, LoadPattern(title, loads), flow))
    return cases


def direction_of(case: Case) -> tuple[float, float] | None:
    """Return the angle, from 0 to less than 360 degrees, and the vertical share of a case of :func:`direction_cases`.

    Other cases give None.
    """
    if not isinstance(case, LimitCase):
        return None
    loads = [load for load in case.variable.loads if isinstance(load, BodyForce)]
    if not 1 <= len(loads) <= 2 or len(loads) < len(case.variable.loads):
        return None
    (x, y, z), *rest = [load.direction for load in loads]
    if z or not math.isclose(loads[0].share, 1.0) or any(direction[:2] != (0.0, 0.0) for direction in rest):
        return None
    upwards = loads[1].share * loads[1].direction[2] if rest else 0.0
    # Rounded as in the names: 360 degrees are 0.
    return round(math.degrees(math.atan2(y, x)), 9) % 360, upwards


def _angles(directions: Any) -> Any:
    """Return the angles, rad."""
    if isinstance(directions, int | np.integer) and not isinstance(directions, bool):
        count = checked_count(directions, 1, "directions:")
        return np.radians(np.arange(count) * 360 / count)
    if isinstance(directions, list | tuple):
        angles = np.array([si(angle, "angle", "directions: angle") for angle in directions])
    else:
        angles = si_array(directions, "angle", "directions: angles").ravel()
    checked_count(len(angles), 1, "directions: number of angles")
    turned = np.degrees(angles).round(9) % 360
    if len(np.unique(turned)) < len(turned):
        msg = f"directions: {shown(turned.tolist())} deg repeats a direction; give each once"
        raise ModelError(msg)
    return np.radians(turned)
