"""Verification of capacity curves from model, forces and positions."""

from collections.abc import Callable, Iterator
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import LimitProblem, MovingProblem, Placement, zero_displacement
from blockstruct.limit.certificate import FORCES
from blockstruct.limit.motion import unit_of_velocity
from blockstruct.model import Pushover
from blockstruct.results.capacity import block_rotations
from blockstruct.results.case_result import CaseResult
from blockstruct.results.pushed_ties import DECIMALS, break_displacements, rounding_of_ties
from blockstruct.results.ties import AT_LIMIT
from blockstruct.statics import Statics, rotated

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Distance of blocks from the positions that their motions give, relative to the mean block size: rotations round.
MOVED = 1e-6
#: Relative rounding error of d0; deviation from 1 J of the work of the variable load in a second.
SAME, AT_ONE_WATT = 1e-9, 1e-5
#: Difference of works, as a share of all work, that counts as rounding: measured 1e-9, from forces too small to be
#: kept. Least load factor, relative to the first, that scales the work.
OF_WORK, LEAST = 1e-6, 0.05
#: Largest force, in units of the dead wrench of a block, that is too small to be kept.
NOT_KEPT = 1e-9
#: Relative difference of two computations of one residual beyond the tolerance of a certificate.
ROUNDING = 1e-3
#: Largest interpenetration of a certified state; largest flow-rule gap, relative to load factor plus dissipation.
PENETRATING, CERTIFIED = 5e-2, 1e-2
#: Tolerated excess of a motion over its stored time, as a share, after the break of a tie in files of old versions.
BEYOND = 2e-3
#: Newton steps from rest to the time of a motion; time increment for the speed, as a share of the motion's time.
NEWTON, CHANGE = 6, 1e-6


def curve_contradictions(statics: Statics, problem: LimitProblem, result: CaseResult) -> Iterator[str]:
    """Yield contradictions between a capacity curve and its model and forces.

    They include loads and block positions. Without a curve there are none. Contacts are not searched again, so
    interpenetration and the flow rule across gaps are not recomputed.
    """
    if result.capacity is None or not isinstance(result.case, Pushover):
        return
    collapse = float(result.history["load_factor"][-1])
    states = _States(MovingProblem(statics, problem, result.case), result.capacity, collapse)
    yield from states.places()
    yield from states.motions()
    yield from states.lengths_of_ties()
    yield from states.breaks_of_ties()
    yield from states.verdicts()
    if "force_of_contact" in result.capacity:
        yield from states.forces()
        yield from states.works()


class _States:
    """The states of a curve; the first dimension of arrays is the state, SI."""

    def __init__(self, moving: MovingProblem, curve: xr.Dataset, collapse: float) -> None:
        self._moving, self._curve, self._collapse = moving, curve, collapse
        self._names = [b.name for b in moving.statics.model.blocks]
        self._alpha, self._displacement = self._of("load_factor"), self._of("displacement")
        self._position, self._rotation = self._of("position", "block", "axis"), block_rotations(curve)
        self._twist = np.concatenate(
            [self._of(name, "block", "axis") for name in ("velocity", "angular_velocity")], axis=2
        )
        self._placements = [Placement(*at) for at in zip(self._position, self._rotation, strict=True)]
        self._size = moving.statics.length

    def _of(self, name: str, *dims: str) -> Array:
        return np.asarray(self._curve[name].transpose("step", *dims))

    def places(self) -> Iterator[str]:
        """Compare displacements, d0 and motions with the block positions."""
        found = np.array([self._moving.control.displacement(at) for at in self._placements])
        yield from _told(
            ~(np.abs(found - self._displacement) <= MOVED * self._size),
            lambda k: f"its displacement is {self._displacement[k]:.6g} m, that of its blocks {found[k]:.6g} m",
        )
        curve = list(zip(self._displacement.tolist(), self._alpha.tolist(), strict=True))
        d0, expected = float(self._curve["d0"]), zero_displacement(curve)
        if not np.isclose(d0, expected, rtol=SAME, atol=0.0, equal_nan=True):
            yield f"d0 is {d0:.6g} m, that of the capacity curve {expected:.6g} m"
        off, time, whole = *self._off_way(), self._of("motion_time")[:-1]
        yield from _told(
            ~(off.max(axis=1) <= MOVED * self._size),
            lambda k: (
                f"block {self._names[off[k].argmax()]!r} is {off[k].max():.3g} m off "
                f"{f'the way that the motion of state {k - 1} leads' if k else 'its place in the model'}, more than "
                f"{MOVED * self._size:.3g} m"
            ),
        )
        yield from _told(
            ~((time > 0) & (time <= (1 + BEYOND) * whole)),
            lambda k: f"its motion_time is {whole[k]:.6g} s, and the next state {time[k]:.6g} s further",
        )

    def _off_way(self) -> tuple[Array, Array]:
        """Return deviations (S, B), m, of blocks from their motions, and times.

        Rotations are multiplied by a characteristic length. At the times (S − 1,) the motions come closest.
        """
        places = np.array([self._flat(at) for at in self._placements])
        motions = list(zip(self._placements[:-1], self._twist[:-1], strict=True))

        def off(time: Array) -> Array:
            led: list[Array] = [self._flat(at.moved(twist * t)) for (at, twist), t in zip(motions, time, strict=True)]
            return np.asarray(np.array(led).reshape(places[1:].shape) - places[1:])

        change = CHANGE * self._of("motion_time")[:-1]
        time = np.zeros_like(change)
        with np.errstate(all="ignore"):
            for _ in range(NEWTON):
                left = off(time)
                speed = (off(time + change) - left) / change[:, None, None]
                time = time - (left * speed).sum(axis=(1, 2)) / (speed**2).sum(axis=(1, 2))
            rest = self._flat(Placement.of(self._moving.statics.model))
            missed = np.abs(np.concatenate([places[:1] - rest, off(time)]))
        return np.asarray(missed.max(axis=2)), time

    def _flat(self, placement: Placement) -> Array:
        """Return positions and scaled rotation matrices, (B, 12), m.

        The scale is a characteristic length.
        """
        return np.asarray(np.column_stack([placement.position, self._size * placement.rotation.reshape(-1, 9)]))

    def motions(self) -> Iterator[str]:
        """Compare the work of the variable load on the velocities with 1 W."""
        power = np.einsum("sbi,sbi->s", self._variable, self._twist)
        yield from _told(
            ~(np.abs(power - 1) <= AT_ONE_WATT),
            lambda k: f"its velocities belong to {power[k]:.6g} W of variable load, not to 1 W",
        )

    def lengths_of_ties(self) -> Iterator[str]:
        """Compare elongations with the positions of the anchors."""
        if "tie_elongation" not in self._curve:
            return
        stored = self._of("tie_elongation", "tie")
        rest = self._moving.statics.ties.span
        found = np.array([self._moving.lengths(at) for at in self._placements]) - rest
        off = np.abs(stored - found)
        names = self._curve["tie"].to_numpy()
        yield from _told(
            ~(off.max(axis=1) <= MOVED * self._size),
            lambda k: (
                f"tie {names[off[k].argmax()]!r} is {stored[k, off[k].argmax()]:.6g} m longer, by its anchors "
                f"{found[k, off[k].argmax()]:.6g} m"
            ),
        )

    def breaks_of_ties(self) -> Iterator[str]:
        """Compare elongation limits and breaks of ties with the model."""
        if "tie_elongation" not in self._curve or "tie_break_displacement" not in self._curve:
            return
        names, limit = self._curve["tie"].to_numpy(), self._moving.statics.ties.elongation_limit
        broke = break_displacements(self._displacement, self._of("tie_elongation", "tie"), limit)
        for name, expected in (("tie_elongation_limit", limit), ("tie_break_displacement", broke)):
            stored = self._curve[name].to_numpy()
            off = ~np.isclose(stored, expected, rtol=SAME, atol=10.0**-DECIMALS, equal_nan=True)
            if off.any():
                k = int(off.argmax())
                yield (
                    f"{name} of tie {names[k]!r} of the capacity curve is {stored[k]:.6g} m, that of its model and "
                    f"elongations {expected[k]:.6g} m"
                )

    def verdicts(self) -> Iterator[str]:
        """Compare the verdicts of certificates with their measures."""
        residual, excess, interpenetration, gap = (
            self._of(name) for name in ("equilibrium_residual", "yield_excess", "interpenetration", "flow_rule_gap")
        )
        holds, work = self._of("holds") == 1, np.abs(self._alpha) + self._of("dissipation")
        within = (np.maximum(residual, excess) <= FORCES) & (interpenetration <= PENETRATING)
        # If the work is small, the gap is relative to the work at collapse.
        most = CERTIFIED * np.maximum(work, LEAST * max(self._alpha[0], self._collapse))
        surely, possibly = (within & (gap <= (1 + rounding) * most) for rounding in (-ROUNDING, ROUNDING))
        yield from _told(
            (holds & ~possibly) | (surely & ~holds),
            lambda k: f"its certificate {'holds' if holds[k] else 'does not hold'}, by its measures the other is true",
        )

    def forces(self) -> Iterator[str]:
        """Compare equilibrium and yield of the forces with the certificates."""
        length, k = np.linalg.norm(self._of_contact("normal_of_contact"), axis=1), self._contacts[0]
        if not np.abs(length - 1).max(initial=0.0) <= SAME:
            at = int(np.abs(length - 1).argmax())
            of_contact = f"the normal of contact {at} has a length of {length[at]:.6g}, not 1"
            yield f"state {k[at]} of the capacity curve: {of_contact}"
        kept = AT_LIMIT * (self._rounded > 0).sum(axis=1)
        yield from self._measure("equilibrium_residual", self._of("equilibrium_residual"), self._residual(), kept)
        # Contact points without a force are not stored; their excess is zero.
        yield from self._measure("yield_excess", np.maximum(self._of("yield_excess"), 0.0), self._excess())

    def _measure(self, name: str, stored: Array, found: Array, rounded: Array | float = 0.0) -> Iterator[str]:
        differs = ~(np.abs(found - stored) <= FORCES + rounded + ROUNDING * np.abs(found))
        beyond = (self._of("holds") == 1) & ~(found <= 2 * FORCES + rounded)
        yield from _told(
            differs | beyond,
            lambda k: (
                f"its {name.replace('_', ' ')} by its load factor, forces and places is {found[k]:.3g}, the stored one "
                f"{stored[k]:.3g}, and one that holds {FORCES:g} at most"
            ),
        )

    def works(self) -> Iterator[str]:
        """Compare dissipation and energy errors with the forces and motions."""
        stored, found = self._of("dissipation"), self._dissipated(self._twist)
        # If blocks drop, the dead load does most of the work.
        work = np.abs(self._alpha) + np.abs(found) + np.abs(self._of("falling"))
        work = np.maximum(work, LEAST * abs(self._alpha[0]))
        of_ties = (self._rounded * np.abs(self._longer(self._twist))).sum(axis=1)
        none = OF_WORK * work + of_ties + self._not_kept()
        yield from _told(
            ~(np.abs(found - stored) <= none),
            lambda k: (
                f"its forces and velocities dissipate {found[k]:.6g} of the variable load's work, not {stored[k]:.6g}"
            ),
        )
        errors, error = self._of("energy_error"), self._energy_error(found)
        yield from _told(
            ~(np.abs(errors - error) <= OF_WORK),
            lambda k: f"the energy error of the way there is {error[k]:.3g}, not {errors[k]:.3g}",
        )

    @cached_property
    def _variable(self) -> Array:
        return np.array([self._moving.variable.at(at) for at in self._placements])

    @cached_property
    def _contacts(self) -> tuple[NDArray[np.int64], tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """State of each contact point, and its plus and minus blocks."""
        names = ("step_of_contact", "plus_of_contact", "minus_of_contact")
        state, plus, minus = (np.asarray(self._curve[name], dtype=np.int64) for name in names)
        return state, (plus, minus)

    def _of_contact(self, name: str) -> Array:
        return np.asarray(self._curve[name].transpose("contact", "axis"))

    @cached_property
    def _tie_columns(self) -> list[Array]:
        """Wrenches (6 F, N) of unit forces of the ties in each state."""
        statics = self._moving.statics
        return [
            self._moving.structure.ties(at).columns(at.position, statics.free, statics.length, at.rotation).toarray()
            for at in self._placements
        ]

    @cached_property
    def _tie_force(self) -> Array:
        if "tie_force" not in self._curve:
            return np.zeros((len(self._alpha), 0))
        return self._of("tie_force", "tie")

    @cached_property
    def _rounded(self) -> Array:
        """Largest force (S, N) of slack ties before rounding to zero, N."""
        if not self._tie_force.size:
            return self._tie_force
        return np.where(self._tie_force > 0, 0.0, rounding_of_ties(self._moving.statics.model))

    def _own(self, values: Array) -> Array:
        """Return values (S, B, 6) in the axes of each free block, (S, F, 6).

        The values are wrenches or twists.
        """
        turned = self._rotation.reshape(-1, 3, 3).transpose(0, 2, 1)
        own = rotated(values.reshape(-1, 6), turned).reshape(values.shape)
        return np.asarray(own[:, self._moving.statics.free])

    def _residual(self) -> Array:
        """Return the equilibrium residual (S,), as in a certificate."""
        state, blocks = self._contacts
        point, force = self._of_contact("point_of_contact"), self._of_contact("force_of_contact")
        dead = np.array([self._moving.dead.at(at) for at in self._placements])
        wrench = dead + self._alpha[:, None, None] * self._variable
        for block, on_block in zip(blocks, (force, -force), strict=True):
            moment = np.cross(point - self._position[state, block], on_block)
            np.add.at(wrench, (state, block), np.column_stack([on_block, moment]))
        problem = self._moving.at_rest
        found = self._own(wrench) / unit_of_velocity(problem)
        for k, columns in enumerate(self._tie_columns):
            found[k] += (columns @ self._tie_force[k]).reshape(-1, 6) / problem.wrench_unit[:, None]
        return np.asarray(np.abs(found).max(axis=(1, 2)))

    def _excess(self) -> Array:
        """Return the yield excess (S,), as in a certificate; zero inside."""
        state, (plus, minus) = self._contacts
        normal = self._of_contact("normal_of_contact")
        force = self._of_contact("force_of_contact") / np.minimum(*self._moving.unit[[plus, minus]])[:, None]
        n = np.einsum("ki,ki->k", force, normal)
        along = np.linalg.norm(force - n[:, None] * normal, axis=1)
        friction, _ = self._moving.structure.friction(minus, plus)
        found = np.zeros(len(self._alpha))
        np.maximum.at(found, state, np.maximum(along - friction * n, -n) / np.maximum(n, 1.0))
        ties = self._moving.at_rest.ties
        if len(ties):
            limit = self._moving.statics.ties.elongation_limit
            broken = np.maximum.accumulate(self._of("tie_elongation", "tie"), axis=0) > limit
            for k, T in enumerate(self._tie_force / ties.force_unit):
                found[k] = max(found[k], ties.excess(T, T).max(), T[broken[k]].max(initial=0.0))
        return found

    def _dissipated(self, twist: Array) -> Array:
        """Return the work (S,) of friction and ties in a second, J.

        The motions have shape (S, B, 6).
        """
        state, (plus, minus) = self._contacts
        point, normal = self._of_contact("point_of_contact"), self._of_contact("normal_of_contact")
        at_plus, at_minus = (
            twist[state, block, :3] + np.cross(twist[state, block, 3:], point - self._position[state, block])
            for block in (plus, minus)
        )
        v = at_plus - at_minus
        v -= np.einsum("ki,ki->k", v, normal)[:, None] * normal
        found = np.zeros(len(twist))
        np.add.at(found, state, -np.einsum("ki,ki->k", self._of_contact("force_of_contact"), v))
        return np.asarray(found + (self._tie_force * self._longer(twist)).sum(axis=1))

    def _not_kept(self) -> Array:
        """Return the largest work (S,) in a second of forces too small to keep.

        The work is not negligible for blocks that drop, which are fast.
        """
        missing = self._of("contact_points") - np.bincount(self._contacts[0], minlength=len(self._alpha))
        speed = np.linalg.norm(self._twist[:, :, :3], axis=2).max(axis=1)
        unit = self._moving.unit
        return np.asarray(2 * speed * missing * NOT_KEPT * unit[np.isfinite(unit)].max())

    def _longer(self, twist: Array) -> Array:
        """Return the lengthening (S, N) of ties in a second, m.

        The motions have shape (S, B, 6).
        """
        own = self._own(twist) * np.repeat([1.0, self._size], 3)
        found = [-(now.ravel() @ columns) for now, columns in zip(own, self._tie_columns, strict=True)]
        return np.reshape(found, self._tie_force.shape)

    def _energy_error(self, dissipation: Array) -> Array:
        """Return the energy error (S,) of each step, relative to all work so far.

        It is zero at the first state.
        """
        carried = self._twist.copy()
        way = np.diff(self._position, axis=0)
        carried[1:] = self._twist[:-1]
        carried[1:, :, :3] += np.cross(self._twist[:-1, :, 3:], way)
        power = np.einsum("sbi,sbi->s", self._variable, carried)
        own = self._dissipated(carried) / power
        pairs = list(zip(self._placements[:-1], self._placements[1:], strict=True))
        dead, variable = (
            np.array([loads.work(*pair) for pair in pairs]) for loads in (self._moving.dead, self._moving.variable)
        )
        pushed = variable * (self._alpha[:-1] + self._alpha[1:]) / 2
        missed = np.abs(dead + pushed - variable * (dissipation[:-1] + own[1:]) / 2)
        done = np.cumsum(np.abs(dead) + np.abs(pushed) + np.abs(dead + pushed))
        return np.concatenate([[0.0], np.divide(missed, done, out=np.zeros_like(missed), where=done > 0)])


def _told(wrong: Flags, words: Callable[[int], str]) -> Iterator[str]:
    """Yield one sentence on the first wrong state, if any."""
    at = np.flatnonzero(wrong)
    if len(at):
        more = f" and {len(at) - 1} more" if len(at) > 1 else ""
        yield f"state {at[0]}{more} of the capacity curve: {words(int(at[0]))}"
