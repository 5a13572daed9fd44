"""Move rigid blocks with mass that touch, rub and strike each other."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import NEGLIGIBLE, SLIGHT, Array, Index
from blockstruct.model import STANDARD_GRAVITY as GRAVITY
from blockstruct.motion.masses import Masses
from blockstruct.motion.nearest import nearest
from blockstruct.solvers.interior_point.schur import OPTIONS
from blockstruct.solvers.step import limited
from blockstruct.statics import MovingStructure, Placement, Worn

#: Loads (B, 6) about the centres of mass in a step of a length, s.
Loads = Callable[[float], Array]

#: Compliance of a contact, in units of ``h² / m`` with the step h and the mass m of the two blocks. Contacts deform by
#: this share of the way that their force moves the blocks in a step, and a bounce decays by 90 % in each step.
COMPLIANCE = 0.01
#: Newton iterations of a step.
ITERATIONS = 200
#: Most halvings of a Newton step, and iterations in which the limits of friction do not follow the normal forces.
HALVINGS, HELD = 8, 2
#: Number of unknowns up to which a dense matrix is faster than a sparse one.
DENSE = 60
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
    cell : (A,) array
        Cells that act.
    system : _System
        Unknowns that the contacts connect.
    """

    ends: Index
    arm: Array
    face: Index
    frame: Array
    friction: Array
    yields: Array
    cell: Index
    system: "_System"


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
    crushed_depth : (C,) array, m
        Depth that each cell has lost.
    """

    placement: Placement
    momentum: Array
    last_step: float
    force: Array
    elongation: Array
    peak_elongation: Array
    crushed_depth: Array


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
    Coulomb's law without dilatancy. The force of a tie follows from its elongation in the same way, up to its capacity,
    and the force of a cell up to its strength. The system is solved by the Newton method of P. Alart, A. Curnier
    (Comput. Methods Appl. Mech. Eng. 92 (1991) 353–375).

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
        self._cells = replace(cells, elastic=COMPLIANCE * time_step**2 * yields * cells.strength)
        self._ties = statics.ties
        centres = self._centres(Placement.of(statics.model))
        #: Anchors (2, M, 3) from the centres of mass, in the axes of the blocks.
        self._anchors = (self._ties.position - centres[self._ties.ends]).transpose(1, 0, 2)

    @property
    def undamaged(self) -> Array:
        """Depths (C,) that cells have lost at first, m."""
        return self._cells.untouched.depth

    def largest_depth(self, motion: Motion) -> float:
        """Return the largest depth that a cell has lost, m, also in part."""
        if not len(self._cells):
            return 0.0
        at = motion.placement
        return float(self._cells.at(at.position, at.rotation, Worn(motion.crushed_depth)).lost.max())

    def contacts(
        self, placement: Placement, depth: Array, reach: float, before: ContactForces
    ) -> tuple[Contacts, Array]:
        """Return the contacts with gaps up to ``reach``, m, and their forces (K, 3) before, by the nearest contact.

        The last of them are cells that act, and all ties. ``depth`` (C,) is the depth that each cell has lost.
        """
        points, gap, level, cell = self._structure.points(placement, reach, self._cells, Worn(depth))
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
        own, force = _turned(R.transpose(0, 1, 3, 2), arm), _turned(points.frame, force)
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
            system=_System(self._slot[ends], len(self._free)),
        )
        return found, force

    def forces(self, motion: Motion, contacts: Contacts) -> ContactForces:
        """Return the forces of the step before on the moved blocks."""
        R, loaded = motion.placement.rotation, motion.force[:, 0] > 0
        first = len(loaded) - len(self._ties)
        loaded[first:] = False
        minus, plus = contacts.ends[:, loaded]
        own = (motion.force[loaded, None] @ contacts.frame[loaded])[:, 0]
        point = self._centres(motion.placement)[plus] + _turned(R[plus], contacts.arm[1, loaded])
        return ContactForces(minus, plus, point, _turned(R[contacts.face[loaded]], own), motion.force[first:, 0])

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
        # A contact that bears its strength gives way without an impact, and so does a cell that a tilted face crushes.
        nearing = -v[:, 0]
        nearing = nearing * (motion.force[:, 0] < strength) * (nearing * self.time_step > tilt)
        h = self._until_impact(h, gap, nearing, contacts.yields[:, 0], float(np.vdot(V, momentum)))
        k = (motion.last_step + h) / 2
        # Points of a block that turns leave its tangent by half of ω × (ω × r) h².
        spin = (before[:, 3:] @ ACROSS).reshape(-1, 3, 3)
        bend = _turned((spin @ spin)[ends], arm)
        way = h**2 / 2 * _turned(frame, bend[1] - bend[0])
        way[:, 0] += gap
        M = len(self._ties)
        if M:
            # Ends that move across a tie lengthen it, too.
            speed = before[ends[:, -M:], :3] - _turned(spin[ends[:, -M:]], arm[:, -M:])
            further = np.linalg.norm(apart[-M:] + h * (speed[1] - speed[0]), axis=1)
            way[-M:, 0] += np.linalg.norm(apart[-M:], axis=1) - h * v[-M:, 0] - further
        # Forces of contacts at rest. A contact that is closed damps the velocity, as if the step were longer.
        resting = -way / compliance
        resting[:, 1:] += motion.force[:, 1:]
        time = h + self.time_step * (gap <= 0)[:, None]
        damping = time / compliance
        acting = loads(h)
        push = momentum / k + acting[free]
        equations = _Equations(system, parts, mass / k, push, self._unit, resting, damping, contacts.friction, strength)
        # At first, contacts are open, stick or slide by the forces before and a share of those at constant velocity.
        share = np.minimum(COMPLIANCE * self.time_step**2 / (k * time), 0.5)
        guess = motion.force + share * (resting - damping * v - motion.force)
        found = equations.solved(V, v, guess)
        if found is None:
            return None
        V, x = found.V, found.x
        twist[free], after[free] = V, _turned(mass, V)
        slipping = (x[:, 0] > 0) * np.einsum("kt,kt->k", found.v[:, 1:], found.v[:, 1:])
        mean = (twist + before) / 2
        placement, longer = self._moved(motion.placement, twist, h), motion.elongation
        if M:
            longer = self._structure.ties(placement).span - self._ties.span
        peak, depth = np.maximum(motion.peak_elongation, longer), motion.crushed_depth
        if len(contacts.cell):
            depth = self._cells.pressed(depth, contacts.cell, placement.position, placement.rotation)
        return Step(
            motion=Motion(placement, after, h, x, longer, peak, depth),
            impulse_time=k,
            twist=twist,
            mean=mean,
            slip=h * float(slipping.max(initial=0.0)) ** 0.5,
            dissipated_energy=-k * float(np.vdot(x, system.relative(parts, mean[free]))),
            kinetic_energy=float(np.vdot(twist, after)) / 2,
            iterations=found.iterations,
            loads=acting,
        )

    def _placed(self, motion: Motion, contacts: Contacts, G: Array) -> "_Placed":
        """Return the contacts at a placement with the centres of mass G (B, 3)."""
        R, ends, ties, c = motion.placement.rotation, contacts.ends, self._ties, contacts.cell
        frame = contacts.frame @ R[contacts.face].transpose(0, 2, 1)
        arm = _turned(R[ends], contacts.arm)
        point = G[ends] + arm
        apart = point[1] - point[0]
        compliance = COMPLIANCE * self.time_step**2 * contacts.yields
        if not len(ties) and not len(c):
            gap = (frame[:, 0] * apart).sum(axis=1)
            return _Placed(frame, arm, apart, gap, compliance, np.array(np.inf), np.array(0.0))
        strength, tilt = np.full(len(frame), np.inf), np.zeros(len(frame))
        if len(c):
            last = len(frame) - len(ties)
            at = slice(last - len(c), last)
            cells = self._cells.at(motion.placement.position, R, Worn(motion.crushed_depth))
            arm[:, at] = cells.point[c] - G[ends[:, at]]
            apart[at] = cells.gap[c, None] * frame[at, 0]
            compliance = np.tile(compliance, 3)
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
        return np.asarray(placement.position + _turned(placement.rotation, self._masses.offset))

    def _moved(self, placement: Placement, twist: Array, h: float) -> Placement:
        """Return the placement after twists (B, 6) about the centres of mass for a time h."""
        G = self._centres(placement) + h * twist[:, :3]
        turned = Placement.at(G, h * twist[:, 3:]).rotation @ placement.rotation
        return Placement(G - _turned(turned, self._masses.offset), turned)


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
    compliance : (K, 1 or 3) array, m/N
    strength : (K,) or () array, N
    tilt : (K,) or () array, m
        Tilt of the other face across the width of a cell.
    """

    frame: Array
    arm: Array
    apart: Array
    gap: Array
    compliance: Array
    strength: Array
    tilt: Array


class _Trial(NamedTuple):
    """Velocities in the solution of a step.

    Attributes
    ----------
    V, v : (F, 6) and (K, 3) arrays
        Velocities and relative velocities.
    x, slope : (K, 3) and (K, 3, 3) arrays
        Forces within their limits, and their derivatives to the forces without limits.
    missed : (F, 6) array
        Unbalanced wrenches.
    worst : float
        Largest unbalanced wrench, in its unit.
    iterations : int
        Linear systems so far.
    """

    V: Array
    v: Array
    x: Array
    slope: Array
    missed: Array
    worst: float
    iterations: int


class _System:
    """Unknowns of free blocks, and the contacts that connect two free blocks, or a free block and a support.

    Parameters
    ----------
    ends : (2, K) array
        Places of the blocks of each contact among the free ones: minus and plus; −1 for a support.
    F
        Number of free blocks.
    """

    def __init__(self, ends: Index, F: int) -> None:
        K, held = ends.shape[1], ends < 0
        # A support has the unknowns of the other block, without an effect.
        ends = np.where(held, ends[::-1], ends).T
        self._sign = (np.array([-1.0, 1.0]) * ~held.T).repeat(6, axis=1)[:, None]
        self._unknown = (6 * ends[:, :, None] + np.arange(6)).reshape(K, 12)
        self._size, self._dense = 6 * F, 6 * F <= DENSE
        rows, columns = np.broadcast_arrays(ends[:, :, None], ends[:, None])
        place = np.arange(F) if self._dense else _order(rows.ravel(), columns.ravel(), F)
        self._place, self._order = place, np.argsort(place)
        code = np.concatenate([(place[columns] * F + place[rows]).ravel(), place * (F + 1)])
        blocks, number = np.unique(np.append(code, np.arange(F**2) if self._dense else []), return_inverse=True)
        # Blocks are in the order of columns, and so are the entries of the matrix.
        column, row = (part.astype(np.int64) for part in np.divmod(blocks, F))
        first = np.searchsorted(column, np.arange(F + 1))
        height, i = 6 * np.diff(first), np.arange(6)[:, None]
        start = 30 * first[column] + 6 * np.arange(len(blocks))
        entries = start[:, None, None] + height[column, None, None] * i.T + i
        self._of_contacts = entries[number[: 4 * K].reshape(K, 2, 2)].transpose(0, 1, 3, 2, 4).ravel()
        self._of_blocks = entries[number[4 * K : 4 * K + F]].ravel()
        self._rows = np.empty(entries.size, dtype=np.int32)
        self._rows[entries] = 6 * row[:, None, None] + i
        self._starts = np.append(0, np.repeat(height, 6).cumsum()).astype(np.int32)

    def parts(self, frame: Array, turning: Array) -> Array:
        """Return the derivatives (K, 3, 12) of relative velocities to the velocities of the minus and the plus block.

        ``turning`` (2, K, 3, 3) are the derivatives to the angular velocities, without the sign.
        """
        return np.asarray(np.concatenate([frame, turning[0], frame, turning[1]], axis=2) * self._sign)

    def relative(self, parts: Array, V: Array) -> Array:
        """Return the relative velocities (K, 3), plus block minus minus block, for velocities (F, 6)."""
        return _turned(parts, V.ravel()[self._unknown])

    def wrench(self, parts: Array, x: Array) -> Array:
        """Return the wrenches (F, 6) of contact forces (K, 3)."""
        onto = (x[:, None] @ parts).ravel()
        return np.asarray(np.bincount(self._unknown.ravel(), onto, self._size).reshape(-1, 6), dtype=np.float64)

    def solved(self, parts: Array, M: Array, weights: Array, b: Array) -> Array:
        """Return the solution (F, 6) of ``M + Jᵀ D J`` with the weights D (K, 3, 3) and the right-hand side (F, 6)."""
        stiffness = parts.transpose(0, 2, 1) @ (weights @ parts)
        # Without contacts, numpy counts in integers.
        data = np.asarray(np.bincount(self._of_contacts, stiffness.ravel(), len(self._rows)), dtype=np.float64)
        data[self._of_blocks] += M.ravel()
        if self._dense:
            return np.asarray(np.linalg.solve(data.reshape(self._size, -1).T, b.ravel()).reshape(-1, 6))
        S = sp.csc_matrix((data, self._rows, self._starts), shape=(self._size, self._size))
        lu = sp.linalg.splu(S, permc_spec="NATURAL", diag_pivot_thresh=0, options=OPTIONS)
        return np.asarray(lu.solve(b[self._order].ravel()).reshape(-1, 6)[self._place])


def _order(rows: Index, columns: Index, F: int) -> Index:
    """Return the places (F,) of blocks in an order that keeps factors of the matrix sparse."""
    pattern = sp.csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(F, F))
    dominant = pattern + sp.diags_array(1 + np.ravel(pattern.sum(axis=0))).tocsc()
    return np.asarray(sp.linalg.splu(sp.csc_matrix(dominant), permc_spec="MMD_AT_PLUS_A", options=OPTIONS).perm_c)


@dataclass(frozen=True, slots=True)
class _Equations:
    """Equations of motion of a step.

    Attributes
    ----------
    system : _System
    parts : (K, 3, 12) array
        As in :meth:`_System.parts`.
    M : (F, 6, 6) array
        Mass matrices by the time of the impulse.
    push : (F, 6) array, N and N·m
        Momentum before by the time of the impulse, and loads.
    unit : (F, 6) array, N and N·m
        Unit of unbalanced wrenches.
    resting, damping : (K, 3) and (K, 1 or 3) arrays, N and N·s/m
        Forces of contacts without limits are ``resting − damping v`` at relative velocities v.
    friction : (K,) array
    strength : (K,) or () array, N
        Largest normal forces.
    """

    system: _System
    parts: Array
    M: Array
    push: Array
    unit: Array
    resting: Array
    damping: Array
    friction: Array
    strength: Array

    def solved(self, V: Array, v: Array, guess: Array) -> "_Trial | None":
        """Return the solution; None if it is not found.

        Parameters
        ----------
        V, v : (F, 6) and (K, 3) arrays
            First velocities and relative velocities.
        guess : (K, 3) array, N
            Forces without limits, by which contacts are open, stick or slide at first.
        """
        x, slope = limited(guess, self.friction, self.strength)
        x = x + _turned(slope, self.resting - self.damping * v - guess)
        trial, least = _Trial(V, v, x, slope, self._missed(V, x), np.inf, 0), np.inf
        try:
            while not trial.worst <= NEGLIGIBLE:
                if trial.iterations > ITERATIONS:
                    return None
                changed = self._changed(trial, least)
                if not changed.worst < least:
                    limit = self.friction * trial.x[:, 0]
                    changed = self._at(trial.V, trial.v, trial.iterations + 1, limit)
                    for _ in range(HELD):
                        changed = self._changed(changed, changed.worst, limit)
                    changed = self._at(changed.V, changed.v, changed.iterations)
                trial, least = changed, min(least, changed.worst)
        except RuntimeError:
            return None
        return trial

    def _changed(self, trial: "_Trial", enough: float, limit: Array | None = None) -> "_Trial":
        """Return the next trial by Newton's method: the share of the change that misses least.

        Shares are halved until the trial misses less than ``enough``, and more than the share before.
        """
        change = self.system.solved(self.parts, self.M, trial.slope * self.damping[:, None], trial.missed)
        relative, count = self.system.relative(self.parts, change), trial.iterations + 1
        best = self._at(trial.V + change, trial.v + relative, count, limit)
        for halving in range(1, HALVINGS + 1):
            if best.worst < enough / 2:
                break
            share = 0.5**halving
            changed = self._at(trial.V + share * change, trial.v + share * relative, count, limit)
            if changed.worst < best.worst:
                best = changed
            elif best.worst < enough:
                break
        return best

    def _at(self, V: Array, v: Array, iterations: int, limit: Array | None = None) -> "_Trial":
        """Return the trial at given velocities, with the given limits of friction (K,) if they wait."""
        free = self.resting - self.damping * v
        x, slope = limited(free, self.friction, self.strength, limit)
        missed = self._missed(V, x)
        return _Trial(V, v, x, slope, missed, float(np.abs(missed / self.unit).max()), iterations)

    def _missed(self, V: Array, x: Array) -> Array:
        return np.asarray(self.push + self.system.wrench(self.parts, x) - _turned(self.M, V))


def _turned(matrices: Array, vectors: Array) -> Array:
    """Return the products (…, r) of matrices (…, r, c) and vectors (…, c)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
