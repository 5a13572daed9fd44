"""Named schedules: other settings of the procedure that may lead to another answer."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from blockstruct.errors import ModelError

#: Settings that each schedule changes. Measured on 36 walls with openings (default settings: 0.2 % above the lowest
#: on average, 7 % at most): each of these finds the lowest load factor of some, the shift the highest.
SCHEDULES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "steep": {"slope": 0.6},
        "low cohesion": {"cohesion": 0.001, "slope": 0.5},
        "slow": {"cohesion": 0.1, "cohesion_decay": 0.7, "slope_decay": 0.6, "patience": 24},
        "shift": {"procedure": "shifted"},
    }
)


def schedules_of(spread: bool | str | Iterable[str]) -> tuple[str, ...]:
    """Names of the schedules that ``spread`` asks for: all for True, none for False.

    Raises
    ------
    ModelError
        A name that no schedule has.
    """
    if isinstance(spread, bool):
        return tuple(SCHEDULES) if spread else ()
    names = (spread,) if isinstance(spread, str) else tuple(spread)
    unknown = [name for name in names if name not in SCHEDULES]
    if unknown:
        msg = f"spread: unknown schedule {', '.join(map(repr, unknown))}; known are {', '.join(SCHEDULES)}, or True"
        raise ModelError(msg)
    return tuple(dict.fromkeys(names))
