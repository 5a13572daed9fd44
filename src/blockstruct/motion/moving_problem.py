"""The limit problem of a structure whose blocks have moved."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.limit import LimitProblem, Ties, unit_of_velocity
from blockstruct.model import STANDARD_GRAVITY, Model, Pushover, Tie
from blockstruct.model.checks import check_at_block
from blockstruct.statics import MovedContacts, MovingLoads, MovingStructure, Placement, Statics, rotated
from blockstruct.vocabulary import Torsion

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MovedProblem:
    """A limit problem at a placement.

    Attributes
    ----------
    problem : LimitProblem
        With the units of the case at rest, and wrenches and velocities in the axes of each block.
    contacts : MovedContacts
    reach : float
        Largest gap of contact points, m.
    placement : Placement
    slack : (M,) array, m
        Elongation before which the ties that hold do not pull; negative of those that are longer than they may be.
    longest : (N,) array, m
        Length that each tie of the model has reached on the way there.
    tight : (N,) array, m
        Length from which on each of them pulls.
    elongation : (N,) array, m
        Of each tie there, beyond its length in the model; negative where its ends have come closer.
    holds : (N,) array
        Whether each tie has not broken.
    free : (F,) array
        The blocks that are free.
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
        """Gaps (K,) in units of relative velocity, for a step in which the unit variable load does a work, J."""
        return np.asarray(self.contacts.gap * self.problem.force_unit / work)

    def slack_in(self, work: float) -> Array:
        """Slack (M,) of ties, in the units of :meth:`gap`."""
        return np.asarray(self.slack * self.problem.ties.force_unit / work)

    def tie_force(self, T: Array) -> Array:
        """Forces (N,) of all ties of the model, N, of those (M,) of the problem."""
        found = np.zeros(len(self.holds))
        found[self.holds] = T * self.problem.ties.force_unit
        return found

    def velocities(self, twist: Array) -> Array:
        """Velocities (6 F,) of the problem of twists (B, 6) of the blocks, SI."""
        own = rotated(twist, self.placement.rotation.transpose(0, 2, 1))
        return np.asarray((own[self.free] * unit_of_velocity(self.problem)).ravel())

    def twist(self, u: Array) -> Array:
        """Twists (B, 6) of the blocks, m/s and rad/s at 1 W, of velocities u (6 F,): the inverse of the above."""
        own = np.zeros((len(self.placement.position), 6))
        own[self.free] = u.reshape(-1, 6) / unit_of_velocity(self.problem)
        return rotated(own, self.placement.rotation)


@dataclass(frozen=True, slots=True)
class ControlPoint:
    """The point whose displacement a pushover follows.

    Attributes
    ----------
    block : int
    start : (3,) array, m
        The point, where the model has it.
    arm : (3,) array, m
        To it from the centroid.
    direction : (3,) array
    """

    block: int
    start: Array
    arm: Array
    direction: Array

    @classmethod
    def of(cls, model: Model, case: Pushover) -> Self:
        """Control point of a case."""
        name, direction = case.control
        block = [b.name for b in model.blocks].index(name)
        centroid = model.blocks[block].centroid
        start = np.array(case.control_point or centroid, dtype=float)
        return cls(block, start, start - centroid, np.array(direction))

    def displacement(self, placement: Placement) -> float:
        """Displacement along the direction, m."""
        now = placement.position[self.block] + placement.rotation[self.block] @ self.arm
        return float((now - self.start) @ self.direction)

    def velocity(self, placement: Placement, twist: Array) -> float:
        """Velocity along the direction, of twists (B, 6)."""
        arm = placement.rotation[self.block] @ self.arm
        return float((twist[self.block, :3] + np.cross(twist[self.block, 3:], arm)) @ self.direction)


#: Share of its yield force that a tie that yields may miss.
YIELDS = 1e-3


class MovingProblem:
    """The limit problems of a case, wherever its blocks are.

    Forces at contact points are measured in the ``unit`` (B,) of the lighter block, N; that of supports is infinite.

    Parameters
    ----------
    statics, problem, case
        The case at rest.

    Raises
    ------
    UnknownNameError, ModelError
        As of :func:`check_pushover`.
    GeometryError
        As of :class:`MovingStructure`.
    """

    def __init__(self, statics: Statics, problem: LimitProblem, case: Pushover) -> None:
        check_pushover(statics.model, case)
        self.statics, self.at_rest, self._case = statics, problem, case
        self.structure = MovingStructure(statics, case.corner_rounding)
        self.control = ControlPoint.of(statics.model, case)
        self.dead, self.variable = (MovingLoads.of(statics.model, p, case.dead) for p in (case.dead, case.variable))
        self.unit = np.full(len(statics.model.blocks), np.inf)
        self.unit[statics.free] = problem.wrench_unit
        self.inertia = self._inertia()

    def _inertia(self) -> sp.csr_array:
        """Mass of the dead wrench of each free block, in the shape of the block, (6 F, 6 F)."""
        unit, blocks = unit_of_velocity(self.at_rest), self.statics.model.blocks
        parts = []
        for own, weight, k in zip(unit, self.at_rest.wrench_unit, self.statics.free, strict=True):
            spread = blocks[k].shape.second_moments / blocks[k].volume
            mass = np.zeros((6, 6))
            mass[:3, :3] = np.eye(3)
            mass[3:, 3:] = np.trace(spread) * np.eye(3) - spread
            parts.append(weight / STANDARD_GRAVITY * mass / np.outer(own, own))
        return sp.csr_array(sp.block_diag(parts))

    @property
    def sharp(self) -> Self:
        """The same with sharp corners, as the model has them."""
        case = replace(self._case, corner_rounding=0.0)
        return self if case == self._case else type(self)(self.statics, self.at_rest, case)

    def lengths(self, placement: Placement) -> Array:
        """Lengths (N,) of the ties of the model, m."""
        return self.structure.ties(placement).span

    def broken(self, longest: Array) -> NDArray[np.bool_]:
        """Which ties break on a way on which they reach lengths (N,), m."""
        own = self.statics.ties
        return np.asarray(longest > own.span + own.elongation_limit)

    def yielding(self, force: Array) -> NDArray[np.bool_]:
        """Which ties of the model yield, by their forces (N,), N."""
        return np.asarray(force >= (1 - YIELDS) * self.statics.ties.capacity)

    def at(self, placement: Placement, reach: float, longest: Array, tight: Array) -> MovedProblem:
        """Limit problem at a placement.

        Parameters
        ----------
        placement
            Of the blocks.
        reach
            Largest gap of contact points, m.
        longest : (N,) array, m
            Length that each tie has had on the way there, by which it breaks.
        tight : (N,) array, m
            Length from which on each pulls.
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
#: Properties of joints that a pushover refuses: what they are without them, their unit, and why and what to do instead.
_UNKNOWN_PROPERTIES = {
    "cohesion": (0.0, "Pa", _PARTS),
    "tensile_strength": (0.0, "Pa", _PARTS),
    "compressive_strength": (np.inf, "Pa", _CRUSHES),
    "dilatancy_angle": (0.0, "rad", _LIFTS),
}
#: Ties that a pushover refuses, likewise.
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
    """Refuse what finite displacements do not know.

    Raises
    ------
    UnknownNameError
        If the control point is on a block that the model does not have.
    ModelError
        If it is on a support or outside its block, if a joint has cohesion, tensile strength, a finite compressive
        strength or dilatancy, or if a tie is prestressed, bonded or a strip.
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
    for joint in {i.joint_material.name: i.joint_material for i in model.interfaces}.values():
        for name, (none, unit, instead) in _UNKNOWN_PROPERTIES.items():
            value = getattr(joint, name)
            if value != none:
                what = f"joint material {joint.name!r} has a {name} of {value:.6g} {unit}"
                msg = f"pushover {case.name!r}: {what}, {instead}"
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
