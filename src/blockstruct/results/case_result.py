"""The result of one limit case."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Self

import numpy as np
import xarray as xr

from blockstruct.errors import ModelError
from blockstruct.limit import Certificate, ProcedureSettings
from blockstruct.model import LimitCase
from blockstruct.results.mechanism import mechanism
from blockstruct.results.resultants import interface_resultants
from blockstruct.results.states import contact_state
from blockstruct.results.utilisation import utilisation
from blockstruct.vocabulary import Status

#: Names of the measures of a certificate, as stored.
CERTIFICATE_MEASURES = tuple(f.name for f in fields(Certificate))


@dataclass(frozen=True, slots=True)
class LazyHistory:
    """A history that is read when it is first looked at.

    Attributes
    ----------
    n_iterations : int
    read : callable
        Gives the history.
    """

    n_iterations: int
    read: Callable[[], xr.Dataset]


@dataclass(frozen=True, slots=True, eq=False)
class CaseResult:
    """Load factor of a case, how it was found and why to believe it.

    Attributes
    ----------
    case : LimitCase
    settings : ProcedureSettings
    status : Status
    load_factor : float
        Load factor at collapse if the status is converged; infinite if unbounded; NaN otherwise.
    certificate : Certificate or None
        Of the last iteration. If the status is unstable under dead load, it is the proof of that: of the state in
        which the joints carry the largest share of the dead load. None if unbounded, or without iterations.
    message : str
        Why the case ended as it did.
    history : xarray.Dataset
        Every iteration; of a file, it is read when it is first looked at.
    started_at : str
        UTC, ISO 8601.
    duration : float
        Seconds.
    """

    case: LimitCase
    settings: ProcedureSettings
    status: Status
    load_factor: float
    certificate: Certificate | None
    message: str
    history: xr.Dataset = field(repr=False)
    started_at: str
    duration: float
    _unread: LazyHistory | None = field(init=False, default=None, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.history, LazyHistory):
            object.__setattr__(self, "_unread", self.history)
            object.__delattr__(self, "history")

    def __getattr__(self, name: str) -> Any:
        # Python asks here for what an instance does not have, which can only be a history that is not read yet.
        if name != "history" or self._unread is None:
            msg = f"{type(self).__name__!r} object has no attribute {name!r}"
            raise AttributeError(msg)
        object.__setattr__(self, "history", self._unread.read())
        object.__setattr__(self, "_unread", None)
        return self.history

    @property
    def name(self) -> str:
        """Name of the case."""
        return self.case.name

    @property
    def n_iterations(self) -> int:
        """Number of iterations in the history."""
        return self._unread.n_iterations if self._unread else int(self.history.sizes["iteration"])

    @property
    def mechanism(self) -> xr.Dataset:
        """Collapse mechanism of the last iteration: :func:`blockstruct.mechanism`."""
        return mechanism(self.history)

    @property
    def resultants(self) -> xr.Dataset:
        """Interface resultants of every iteration: :func:`blockstruct.interface_resultants`."""
        return interface_resultants(self.history)

    @property
    def states(self) -> xr.DataArray:
        """Interface states of every iteration: :func:`blockstruct.contact_state`."""
        return contact_state(self.history)

    @property
    def utilisation(self) -> xr.Dataset:
        """Utilisation and neutral-axis depth of every iteration: :func:`blockstruct.utilisation`."""
        return utilisation(self.history)

    @property
    def last_feasible(self) -> int | None:
        """Last iteration whose forces are in equilibrium inside the true conditions, whatever its mechanism.

        None if there is none. Where a case has not converged, its last iteration may well be another one.
        """
        residual, excess = (self.history[name].to_numpy() for name in ("equilibrium_residual", "yield_excess"))
        s = self.settings
        found = np.flatnonzero((residual <= s.equilibrium_tolerance) & (excess <= s.yield_tolerance))
        return int(found[-1]) if len(found) else None

    @classmethod
    def restored(
        cls,
        *,
        case: LimitCase,
        settings: Mapping[str, Any],
        status: str,
        certificate: Mapping[str, float],
        **rest: Any,
    ) -> Self:
        """Result of plain values, as a file keeps them."""
        measures = {name: float(value) for name, value in certificate.items() if name != "holds"}
        if not isinstance(settings, Mapping):
            msg = f"case {case.name!r}: settings {settings!r} are no names and values"
            raise ModelError(msg)
        return cls(
            case=case,
            settings=ProcedureSettings.of(settings),
            status=Status(status),
            certificate=Certificate(**measures, holds=bool(certificate["holds"])) if certificate else None,
            **rest,
        )

    def __str__(self) -> str:
        return f"{self.name}: {self.status}, load factor {self.load_factor:.6g} ({self.message})"
