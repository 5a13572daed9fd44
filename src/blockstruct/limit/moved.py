"""Set up the limit problem of a structure whose blocks have moved."""

from dataclasses import dataclass, replace
from typing import Self

import attrs
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.limit.motion import unit_of_velocity
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.ties import Ties
from blockstruct.model import Model, Pushover, Tie
from blockstruct.model.checks import check_at_block
from blockstruct.statics import MovedContacts, MovingLoads, MovingStructure, Placement, Statics, rotated
from blockstruct.vocabulary import Torsion, listed

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MovedProblem:
    """A limit problem at a placement of the blocks.

    Attributes
    ----------
    problem : LimitProblem
        Limit problem with the units of the case at rest. Wrenches and velocities are in the axes of each block.
    contacts : MovedContacts
    reach : float
        Largest gap of contact points, m.
    placement : Placement
    slack : (M,) array, m
        Elongation at which each unbroken tie begins to pull; negative if the tie is longer than allowed.
    longest : (N,) array, m
        Largest length of each tie of the model so far.
    tight : (N,) array, m
        Length at which each tie of the model begins to pull.
    elongation : (N,) array, m
        Elongation of each tie from its length in the model; negative if its ends have come closer.
    holds : (N,) array
        Whether each tie is unbroken.
    free : (F,) array
        Indices of the free blocks.
    """

    problem: LimitProblem
    contacts: MovedContacts
    reach: float
    placement: Placement
    slack: Array
    longest: Array
    tight: Array
    elongation: Array
    holds: NDArray[np.bool_]
    free: Index

    @property
    def penetration(self) -> float:
        """Deepest penetration, m."""
        return max(0.0, -float(self.contacts.gap.min(initial=0.0)))

    def gap(self, work: float) -> Array:
        """Return the gaps (K,) in units of relative velocity.

        ``work`` is the work of the unit variable load in the step, J.
        """
        return np.asarray(self.contacts.gap * self.problem.force_unit / work)

    def slack_in(self, work: float) -> Array:
        """Return the slack (M,) of ties in units of their rate of elongation.

        ``work`` is the same as in :meth:`gap`.
        """
        return np.asarray(self.slack * self.problem.ties.force_unit / work)

    def tie_force(self, T: Array) -> Array:
        """Return the forces (N,) of all ties of the model, N.

        ``T`` (M,) are the forces of the unbroken ties of the problem. Broken ties have zero.
        """
        found = np.zeros(len(self.holds))
        found[self.holds] = T * self.problem.ties.force_unit
        return found

    def velocities(self, twist: Array) -> Array:
        """Return the velocities (6 F,) of the problem for twists (B, 6).

        Twists of the blocks are in SI units, in global axes.
        """
        own = rotated(twist, self.placement.rotation.transpose(0, 2, 1))
        return np.asarray((own[self.free] * unit_of_velocity(self.problem)).ravel())

    def twist(self, u: Array) -> Array:
        """Return the twists (B, 6) of the blocks for velocities u (6 F,).

        They are in m/s and rad/s at 1 W. This is the inverse of :meth:`velocities`.
        """
        own = np.zeros((len(self.placement.position), 6))
        own[self.free] = u.reshape(-1, 6) / unit_of_velocity(self.problem)
        return rotated(own, self.placement.rotation)

    def relative(self, twist: Array) -> Array:
        """Return the relative velocities (K, 3) of twists (B, 6) of the blocks.

        Both are in SI units. The velocities are in the frames of the contact points.
        """
        points, centre = self.contacts.points, self.placement.position
        plus, minus = (
            twist[block, :3] + np.cross(twist[block, 3:], points.position - centre[block])
            for block in (points.plus, points.minus)
        )
        return np.asarray(np.einsum("kij,kj->ki", points.frame, plus - minus))


@dataclass(frozen=True, slots=True)
class ControlPoint:
    """The point whose displacement a pushover follows.

    Attributes
    ----------
    block : int
        Index of the block.
    start : (3,) array, m
        Position of the point in the model.
    arm : (3,) array, m
        Vector from the centroid of the block to the point.
    direction : (3,) array
        Direction of the displacement.
    """

    block: int
    start: Array
    arm: Array
    direction: Array

    @classmethod
    def of(cls, model: Model, case: Pushover) -> Self:
        """Return the control point of a case."""
        name, direction = case.control
        block = [b.name for b in model.blocks].index(name)
        centroid = model.blocks[block].centroid
        start = np.array(case.control_point or centroid, dtype=float)
        return cls(block, start, start - centroid, np.array(direction))

    def displacement(self, placement: Placement) -> float:
        """Return the displacement along the direction, m."""
        now = placement.position[self.block] + placement.rotation[self.block] @ self.arm
        return float((now - self.start) @ self.direction)

    def velocity(self, placement: Placement, twist: Array) -> float:
        """Return the velocity along the direction for twists (B, 6)."""
        arm = placement.rotation[self.block] @ self.arm
        return float((twist[self.block, :3] + np.cross(twist[self.block, 3:], arm)) @ self.direction)


#: Relative difference from the yield force up to which a tie counts as yielding.
YIELDS = 1e-3
#: Relative distance to the elongation limit up to which a tie has reached it. Parts of a step by which the step ends
#: before this limit, and by which it continues past a limit already reached.
AT_LIMIT, SHORT_OF, BEYOND = 1e-4, 1e-5, 1 / 4096


class MovingProblem:
    """The limit problems of a case at any placement of its blocks.

    The unit of force at a contact point is the ``unit`` (B,) of the lighter block, N. Supports have an infinite unit.

    Parameters
    ----------
    statics, problem, case
        The case at rest.

    Raises
    ------
    UnknownNameError, ModelError
        As in :func:`check_pushover`.
    GeometryError
        As in :class:`MovingStructure`.
    """

    def __init__(self, statics: Statics, problem: LimitProblem, case: Pushover) -> None:
        check_pushover(statics.model, case)
        self.statics, self.at_rest, self._case = statics, problem, case
        self.structure = MovingStructure(statics, case.corner_rounding)
        self.control = ControlPoint.of(statics.model, case)
        self.dead, self.variable = (MovingLoads.of(statics.model, p, case.dead) for p in (case.dead, case.variable))
        self.unit = np.full(len(statics.model.blocks), np.inf)
        self.unit[statics.free] = problem.wrench_unit

    @property
    def sharp(self) -> Self:
        """The same problem with the sharp corners of the model."""
        case = attrs.evolve(self._case, corner_rounding=0.0)
        return self if case == self._case else type(self)(self.statics, self.at_rest, case)

    def lengths(self, placement: Placement) -> Array:
        """Return the lengths (N,) of the ties of the model, m."""
        return self.structure.ties(placement).span

    def broken(self, longest: Array) -> NDArray[np.bool_]:
        """Return whether ties (N,) are broken after their largest lengths, m."""
        own = self.statics.ties
        return np.asarray(longest > own.span + own.elongation_limit)

    def breaks(self, before: Array, after: Array) -> NDArray[np.bool_]:
        """Return whether ties (N,) break in a step.

        ``before`` (N,) are their largest lengths before the step, and ``after`` (N,) their lengths at its end, m.
        """
        reserve = self._reserve(before)
        return np.asarray((reserve >= 0) & (after - before > reserve))

    def until_broken(self, before: Array, after: Array) -> float:
        """Return the part of a step until a tie breaks; one if no tie breaks.

        Lengths (N,) are the same as in :meth:`breaks`. The part ends just before the first tie breaks. If this tie is
        already at its limit, the part ends just after it breaks.
        """
        breaks = self.breaks(before, after)
        share = self._reserve(before)[breaks] / (after - before)[breaks]
        reached = self.at_limit(before)[breaks]
        return float(np.where(reached, share + BEYOND, (1 - SHORT_OF) * share).min(initial=1.0))

    def at_limit(self, longest: Array) -> NDArray[np.bool_]:
        """Return whether unbroken ties (N,) are at their elongation limit.

        ``longest`` (N,) are their largest lengths, m.
        """
        limit, reserve = self.statics.ties.elongation_limit, self._reserve(longest)
        return np.asarray((reserve >= 0) & (reserve <= AT_LIMIT * limit) & np.isfinite(limit))

    def _reserve(self, longest: Array) -> Array:
        """Return the further elongation (N,) at which ties break, m."""
        return self.statics.ties.span + self.statics.ties.elongation_limit - longest

    def yielding(self, force: Array) -> NDArray[np.bool_]:
        """Return whether ties of the model yield at forces (N,), N."""
        return np.asarray(force >= (1 - YIELDS) * self.statics.ties.capacity)

    def at(self, placement: Placement, reach: float, longest: Array, tight: Array | None = None) -> MovedProblem:
        """Return the limit problem at a placement.

        Parameters
        ----------
        placement
            Placement of the blocks.
        reach
            Largest gap of contact points, m.
        longest : (N,) array, m
            Largest length of each tie so far. It decides whether the tie is broken.
        tight : (N,) array, m
            Length at which each tie begins to pull; its largest length so far by default.
        """
        statics, problem = self.statics, self.at_rest
        contacts = self.structure.contacts(placement, reach)
        points, K = contacts.points, len(contacts.gap)
        force_unit = np.minimum(self.unit[points.minus], self.unit[points.plus])
        rows, columns = sp.diags_array(np.repeat(1 / problem.wrench_unit, 6)), sp.diags_array(np.repeat(force_unit, 3))
        scale = unit_of_velocity(problem)
        dead, variable = ((loads.own(placement)[statics.free] / scale).ravel() for loads in (self.dead, self.variable))
        table = self.structure.ties(placement)
        elongation = table.span - statics.ties.span
        longest = np.maximum(longest, table.span)
        tight = longest if tight is None else tight
        holds = ~self.broken(longest)
        table = table[holds]
        wrench = table.columns(placement.position, statics.free, statics.length, placement.rotation)
        moved = replace(
            problem,
            ties=Ties.of(table, wrench, problem.wrench_unit, self.unit),
            A=sp.csc_array(rows @ contacts.A @ columns),
            w_D=dead,
            w_L=variable,
            friction=points.friction,
            dilatancy=points.dilatancy,
            cohesion=points.cohesion,
            tension=points.tension,
            compression=points.compression,
            compliance=np.ones((K, 2)),
            rectangles=points.rectangles,
            capacity=np.empty(0),
            force_unit=force_unit,
        )
        slack = tight[holds] - table.span
        return MovedProblem(moved, contacts, reach, placement, slack, longest, tight, elongation, holds, statics.free)


_PARTS = (
    "which is lost where blocks part, in a way that this method does not know: give a joint material without it, and "
    "run a LimitCase for the load factor with it"
)
_CRUSHES = (
    "but what crushes changes the shape of blocks, which keep theirs here: give a joint material without it, which "
    "raises the curve, or for a body that turns as one take a LimitCase with it: bs.assess.local_mechanism then sets "
    "its hinge back"
)
_LIFTS = (
    "by which sliding lifts blocks, and nothing says how far: give a joint material without it, which lowers the curve"
)
#: Joint properties that a pushover refuses: neutral value, unit, and reason with the remedy.
_UNKNOWN_PROPERTIES = {
    "cohesion": (0.0, "Pa", _PARTS),
    "tensile_strength": (0.0, "Pa", _PARTS),
    "compressive_strength": (np.inf, "Pa", _CRUSHES),
    "dilatancy_angle": (0.0, "rad", _LIFTS),
}
#: Ties that a pushover refuses: reason with the remedy.
_UNKNOWN_TIES = {
    "Tie": (
        "which changes as its ends move, in a way that this method does not know: leave it out, the tie yields at the "
        "same force; and run a LimitCase for the load factor with it"
    ),
    "Strip": (
        "whose bond to the blocks peels off in a way that this method does not know: give a Tie across the joint with "
        "its force, and as elongation_limit the opening at which it comes off"
    ),
    "BondedBar": (
        "which slips in its blocks in a way that this method does not know: give a Tie between each two of them, with "
        "the force that its bond lets it have there, and the slip that it bears as elongation_limit"
    ),
}


def check_pushover(model: Model, case: Pushover) -> None:
    """Refuse models and cases that finite displacements do not support.

    Raises
    ------
    UnknownNameError
        If the control point is on a block that the model does not have.
    ModelError
        If the control point is on a support or outside its block. If a joint has cohesion, tensile strength, a finite
        compressive strength, dilatancy, infinite friction or a torsion other than at corners. If a tie is prestressed,
        bonded or a strip.
    """
    blocks = {b.name: b for b in model.blocks}
    name = case.control[0]
    if name not in blocks:
        msg = (
            f"pushover {case.name!r}: control point on block {name!r}, which model {model.name!r} does not have; it "
            f"has {', '.join(list(blocks)[:10])}{', …' if len(blocks) > 10 else ''}"
        )
        raise UnknownNameError(msg)
    if blocks[name].fixed:
        msg = f"pushover {case.name!r}: control point on support {name!r}, which does not move; give a free block"
        raise ModelError(msg)
    if case.control_point is not None:
        remedy = "give a point of the block, as one of its corners, or another block"
        what = f"pushover {case.name!r}: control point"
        check_at_block(what, case.control_point, name, blocks[name].shape.vertices, remedy)
    rollers = [b.name for b in model.blocks if b.is_roller]
    if rollers:
        msg = (
            f"pushover {case.name!r}: {listed(rollers)} held in some motions only, whose axes do not turn with the "
            "block: fix a block that touches the structure with a joint of friction 0, or run a LimitCase"
        )
        raise ModelError(msg)
    for joint in {i.joint_material.name: i.joint_material for i in model.interfaces}.values():
        for name, (none, unit, instead) in _UNKNOWN_PROPERTIES.items():
            value = getattr(joint, name)
            if value != none:
                what = f"joint material {joint.name!r} has a {name} of {value:.6g} {unit}"
                msg = f"pushover {case.name!r}: {what}, {instead}"
                raise ModelError(msg)
        if np.isinf(joint.friction_coefficient):
            msg = (
                f"pushover {case.name!r}: joint material {joint.name!r} never slides. Blocks "
                "that part and meet again need a finite friction coefficient: give one"
            )
            raise ModelError(msg)
        if joint.torsion is not Torsion.CORNERS:
            msg = (
                f"pushover {case.name!r}: joint material {joint.name!r} has the torsion of {joint.torsion}, which goes "
                "with the whole area of a joint: give one with the torsion of corners"
            )
            raise ModelError(msg)
    for tie in model.ties:
        if isinstance(tie, Tie) and tie.prestress == 0:
            continue
        kind = type(tie).__name__
        what = f"has a prestress of {tie.prestress:.6g} N" if isinstance(tie, Tie) else f"is a {kind}"
        msg = f"pushover {case.name!r}: tie {tie.name!r} {what}, {_UNKNOWN_TIES[kind]}"
        raise ModelError(msg)
