"""Move rigid blocks with mass that touch, rub and strike each other."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from blockstruct.arrays import MOSTLY, NEGLIGIBLE, SLIGHT, Array, Flags, Index
from blockstruct.model import STANDARD_GRAVITY as GRAVITY
from blockstruct.motion.equations import Equations, System, Trial, turned
from blockstruct.motion.masses import Masses
from blockstruct.motion.nearest import nearest
from blockstruct.statics.moved import MovingStructure, Placement
from blockstruct.statics.moving_cells import Crushed

#: Loads (B, 6) about the centres of mass in a step of a length, s.
Loads = Callable[[float], Array]

#: Compliance of a contact, in units of ``h² / m`` with the step h and the mass m of the two blocks. Contacts deform by
#: this share of the way that their force moves the blocks in a step, and a bounce decays by 90 % in each step.
COMPLIANCE = 0.01
#: Shortest part of a step that is divided at an impact, as a share.
SPLIT = 0.05
#: Matrices of the cross product ``r × n`` with the unit vectors r, transposed: (3, 9).
ACROSS = np.cross(np.eye(3)[:, None], np.eye(3)).reshape(3, 9)


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contact points that move with the two blocks, cells of joints that crush, and then the ties.

    A cell is a contact with a strength. Its point moves on its face as the other face is tilted.

    A tie is a contact without friction whose normal points from its end to its start, and whose normal force is its
    tension. Its gap is the elongation that is left before it pulls. Its face and its frame follow from its ends.

    Attributes
    ----------
    ends : (2, K) array
        Blocks: minus and plus. The normal points from minus to plus.
    arm : (2, K, 3) array, m
        Points of the two blocks that touch, or anchors, from their centres of mass, in the axes of each block.
    face : (K,) array
        Block whose face has the normal.
    frame : (K, 3, 3) array
        Normal and two tangents, in the axes of this block.
    friction : (K,) array
    yields : (K, 1) array, 1/kg
        Sum of the inverse masses of the two blocks.
    cell, place : (A,) arrays
        Cells that act, and their places among the contacts.
    system : System
        Unknowns that the contacts connect.
    """

    ends: Index
    arm: Array
    face: Index
    frame: Array
    friction: Array
    yields: Array
    cell: Index
    place: Index
    system: System


@dataclass(frozen=True, slots=True)
class ContactForces:
    """Forces of contacts that are loaded.

    Attributes
    ----------
    minus, plus : (P,) arrays
        Blocks.
    point, force : (P, 3) arrays
        Position, m, and force on the plus block, N, in global axes.
    tie_force : (M,) array, N
        Of all ties.
    """

    minus: Index
    plus: Index
    point: Array
    force: Array
    tie_force: Array


@dataclass(frozen=True, slots=True)
class Motion:
    """Blocks in motion.

    Attributes
    ----------
    placement : Placement
        Positions of the centroids, and rotations.
    momentum : (B, 6) array
        Linear momentum, N·s, and angular momentum about the centre of mass, N·m·s, in the middle of the step before.
        Those of supports are zero.
    last_step : float
        Length of the step before, s; zero at first.
    force : (K, 3) array, N
        Of each contact in the step before: normal, and along the tangents.
    elongation, peak_elongation : (M,) arrays, m
        Of each tie from its length in the model, and the largest so far. A tie that yields keeps the largest one, and
        a tie beyond its limit is broken.
    crushed : Crushed
        Memory of the cells of joints that crush.
    """

    placement: Placement
    momentum: Array
    last_step: float
    force: Array
    elongation: Array
    peak_elongation: Array
    crushed: Crushed


@dataclass(frozen=True, slots=True)
class Step:
    """A step of time.

    Attributes
    ----------
    motion : Motion
        After the step.
    impulse_time : float
        Time for which forces act, s: from the middle of the step before to the middle of this one.
    twist, mean : (B, 6) arrays
        Twists about the centres of mass. Forces do work with the mean of the twists of the step before and this one.
    slip : float
        Largest slip of a loaded contact, m.
    dissipated_energy : float
        Work that contacts and ties take up, J.
    kinetic_energy : float
        J.
    iterations : int
        Linear systems.
    loads : (B, 6) array
        Loads about the centres of mass.
    """

    motion: Motion
    impulse_time: float
    twist: Array
    mean: Array
    slip: float
    dissipated_energy: float
    kinetic_energy: float
    iterations: int
    loads: Array


class Dynamics:
    """Equations of motion of a structure.

        ``M (V − V_0) = h (w + Jᵀ x)``, ``C x + g + h J V = opening``

    The velocities V at the end of a step move the blocks in it: impacts are without bounce, and the energy of a
    motion without friction and impacts is kept in the mean (a step of Verlet's method). Normal forces
    follow from the gap at the end of the step, tangential forces from the slip in it and the force before, with
    Coulomb's law without dilatancy. Where the slip turns, friction opposes its mean in the step. The force of a tie
    follows from its elongation in the same way, up to its capacity, and the force of a cell up to its strength. The
    system is solved by the Newton method of P. Alart, A. Curnier (Comput. Methods Appl. Mech. Eng. 92 (1991) 353–375).

    Parameters
    ----------
    structure
        The blocks, their contacts and their friction.
    masses
        Their masses.
    """

    def __init__(self, structure: MovingStructure, masses: Masses, time_step: float) -> None:
        self.time_step = time_step
        statics = structure.statics
        self._structure, self._masses = structure, masses
        self._free, self._B = statics.free, len(statics.model.blocks)
        #: Place of each block among the free ones; −1 for supports.
        self._slot = np.full(self._B, -1)
        self._slot[self._free] = np.arange(len(self._free))
        mass = masses.mass[statics.free, None]
        #: Mass matrix (F, 6, 6) without rotations, and unit of the unbalanced wrenches (F, 6).
        self._mass = mass[:, :, None] * np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        self._inertia = masses.inertia[statics.free]
        size = masses.size[statics.free, None]
        self._unit = GRAVITY * mass * np.hstack([np.ones_like(size), size]).repeat(3, axis=1)
        self._yield = np.zeros(self._B)
        self._yield[self._free] = 1 / masses.mass[self._free]
        cells = structure.cells(0.0)
        yields = self._yield[cells.owner] + self._yield[cells.other]
        #: Trace of compliance of any contact, times the mass of its two blocks, s².
        self._trace = COMPLIANCE * time_step**2
        self._cells = replace(cells, elastic=self._trace * yields * cells.strength)
        self._ties = statics.ties
        centres = self._centres(Placement.of(statics.model))
        #: Anchors (2, M, 3) from the centres of mass, in the axes of the blocks.
        self._anchors = (self._ties.position - centres[self._ties.ends]).transpose(1, 0, 2)

    @property
    def undamaged(self) -> Crushed:
        """Memory of cells at first."""
        return self._cells.untouched._replace(share=np.full(len(self._cells), np.nan))

    def largest_depth(self, motion: Motion) -> float:
        """Return the largest depth that a cell has lost, m, also in part."""
        if not len(self._cells):
            return 0.0
        at = motion.placement
        return float(self._cells.at(at.position, at.rotation, motion.crushed).lost.max())

    def contacts(
        self, placement: Placement, crushed: Crushed, reach: float, before: ContactForces
    ) -> tuple[Contacts, Array]:
        """Return the contacts with gaps up to ``reach``, m, and their forces (K, 3) before, by the nearest contact.

        Cells that act come after the other contacts, and all ties come last. ``crushed`` is the memory of cells.
        """
        points, gap, level, cell = self._structure.points(placement, reach, self._cells, crushed)
        ends = np.stack([points.minus, points.plus])
        R = placement.rotation[ends]
        face = np.where(level > 0, points.minus, points.plus)
        share = np.stack([-level, 1 - level])[:, :, None]
        arm = points.position + share * gap[:, None] * points.frame[:, 0] - self._centres(placement)[ends]
        force = np.zeros_like(points.position)
        row, at, _ = nearest(
            (before.minus, before.plus),
            (points.minus, points.plus),
            lambda row, at: np.linalg.norm(points.position[at] - before.point[row], axis=1),
        )
        sign = np.where(points.minus[at] == before.minus[row], 1.0, -1.0)
        np.add.at(force, at, sign[:, None] * before.force[row])
        own, force = turned(R.transpose(0, 1, 3, 2), arm), turned(points.frame, force)
        frame, friction = points.frame @ placement.rotation[face], points.friction
        if M := len(self._ties):
            ends = np.concatenate([ends, self._ties.ends.T], axis=1)
            own = np.concatenate([own, self._anchors], axis=1)
            face = np.concatenate([face, self._ties.ends[:, 0]])
            frame = np.concatenate([frame, np.zeros((M, 3, 3))])
            friction = np.concatenate([friction, np.zeros(M)])
            force = np.concatenate([force, before.tie_force[:, None] * np.eye(3)[0]])
        found = Contacts(
            ends=ends,
            arm=own,
            face=face,
            frame=frame,
            friction=friction,
            yields=self._yield[ends].sum(axis=0)[:, None],
            cell=cell,
            place=np.arange(len(gap) - len(cell), len(gap)),
            system=System(self._slot[ends], len(self._free)),
        )
        return found, force

    def forces(self, motion: Motion, contacts: Contacts) -> ContactForces:
        """Return the forces of the step before on the moved blocks."""
        R, loaded = motion.placement.rotation, motion.force[:, 0] > 0
        first = len(loaded) - len(self._ties)
        loaded[first:] = False
        minus, plus = contacts.ends[:, loaded]
        own = (motion.force[loaded, None] @ contacts.frame[loaded])[:, 0]
        point = self._centres(motion.placement)[plus] + turned(R[plus], contacts.arm[1, loaded])
        return ContactForces(minus, plus, point, turned(R[contacts.face[loaded]], own), motion.force[first:, 0])

    def step(self, motion: Motion, contacts: Contacts, loads: Loads, h: float) -> Step | None:
        """Return the state after a step; None without a solution.

        Parameters
        ----------
        motion, contacts
            Before the step.
        loads
            Returns the loads (B, 6) about the centres of mass in a step of a given length, s.
        h
            Length of the step, s. The step ends before or at an impact in it.
        """
        free, ends, system = self._free, contacts.ends, contacts.system
        R, G, momentum = motion.placement.rotation, self._centres(motion.placement), motion.momentum[self._free]
        mass = self._mass.copy()
        mass[:, 3:, 3:] = R[free] @ self._inertia @ R[free].transpose(0, 2, 1)
        before, twist, mean, after = np.zeros((4, self._B, 6))
        V = np.asarray(np.linalg.solve(mass, momentum[:, :, None])[:, :, 0], dtype=np.float64)
        before[free] = V
        frame, arm, apart, gap, compliance, strength, tilt = self._placed(motion, contacts, G)
        parts = system.parts(frame, frame @ (arm @ ACROSS).reshape(2, -1, 3, 3))
        v = system.relative(parts, V)
        unloads = self._unloading(contacts, motion.force[:, 0], gap, compliance[:, 0], strength, h * v[:, 0])
        # A contact that bears its strength gives way without an impact, and so does a cell that a tilted face crushes.
        nearing = -v[:, 0]
        nearing = nearing * (motion.force[:, 0] < strength) * (nearing * self.time_step > tilt)
        h = self._until_impact(h, gap, nearing, contacts.yields[:, 0], float(np.vdot(V, momentum)))
        k = (motion.last_step + h) / 2
        # Points of a block that turns leave its tangent by half of ω × (ω × r) h².
        spin = (before[:, 3:] @ ACROSS).reshape(-1, 3, 3)
        bend = turned((spin @ spin)[ends], arm)
        way = h**2 / 2 * turned(frame, bend[1] - bend[0])
        way[:, 0] += gap
        M = len(self._ties)
        if M:
            # Ends that move across a tie lengthen it, too.
            speed = before[ends[:, -M:], :3] - turned(spin[ends[:, -M:]], arm[:, -M:])
            further = np.linalg.norm(apart[-M:] + h * (speed[1] - speed[0]), axis=1)
            way[-M:, 0] += np.linalg.norm(apart[-M:], axis=1) - h * v[-M:, 0] - further
        # Forces of contacts at rest. A contact that is closed damps the velocity, as if the step were longer.
        resting = -way / compliance
        resting[:, 1:] += motion.force[:, 1:]
        resting[unloads, 0] += motion.force[unloads, 0] + gap[unloads] / compliance[unloads, 0]
        time = h + self.time_step * (gap <= 0)[:, None]
        damping = time / compliance
        acting = loads(h)
        push = momentum / k + acting[free]
        equations = Equations(system, parts, mass / k, push, self._unit, resting, damping, contacts.friction, strength)
        # At first, contacts are open, stick or slide by the forces before and a share of those at constant velocity.
        share = np.minimum(self._trace / (k * time), 0.5)
        guess = motion.force + share * (resting - damping * v - motion.force)
        found = equations.solved(V, v, guess)
        if found is None:
            return None
        turns = _turns(v, found, contacts.friction)
        if turns.any():
            # Friction opposes the mean slip of the step.
            resting[turns, 1:] -= (damping * v[:, 1:])[turns]
            further = replace(equations, resting=resting).continued(found)
            if further is not None and _turns(v, further, contacts.friction)[turns].all():
                found = further
        V, x = found.V, found.x
        twist[free], after[free] = V, turned(mass, V)
        slipping = (x[:, 0] > 0) * np.einsum("kt,kt->k", found.v[:, 1:], found.v[:, 1:])
        mean = (twist + before) / 2
        placement, longer, peak = self._moved(motion.placement, twist, h), motion.elongation, motion.peak_elongation
        if M:
            longer = self._structure.ties(placement).span - self._ties.span
            # A tie breaks only where it yields: its trace of compliance does not count beyond its limit.
            yields = x[-M:, 0] >= strength[-M:]
            grown = np.where(yields, longer, np.minimum(longer, self._ties.elongation_limit))
            peak = np.maximum(peak, grown)
        crushed = motion.crushed
        if len(contacts.cell):
            crushed = self._cells.pressed(crushed, contacts.cell, placement.position, placement.rotation)
        return Step(
            motion=Motion(placement, after, h, x, longer, peak, crushed),
            impulse_time=k,
            twist=twist,
            mean=mean,
            slip=h * float(slipping.max(initial=0.0)) ** 0.5,
            dissipated_energy=-k * float(np.vdot(x, system.relative(parts, mean[free]))),
            kinetic_energy=float(np.vdot(twist, after)) / 2,
            iterations=found.iterations,
            loads=acting,
        )

    def _unloading(
        self, contacts: Contacts, force: Array, gap: Array, compliance: Array, strength: Array, parting: Array
    ) -> Index:
        """Let cells that do not crush in a step deform elastically, and return their places among the contacts.

        The force of such a cell, if it parts by ``parting`` (K,), m, stays below the one that crushes it. This one
        becomes its ``strength`` (K,), and its ``compliance`` (K,) the trace of any contact.
        """
        at = contacts.place
        if not len(at):
            return at
        trace, crushes = self._trace * contacts.yields[at, 0], np.clip(-gap[at] / compliance[at], 0.0, strength[at])
        below = force[at] - parting[at] / trace < crushes
        unloads: Index = at[below]
        strength[unloads], compliance[unloads] = crushes[below], trace[below]
        return unloads

    def _placed(self, motion: Motion, contacts: Contacts, G: Array) -> "_Placed":
        """Return the contacts at a placement with the centres of mass G (B, 3)."""
        R, ends, ties, c = motion.placement.rotation, contacts.ends, self._ties, contacts.cell
        frame = contacts.frame @ R[contacts.face].transpose(0, 2, 1)
        arm = turned(R[ends], contacts.arm)
        point = G[ends] + arm
        apart = point[1] - point[0]
        compliance = self._trace * contacts.yields
        if not len(ties) and not len(c):
            gap = (frame[:, 0] * apart).sum(axis=1)
            return _Placed(frame, arm, apart, gap, compliance, np.array(np.inf), np.array(0.0))
        strength, tilt = np.full(len(frame), np.inf), np.zeros(len(frame))
        if len(c):
            at = contacts.place
            cells = self._cells.at(motion.placement.position, R, motion.crushed)
            arm[:, at] = cells.point[c] - G[ends[:, at]]
            apart[at] = cells.gap[c, None] * frame[at, 0]
            compliance[at, 0] = cells.compliance[c]
            strength[at], tilt[at] = self._cells.strength[c], (cells.tilt * cells.sinks)[c]
        slack = np.zeros(len(frame))
        if M := len(ties):
            # Anchors at the same point define no direction.
            span = np.maximum(np.linalg.norm(apart[-M:], axis=1), 1e-300)
            frame[-M:, 0] = -apart[-M:] / span[:, None]
            # A tie that has yielded pulls with its capacity at the largest elongation.
            peak = motion.peak_elongation
            slack[-M:] = ties.span + np.maximum(peak - compliance[-M:, 0] * ties.capacity, 0.0)
            strength[-M:] = np.where(peak > ties.elongation_limit, 0.0, ties.capacity)
        return _Placed(frame, arm, apart, slack + (frame[:, 0] * apart).sum(axis=1), compliance, strength, tilt)

    def _until_impact(self, h: float, gap: Array, nearing: Array, compliance: Array, energy: float) -> float:
        """Return the time until the first strong impact within a step h."""
        strong = (nearing > GRAVITY * SPLIT * self.time_step) & (nearing**2 > SLIGHT * energy * compliance)
        if not strong.any():
            return h
        first = float((gap[strong] / nearing[strong]).min())
        short = SPLIT * self.time_step
        return min(h, max(first - 1.5 * short, short))

    def _centres(self, placement: Placement) -> Array:
        return np.asarray(placement.position + turned(placement.rotation, self._masses.offset))

    def _moved(self, placement: Placement, twist: Array, h: float) -> Placement:
        """Return the placement after twists (B, 6) about the centres of mass for a time h."""
        G = self._centres(placement) + h * twist[:, :3]
        rotation = Placement.at(G, h * twist[:, 3:]).rotation @ placement.rotation
        return Placement(G - turned(rotation, self._masses.offset), rotation)


def _turns(before: Array, found: Trial, friction: Array) -> Flags:
    """Return the contacts (K,) that slide, and whose slip turns in a step by less than half of itself."""
    old, new = before[:, 1:], found.v[:, 1:]
    speed = np.hypot(*old.T)
    slides = np.hypot(*found.x[:, 1:].T) > (1 - NEGLIGIBLE) * friction * found.x[:, 0]
    across = np.abs(old[:, 0] * new[:, 1] - old[:, 1] * new[:, 0]) > SLIGHT * speed**2
    return np.asarray(slides & across & (np.hypot(*(new - old).T) < MOSTLY * speed))


class _Placed(NamedTuple):
    """Contacts at the beginning of a step.

    Attributes
    ----------
    frame, arm : (K, 3, 3) and (2, K, 3) arrays
        As in :class:`Contacts`, in global axes; arms in m.
    apart : (K, 3) array, m
        From the point of the minus block to the point of the plus block.
    gap : (K,) array, m
        Negative for an overlap, and for ties that pull.
    compliance : (K, 1) array, m/N
    strength : (K,) or () array, N
    tilt : (K,) or () array, m
        Difference of the overlap across a cell: the tilt of the other face times the width.
    """

    frame: Array
    arm: Array
    apart: Array
    gap: Array
    compliance: Array
    strength: Array
    tilt: Array
