"""Describe the state of a pushover and the motion that follows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import LimitProblem, Placement
from blockstruct.limit.bodies import bodies_of
from blockstruct.limit.capacity_curve import FiniteStep
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.moved import MovedProblem, MovingProblem
from blockstruct.procedures.finite_step import Solved, dissipated
from blockstruct.vocabulary import listed

Array = NDArray[np.float64]

#: Force at a contact point, in dead wrenches of the lighter block, that counts as zero.
NO_FORCE = 1e-9
#: Speed of the control point, relative to the fastest block, below which it stands still.
STANDS = 1e-2
#: Speed, relative to the fastest block, above which a message names a block; most blocks in a message.
FAST, NAMED = 0.5, 5


@dataclass(frozen=True, slots=True)
class State:
    """Placement of the blocks and their motion from there.

    The motion has twists (B, 6) at 1 W and lasts for a time, s. ``falling`` is the work of the dead load that ties do
    not take up, per unit of work of the variable load. ``dropped`` marks a motion in which only dropping blocks move,
    and ``drops_next`` the motion before it. ``dissipated`` is the work of friction and ties on the way from the last
    state, per unit of work of the variable load. For ties (N,), ``longest`` is the largest length so far, m. ``tight``
    is the length at which a tie begins to pull, m, and ``yields`` marks the ties that yield.
    """

    placement: Placement
    load_factor: float
    dissipation: float
    twist: Array
    time: float
    displacement: float
    longest: Array
    tight: Array
    yields: NDArray[np.bool_]
    falling: float
    dropped: bool = False
    drops_next: bool = False
    dissipated: float = 0.0

    @classmethod
    def of(cls, step: FiniteStep, longest: Array, tight: Array, yields: NDArray[np.bool_]) -> Self:
        """Return the state of a step, with the data of its ties (N,)."""
        twist = np.column_stack([step.velocity, step.angular_velocity])
        placement = Placement.at(step.position, step.rotation)
        return cls(
            placement,
            step.load_factor,
            step.dissipation,
            twist,
            step.motion_time,
            step.displacement,
            longest,
            tight,
            yields,
            step.falling,
            step.dropped,
            step.drops_next,
        )

    def tightened(self, lengths: Array) -> Array:
        """Return the lengths (N,) at which ties begin to pull, m.

        ``lengths`` are the present lengths, m. Only yielding ties become longer. Anchors move along chords, so that
        ties that do not yield also lengthen slightly in a step. This is no elongation.
        """
        return np.where(self.yields, np.maximum(self.tight, lengths), self.tight)

    def carried(self, placement: Placement) -> Array:
        """Return the same screws as twists (B, 6) at another placement."""
        way = placement.position - self.placement.position
        return np.column_stack([self.twist[:, :3] + np.cross(self.twist[:, 3:], way), self.twist[:, 3:]])


@dataclass(frozen=True, slots=True)
class Found:
    """State with its problem and solution."""

    state: State
    moved: MovedProblem
    solved: Solved

    def after(self, before: State) -> Self:
        """Return the same state with the work dissipated on the way.

        The work is the mean for the forces at both ends, in the same motion.
        """
        problem, solved = self.moved.problem, self.solved
        u = self.moved.velocities(before.carried(self.state.placement))
        own = sum(dissipated(problem, solved.x, solved.tie_force, u)) / float(problem.w_L @ u)
        return replace(self, state=replace(self.state, dissipated=(before.dissipation + own) / 2))

    def kept(
        self,
        *,
        divided: bool,
        waiting: tuple[int, int],
        energy_error: float,
        spent: tuple[int, int],
        time: float,
    ) -> FiniteStep:
        """Return the state with all data that the next step needs.

        Parameters
        ----------
        divided
            Whether the step to this state was divided.
        waiting
            Number of failures of body steps in a row, and solutions before bodies are tried again.
        energy_error
            Error of the step's energy balance.
        spent
            Programs and interior-point iterations.
        time
            Computing time of the step, s.
        """
        state, solved, moved, c = self.state, self.solved, self.moved, self.solved.certificate
        points = moved.contacts.points
        frame, force = points.frame[points.interface], solved.x * moved.problem.force_unit[:, None]
        loaded = np.linalg.norm(solved.x, axis=1) > NO_FORCE
        return FiniteStep(
            load_factor=state.load_factor,
            displacement=state.displacement,
            position=state.placement.position,
            rotation=state.placement.vectors,
            velocity=state.twist[:, :3],
            angular_velocity=state.twist[:, 3:],
            motion_time=state.time,
            dissipation=state.dissipation,
            falling=state.falling,
            dropped=state.dropped,
            drops_next=state.drops_next,
            tie_force=moved.tie_force(solved.tie_force),
            tie_elongation=moved.elongation,
            minus_of_contact=points.minus[loaded],
            plus_of_contact=points.plus[loaded],
            point_of_contact=points.position[loaded],
            normal_of_contact=frame[loaded, 0],
            force_of_contact=np.einsum("kij,ki->kj", frame, force)[loaded],
            body=bodies_of(moved, solved.u),
            penetration=moved.penetration,
            energy_error=energy_error,
            equilibrium_residual=c.equilibrium_residual,
            yield_excess=c.yield_excess,
            interpenetration=c.interpenetration,
            flow_rule_gap=c.flow_rule_gap,
            holds=solved.holds,
            contact_points=len(moved.contacts.gap),
            programs=spent[0],
            solver_iterations=spent[1],
            solver_time=time,
            divided=divided,
            body_failures=waiting[0],
            body_waits=waiting[1],
        )


def friction_of(problem: LimitProblem, collapse: Iteration) -> float:
    """Return the work of friction in a collapse state.

    The unit is the work of the variable load. It is the work of all loads less the work of ties.
    """
    _, of_ties = dissipated(problem, collapse.x, collapse.tie_force, collapse.u)
    return float(collapse.load_factor + problem.w_D @ collapse.u - of_ties)


def stands(problem: MovingProblem, curve: Sequence[tuple[float, float]], state: State) -> str:
    """Return a clause if the control point stands still or moves back.

    The direction is relative to the start of the curve. The clause is empty otherwise.
    """
    begun, _ = curve[:2][-1]
    names, control = [b.name for b in problem.statics.model.blocks], problem.control
    fastest = np.linalg.norm(state.twist[:, :3], axis=1).max()
    if not begun or control.velocity(state.placement, state.twist) * np.sign(begun) > STANDS * fastest:
        return ""
    moves = moves_furthest(names, state.twist)
    return f", where the control point at block {names[control.block]!r} stands still or goes back: {moves}"


def begins_above(problem: MovingProblem, first: Found, load_factor: float) -> str:
    """Explain that the curve would begin above the collapse load.

    Blocks touch beyond the interfaces of the model, and these contacts carry more.
    """
    points, own = first.moved.contacts.points, problem.statics.points
    names = [b.name for b in problem.statics.model.blocks]
    joints, found = (np.sort(np.column_stack([p.minus, p.plus])).tolist() for p in (own, points))
    loaded = {(i, j) for (i, j), n in zip(found, first.solved.x[:, 0], strict=True) if n > NO_FORCE}
    without = [f"{names[i]}|{names[j]}" for i, j in sorted(loaded - {(i, j) for i, j in joints})]
    where = (
        f"{listed(without, NAMED)}, where the model has no interface" if without else "faces larger than its interfaces"
    )
    return (
        f"no curve: with sharp corners it would begin at a load factor of {first.state.load_factor:.4g}, above the "
        f"{load_factor:.4g} of the collapse state, as blocks that move touch wherever faces do: forces at {where}. "
        "Give the interfaces that are there, or blocks whose faces are no larger, and compare the load factors"
    )


def lost(problem: MovingProblem, placement: Placement, found: Found | None, *, falls: bool) -> str:
    """Explain why a pushover cannot continue at a placement.

    Either no forces are in equilibrium, or the state does not allow another step.
    """
    at = f"at a displacement of {problem.control.displacement(placement):.6g} m"
    if found is None:
        return (
            f"no load factor is found {at}: no forces carry the dead load, and blocks fall, or the push meets what it "
            "cannot move; and the method ends"
        )
    speed = np.linalg.norm(found.state.twist[:, :3], axis=1)
    fastest = np.argsort(-speed, kind="stable")
    names = [problem.statics.model.blocks[i].name for i in fastest[speed[fastest] > FAST * speed.max()]]
    if falls:
        return f"blocks fall under the dead load alone {at} ({listed(names, NAMED)}), and the method ends"
    return f"no motion that satisfies the flow rule is found {at} (blocks {listed(names, NAMED)}), and the method ends"


def moves_furthest(names: Sequence[str], twist: Array) -> str:
    """Return a text with the fastest block of a motion and its direction.

    The motion has twists (B, 6).
    """
    speed = np.linalg.norm(twist[:, :3], axis=1)
    fastest = int(speed.argmax())
    along = ", ".join(f"{value:.3g}" for value in np.round(twist[fastest, :3] / speed[fastest], 4) + 0.0)
    return f"block {names[fastest]!r} moves furthest, along ({along})"
