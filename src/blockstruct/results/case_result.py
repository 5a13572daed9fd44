"""The result of one limit case."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.limit import CERTIFICATE_MEASURES, Certificate, Outcome, ProcedureSettings, are_admissible
from blockstruct.model import Case, Model, Pushover, SelfWeight, SettlementCase
from blockstruct.motion import CurveOutcome
from blockstruct.notebook import html_table
from blockstruct.results.admissible_state import AdmissibleState
from blockstruct.results.crushing_words import beyond_rectangle_words, cell_words
from blockstruct.results.description import describe, failures
from blockstruct.results.headline import Headline
from blockstruct.results.macro_blocks import MacroBlock, macro_blocks
from blockstruct.results.mechanism import mechanism
from blockstruct.results.pushed import pushed_masses
from blockstruct.results.pushed_ties import broken_ties
from blockstruct.results.resultants import interface_resultants
from blockstruct.results.states import active_joints, contact_state
from blockstruct.results.ties import ties_at_collapse
from blockstruct.results.torsion import torsion_words
from blockstruct.results.utilisation import utilisation
from blockstruct.text import Answer, caveats, curve_end, ended, why
from blockstruct.vocabulary import Flow, Stage, Status

#: Stages that do not ask the question of the case.
_OF_OTHER_PROGRAMS = [Stage.DEAD_LOAD.value, Stage.DEAD_LOAD_COLLAPSE.value, Stage.LARGEST_REACTION.value]
#: Statuses whose last iteration shows how the structure falls under its dead load.
_FALLS = (Status.UNSTABLE, Status.SELF_STRESS)


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
    model : Model
        The structure the case is of.
    case : LimitCase or SettlementCase
    settings : ProcedureSettings
    outcome : Outcome
        How the case ended: status, load factor, how it was found, whether it settled, its peak and its range.
    certificate : Certificate or None
        Of the last iteration. If the status is unstable under dead load, it is the proof of that: of the state in
        which the joints carry the largest share of the dead load; if it depends on self-stress, of the collapse state
        of the dead load. None if unbounded, or without iterations.
    history : xarray.Dataset
        Every iteration; of a file, it is read when it is first looked at.
    started_at : str
        UTC, ISO 8601.
    duration : float
        Seconds.
    schedule, of_case : str
        The schedule of a run of a spread, and the case that it varies; empty for any other case.
    path_dependence : tuple of float or None
        Lowest and highest load factor of the variants of the loading path, by step length and joint stiffness; None
        if they were not run (``spread=True``).
    damage : str
        What could not be read of a run that was killed; empty as a rule.
    curve_outcome : CurveOutcome or None
        How and where the curve of a pushover ended, or why there is none; None if it has not ended.
    capacity : xarray.Dataset or None
        Of a :class:`~blockstruct.Pushover`, the states beyond the collapse state, which is the last of the history:
        :func:`blockstruct.results.capacity_of`. None for any other case, and without a collapse state.
    versions : tuple of mapping
        Version of every package that made its numbers, as :attr:`Analysis.versions`: several where others have gone on
        with what the first had begun, in their order; empty without numbers.
    """

    model: Model = field(repr=False)
    case: Case
    settings: ProcedureSettings
    outcome: Outcome
    certificate: Certificate | None
    history: xr.Dataset = field(repr=False)
    started_at: str
    duration: float
    schedule: str = ""
    of_case: str = ""
    path_dependence: tuple[float, float] | None = None
    damage: str = ""
    curve_outcome: CurveOutcome | None = None
    capacity: xr.Dataset | None = field(default=None, repr=False)
    versions: tuple[Mapping[str, str], ...] = field(default=(), repr=False)
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
    def status(self) -> Status:
        """How the case ended."""
        return self.outcome.status

    @property
    def load_factor(self) -> float:
        """Load factor at collapse; infinite if unbounded, NaN without a result.

        Of a settlement it is minus the reaction as a share of the dead load, so that it grows as the support gives
        way; read :attr:`reaction`.
        """
        return self.outcome.load_factor

    @property
    def settled(self) -> bool:
        """Whether the load factor had settled when the procedure ended.

        Where it had not, the state is certified all the same, but another procedure would end at another one.
        """
        return self.outcome.settled

    @property
    def drifts(self) -> bool:
        """Whether the case has a certified load factor that had not settled."""
        return self.status is Status.CONVERGED and not self.settled

    @property
    def hung(self) -> tuple[str, ...]:
        """Blocks that friction holds under the dead load in some states of self-stress only."""
        return self._free_blocks(self.outcome.hung)

    @property
    def jammed(self) -> tuple[str, ...]:
        """Blocks whose share of the variable load depends on self-stress."""
        return self._free_blocks(self.outcome.jammed)

    def _free_blocks(self, indices: tuple[int, ...]) -> tuple[str, ...]:
        names = [block.name for block in self.model.blocks if not block.fixed] if indices else []
        return tuple(names[i] for i in indices)

    @property
    def ended(self) -> str:
        """How the case ended in a few words: its status, and whether a non-associative load factor settled."""
        return ended(self.outcome, has_procedure=self.case.flow is Flow.NONASSOCIATIVE)

    @property
    def message(self) -> str:
        """Why the case ended with its status, without a full stop."""
        text = why(self.outcome, self.answer, self.hung)
        if self.status in _FALLS and self.n_iterations:
            text += failures(self.history)
        return f"{text}; {self.damage}" if self.damage else text

    @property
    def mechanism(self) -> xr.Dataset:
        """Collapse mechanism of the last iteration: :func:`blockstruct.results.mechanism`."""
        return mechanism(self.history)

    @property
    def macro_blocks(self) -> list[MacroBlock]:
        """Bodies of the mechanism of the last iteration: :func:`blockstruct.results.macro_blocks`."""
        return macro_blocks(self.model, self.mechanism, dead=self.case.dead)

    @property
    def resultants(self) -> xr.Dataset:
        """Interface resultants of every iteration: :func:`blockstruct.results.interface_resultants`."""
        return interface_resultants(self.history)

    @property
    def states(self) -> xr.DataArray:
        """Interface states of every iteration: :func:`blockstruct.results.contact_state`."""
        return contact_state(self.history)

    @property
    def utilisation(self) -> xr.Dataset:
        """Utilisation and neutral-axis depth of every iteration: :func:`blockstruct.results.utilisation`."""
        return utilisation(self.history)

    @property
    def active_joints(self) -> pd.DataFrame:
        """Joints that move in the last iteration: :func:`blockstruct.results.active_joints`."""
        return active_joints(self.history)

    @property
    def answer(self) -> Answer:
        """What the number of the case is called and how it is written: a load factor, or a reaction."""
        return Answer.of(self.model, self.case)

    @property
    def reaction(self) -> Any:
        """Reaction of a settlement when the structure begins to follow, a force or a moment; NaN without an answer.

        Raises
        ------
        ModelError
            If the case is not a settlement.
        """
        return self._reactions(self.load_factor)

    @property
    def reaction_range(self) -> Any:
        """Least and largest reaction of a settlement that statics allows under the dead load, two quantities in one.

        Any reaction between them is one of forces in equilibrium inside the strength of the joints: by two programs
        with associative flow, whatever that of the case, so that the reaction itself is not below the least. Infinite
        where friction may jam the structure by any force, NaN where a program found no proof. A horizontal direction
        gives the range of the thrust.

        Raises
        ------
        ModelError
            If the case is not a settlement.
        """
        h, stages = self.history, self.history["stage"].to_numpy()
        largest = np.flatnonzero(stages == Stage.LARGEST_REACTION.value)
        alpha = float(h["load_factor"].to_numpy()[largest[0]]) if len(largest) else np.nan
        if len(largest) and np.isfinite(alpha) and not self._certificate_at(int(largest[0])).holds:
            alpha = np.nan
        return self._reactions([self.associative_load_factor, alpha])

    def _reactions(self, alpha: Any) -> Any:
        if not isinstance(self.case, SettlementCase):
            msg = f"case {self.name!r}: has a load factor and no reaction; give a SettlementCase to find one"
            raise ModelError(msg)
        return self.answer.quantity(alpha)

    @property
    def ties(self) -> pd.DataFrame:
        """Force, state and elongation of each tie: :func:`blockstruct.results.ties_at_collapse`; empty without ties."""
        return ties_at_collapse(self.history) if "tie" in self.history.sizes and self.n_iterations else pd.DataFrame()

    @property
    def broken_ties(self) -> pd.DataFrame:
        """Ties that break in a pushover: :func:`blockstruct.results.broken_ties`; empty without any."""
        return broken_ties(xr.Dataset() if self.capacity is None else self.capacity)

    @property
    def curve_ended(self) -> str:
        """How the curve of a pushover ended, or why there is none, as a clause; empty if it has not ended."""
        if self.curve_outcome is None or not isinstance(self.case, Pushover):
            return ""
        return curve_end(self.curve_outcome, self.case.control)

    @property
    def missing_curve(self) -> str:
        """Why a pushover with a collapse state has no capacity curve; empty if it has one, and of any other case."""
        return self.curve_ended if self.capacity is None else ""

    @property
    def headline(self) -> Headline:
        """The load factor with its range and the associative bound."""
        return Headline(
            self.outcome, self.case.flow, self.associative_load_factor, self.path_dependence, self.answer, self.hung
        )

    @property
    def associative_load_factor(self) -> float:
        """Load factor of the associative program: an upper bound of every flow rule, infinite if it is unbounded.

        NaN where the case ended before that program was solved.
        """
        found = np.flatnonzero(self.history["stage"].to_numpy() == Stage.ASSOCIATIVE.value)
        return float(self.history["load_factor"].to_numpy()[found[-1]]) if len(found) else np.nan

    @property
    def warnings(self) -> tuple[str, ...]:
        """What must be known before the number is used, as sentences; empty as a rule."""
        if self.case.flow is not Flow.NONASSOCIATIVE:
            return ()
        bound, is_searched = self.associative_load_factor, False
        if np.isposinf(bound):
            stages, alpha = (self.history[name].to_numpy() for name in ("stage", "load_factor"))
            is_searched = bool(np.isfinite(alpha[~np.isin(stages, _OF_OTHER_PROGRAMS)]).any())
        return caveats(self.outcome, self.answer, bound=bound, is_searched=is_searched, jammed=self.jammed)

    @property
    def torsion_warning(self) -> str:
        """What the number owes to torsion at the corners of joints, as a sentence; empty if it is little.

        :func:`blockstruct.results.corner_torsion` tells it joint by joint.
        """
        return torsion_words(self.model, self.history, self.answer.name) if self.status is Status.CONVERGED else ""

    @property
    def crushing_warning(self) -> str:
        """Which rectangular joints bear more than they can, bent about both axes, as sentences; empty if none do.

        With ``crushing_interaction="biaxial"`` none do. ``result.utilisation["crushing"]`` tells it joint by joint.
        """
        if self.status is not Status.CONVERGED or self.settings.crushing_interaction == "biaxial":
            return ""
        return beyond_rectangle_words(self.history, is_reaction=self.answer.is_reaction)

    @property
    def owed(self) -> tuple[str, ...]:
        """What the number owes to torsion and to crushing: those of the two warnings above that say something."""
        return tuple(filter(None, (self.torsion_warning, self.crushing_warning)))

    @property
    def cells(self) -> str:
        """How many joints crush in cells and what that takes, as sentences; empty if none do."""
        return cell_words(self.history, is_reaction=self.answer.is_reaction) if self.n_iterations else ""

    @property
    def admissible_state(self) -> AdmissibleState | None:
        """Of the iterations inside the true conditions the one that misses the flow rule least, None without any.

        It is what a case that has not converged leaves behind.
        """
        h = self.history
        within = self._admissible & np.isfinite(h["flow_rule_gap"].to_numpy())
        within &= (h["load_factor"].to_numpy() >= 0) | isinstance(self.case, SettlementCase)
        within &= ~np.isin(h["stage"].to_numpy(), _OF_OTHER_PROGRAMS) & np.isfinite(h["load_factor"].to_numpy())
        if not within.any():
            return None
        i = int(np.argmin(np.where(within, h["flow_rule_gap"].to_numpy(), np.inf)))
        return AdmissibleState(i, float(h["load_factor"][i]), self._certificate_at(i))

    def _certificate_at(self, iteration: int) -> Certificate:
        """Certificate of an iteration of the history."""
        measures = {name: float(self.history[name][iteration]) for name in CERTIFICATE_MEASURES if name != "holds"}
        gap, limit = measures["flow_rule_gap"], measures["flow_rule_gap_limit"]
        holds = measures["interpenetration"] <= self.settings.numerics.interpenetration_tolerance and gap <= limit
        return Certificate(**measures, holds=bool(holds and self._admissible[iteration]), settings=self.settings)

    @property
    def admissible_load_factor(self) -> float:
        """Load factor of :attr:`admissible_state`; NaN without one."""
        state = self.admissible_state
        return np.nan if state is None else state.load_factor

    @property
    def last_feasible(self) -> int | None:
        """Last iteration whose forces are in equilibrium inside the true conditions, whatever its mechanism.

        None if there is none. Where a case has not converged, its last iteration may well be another one.
        """
        found = np.flatnonzero(self._admissible)
        return int(found[-1]) if len(found) else None

    @property
    def _admissible(self) -> NDArray[np.bool_]:
        residual, excess = (self.history[name].to_numpy() for name in ("equilibrium_residual", "yield_excess"))
        return are_admissible(residual, excess, self.settings)

    def changed(self, **changes: Any) -> Self:
        """The same result with other fields; a history that is not read yet stays so."""
        return replace(self, **{"history": self._unread or self.history, **changes})

    @classmethod
    def restored(
        cls,
        *,
        case: Case,
        settings: Mapping[str, Any],
        certificate: Mapping[str, float],
        **rest: Any,
    ) -> Self:
        """Result of plain values, as a file keeps them."""
        measures = {name: float(value) for name, value in certificate.items() if name != "holds"}
        if not isinstance(settings, Mapping):
            msg = f"case {case.name!r}: settings {settings!r} are not names and values"
            raise ModelError(msg)
        given = ProcedureSettings.of(settings)
        holds = bool(certificate.get("holds"))
        return cls(
            case=case,
            settings=given,
            certificate=Certificate(**measures, holds=holds, settings=given) if certificate else None,
            **rest,
        )

    @property
    def masses(self) -> str:
        """Which weights a push takes along, and loads on supports of a settlement, in words; empty for own weight."""
        plain = all(isinstance(load, SelfWeight) for load in self.case.dead.loads)
        return "" if plain else pushed_masses(self.model, self.case)

    def describe(self) -> str:
        """How the structure collapses, in sentences: number, bodies that move, failing joints, and ties."""
        moves = self.n_iterations > 0 and np.isfinite(self.history["block_velocity"].isel(iteration=-1)).all()
        found = describe(self.model, self.history, self.case.dead, self.status) if moves else ""
        return "\n".join(filter(None, (str(self), *self.owed, self.cells, self.masses, found)))

    def __repr__(self) -> str:
        answer = f"{self.answer.name} {self.answer.text(self.load_factor, 4)}"
        return f"<CaseResult {self.name!r}: {self.ended}, {answer}>"

    def _repr_html_(self) -> str:
        rows = [
            ("result", self.headline.text(6)),
            ("loads", self.case.question),
            ("numerical iterations", self.n_iterations),
        ]
        table = html_table(self.name, ["", ""], rows, (*self.warnings, *self.owed))
        return table + (self.certificate._repr_html_() if self.certificate else "")

    def __str__(self) -> str:
        text = self.headline.text()
        if self.status in _FALLS and self.n_iterations:
            text += failures(self.history)
        return "\n".join([f"{self.name}: {text}", *(f"  warning: {text}" for text in self.warnings)])
