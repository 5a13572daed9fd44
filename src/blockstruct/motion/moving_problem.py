"""Set up the limit problem of a structure whose blocks have moved."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import NEGLIGIBLE, Array, Flags
from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.limit import LimitProblem
from blockstruct.limit.mirror import Mirror
from blockstruct.limit.motion import block_motion, unit_of_velocity, velocities_of
from blockstruct.limit.settlement import Settlement
from blockstruct.limit.ties import Ties
from blockstruct.model import STANDARD_GRAVITY, Model, MovingCase, Pushover, Tie
from blockstruct.model.fields import check_at_block, label
from blockstruct.statics.equilibrium import equilibrium_matrix
from blockstruct.statics.moved import MovedContacts, MovingLoads, MovingStructure, Placement, rotated
from blockstruct.statics.moving_cells import Crushed
from blockstruct.statics.statics import Statics
from blockstruct.vocabulary import Torsion, listed


@dataclass(frozen=True)
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
    elongation : (N,) array, m
        Elongation of each tie from its length in the model; negative if its ends have come closer.
    holds : (N,) array
        Whether each tie is unbroken.
    crushed : Crushed
        Memory of the cells of joints that crush.
    statics : Statics
        Statics of the structure at rest.
    plane : (3,) array or None
        Normal of the plane of symmetry of the structure at rest; None if it has none.
    """

    problem: LimitProblem
    contacts: MovedContacts
    reach: float
    placement: Placement
    slack: Array
    longest: Array
    elongation: Array
    holds: Flags
    crushed: Crushed
    statics: Statics
    plane: Array | None

    @cached_property
    def mirror(self) -> Mirror | None:
        """The problem of half of the structure; None if blocks have not moved symmetrically."""
        if self.plane is None or not len(self.contacts.gap):
            return None
        return Mirror.about(self.problem, self.plane, self.placement.position, self.contacts.points, NEGLIGIBLE)

    def of_cells(self, values: Array, other: float) -> Array:
        """Return the values (K,) of the cells of contact points, given those (C,) of all cells and another."""
        return np.append(values, other)[self.contacts.cell]

    @property
    def penetration(self) -> float:
        """Deepest penetration, m; of cells, beyond the overlap under their strength."""
        beyond = self.contacts.gap + self.of_cells(self.contacts.cells.sinks, 0.0)
        return max(0.0, -float(beyond.min(initial=0.0)))

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

        Twists of the blocks are in SI units, in global axes. The velocity of supports that settle comes last.
        """
        own = rotated(twist, self.placement.rotation.transpose(0, 2, 1))
        return np.asarray(velocities_of(self.statics, self.problem, own[None])[0])

    def twist(self, u: Array) -> Array:
        """Return the twists (B, 6) of the blocks for velocities u (6 F,).

        They are in m/s and rad/s at 1 W. This is the inverse of :meth:`velocities`.
        """
        return rotated(block_motion(self.statics, self.problem, u[None])[0], self.placement.rotation)


@dataclass(frozen=True, slots=True)
class ControlPoint:
    """The point whose displacement a curve follows.

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
    def of(cls, model: Model, case: MovingCase) -> Self:
        """Return the control point of a case: a point of a support, if supports settle."""
        if isinstance(case, Pushover):
            (name, direction), point = case.control, case.control_point
        else:
            name, direction, point = case.supports[0], case.direction, None
        block = model.block_index[name]
        centroid = model.blocks[block].centroid
        start = np.array(point or centroid, dtype=float)
        return cls(block, start, start - centroid, np.array(direction))

    def displacement(self, placement: Placement) -> float:
        """Return the displacement along the direction, m."""
        now = placement.position[self.block] + placement.rotation[self.block] @ self.arm
        return float((now - self.start) @ self.direction)

    def velocity(self, placement: Placement, twist: Array) -> float:
        """Return the velocity along the direction for twists (B, 6)."""
        arm = placement.rotation[self.block] @ self.arm
        return float((twist[self.block, :3] + np.cross(twist[self.block, 3:], arm)) @ self.direction)


#: Overlap of two blocks under the mean dead wrench, in mean block sizes.
COMPLIANCE = NEGLIGIBLE
#: Elastic overlap of a joint under its compressive strength, in mean block sizes.
ELASTIC = 1e-8


class MovingProblem:
    """The limit problems of a case at any placement of its blocks.

    The unit of force at a contact point is the ``unit`` (B,) of the lighter block, N. Supports have an infinite unit.
    The variable load of a settlement is its unit of reaction, on a support.

    Parameters
    ----------
    statics, problem, case
        The case at rest.

    Raises
    ------
    UnknownNameError, ModelError
        As in :func:`check_moving_case`.
    GeometryError
        As in :class:`MovingStructure`.
    """

    def __init__(self, statics: Statics, problem: LimitProblem, case: MovingCase) -> None:
        model = statics.model
        check_moving_case(model, case)
        self.statics, self.at_rest, self.case = statics, problem, case
        self.structure = MovingStructure(statics, case.corner_rounding if isinstance(case, Pushover) else 0.0)
        self.control = ControlPoint.of(model, case)
        dead, free = MovingLoads.of(model, case.dead, case.dead), ~self.structure.fixed
        # Loads on supports do no work on the structure.
        self.dead = MovingLoads(dead.wrench * free[:, None], dead.lever * free[:, None, None])
        if isinstance(case, Pushover):
            self.variable = MovingLoads.of(model, case.variable, case.dead)
        else:
            wrench = np.zeros((len(model.blocks), 6))
            wrench[self.control.block, :3] = self.settlement.reaction_unit * self.control.direction
            self.variable = MovingLoads(wrench, np.zeros((len(model.blocks), 3, 3)))
        self.unit = np.full(len(statics.model.blocks), np.inf)
        self.unit[statics.free] = problem.wrench_unit
        self.inertia = self._inertia()
        mirror = Mirror.of(problem)
        self._plane = None if mirror is None else mirror.normal
        self.compliance = COMPLIANCE * statics.length / float(np.linalg.norm(problem.wrench_unit))
        self.cells = self.structure.cells(ELASTIC * statics.length)

    @property
    def settlement(self) -> Settlement:
        """The settlement of the case at rest."""
        if self.at_rest.settlement is None:
            msg = f"{label(self.case)}: is no settlement"
            raise ModelError(msg)
        return self.at_rest.settlement

    def _inertia(self) -> sp.csr_array:
        """Mass of the dead wrench of each free block, in the shape of the block, (6 F, 6 F).

        Supports that settle have the mass of a mean dead wrench: they resist a motion that no joint resists.
        """
        unit, blocks = unit_of_velocity(self.at_rest), self.statics.model.blocks
        parts = []
        for own, weight, k in zip(unit, self.at_rest.wrench_unit, self.statics.free, strict=True):
            spread = blocks[k].shape.second_moments / blocks[k].volume
            mass = np.zeros((6, 6))
            mass[:3, :3] = np.eye(3)
            mass[3:, 3:] = np.trace(spread) * np.eye(3) - spread
            parts.append(weight / STANDARD_GRAVITY * mass / np.outer(own, own))
        if self.at_rest.settlement is not None:
            parts.append(np.array([[1 / (STANDARD_GRAVITY * self.at_rest.settlement.force)]]))
        return sp.csr_array(sp.block_diag([sp.coo_array(part) for part in parts]))

    def lengths(self, placement: Placement) -> Array:
        """Return the lengths (N,) of the ties of the model, m."""
        return self.structure.ties(placement).span

    def broken(self, longest: Array) -> Flags:
        """Return whether ties (N,) are broken after their largest lengths, m."""
        own = self.statics.ties
        return np.asarray(longest > own.span + own.elongation_limit)

    def at(
        self, placement: Placement, reach: float, longest: Array, tight: Array, crushed: Crushed | None = None
    ) -> MovedProblem:
        """Limit problem at a placement.

        Parameters
        ----------
        placement
            Placement of the blocks.
        reach
            Largest gap of contact points, m.
        longest : (N,) array, m
            Largest length of each tie so far. It decides whether the tie is broken.
        tight : (N,) array, m
            Length from which on each pulls.
        crushed : Crushed, optional
            Memory of the cells of joints that crush; none by default.
        """
        statics, problem = self.statics, self.at_rest.held
        crushed = crushed or self.cells.untouched
        contacts = self.structure.contacts(placement, reach, self.cells, crushed)
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
            compression=points.compression / force_unit,
            compliance=np.ones((K, 2)),
            rectangles=points.rectangles,
            capacity=np.empty(0),
            force_unit=force_unit,
        )
        settlement = self.at_rest.settlement
        if settlement is not None:
            motion, at = settlement.motion.ravel(), (placement.position, settlement.supports, 1.0)
            row, tie_row = motion @ equilibrium_matrix(points, *at), motion @ table.columns(*at)
            moved = moved.releasing(replace(settlement, row=row, tie_row=tie_row))
        slack = tight[holds] - table.span
        return MovedProblem(
            moved, contacts, reach, placement, slack, longest, elongation, holds, crushed, statics, self._plane
        )


_PARTS = (
    "which is lost where blocks part, in a way that this method does not know: give a joint material without it, and "
    "run a LimitCase for the load factor with it"
)
_LIFTS = "by which sliding lifts blocks, and nothing says how far: give a joint material without it, which resists less"
#: Joint properties that motions refuse: neutral value, unit, and reason with the remedy.
_UNKNOWN_PROPERTIES = {
    "cohesion": (0.0, "Pa", _PARTS),
    "tensile_strength": (0.0, "Pa", _PARTS),
    "dilatancy_angle": (0.0, "rad", _LIFTS),
}
#: Ties that motions refuse: reason with the remedy.
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


def check_moving_case(model: Model, case: MovingCase) -> None:
    """Refuse models and cases that finite displacements do not support.

    Raises
    ------
    UnknownNameError
        If the control point is on a block that the model does not have.
    ModelError
        If the control point is on a support or outside its block, if rounded corners crush, or as in
        :func:`check_in_motion`.
    """
    who = label(case)
    if isinstance(case, Pushover):
        _check_control(model, case, who)
    check_in_motion(model, who)
    if not isinstance(case, Pushover) or not case.corner_rounding:
        return
    for joint in (i.joint_material for i in model.interfaces):
        if np.isfinite(joint.compressive_strength):
            msg = (
                f"{who}: joint material {joint.name!r} has a compressive_strength of {joint.compressive_strength:.6g} "
                f"Pa, and corner_rounding is {case.corner_rounding:.6g} m; it is known only where corners are sharp: "
                "give a corner_rounding of 0 m, or a joint material without it"
            )
            raise ModelError(msg)


def check_in_motion(model: Model, who: str) -> None:
    """Refuse models whose motion is not followed, in any case.

    Raises
    ------
    ModelError
        If a block is held in some motions only. If a joint has cohesion, tensile strength, dilatancy, infinite friction
        or a torsion other than at corners. If a tie is prestressed, bonded or a strip.
    """
    rollers = [b.name for b in model.blocks if b.is_roller]
    if rollers:
        msg = (
            f"{who}: {listed(rollers)} held in some motions only, whose axes do not turn with the "
            "block: fix a block that touches the structure with a joint of friction 0, or run a LimitCase"
        )
        raise ModelError(msg)
    for joint in {i.joint_material.name: i.joint_material for i in model.interfaces}.values():
        for name, (none, unit, instead) in _UNKNOWN_PROPERTIES.items():
            value = getattr(joint, name)
            if value != none:
                what = f"joint material {joint.name!r} has a {name} of {value:.6g} {unit}"
                msg = f"{who}: {what}, {instead}"
                raise ModelError(msg)
        if np.isinf(joint.friction_coefficient):
            msg = (
                f"{who}: joint material {joint.name!r} never slides. Blocks "
                "that part and meet again need a finite friction coefficient: give one"
            )
            raise ModelError(msg)
        if joint.torsion is not Torsion.CORNERS:
            msg = (
                f"{who}: joint material {joint.name!r} has the torsion of {joint.torsion}, which goes "
                "with the whole area of a joint: give one with the torsion of corners"
            )
            raise ModelError(msg)
    for tie in model.ties:
        if isinstance(tie, Tie) and tie.prestress == 0:
            continue
        kind = type(tie).__name__
        what = f"has a prestress of {tie.prestress:.6g} N" if isinstance(tie, Tie) else f"is a {kind}"
        msg = f"{who}: tie {tie.name!r} {what}, {_UNKNOWN_TIES[kind]}"
        raise ModelError(msg)


def _check_control(model: Model, case: Pushover, who: str) -> None:
    """Refuse a control point on another block than a free one."""
    name = case.control[0]
    try:
        block = model.block(name)
    except UnknownNameError as error:
        error.add_note(f"at the control point of {who}")
        raise
    if block.fixed:
        msg = f"{who}: control point on support {name!r}, which does not move; give a free block"
        raise ModelError(msg)
    if case.control_point is not None:
        remedy = "give a point of the block, as one of its corners, or another block"
        what = f"{who}: control point"
        check_at_block(what, case.control_point, name, block.shape.vertices, remedy)
