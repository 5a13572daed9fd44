"""Define and check the settings of the procedure."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any, Self

from blockstruct.errors import ModelError, UnknownKeywordError, did_you_mean, shown
from blockstruct.model import checked_tuple


class _Checked:
    """Checks numbers against their limits and texts against their choices."""

    #: Lowest and highest value of each number, and permitted values of each text, by name.
    _LIMITS: Mapping[str, tuple[float, float]] = MappingProxyType({})
    _CHOICES: Mapping[str, tuple[str, ...]] = MappingProxyType({})

    def _check(self) -> None:
        who = type(self).__name__
        for name, (low, high) in self._LIMITS.items():
            value, whole = getattr(self, name), isinstance(_default(self, name), int)
            kind: type[Any] = Integral if whole else Real
            if isinstance(value, bool) or not isinstance(value, kind):
                msg = f"{who}: {name} is {shown(value)}; give a {'whole ' if whole else ''}number"
                raise ModelError(msg)
            if not low <= value <= high:
                msg = f"{who}: {name} is {shown(value)}; give a value from {low:g} to {high:g}"
                raise ModelError(msg)
            # JSON stores Python numbers but not numpy numbers.
            object.__setattr__(self, name, int(value) if whole else float(value))
        for name, known in self._CHOICES.items():
            if getattr(self, name) not in known:
                msg = f"{who}: {name} is {shown(getattr(self, name))}; give one of {', '.join(known)}"
                raise ModelError(msg)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Return settings from names and values, as stored in files.

        Raises
        ------
        ModelError
            If ``values`` is not a mapping, or a value is not allowed.
        UnknownKeywordError
            If a name is unknown.
        """
        if not isinstance(values, Mapping):
            msg = f"{cls.__name__}: {shown(values)} are not settings; give a mapping of names to values"
            raise ModelError(msg)
        parts: dict[str, type[_Checked]] = {"schedule": FictitiousSchedule, "numerics": Numerics}
        known = [f.name for f in fields(cls)]  # type: ignore[arg-type]
        for name in values:
            if name not in known:
                msg = f"{cls.__name__}: no setting {shown(name)}; {did_you_mean(str(name), known)}"
                raise UnknownKeywordError(msg)
        given = {n: parts[n].of(v) if n in parts and isinstance(v, Mapping) else v for n, v in values.items()}
        return cls(**given)


def _default(settings: Any, name: str) -> Any:
    return next(f.default for f in fields(settings) if f.name == name)


@dataclass(frozen=True, slots=True)
class FictitiousSchedule(_Checked):
    """Schedule of the iteration with fictitious sliding conditions.

    Each program has the condition ``‖(s, t)‖ ≤ c0 + (1 + a) μ n0 − a μ n`` (for zero dilatancy). n0 follows the
    solution of the program before (Gilbert, Casapulla & Ahmed 2006; Portioli et al. 2014). c0 is in multiples of the
    dead wrench of the lighter of the two blocks.

    Parameters
    ----------
    slope, slope_decay, slope_min
        Start, factor per program and end of ``a``. A falling condition (``a > 0``) leads to the low solution. ``a``
        must decrease faster than c0, because ``a > 0`` also limits the normal force at contacts without force in the
        program before.
    c0, c0_decay, c0_min
        Start, factor per program and end of ``c0``. Without ``c0``, contacts without force may make a program
        infeasible.
    c0_limit
        Largest ``c0`` at which the iteration may end.
    relaxation, relaxation_growth, relaxation_cut, relaxation_min, relaxation_max
        Start, growth factor, reduction factor and limits of β, the share of the new normal forces in ``n0``. β grows
        after a program that changes the load factor in the same direction. It is reduced after a program that reverses
        the direction.
    load_factor_tolerance
        Relative change of the load factor, extrapolated to the end of the iteration, below which it has settled.
    patience
        Number of programs after which a load factor that still changes is also certified, if possible.
    max_programs
        Number of programs after which the case ends without a result.
    fallback_after
        Number of programs after which the shifted objective replaces the fictitious conditions.
    """

    slope: float = 0.3
    slope_decay: float = 0.35
    slope_min: float = 1e-6
    c0: float = 0.01
    c0_decay: float = 0.5
    c0_min: float = 1e-6
    c0_limit: float = 1e-3
    relaxation: float = 0.4
    relaxation_growth: float = 1.15
    relaxation_cut: float = 0.6
    relaxation_min: float = 0.25
    relaxation_max: float = 0.8
    load_factor_tolerance: float = 3e-4
    patience: int = 16
    max_programs: int = 120
    fallback_after: int = 60

    _LIMITS = MappingProxyType(
        {
            **dict.fromkeys(("slope", "slope_decay", "slope_min", "c0_decay", "relaxation_cut"), (0.0, 1.0)),
            **dict.fromkeys(("relaxation", "relaxation_min", "relaxation_max"), (1e-3, 1.0)),
            **dict.fromkeys(("c0", "c0_min", "c0_limit", "load_factor_tolerance"), (0.0, 1e6)),
            "relaxation_growth": (1.0, 10.0),
            "patience": (1, 10_000),
            "max_programs": (1, 10_000),
            "fallback_after": (3, 10_000),
        }
    )

    def __post_init__(self) -> None:
        self._check()
        if self.relaxation_min > self.relaxation_max:
            msg = (
                f"FictitiousSchedule: relaxation_min is {self.relaxation_min!r}, above relaxation_max "
                f"{self.relaxation_max!r}; give less"
            )
            raise ModelError(msg)


@dataclass(frozen=True, slots=True)
class Numerics(_Checked):
    """Conic solver, and tolerances of the solver and the certificate.

    Parameters
    ----------
    solver
        ``"clarabel"`` (direct, reused between programs) or ``"cvxpy:NAME"`` for any conic solver of CVXPY.
    solver_tolerance
        Feasibility and duality-gap tolerance of the solver.
    step_tolerance
        Solver tolerance in a program of the fictitious iteration, in multiples of its c0. An interior-point solution
        leaves a small force on open contacts. Measured on walls of 50 blocks: with 1e-6 in all programs the load factor
        is 0.8 % too high.
    equilibrium_tolerance
        Largest residual, in multiples of the dead wrench of the block.
    yield_tolerance
        Largest yield excess, in multiples of the dead wrench of the lighter block or of the normal force, whichever
        is larger.
    interpenetration_tolerance
        Largest interpenetration, in multiples of the largest relative velocity. Slower motion counts as rest.
    gap_tolerance
        Largest flow-rule gap, relative to the load factor or to a thousandth of the work scale of the mechanism,
        whichever is larger. The work scale is the sum of weight times velocity over the blocks.
    """

    solver: str = "clarabel"
    solver_tolerance: float = 1e-9
    step_tolerance: float = 1e-3
    equilibrium_tolerance: float = 1e-6
    yield_tolerance: float = 1e-5
    interpenetration_tolerance: float = 1e-4
    gap_tolerance: float = 1e-3

    _LIMITS = MappingProxyType(
        {
            "solver_tolerance": (1e-14, 1e-4),
            "step_tolerance": (0.0, 1e-2),
            # A certificate within wider tolerances would prove nothing.
            **dict.fromkeys(
                ("equilibrium_tolerance", "yield_tolerance", "interpenetration_tolerance", "gap_tolerance"), (0.0, 1e-2)
            ),
        }
    )

    def __post_init__(self) -> None:
        self._check()
        if not isinstance(self.solver, str):
            msg = f"Numerics: solver is {shown(self.solver)}; give a text"
            raise ModelError(msg)


@dataclass(frozen=True, slots=True)
class ProcedureSettings(_Checked):
    """Settings of the search for a load factor.

    They are part of every result, because the load factor depends on them.

    Parameters
    ----------
    procedure
        Procedure for non-associative sliding. ``"loading path"`` follows slightly elastic joints from the state under
        dead load to collapse. ``"fictitious"`` is the iteration of Portioli, Casapulla & Cascini (2015). ``"shifted"``
        is the objective of De Saxcé & Feng (1998), always feasible and often too high.
    crushing
        Form of crushing of rectangles. ``"conic"`` is exact, by rotated cones. ``"linearised"`` uses four tangents as
        in the paper. The tangents converge in the same loop as friction.
    crushing_interaction
        ``"biaxial"`` limits bending about both axes together by the effective rectangle. It is the default with
        ``crushing="conic"``. ``"uniaxial"`` limits bending about each axis separately, as in the paper. It is the
        default with ``crushing="linearised"``.
    crushing_cells
        Approximate number of cells of an interface that crushes and is not a rectangle. A rocking block turns about
        the middle of the outer row of cells. With 64 cells this reduces its lever by up to 7 %, mostly by 3 to 5 %. In
        a pushover and in a large settlement all interfaces that crush have cells, which bear the stress block exactly.
    shear_stiffness_ratio
        Shear over normal stiffness of joints without a shear stiffness, on the loading path. 0.4 is the ratio of an
        elastic layer with a Poisson ratio of 0.2.
    path_step, path_growth
        First step of the loading path, in multiples of the elastic displacement under the variable load. Largest ratio
        of one step to the step before.
    path_steps
        Solution of the steps of the loading path. ``"splitting"`` is approximate, with a hundred cheap iterations per
        step. ``"interior point"`` is exact when it succeeds, and ten times as slow. The collapse state at the end is
        exact with both.
    schedule : FictitiousSchedule
        Schedule of the fictitious conditions.
    numerics : Numerics
        Solver and tolerances.
    """

    procedure: str = "loading path"
    crushing: str = "conic"
    crushing_interaction: str = ""
    crushing_cells: int = 64
    shear_stiffness_ratio: float = 0.4
    path_step: float = 0.5
    path_growth: float = 2.0
    path_steps: str = "splitting"
    schedule: FictitiousSchedule = field(default_factory=FictitiousSchedule)
    numerics: Numerics = field(default_factory=Numerics)

    _LIMITS = MappingProxyType(
        {
            "crushing_cells": (1, 100_000),
            "shear_stiffness_ratio": (1e-3, 1e3),
            "path_step": (1e-3, 1e3),
            "path_growth": (1.0, 100.0),
        }
    )
    _CHOICES = MappingProxyType(
        {
            "procedure": ("loading path", "fictitious", "shifted"),
            "crushing": ("conic", "linearised"),
            "crushing_interaction": ("uniaxial", "biaxial"),
            "path_steps": ("splitting", "interior point"),
        }
    )

    def __post_init__(self) -> None:
        if self.crushing_interaction == "":
            object.__setattr__(self, "crushing_interaction", "biaxial" if self.crushing == "conic" else "uniaxial")
        self._check()
        for name, kind in (("schedule", FictitiousSchedule), ("numerics", Numerics)):
            if not isinstance(getattr(self, name), kind):
                msg = f"ProcedureSettings: {name} is {shown(getattr(self, name))}; give {kind.__name__}(…)"
                raise ModelError(msg)
        if self.crushing_interaction == "biaxial" and self.crushing != "conic":
            msg = (
                f"ProcedureSettings: crushing={self.crushing!r} has no biaxial interaction; give crushing='conic', or "
                "crushing_interaction='uniaxial'"
            )
            raise ModelError(msg)

    @property
    def flat(self) -> dict[str, Any]:
        """All settings by name.

        Names of the two parts have a prefix, as ``schedule_slope`` and ``numerics_solver``.
        """
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        parts = {name: asdict(own.pop(name)) for name in ("schedule", "numerics")}
        return own | {f"{part}_{name}": value for part, of_part in parts.items() for name, value in of_part.items()}


#: Variants of the loading path, because the load factor may depend on step length and joint stiffness.
PATH_VARIANTS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "loading path": {"procedure": "loading path"},
        "half steps": {"procedure": "loading path", "path_step": 0.25, "path_growth": 2**0.5},
        "shear ratio 0.2": {"procedure": "loading path", "shear_stiffness_ratio": 0.2},
        "shear ratio 1": {"procedure": "loading path", "shear_stiffness_ratio": 1.0},
    }
)
#: Schedules of the paper's procedure, and the shifted objective.
FICTITIOUS_VARIANTS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "fictitious": {"procedure": "fictitious"},
        "steep": {"procedure": "fictitious", "schedule": {"slope": 0.6}},
        "low c0": {"procedure": "fictitious", "schedule": {"c0": 0.001, "slope": 0.5}},
        "slow": {
            "procedure": "fictitious",
            "schedule": {"c0": 0.1, "c0_decay": 0.7, "slope_decay": 0.6, "patience": 24},
        },
        # Measured: a shifted objective that finds a certificate needs fewer than 30 programs.
        "shifted": {"procedure": "shifted", "schedule": {"max_programs": 40}},
    }
)
#: Settings that each schedule changes, by the name of the schedule.
SCHEDULES: Mapping[str, Mapping[str, Any]] = MappingProxyType({**PATH_VARIANTS, **FICTITIOUS_VARIANTS})
#: Schedules by the name of their group.
_GROUPS = {"path": tuple(PATH_VARIANTS), "paper": tuple(FICTITIOUS_VARIANTS)}


def scheduled(settings: ProcedureSettings, schedule: str) -> ProcedureSettings:
    """Return settings changed by a schedule.

    A schedule never increases the largest number of programs.
    """
    changes = dict(SCHEDULES[schedule])
    of_schedule = dict(changes.pop("schedule", {}))
    most = settings.schedule.max_programs
    of_schedule["max_programs"] = min(most, of_schedule.get("max_programs", most))
    return replace(settings, schedule=replace(settings.schedule, **of_schedule), **changes)


def schedules_of(spread: bool | str | Iterable[str]) -> tuple[str, ...]:
    """Return the names of the schedules of a spread.

    Parameters
    ----------
    spread
        True for the variants of the loading path, names of :data:`SCHEDULES`, or ``"paper"`` for all schedules of the
        paper's procedure.

    Raises
    ------
    ModelError
        If a name is unknown.
    """
    if isinstance(spread, bool):
        return tuple(PATH_VARIANTS) if spread else ()
    names = checked_tuple((spread,) if isinstance(spread, str) else spread, str, "spread")
    names = tuple(each for name in names for each in _GROUPS.get(name, (name,)))
    unknown = [name for name in names if name not in SCHEDULES]
    if unknown:
        known = ", ".join((*_GROUPS, *SCHEDULES))
        msg = f"spread: unknown schedule {', '.join(map(repr, unknown))}; known are {known}, or True"
        raise ModelError(msg)
    return tuple(dict.fromkeys(names))
