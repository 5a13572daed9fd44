"""Settings of the procedure."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any, Self

from blockstruct.errors import ModelError, UnknownKeywordError, shown
from blockstruct.keywords import checked_keywords, did_you_mean
from blockstruct.model import checked_tuple

#: Tolerances of the certificate.
CERTIFIED = ("equilibrium_tolerance", "yield_tolerance", "interpenetration_tolerance", "gap_tolerance")


@checked_keywords
@dataclass(frozen=True, slots=True)
class ProcedureSettings:
    """Schedule and tolerances of the procedure: part of every result, because the answer depends on them.

    The non-associative iteration replaces the friction cone by a fictitious condition
    ``‖(s, t)‖ ≤ c0 + (1 + a) μ n0 − a μ n`` (for zero dilatancy) that is moved along with the solution
    (Gilbert, Casapulla & Ahmed 2006; Portioli et al. 2014). Forces at a contact are in multiples of the dead wrench of
    the lighter of its two blocks.

    Parameters
    ----------
    slope, slope_decay, slope_min
        Start, factor per step and end of ``a``. A negative slope steers to the low solution; it must fade faster
        than the cohesion, because ``a > 0`` also caps the force on contacts that were unloaded.
    cohesion, cohesion_decay, cohesion_min
        Start, factor per step and end of ``c0``, which keeps unloaded contacts from making a program infeasible.
    relaxation, relaxation_growth, relaxation_cut, relaxation_min, relaxation_max
        β, the share of the new normal forces in ``n0``: its start, its factor in a step that moves the load factor
        on in the same direction, its factor in a step that turns it back, and its limits.
    load_factor_tolerance
        Relative change of the load factor, extrapolated to the end of its drift, below which it has settled.
    patience
        After this many steps a load factor that still moves is certified as well, if it can be.
    cohesion_limit
        Largest ``c0`` at which the iteration may end.
    procedure
        Non-associative sliding by ``"fictitious"`` conditions; by the ``"shifted"`` objective of De Saxcé & Feng
        (1998), which is never infeasible and often ends higher; or along the ``"loading path"`` of a structure with
        slightly elastic joints, from its state under dead load.
    shear_stiffness_ratio
        Shear over normal stiffness of joints that were given no shear stiffness, in the loading path: 0.4 is that of
        an elastic layer with a Poisson ratio of 0.2.
    path_step, path_growth
        First step of the loading path, in multiples of the displacement of the elastic structure under the variable
        load; and the largest ratio of one step to the last.
    path_steps
        How the steps of the loading path are solved: by ``"splitting"``, to three digits or so in a hundred cheap
        iterations each, or by ``"interior point"``, exactly where it succeeds and ten times as slow. The collapse state
        at their end is closed exactly in either case.
    max_programs
        Programs solved before the case is given up.
    fallback_after
        Programs after which the fictitious conditions give way to the shifted objective.
    equilibrium_tolerance, yield_tolerance
        Largest residual, in multiples of the dead wrench of the block; and yield excess, in multiples of that of the
        lighter block or, where it is larger, of the normal force.
    interpenetration_tolerance
        Largest interpenetration, in multiples of the largest relative velocity.
    gap_tolerance
        Largest flow-rule gap, relative to the load factor; or, where that is smaller, to a thousandth of the work
        scale of the mechanism, the sum of weight times velocity over the blocks.
    crushing
        How crushing of rectangles enters the programs: ``"conic"`` exactly, by rotated cones, or ``"linearised"``
        about the last iterate, as in the paper, in the same loop as friction.
    crushing_interaction
        ``"biaxial"`` bounds bending about both axes by the effective rectangle, exact about one axis and on the safe
        side about both; the default with ``crushing="conic"``, which it needs. ``"uniaxial"``, as in the paper, bounds
        that about each axis by itself, on the unsafe side about both; the default with ``crushing="linearised"``.
    crushing_cells
        Number of cells, about, of an interface that crushes and is not a rectangle. A block that rocks turns about the
        middle of the outer row: 64 cells take up to 7 % off its lever, mostly 3 to 5 %.
    solver
        ``"clarabel"`` (direct, reused between iterations) or ``"cvxpy:NAME"`` for any conic solver CVXPY has.
    solver_tolerance
        Feasibility and duality-gap tolerance asked of the solver.
    step_tolerance
        The same in a step of the non-associative iteration, in multiples of its ``c0``. An interior-point solution
        leaves a little force on unloaded contacts: it must stay small beside c0, or it holds the wall together
        (measured: 1e-6 in all steps ends 0.8 % high on walls of 50 blocks, 1e-3 c0 does not, with a tenth fewer
        interior-point iterations).
    """

    slope: float = 0.3
    slope_decay: float = 0.35
    slope_min: float = 1e-6
    cohesion: float = 0.01
    cohesion_decay: float = 0.5
    cohesion_min: float = 1e-6
    relaxation: float = 0.4
    relaxation_growth: float = 1.15
    relaxation_cut: float = 0.6
    relaxation_min: float = 0.25
    relaxation_max: float = 0.8
    load_factor_tolerance: float = 3e-4
    patience: int = 16
    cohesion_limit: float = 1e-3
    procedure: str = "fictitious"
    shear_stiffness_ratio: float = 0.4
    path_step: float = 1.0
    path_growth: float = 4.0
    path_steps: str = "splitting"
    max_programs: int = 120
    fallback_after: int = 60
    equilibrium_tolerance: float = 1e-6
    yield_tolerance: float = 1e-5
    interpenetration_tolerance: float = 1e-4
    gap_tolerance: float = 1e-3
    crushing: str = "conic"
    crushing_interaction: str = ""
    crushing_cells: int = 64
    solver: str = "clarabel"
    solver_tolerance: float = 1e-9
    step_tolerance: float = 1e-3

    def __post_init__(self) -> None:
        if self.crushing_interaction == "":
            object.__setattr__(self, "crushing_interaction", "biaxial" if self.crushing == "conic" else "uniaxial")
        limits = {
            "slope": (0.0, 1.0),
            "slope_decay": (0.0, 1.0),
            "cohesion_decay": (0.0, 1.0),
            "relaxation": (1e-3, 1.0),
            "relaxation_growth": (1.0, 10.0),
            "relaxation_cut": (0.0, 1.0),
            "relaxation_min": (1e-3, 1.0),
            "relaxation_max": (1e-3, 1.0),
            "max_programs": (1, 10_000),
            "fallback_after": (3, 10_000),
            "patience": (1, 10_000),
            "crushing_cells": (1, 100_000),
            "solver_tolerance": (1e-14, 1e-4),
            "step_tolerance": (0.0, 1e-2),
            "shear_stiffness_ratio": (1e-3, 1e3),
            "path_step": (1e-3, 1e3),
            "path_growth": (1.0, 100.0),
            "slope_min": (0.0, 1.0),
            # A certificate within wider tolerances would say nothing.
            **{f.name: (0.0, 1e-2) for f in fields(self) if f.name in CERTIFIED},
        }
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type is str or field.type == "str":
                if not isinstance(value, str):
                    msg = f"ProcedureSettings: {field.name} is {shown(value)}; give a text"
                    raise ModelError(msg)
                continue
            low, high = limits.get(field.name, (0.0, 1e6))
            whole = field.type is int or field.type == "int"
            kind: type[Any] = Integral if whole else Real
            if isinstance(value, bool) or not isinstance(value, kind):
                msg = f"ProcedureSettings: {field.name} is {shown(value)}; give a {'whole ' if whole else ''}number"
                raise ModelError(msg)
            if not low <= value <= high:
                msg = f"ProcedureSettings: {field.name} is {shown(value)}; give a value from {low:g} to {high:g}"
                raise ModelError(msg)
            # Numbers of numpy are stored as JSON like any other.
            object.__setattr__(self, field.name, int(value) if whole else float(value))

        if self.relaxation_min > self.relaxation_max:
            msg = (
                f"ProcedureSettings: relaxation_min is {self.relaxation_min!r}, above relaxation_max "
                f"{self.relaxation_max!r}; give less"
            )
            raise ModelError(msg)
        choices = {
            "procedure": ("fictitious", "shifted", "loading path"),
            "path_steps": ("splitting", "interior point"),
            "crushing": ("conic", "linearised"),
            "crushing_interaction": ("uniaxial", "biaxial"),
        }
        for name, known in choices.items():
            if getattr(self, name) not in known:
                msg = f"ProcedureSettings: {name} is {shown(getattr(self, name))}; give one of {', '.join(known)}"
                raise ModelError(msg)
        if self.crushing_interaction == "biaxial" and self.crushing != "conic":
            msg = (
                f"ProcedureSettings: crushing={self.crushing!r} has no biaxial interaction; give crushing='conic', or "
                "crushing_interaction='uniaxial'"
            )
            raise ModelError(msg)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Settings from names and values, as documents and files keep them."""
        if not isinstance(values, Mapping):
            msg = f"ProcedureSettings: {shown(values)} are not settings; give a mapping of names to values"
            raise ModelError(msg)
        known = [f.name for f in fields(cls)]
        for name in values:
            if name not in known:
                msg = f"ProcedureSettings: no setting {shown(name)}; {did_you_mean(str(name), known)}"
                raise UnknownKeywordError(msg)
        return cls(**values)


#: Settings that each schedule changes. Measured on 36 walls with openings (default settings: 0.2 % above the lowest
#: on average, 7 % at most): each of the first three finds the lowest load factor of some, the shift the highest. The
#: loading paths tell what the answer to how a structure is loaded depends on.
SCHEDULES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "steep": {"procedure": "fictitious", "slope": 0.6},
        "low cohesion": {"procedure": "fictitious", "cohesion": 0.001, "slope": 0.5},
        "slow": {"procedure": "fictitious", "cohesion": 0.1, "cohesion_decay": 0.7, "slope_decay": 0.6, "patience": 24},
        # Where the shift finds a certificate it does so in fewer than 30 programs; it need not try 120.
        "shift": {"procedure": "shifted", "max_programs": 40},
        "loading path": {"procedure": "loading path"},
        "path half steps": {"procedure": "loading path", "path_step": 0.5, "path_growth": 2.0},
        "path shear 0.2": {"procedure": "loading path", "shear_stiffness_ratio": 0.2},
        "path shear 1": {"procedure": "loading path", "shear_stiffness_ratio": 1.0},
    }
)


#: The loading paths among them, by one name: what the number along the path depends on.
PATH_DEPENDENCE = "path dependence"
_PATHS = tuple(name for name, changes in SCHEDULES.items() if changes["procedure"] == "loading path")


def scheduled(settings: ProcedureSettings, schedule: str) -> ProcedureSettings:
    """Settings changed by a schedule, which never raises the number of programs."""
    changes = dict(SCHEDULES[schedule])
    changes["max_programs"] = min(settings.max_programs, changes.get("max_programs", settings.max_programs))
    return replace(settings, **changes)


def schedules_of(spread: bool | str | Iterable[str]) -> tuple[str, ...]:
    """Names of the schedules that ``spread`` asks for: all for True, none for False, the paths for their one name.

    Raises
    ------
    ModelError
        If no schedule has a name.
    """
    if isinstance(spread, bool):
        return tuple(SCHEDULES) if spread else ()
    names = checked_tuple((spread,) if isinstance(spread, str) else spread, str, "spread")
    names = tuple(each for name in names for each in (_PATHS if name == PATH_DEPENDENCE else (name,)))
    unknown = [name for name in names if name not in SCHEDULES]
    if unknown:
        known = ", ".join((*SCHEDULES, PATH_DEPENDENCE))
        msg = f"spread: unknown schedule {', '.join(map(repr, unknown))}; known are {known}, or True"
        raise ModelError(msg)
    return tuple(dict.fromkeys(names))
