"""The result of one case: its number, its sentences, and all that follows from its history."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, Self

import numpy as np
import pandas as pd
import xarray as xr

from blockstruct.arrays import Flags
from blockstruct.errors import ModelError, check_known
from blockstruct.limit import Certificate, LimitProblem, Outcome
from blockstruct.limit.certificate import CERTIFICATE_MEASURES, are_admissible
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import Case, LoadPattern, Model, SelfWeight, SettlementCase, has_curve
from blockstruct.motion.state import CurveOutcome
from blockstruct.notebook import html_table
from blockstruct.results import interfaces
from blockstruct.results.capacity import doubtful_parts, response_words
from blockstruct.results.mechanism import MacroBlock, body_table, macro_blocks, mechanism
from blockstruct.results.ties import broken_ties, tie_sentences, ties_at_collapse
from blockstruct.statics.statics import Statics
from blockstruct.text import case as case_text
from blockstruct.text import mechanism as mechanism_text
from blockstruct.text import note as note_text
from blockstruct.text.case import DoubtfulPart
from blockstruct.text.headline import Headline
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.text.numbers import Answer
from blockstruct.vocabulary import ContactState, Flow, Stage, Status, shortened

_FAILING = {
    ContactState.HINGE: "Hinges",
    ContactState.SLIDING: "Sliding joints",
    ContactState.TWISTING: "Twisting joints",
    ContactState.CRUSHING: "Crushing joints",
}


def describe(
    model: Model, history: xr.Dataset, dead: LoadPattern | None = None, status: Status = Status.CONVERGED
) -> str:
    """Return sentences on a mechanism: bodies, axes, joints, ties.

    Parameters
    ----------
    model, history
        The structure, and the history of a case with a mechanism.
    dead
        The dead load, whose weights count with the blocks that carry them. Without it, blocks carry no weights.
    status
        How the case ended. Without a collapse state the sentences describe the last iteration.
    """
    bodies = macro_blocks(model, mechanism(history), dead=dead)
    moving = [body for body in bodies if body.moves]
    weight, carried = (sum(getattr(body, name) for body in bodies) for name in ("total", "carried"))
    free, moved = (sum(len(body.blocks) for body in some) for some in (bodies, moving))
    parts = [
        (
            body.blocks,
            body.total / weight if weight > 0 else 0.0,
            mechanism_text.motion_clause(body.translation, body.axis, body.centroid, body.speed),
        )
        for body in moving
    ]
    lines = [mechanism_text.NO_COLLAPSE_STATE] if status in (Status.NOT_CONVERGED, Status.INTERRUPTED) else []
    share = sum(share for _, share, _ in parts)
    lines.append(mechanism_text.moving_sentence(moved, free, len(moving), share, carried=bool(carried)))
    lines += mechanism_text.body_sentences(parts)
    lines += [mechanism_text.joints_sentence(_FAILING[state], joints) for state, joints in main_joints(history).items()]
    if "tie" in history.sizes:
        lines += shortened(tie_sentences(history), mechanism_text.more_ties)
    on_path = (history["stage"] == Stage.LOADING_PATH.value).any()
    lines.append(mechanism_text.STEPS_OF_PATH if on_path else mechanism_text.STEPS_OF_PROGRAMS)
    return "\n".join(lines)


def failures(history: xr.Dataset) -> str:
    """Return the clause on the joints that dissipate most; empty without any.

    The last iteration counts.
    """
    states = interfaces.active_joints(history).head(3)["state"]
    return mechanism_text.failure_clause(zip(states.index.astype(str), states, strict=True))


def main_joints(history: xr.Dataset) -> dict[ContactState, list[str]]:
    """Return the joints that fail in each way in the last iteration, the most active first.

    Hinges are ranked by normal force times opening velocity, the others by dissipation. Joints below a share of the
    largest, :data:`blockstruct.text.mechanism.SMALL`, are left out.
    """
    last = history.isel(iteration=-1)
    state = interfaces.contact_state(last)
    force, v = (interfaces.at_points(last, name) for name in ("contact_force", "relative_velocity"))

    pressed, opens = (interfaces.sum_of_points(last, part) for part in (force[:, 0], np.maximum(v[:, 0], 0.0)))
    friction = interfaces.sum_of_points(last, -np.einsum("kc,kc->k", force[:, 1:], v[:, 1:]))
    measures = {
        ContactState.HINGE: pressed * opens,
        ContactState.SLIDING: friction,
        ContactState.TWISTING: friction,
        ContactState.CRUSHING: interfaces.sum_of_points(last, np.maximum(-force[:, 0] * v[:, 0], 0.0)),
    }
    joints = {}
    for part, measure in measures.items():
        ranked = np.where(state.str.contains(part.value).to_numpy(), measure, 0.0)
        largest = ranked.max(initial=0.0)
        if largest > 0:
            order = np.argsort(-ranked, kind="stable")
            joints[part] = [
                str(state["interface"].to_numpy()[k]) for k in order if ranked[k] > mechanism_text.SMALL * largest
            ]
    return joints


#: Stages whose load factor is not a load factor of the case.
_OF_OTHER_PROGRAMS = [Stage.DEAD_LOAD.value, Stage.DEAD_LOAD_COLLAPSE.value, Stage.LARGEST_REACTION.value]
#: Figures of a result.
_KINDS = ("mechanism", "structure", "forces", "loads", "convergence", "certificate", "capacity", "response")


@dataclass(frozen=True, slots=True)
class AdmissibleState:
    """Forces in equilibrium within the strength of joints, at a load factor.

    With associative flow the load factor is a lower bound of the collapse load (static theorem). Without dilatancy the
    theorem does not hold: joints may slide at a lower load factor, so it is not a safe bound.

    Attributes
    ----------
    iteration : int
        Position in the history.
    load_factor : float
    certificate : Certificate
        Equilibrium residual and yield excess are within the tolerances. The flow-rule gap separates the state from a
        collapse state.
    """

    iteration: int
    load_factor: float
    certificate: Certificate


@dataclass(frozen=True, slots=True)
class LazyHistory:
    """A history that is read at its first use.

    Attributes
    ----------
    n_iterations : int
    read : callable
        Returns the history.
    """

    n_iterations: int
    read: Callable[[], xr.Dataset]


@dataclass(frozen=True, slots=True, eq=False)
class CaseResult:
    """Load factor of a case, with its history and its certificate.

    Attributes
    ----------
    model : Model
    case : LimitCase, SettlementCase or RecordCase
    settings : ProcedureSettings
    outcome : Outcome
        How the case ended: status, load factor, procedure, whether it settled, its peak and its range.
    certificate : Certificate or None
        Certificate of the last iteration. If the status is unstable under dead load, it proves the state in which the
        joints carry the largest share of the dead load. If the status depends on self-stress, it proves a collapse
        state of the dead load. None if unbounded, without iterations, or if the last program has no solution.
    history : xarray.Dataset
        Every iteration. The history of a file is read at its first use.
    started_at : str
        UTC, ISO 8601.
    duration : float
        Seconds.
    schedule, of_case : str
        In a spread: the schedule of this run, and the case that it varies. Otherwise empty.
    path_dependence : tuple of float or None
        Lowest and highest load factor of the variants of the loading path, by step length and joint stiffness; None
        if they were not run (``spread=True``).
    damage : str
        The part of a killed run that could not be read; usually empty.
    curve_outcome : CurveOutcome or None
        How and where the curve ended, or why it is missing; None if it has not ended.
    capacity : xarray.Dataset or None
        States of a :class:`~blockstruct.Pushover`, or of a :class:`~blockstruct.SettlementCase` with a displacement,
        beyond the collapse state, which is the last state of the history: :func:`blockstruct.results.capacity_of`. None
        for any other case, and without a collapse state.
    response : xarray.Dataset or None
        Motion of the blocks of a :class:`~blockstruct.RecordCase`: :func:`blockstruct.results.response_of`. None for
        any other case, and if the structure does not stand under its dead load.
    versions : tuple of mapping
        Version of every package, as in :attr:`Analysis.versions`. A resumed run has one entry per part, in order; empty
        without numbers.
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
    response: xr.Dataset | None = field(default=None, repr=False)
    versions: tuple[Mapping[str, str], ...] = field(default=(), repr=False)
    _unread: LazyHistory | None = field(init=False, default=None, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.history, LazyHistory):
            object.__setattr__(self, "_unread", self.history)
            object.__delattr__(self, "history")

    def __getattr__(self, name: str) -> Any:
        # Python calls this for missing attributes only. Only a history that is still unread may be missing.
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

        For a settlement it is minus the reaction as a share of the dead load: it grows as the support moves. Use
        :attr:`reaction` instead.
        """
        return self.outcome.load_factor

    @property
    def collapse_time(self) -> float:
        """Time of a record at which a block has fallen, s; NaN if the structure stands, and for any other case."""
        return self.outcome.collapse_time

    def number(self, digits: int = 4) -> tuple[str, str]:
        """Return name and text of the number: load factor, reaction, largest displacement or time of collapse."""
        if self.response is None:
            return self.answer.name, self.answer.text(self.load_factor, digits)
        return case_text.response_number(self.peak_displacement, self.collapse_time)

    @property
    def peak_displacement(self) -> float:
        """Largest displacement of a block relative to the ground under a record, m; NaN for any other case."""
        return np.nan if self.response is None else float(self.response["peak_displacement"].isel(time=-1).max())

    @property
    def settled(self) -> bool:
        """Whether the load factor had settled when the procedure ended.

        An unsettled state is certified, too, but another procedure would end at another load factor.
        """
        return self.outcome.settled

    @property
    def drifts(self) -> bool:
        """Whether the load factor is certified but has not settled."""
        return self.status is Status.CONVERGED and not self.settled

    @property
    def hung(self) -> tuple[str, ...]:
        """Blocks that friction holds only in some states of self-stress.

        The dead load acts alone.
        """
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
        """Status of the case, and whether its load factor settled, in words."""
        return Headline(self.outcome, self.case.flow).ended

    @property
    def message(self) -> str:
        """Why the case ended with its status, without a full stop."""
        text = Headline(self.outcome, self.case.flow, answer=self.answer, hung=self.hung).why
        if self.status.is_of_dead_load and self.n_iterations:
            text += failures(self.history)
        return f"{text}; {self.damage}" if self.damage else text

    @property
    def mechanism(self) -> xr.Dataset:
        """Collapse mechanism: :func:`blockstruct.results.mechanism`.

        Raises
        ------
        ModelError
            If the result has no iterations.
        """
        if not self.n_iterations:
            msg = f"case {self.name!r}: no mechanism, {self.headline}; a mechanism needs an iteration"
            raise ModelError(msg)
        return mechanism(self.history)

    @property
    def macro_blocks(self) -> list[MacroBlock]:
        """Bodies of the mechanism: :func:`blockstruct.results.macro_blocks`."""
        return macro_blocks(self.model, self.mechanism, dead=self.case.dead)

    @property
    def bodies(self) -> pd.DataFrame:
        """Moving bodies as a table of vectors: :func:`blockstruct.results.body_table`."""
        return body_table([body for body in self.macro_blocks if body.moves])

    @property
    def resultants(self) -> xr.Dataset:
        """Resultants: :func:`blockstruct.results.interface_resultants`."""
        return interfaces.interface_resultants(self.history)

    @property
    def support_reactions(self) -> xr.Dataset:
        """Reactions of the supports: :func:`blockstruct.results.support_reactions`."""
        return interfaces.support_reactions(self.model, self.case, self.history)

    @property
    def states(self) -> xr.DataArray:
        """Interface states: :func:`blockstruct.results.contact_state`."""
        return interfaces.contact_state(self.history)

    @property
    def utilisation(self) -> xr.Dataset:
        """Utilisation of joints: :func:`blockstruct.results.utilisation`."""
        return interfaces.utilisation(self.history)

    @property
    def active_joints(self) -> pd.DataFrame:
        """Joints that move at last: :func:`blockstruct.results.active_joints`."""
        return interfaces.active_joints(self.history)

    @property
    def answer(self) -> Answer:
        """Name, symbol and unit of the answer: a load factor or a reaction."""
        return Answer.of(self.model, self.case)

    @property
    def reaction(self) -> Any:
        """Reaction when the structure begins to follow its supports.

        It is a force or a moment; NaN without a result.

        Raises
        ------
        ModelError
            If the case is not a settlement.
        """
        return self._reactions(self.load_factor)

    @property
    def reaction_range(self) -> Any:
        """Least and largest reaction that statics allows under the dead load.

        Every reaction in between belongs to forces in equilibrium within the strength of the joints. Two programs with
        associative flow find both ends, whatever the flow of the case, so the reaction is not below the least. An end
        is infinite if friction may jam the structure with any force, and NaN if a program found no proof. A horizontal
        direction gives the range of the thrust.

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
        """Ties at the end: :func:`blockstruct.results.ties_at_collapse`."""
        return ties_at_collapse(self.history) if "tie" in self.history.sizes and self.n_iterations else pd.DataFrame()

    @property
    def broken_ties(self) -> pd.DataFrame:
        """Ties that break in a pushover or under a record: :func:`blockstruct.results.broken_ties`."""
        motions = (motion for motion in (self.capacity, self.response) if motion is not None)
        return broken_ties(next(motions, xr.Dataset()))

    @property
    def curve_doubts(self) -> list[DoubtfulPart]:
        """Doubts on the capacity curve: :func:`blockstruct.results.doubtful_parts`; none without a curve."""
        if self.capacity is None:
            return []
        return doubtful_parts(self.capacity, self.settings.procedure, self.load_factor)

    @property
    def curve_ended(self) -> str:
        """How the curve ended, or why it is missing, as a clause; empty if it has not ended."""
        if self.curve_outcome is None or not has_curve(self.case):
            return ""
        return case_text.curve_end(self.curve_outcome, self.case)

    @property
    def missing_curve(self) -> str:
        """Why a pushover or settlement with a collapse state has no curve; empty with a curve and for other cases."""
        return self.curve_ended if self.capacity is None else ""

    @property
    def headline(self) -> Headline:
        """The load factor with its range and the associative bound."""
        return Headline(
            self.outcome, self.case.flow, self.associative_load_factor, self.path_dependence, self.answer, self.hung
        )

    @property
    def associative_load_factor(self) -> float:
        """Associative load factor, an upper bound of every flow rule.

        It is infinite if unbounded, and NaN if the case ended before that program was solved.
        """
        iterations = np.flatnonzero(self.history["stage"].to_numpy() == Stage.ASSOCIATIVE.value)
        return float(self.history["load_factor"].to_numpy()[iterations[-1]]) if len(iterations) else np.nan

    @property
    def notes(self) -> tuple[Note, ...]:
        """Facts about the number: warnings, cautions, then explanations."""
        masses = Note(NoteCode.MASSES, Severity.INFO, self.masses) if self.masses else None
        return (*self._caveats, *self._cautions, *filter(None, (self._cells, masses)))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences to read before using the number; usually empty."""
        return tuple(map(str, self._caveats))

    @property
    def owed(self) -> tuple[str, ...]:
        """Sentences on the effect of torsion and crushing; usually empty."""
        return tuple(map(str, self._cautions))

    @property
    def cells(self) -> str:
        """Sentences on joints that crush in cells; empty without any."""
        return str(self._cells or "")

    @property
    def wanted_effects(self) -> tuple[str, ...]:
        """Names of the outcome's facts that the notes ask for: load factors without the cause of a note.

        They are ``uniform_torsion``, ``lowered_friction``, ``biaxial_crushing`` and ``other_procedure``.
        """
        codes = [note.code for note in (*self._cautions, *self._caveats)]
        return tuple(dict.fromkeys(note_text.EFFECTS[code] for code in codes if code in note_text.EFFECTS))

    @property
    def _cells(self) -> Note | None:
        if not self.n_iterations:
            return None
        return interfaces.crushing_in_cells(self.history, is_reaction=self.answer.is_reaction)

    @property
    def _caveats(self) -> tuple[Note, ...]:
        if self.case.flow is not Flow.NONASSOCIATIVE:
            return ()
        bound, is_searched = self.associative_load_factor, False
        if np.isposinf(bound):
            stages, alpha = (self.history[name].to_numpy() for name in ("stage", "load_factor"))
            is_searched = bool(np.isfinite(alpha[~np.isin(stages, _OF_OTHER_PROGRAMS)]).any())
        return note_text.caveats(self.outcome, self.answer, bound=bound, is_searched=is_searched, jammed=self.jammed)

    @property
    def _cautions(self) -> list[Note]:
        if self.status is not Status.CONVERGED:
            return []
        changed = {code: getattr(self.outcome, note_text.EFFECTS[code]) for code in note_text.REMEDIES}
        known = {code: number for code, number in changed.items() if not np.isnan(number)}
        is_estimate, answer = self.outcome.estimated, self.answer
        notes = [
            note_text.effect_note(code, self.load_factor, number, answer, is_estimate=is_estimate)
            for code, number in known.items()
        ]
        if NoteCode.ELLIPSOID_TORSION not in known:
            # In narrow joints the first remedy leaves much of the excess.
            limited = NoteCode.CORNER_TORSION in known
            notes += interfaces.torsion_notes(self.model, self.history, answer.name, limited=limited)
        if NoteCode.BIAXIAL_CRUSHING not in known and self.settings.crushing_interaction != "biaxial":
            notes.append(interfaces.biaxial_crushing(self.history, is_reaction=answer.is_reaction))
        return [note for note in notes if note is not None]

    def final_problem(self, statics: Statics) -> LimitProblem:
        """Return the limit problem of the last iteration: without crushing, if crushing raised the load factor."""
        problem = LimitProblem.of(statics, self.case)
        is_raised = self.outcome.without_crushing == float(self.history["load_factor"][-1])
        return problem.without_crushing if is_raised else problem

    @property
    def admissible_state(self) -> AdmissibleState | None:
        """Admissible iteration with the smallest flow-rule gap; None without one.

        It is the best result of a case that has not converged.
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
        """Return the certificate of an iteration of the history."""
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
    def _admissible(self) -> Flags:
        residual, excess = (self.history[name].to_numpy() for name in ("equilibrium_residual", "yield_excess"))
        return are_admissible(residual, excess, self.settings)

    def changed(self, **changes: Any) -> Self:
        """Return the result with other fields; an unread history stays unread."""
        return replace(self, **{"history": self._unread or self.history, **changes})

    @classmethod
    def restored(
        cls, *, case: Case, settings: Mapping[str, Any], certificate: Mapping[str, float], **rest: Any
    ) -> Self:
        """Return the result of plain values from a file."""
        measures = {name: float(value) for name, value in certificate.items() if name != "holds"}
        if not isinstance(settings, Mapping):
            msg = f"case {case.name!r}: settings {settings!r} are not names and values"
            raise ModelError(msg)
        all_settings = ProcedureSettings.of(settings)
        proof = (
            Certificate(**measures, holds=bool(certificate.get("holds")), settings=all_settings)
            if certificate
            else None
        )
        # Files of earlier versions have certificates of programs without a solution, which never hold.
        valid = proof if proof and (proof.holds or proof.is_of_a_state) else None
        return cls(case=case, settings=all_settings, certificate=valid, **rest)

    @property
    def masses(self) -> str:
        """Sentences on the masses that a push or a record moves; empty for self-weight alone."""
        plain = all(isinstance(load, SelfWeight) for load in self.case.dead.loads)
        return "" if plain else case_text.pushed_masses(self.model, self.case)

    @property
    def moves(self) -> bool:
        """Whether the last iteration has a mechanism."""
        return self.n_iterations > 0 and bool(np.isfinite(self.history["block_velocity"].isel(iteration=-1)).all())

    def plot(self, kind: str = "", **options: Any) -> Any:
        """Draw the result and return the Axes.

        Parameters
        ----------
        kind
            A figure of :mod:`blockstruct.views.figures` that takes a result: ``"mechanism"``, ``"structure"``,
            ``"forces"``, ``"loads"``, ``"convergence"``, ``"certificate"``, ``"capacity"`` or ``"response"``. By
            default the response to a record, otherwise the mechanism, or the structure if nothing moves.
        options
            Arguments of the figure, such as ``look="3d"`` or ``ax=``.

        Raises
        ------
        UnknownNameError
            If the kind is unknown.
        MissingExtraError
            Without the extra ``viz``.
        """
        kind = kind or ("mechanism" if self.moves else "structure" if self.response is None else "response")
        check_known(kind, _KINDS, f"case {self.name!r}: no figure")
        # Views stand above results, and are loaded by name when they are used.
        return getattr(import_module("blockstruct.views.figures"), kind)(self, **options)

    def describe(self) -> str:
        """Return sentences on the collapse.

        They give the number, notes, moving bodies, failing joints and ties.
        """
        motion = describe(self.model, self.history, self.case.dead, self.status) if self.moves else ""
        notes = [note.text for note in self.notes if note.severity is not Severity.WARNING]
        moved = "" if self.response is None else " ".join(response_words(self.model, self.response))
        if self.curve_ended:
            moved = case_text.capitalised(self.curve_ended)
        return "\n".join(filter(None, (str(self), moved, *notes, motion)))

    def __repr__(self) -> str:
        answer = f", {self.answer.name} {self.answer.text(self.load_factor, 4)}" * (self.response is None)
        return f"<CaseResult {self.name!r}: {self.ended}{answer}>"

    def _repr_html_(self) -> str:
        rows = [
            ("result", self.headline.text(6)),
            *([] if self.response is None else [self.number(6)]),
            ("loads", self.case.question),
            ("numerical iterations", self.n_iterations),
        ]
        table = html_table(self.name, ["", ""], rows, (*self.warnings, *self.owed))
        return table + (self.certificate._repr_html_() if self.certificate else "")

    def __str__(self) -> str:
        text = self.headline.text()
        if self.status.is_of_dead_load and self.n_iterations:
            text += failures(self.history)
        return "\n".join([f"{self.name}: {text}", *(f"  warning: {text}" for text in self.warnings)])
