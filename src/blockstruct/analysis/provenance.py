"""Origin of the numbers of an analysis: time, versions and options."""

import platform
import warnings
from collections.abc import Iterable
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from typing import Any

from blockstruct.errors import VersionWarning
from blockstruct.limit import Numerics, ProcedureSettings
from blockstruct.results import Analysis
from blockstruct.solvers import solver_of

_PACKAGES = (
    "blockstruct",
    "clarabel",
    "cvxpy",
    "h5netcdf",
    "h5py",
    "numpy",
    "pint",
    "scipy",
    "shapely",
    "xarray",
)
#: Options of Clarabel that every solve takes from the settings, so their defaults are never used.
_TOLERANCES = {"tol_gap_abs", "tol_gap_rel", "tol_feas"}


def now() -> str:
    """Return the time, UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def versions() -> dict[str, str]:
    """Return the versions of all numerical packages, Python and the platform."""
    return {**_installed(), "python": platform.python_version(), "platform": platform.platform()}


@cache
def _installed() -> dict[str, str]:
    """Return the versions, read once: reading takes as long as a small case."""
    return {package: version(package) for package in _PACKAGES}


def solver_options(settings: Iterable[ProcedureSettings]) -> dict[str, dict[str, Any]]:
    """Return the options of each solver, apart from the tolerances.

    The settings contain the tolerances.
    """
    return {
        name: _options(solver_of(ProcedureSettings(numerics=Numerics(solver=name))))
        for name in sorted({s.numerics.solver for s in settings})
    }


def _options(solver: Any) -> dict[str, Any]:
    settings = getattr(solver, "settings", None)
    names = [name for name in dir(settings) if not name.startswith("_") and name not in _TOLERANCES]
    plain = {name: getattr(settings, name) for name in names}
    return {name: value for name, value in plain.items() if isinstance(value, bool | int | float | str)}


def warn_of_versions(analysis: Analysis) -> None:
    """Warn of cases whose kept numbers come from other versions."""
    present, cases = versions(), dict[str, list[str]]()
    for name, result in analysis.items():
        for made_by in result.versions:
            differ = [
                f"{package} {of_numbers} (now {present.get(package, 'not installed')})"
                for package, of_numbers in made_by.items()
                if of_numbers != present.get(package)
            ]
            if differ:
                cases.setdefault(", ".join(differ), []).append(repr(name))
    for made_with, names in cases.items():
        text = f"case {', '.join(names)}: made by {made_with}, and kept; the versions of each case tell what made it"
        warnings.warn(text, VersionWarning, stacklevel=3)
