"""Verification of results and capacity curves from model, forces and positions."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import xarray as xr

from blockstruct.arrays import CHUNK, NEGLIGIBLE, ROUNDING, SLIGHT, Array, Flags
from blockstruct.errors import BlockstructError, CertificateError
from blockstruct.limit import Certificate, LimitProblem
from blockstruct.limit.certificate import CERTIFICATE_MEASURES, certify
from blockstruct.limit.motion import block_motion, velocities_of
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.limit.settlement import reaction_unit
from blockstruct.model import SettlementCase, has_curve
from blockstruct.motion.course import recomputed
from blockstruct.motion.masses import Masses
from blockstruct.motion.moving_problem import MovingProblem
from blockstruct.motion.state import MotionState, largest_displacement
from blockstruct.results.analysis import Analysis
from blockstruct.results.capacity import block_rotations, fallen_blocks, steps_of
from blockstruct.results.case_result import CaseResult
from blockstruct.results.history import coordinates, division_of, forces_in, motions_in, rows
from blockstruct.results.ties import DECIMALS, break_points
from blockstruct.schema import stated
from blockstruct.statics.contacts import Division
from blockstruct.statics.moved import Placement
from blockstruct.statics.statics import Statics
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import Stage, Status, listed

#: Stages under the dead load alone.
_PROGRAMS_OF_DEAD_LOAD = [stage.value for stage in Stage if stage.is_of_dead_load]


@dataclass(frozen=True, slots=True)
class _State:
    """Final state of a history, non-dimensional by the units of the problem."""

    problem: LimitProblem
    x: Array
    T: Array
    u: Array
    alpha: float

    @classmethod
    def of(cls, statics: Statics, result: CaseResult) -> Self:
        """Return the state of SI forces and velocities.

        Under dead load alone, the load factor is the carried share.
        """
        problem, last = result.final_problem(statics), result.history.isel(iteration=[-1])
        x, T = (forces[0] for forces in forces_in(problem, last))
        alpha, stage = float(last["load_factor"][0]), Stage(last["stage"].to_numpy()[0])
        if stage.is_of_dead_load:
            dilatancy = problem.friction if stage is Stage.DEAD_LOAD else problem.dilatancy
            problem = replace(problem.dead_load_alone, dilatancy=dilatancy)
            # The prestress grows with the share and is part of the forces T.
            load = problem.w_L - problem.ties.columns @ problem.ties.prestress_L
            alpha = -float((problem.A @ x.ravel() + problem.ties.columns @ T) @ load / (load @ load))
        return cls(problem, x, T, velocities_of(statics, problem, motions_in(last))[0], alpha)

    def certificate(self, settings: ProcedureSettings) -> Certificate:
        return certify(self.problem, self.x, self.u, self.alpha, settings, self.T)


def recomputed_certificate(analysis: Analysis, name: str) -> Certificate | None:
    """Return the recomputed certificate of a case.

    Model, loads and history give it.

    It is None if the case is unbounded, has no iterations, or its last program has no solution.

    Raises
    ------
    ModelError
        If the history does not belong to this model and case.
    """
    result = analysis[name]
    if result.status is Status.UNBOUNDED or not result.n_iterations:
        return None
    division = division_of(analysis.model, result.settings.crushing_cells, result.history)
    statics = Statics.of(analysis.model, division)
    proof = _State.of(statics, result).certificate(result.settings)
    return proof if proof.is_of_a_state else None


def contradictions(analysis: Analysis) -> list[tuple[str, str]]:
    """Return the contradictions between results and their own model and loads.

    Statics, yield conditions, kinematics and flow-rule gap of every final state are computed again. The inputs are the
    model, and the forces and velocities of the history. Status, load factor and stored certificate must agree with
    them.

    Returns
    -------
    list of (name of the case, contradiction); empty without any
    """
    contradictory, statics = [], dict[Division, Statics]()
    for name, result in analysis.items():
        try:
            division = division_of(analysis.model, result.settings.crushing_cells, result.history)
            if division not in statics:
                statics[division] = Statics.of(analysis.model, division)
            contradictory += [(name, what) for what in _of_case(statics[division], result)]
        except (BlockstructError, KeyError, ValueError, IndexError) as error:
            contradictory.append((name, f"the history does not belong to this model and case ({error})"))
    return contradictory


def confirm(analysis: Analysis) -> None:
    """Refuse an analysis whose results contradict their own numbers.

    Raises
    ------
    CertificateError
        If :func:`contradictions` finds any; the message lists them.
    """
    contradictory = contradictions(analysis)
    if contradictory:
        some = listed([f"case {name!r}: {what}" for name, what in contradictory])
        msg = f"analysis of {analysis.model.name!r}: {some}; run the model again, these results are not proof"
        raise CertificateError(msg)


def _of_case(statics: Statics, result: CaseResult) -> Iterator[str]:
    yield from _status(result)
    yield from _of_response(statics, result)
    if not result.n_iterations:
        return
    problem = LimitProblem.of(statics, result.case)
    yield from curve_contradictions(statics, problem, result)
    yield from _reactions(result)
    yield from _other_model(statics, problem, result.history)
    yield from _residuals(problem, result)
    yield from _velocities(statics, problem, result.history)
    if result.status is Status.UNBOUNDED or (result.status is Status.INTERRUPTED and result.certificate is None):
        # An interrupted case makes no claim.
        return
    state = _State.of(statics, result)
    again = state.certificate(result.settings)
    stored = result.certificate
    if stored is None:
        if again.is_of_a_state:
            yield "there is no certificate"
        return
    last = {name: float(result.history[name][-1]) for name in CERTIFICATE_MEASURES if name != "holds"}
    scales = again.tolerances | {"flow_rule_gap_limit": again.flow_rule_gap_limit}
    for name, scale in scales.items():
        now = getattr(again, name)
        for where, value in (("certificate", getattr(stored, name)), ("history", last[name])):
            if not _same(value, now, scale):
                yield f"{name.replace('_', ' ')} of the {where} is {value:.3g}, its final state has {now:.3g}"
    if stored.holds != again.holds:
        says, has = ("holds" if c.holds else "does not hold" for c in (stored, again))
        yield f"the stored certificate {says}, the recomputed one {has}"
    if (result.status is Status.CONVERGED or result.status.is_of_dead_load) and not again.holds:
        yield f"{result.status.words}, but the certificate of the final state does not hold"
    numerics = result.settings.numerics
    whole = state.alpha >= 1 - max(numerics.gap_tolerance, numerics.equilibrium_tolerance)
    if result.status is Status.SELF_STRESS and not whole:
        yield f"{result.status.words}, but the final state carries {state.alpha:.3g} of the dead load, not all of it"
    if result.status is Status.UNSTABLE and state.alpha >= 1 - result.settings.numerics.equilibrium_tolerance:
        yield f"{result.status.words}, but the final state carries the whole dead load"


def _status(result: CaseResult) -> Iterator[str]:
    """Compare the status with load factor and last iteration."""
    alpha, h = result.load_factor, result.history
    last = float(h["load_factor"][-1]) if result.n_iterations else np.nan
    stage = str(h["stage"].to_numpy()[-1]) if result.n_iterations else ""
    if result.status is Status.CONVERGED:
        signed = isinstance(result.case, SettlementCase)
        if not (np.isfinite(alpha) and (signed or alpha >= 0)):
            yield f"converged, but its load factor is {alpha:.6g}"
        within = result.certificate.flow_rule_gap_limit if result.certificate else 0.0
        # Of earlier versions, whose last iteration is the state with crushing.
        limited = alpha == result.outcome.without_crushing < last
        if not (alpha == last or limited or (alpha == 0 and abs(last) <= within and not signed)):
            yield f"the load factor is {alpha:.6g}, in the last iteration {last:.6g}"
        if stage in _PROGRAMS_OF_DEAD_LOAD:
            yield "converged, but its last iteration is the dead-load program"
    elif result.status is Status.UNBOUNDED:
        if not (np.isposinf(alpha) and np.isposinf(last)):
            yield f"unbounded, but its load factor is {alpha:.6g}, in the last iteration {last:.6g}"
        if result.certificate is not None:
            yield "unbounded, but it has a certificate of a collapse state"
    elif not np.isnan(alpha):
        yield f"{result.status.words}, but its load factor is {alpha:.6g}"
    if result.status.is_of_dead_load and stage not in _PROGRAMS_OF_DEAD_LOAD:
        yield f"{result.status.words}, but its last iteration is not a dead-load program"


def _other_model(statics: Statics, problem: LimitProblem, history: xr.Dataset) -> Iterator[str]:
    """Compare names, positions, frames and strengths of the history with the model."""
    for name, (_, values, _) in coordinates(statics, problem).items():
        stored = history[name].to_numpy()
        if values.dtype.kind in "OU":
            same = stored.tolist() == values.tolist()
        else:
            scale = np.abs(values[np.isfinite(values)]).max(initial=0.0)
            same = stored.shape == values.shape and np.allclose(stored, values, rtol=ROUNDING, atol=ROUNDING * scale)
        if not same:
            yield f"{name} of the history differs from the model"


def _residuals(problem: LimitProblem, result: CaseResult) -> Iterator[str]:
    """Compare residuals of earlier iterations with their forces."""
    history = result.history
    alpha, stored, stage = (history[name].to_numpy()[:-1] for name in ("load_factor", "equilibrium_residual", "stage"))
    x, T = forces_in(problem, history.isel(iteration=slice(-1)))
    # Programs under dead load alone have no load factor, and a file need not keep the forces of every iteration.
    known = np.isfinite(alpha) & np.isfinite(x).all(axis=(1, 2)) & ~np.isin(stage, _PROGRAMS_OF_DEAD_LOAD)
    for k in np.flatnonzero(known):
        recomputed = float(np.abs(problem.unbalanced(x[k], T[k], float(alpha[k]))).max())
        if not _same(float(stored[k]), recomputed, result.settings.numerics.equilibrium_tolerance):
            yield (
                f"load factor and forces of iteration {k} miss equilibrium by {recomputed:.3g}, its "
                f"equilibrium residual is {stored[k]:.3g}"
            )
            return


def _reactions(result: CaseResult) -> Iterator[str]:
    """Compare the reactions of a settlement with its load factors."""
    if not result.answer.is_reaction:
        return
    stored, alpha = (result.history[name].to_numpy() for name in ("reaction", "load_factor"))
    expected = result.answer.factor * alpha + 0.0
    wrong = np.flatnonzero(~np.isclose(stored, expected, rtol=ROUNDING, atol=0, equal_nan=True))
    if len(wrong):
        k, text = wrong[0], result.answer.format
        yield f"the reaction of iteration {k} is {text(stored[k], 6)}, by its load factor {text(expected[k], 6)}"


def _velocities(statics: Statics, problem: LimitProblem, history: xr.Dataset) -> Iterator[str]:
    """Compare relative and support velocities with the free blocks."""
    ties, n = problem.ties, history.sizes["iteration"]
    fixed = np.setdiff1d(np.arange(len(statics.model.blocks)), statics.free)
    of_contacts = rows(history, "relative_velocity", "contact_point", "component")
    # Large histories are read from a file in parts.
    step = max(1, CHUNK // problem.A.nnz)
    for begin in range(0, n, step):
        part = slice(begin, begin + step)
        motion, stored = motions_in(history.isel(iteration=part)), of_contacts[part].to_numpy()
        # The solver found no velocities, or the file does not keep them.
        known = ~(np.isnan(motion).all(axis=(1, 2)) & np.isnan(stored).all(axis=(1, 2)))
        motion, stored = motion[known], stored[known]
        u = velocities_of(statics, problem, motion)
        v = (problem.A.T @ u.T).T.reshape(len(u), -1, 3) / problem.force_unit[:, None]
        text = "the relative velocities of iteration {} differ from the velocities of its blocks"
        # Blocks that a support takes with it have relative velocities of rounding alone.
        off = {text: _off(stored, v, NEGLIGIBLE * motion)}
        if len(ties):
            rates = ties.elongation(u.T).T / ties.force_unit
            found = rows(history, "tie_elongation_rate", "tie")[part].to_numpy()[known]
            # A tie across the motion has a rate of rounding alone.
            text = "the rates of elongation of iteration {} differ from the velocities of its blocks"
            off[text] = _off(found, rates, v)
        allowed = block_motion(statics, problem, u)[:, fixed]
        still = np.isclose(motion[:, fixed], allowed, rtol=ROUNDING, atol=0, equal_nan=True).all(axis=(1, 2))
        off["supports move in the mechanism of iteration {}"] = ~still
        wrong = np.flatnonzero(np.any(list(off.values()), axis=0))
        if len(wrong):
            at = begin + np.flatnonzero(known)[wrong[0]]
            yield from (text.format(at) for text, of in off.items() if of[wrong[0]])
            return


def _off(stored: Array, expected: Array, *others: Array) -> Flags:
    """Return whether values (n, ...) differ beyond rounding, relative to the largest of them and of others."""
    largest = np.zeros((len(stored), 1))
    for values in (expected, *others):
        flat = np.abs(np.where(np.isfinite(values), values, 0.0)).reshape(len(values), -1)
        largest = np.maximum(largest, flat.max(axis=1, initial=0.0, keepdims=True))
    one, other = (values.reshape(len(values), -1) for values in (stored, expected))
    # Not isclose: before NumPy 2 it takes no tolerance of several rows where a value is infinite or NaN.
    with np.errstate(invalid="ignore"):
        near = np.abs(one - other) <= SLIGHT * largest
    return np.asarray(~(near | (one == other) | (np.isnan(one) & np.isnan(other))).all(axis=1))


def _same(one: float, other: float, scale: float) -> bool:
    if np.isnan(one) or np.isnan(other):
        return bool(np.isnan(one) and np.isnan(other))
    return abs(one - other) <= max(SLIGHT * abs(other), 1e-2 * scale, 1e-9)


#: Difference of the work of the variable load in a second from 1 J that rounding makes.
AT_ONE_WATT = 1e-5
#: Values that follow from the others of a state.
_FOLLOWS = (
    *("displacement", "tie_elongation", "crushed_depth", "crushed_slope", "crushed_share", "largest_crushed_depth"),
    *("penetration", "dissipation", "work", "inertia", "energy_error", "equilibrium_residual", "yield_excess"),
    *("interpenetration", "flow_rule_gap", "contact_points"),
)


def curve_contradictions(statics: Statics, problem: LimitProblem, result: CaseResult) -> Iterator[str]:
    """Yield contradictions between a capacity curve and its model and forces.

    All that follows from forces, places and motions is computed again by the function that computed it first.
    """
    if result.capacity is None or not has_curve(result.case):
        return
    curve, moving = result.capacity, MovingProblem(statics, problem, result.case)
    states, names = steps_of(curve), [b.name for b in statics.model.blocks]
    for k, state in enumerate(states):
        for what in _of_state(moving, states[k - 1] if k else None, state, names):
            yield f"state {k} of the capacity curve: {what}"
    for k, (state, again) in enumerate(zip(states, recomputed(moving, result.settings, states), strict=True)):
        for what in _differences(state, again, statics.length):
            yield f"state {k} of the capacity curve: {what}"
    of_states = (np.array([getattr(s, name) for s in states]) for name in ("displacement", "load_factor", "falls"))
    d0 = largest_displacement(result.case, *of_states)
    if not np.isclose(float(curve["d0"]), d0, rtol=ROUNDING, atol=0.0, equal_nan=True):
        yield f"d0 is {float(curve['d0']):.6g} m, that of the capacity curve {d0:.6g} m"
    if isinstance(result.case, SettlementCase):
        reaction = -reaction_unit(statics.model, result.case) * curve["load_factor"].to_numpy()
        if not np.allclose(curve["reaction"], reaction, rtol=ROUNDING, atol=0.0):
            yield "the reactions of the capacity curve are not those of its load factors"
    if "tie_break_displacement" in curve:
        limit = statics.ties.elongation_limit
        elongation = np.array([state.tie_elongation for state in states])
        broke = break_points(np.array([state.displacement for state in states]), elongation, limit)
        for name, expected in (("tie_elongation_limit", limit), ("tie_break_displacement", broke)):
            stored = curve[name].to_numpy()
            off = ~np.isclose(stored, expected, rtol=ROUNDING, atol=10.0**-DECIMALS, equal_nan=True)
            if off.any():
                k = int(off.argmax())
                yield (
                    f"{name} of tie {curve['tie'].to_numpy()[k]!r} of the capacity curve is {stored[k]:.6g} m, that of "
                    f"its model and elongations {expected[k]:.6g} m"
                )


def _of_response(statics: Statics, result: CaseResult) -> Iterator[str]:
    """Compare a response to a record with its status, its masses and the balance of its energies."""
    response, model = result.response, statics.model
    if response is None:
        return
    fallen, time = fallen_blocks(model, response), response["time"].to_numpy()
    if bool(fallen) != (result.status is Status.COLLAPSES):
        yield f"{result.status.words}, but in the last state {listed(fallen) if fallen else 'no block'} has fallen"
    if fallen and result.collapse_time != time[-1]:
        yield f"the time of collapse is {result.collapse_time:.6g} s, that of the last state {time[-1]:.6g} s"
    of_blocks = ("displacement", "velocity", "angular_velocity")
    way, speed, spin = (response[name].transpose("time", "block", "axis").to_numpy() for name in of_blocks)
    masses, own = Masses.of(model, result.case.dead, result.name), block_rotations(response)
    spin = np.einsum("tbji,tbj->tbi", own, spin)
    moving = np.einsum("b,tbi->t", masses.mass, speed**2) + np.einsum("tbi,bij,tbj->t", spin, masses.inertia, spin)
    kinetic, dead, record, lost = (
        response[name].to_numpy() for name in ("kinetic_energy", "dead_work", "record_work", "dissipated_energy")
    )
    scale = np.maximum.accumulate(np.abs([kinetic, dead, record, lost]).max(axis=0))
    peak = response["peak_displacement"].transpose("time", "block").to_numpy()
    reached = np.maximum.accumulate(np.linalg.norm(way, axis=2), axis=0)
    checks = {
        "the kinetic energy is not that of its velocities": np.abs(kinetic - moving / 2) > SLIGHT * scale,
        "its energies do not balance": np.abs(kinetic + lost - dead - record) > SLIGHT * scale,
        "a block is displaced by more than its peak": (reached > (1 + ROUNDING) * peak).any(axis=1),
    }
    for what, wrong in checks.items():
        if wrong.any():
            yield f"the response at {time[int(wrong.argmax())]:.6g} s: {what}"


def _of_state(moving: MovingProblem, before: MotionState | None, state: MotionState, names: list[str]) -> Iterator[str]:
    """Compare the positions of blocks with the motion that led there, and this motion with its unit."""
    size, at = moving.statics.length, Placement.at(state.position, state.rotation)
    # The first steps double, so blocks have not gone further than twice the next step.
    furthest = float(np.linalg.norm(state.velocity, axis=1).max()) * state.motion_time
    led, most = Placement.of(moving.statics.model), max(SLIGHT * size, 2 * furthest)
    if before is not None:
        most = NEGLIGIBLE * size
        led = Placement.at(before.position, before.rotation).moved(before.twist * before.motion_time)
    turned = np.abs(at.rotation - led.rotation).max(axis=(1, 2)) * size
    off = np.maximum(np.abs(at.position - led.position).max(axis=1), turned)
    if not off.max() <= most:
        where = "the way that the motion before leads" if before is not None else "its place in the model"
        yield f"block {names[int(off.argmax())]!r} is {off.max():.3g} m off {where}, more than {most:.3g} m"
    power = float((moving.variable.at(at) * state.twist).sum())
    if not abs(power - 1) <= AT_ONE_WATT:
        yield f"its velocities belong to {power:.6g} W of variable load, not to 1 W"
    length = np.linalg.norm(state.normal_of_contact, axis=1)
    if not np.abs(length - 1).max(initial=0.0) <= ROUNDING:
        yield f"the normal of one of its contacts has a length of {length[np.abs(length - 1).argmax()]:.6g}, not 1"


def _differences(state: MotionState, again: MotionState, size: float) -> Iterator[str]:
    """Compare the derived values of a state with those that it stores."""
    work, known = max(abs(again.load_factor), abs(again.dissipation), 1.0), stated("capacity")
    for name in _FOLLOWS:
        stored, found = (np.atleast_1d(np.asarray(getattr(of, name), dtype=float)) for of in (state, again))
        least = NEGLIGIBLE * (size if known[name].attrs["units"] == SI_UNITS["length"] else work)
        # NaN differs from every number.
        off = ~(np.abs(stored - found) <= least + SLIGHT * np.abs(found))
        if off.any():
            k = int(off.argmax())
            yield f"its {name.replace('_', ' ')} is {stored[k]:.6g}, and {found[k]:.6g} by its forces and places"
    if state.holds != again.holds:
        yield f"its certificate {'holds' if state.holds else 'does not hold'}, by its forces the other is true"
