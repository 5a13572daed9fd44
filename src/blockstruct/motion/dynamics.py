"""Move rigid blocks with mass that touch, rub and strike each other."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Index
from blockstruct.model import STANDARD_GRAVITY as GRAVITY
from blockstruct.motion.masses import Masses
from blockstruct.motion.nearest import nearest
from blockstruct.solvers.step import limited
from blockstruct.statics import MovingStructure, Placement

#: Loads (B, 6) about the centres of mass in a step of a length, s.
Loads = Callable[[float], Array]

#: Compliance of a contact, in units of ``h² / m`` with the step h and the mass m of the two blocks. Contacts deform by
#: this share of the way that their force moves the blocks in a step, and a bounce decays by 90 % in each step.
COMPLIANCE = 0.01
#: Newton iterations of a step, and the unbalanced wrench of a solution relative to the weight of each block.
ITERATIONS, SOLVED = 100, 1e-7
#: Iterations after which changes are halved, because contacts change their state to and fro, and so is the effect of
#: normal forces on the limits of friction.
PATIENCE, LEAST = 8, 0.1
#: Number of unknowns up to which a dense matrix is faster than a sparse one.
DENSE = 60
#: Energy of an impact, relative to the energy of the motion, from which a step ends at the impact. Shortest part of a
#: divided step, as a share.
IMPACT, SPLIT = 1e-3, 0.05


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contact points that move with the two blocks.

    Attributes
    ----------
    minus, plus : (K,) arrays
        Blocks; the normal points from minus to plus.
    on_minus, on_plus : (K, 3) arrays, m
        Points of the two blocks that touch, from their centres of mass, in the axes of each block.
    minus_lever, plus_lever : (K, 3, 3) arrays, m
        Matrices from a row of force to its moment, in the same axes.
    frame : (K, 3, 3) array
        Normal and two tangents, in the axes of the minus block.
    friction : (K,) array
    force : (K, 3) array, N
        In the step before: normal, and along the tangents.
    """

    minus: Index
    plus: Index
    on_minus: Array
    on_plus: Array
    minus_lever: Array
    plus_lever: Array
    frame: Array
    friction: Array
    force: Array


@dataclass(frozen=True, slots=True)
class ContactForces:
    """Forces of contacts that are loaded.

    Attributes
    ----------
    minus, plus : (P,) arrays
        Blocks.
    point, force : (P, 3) arrays
        Position, m, and force on the plus block, N, in global axes.
    """

    minus: Index
    plus: Index
    point: Array
    force: Array


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
    """

    placement: Placement
    momentum: Array
    last_step: float


@dataclass(frozen=True, slots=True)
class Step:
    """A step of time.

    Attributes
    ----------
    motion : Motion
        After the step.
    contacts : Contacts
        The same, with their forces.
    forces : ContactForces
    impulse_time : float
        Time for which forces act, s: from the middle of the step before to the middle of this one.
    twist, mean : (B, 6) arrays
        Twists about the centres of mass. Forces do work with the mean of the twists of the step before and this one.
    dissipated_energy : float
        Work that contacts take up, J.
    kinetic_energy : float
        J.
    iterations : int
        Linear systems.
    loads : (B, 6) array
        Loads about the centres of mass.
    """

    motion: Motion
    contacts: Contacts
    forces: ContactForces
    impulse_time: float
    twist: Array
    mean: Array
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
    Coulomb's law without dilatancy. The system is solved by the Newton method of P. Alart, A. Curnier (Comput.
    Methods Appl. Mech. Eng. 92 (1991) 353–375).

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
        #: Place of each block among the free ones. Supports have the place after the last.
        self._slot = np.full(self._B, len(self._free))
        self._slot[self._free] = np.arange(len(self._free))
        mass = masses.mass[statics.free, None]
        #: Mass matrix (F, 6, 6) without rotations, and unit of the unbalanced wrenches (6 F,).
        self._mass = mass[:, :, None] * np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        size = masses.size[statics.free, None]
        self._scale = (GRAVITY * mass * np.hstack([np.ones_like(size), size]).repeat(3, axis=1)).ravel()
        self._yield = np.zeros(self._B)
        self._yield[self._free] = 1 / masses.mass[self._free]

    def contacts(self, placement: Placement, reach: float, before: ContactForces) -> Contacts:
        """Return the contacts with gaps up to ``reach``, m, with the forces before at the nearest contact of each."""
        points, gap = self._structure.points(placement, reach)
        R, G = placement.rotation, self._centres(placement)
        half = gap[:, None] / 2 * points.frame[:, 0]
        on_minus, on_plus = (
            np.einsum("kji,kj->ki", R[block], points.position + side - G[block])
            for block, side in ((points.minus, -half), (points.plus, half))
        )
        frame = points.frame @ R[points.minus]
        force = np.zeros_like(points.position)
        row, at, _ = nearest(
            (before.minus, before.plus),
            (points.minus, points.plus),
            lambda row, at: np.linalg.norm(points.position[at] - before.point[row], axis=1),
        )
        sign = np.where(points.minus[at] == before.minus[row], 1.0, -1.0)
        np.add.at(force, at, sign[:, None] * before.force[row])
        force = _turned(points.frame, force)
        levers = np.cross(on_minus[:, None], np.eye(3)), np.cross(on_plus[:, None], np.eye(3))
        return Contacts(points.minus, points.plus, on_minus, on_plus, *levers, frame, points.friction, force)

    def step(self, motion: Motion, contacts: Contacts, loads: Loads, h: float, *, whole: bool = False) -> Step | None:
        """Return the state after a step; None without a solution.

        Parameters
        ----------
        motion, contacts
            Before the step.
        loads
            Returns the loads (B, 6) about the centres of mass in a step of a given length, s.
        h
            Length of the step, s. The step ends before or at an impact in it.
        whole
            Whether the step does not end at impacts.
        """
        free, m = self._free, self._masses
        R, G = motion.placement.rotation, self._centres(motion.placement)
        i, j = contacts.minus, contacts.plus
        J = R[free] @ m.inertia[free] @ R[free].transpose(0, 2, 1)
        M = self._mass.copy()
        M[:, 3:, 3:] = J
        before = np.linalg.solve(M, motion.momentum[free, :, None])[:, :, 0]
        frame = contacts.frame @ R[i].transpose(0, 2, 1)
        arm_i, arm_j = _turned(R[i], contacts.on_minus), _turned(R[j], contacts.on_plus)
        gap = np.einsum("ki,ki->k", frame[:, 0], G[j] + arm_j - G[i] - arm_i)
        relative = self._relative(contacts, frame, R)
        yields = self._yield[i] + self._yield[j]
        if not whole:
            nearing = -(relative @ before.ravel())[::3]
            h = self._until_impact(h, gap, nearing, yields, float((before * motion.momentum[free]).sum()))
        k = (motion.last_step + h) / 2
        # Points of a block that turns leave its tangent by half of ω × (ω × r) h².
        bend, omega = np.zeros((self._B, 3, 3)), before[:, 3:]
        bend[free] = omega[:, :, None] * omega[:, None] - (omega**2).sum(axis=1)[:, None, None] * np.eye(3)
        way = h**2 / 2 * _turned(frame, _turned(bend[j], arm_j) - _turned(bend[i], arm_i))
        way[:, 0] += gap
        compliance = COMPLIANCE * self.time_step**2 * yields
        # A contact that is closed damps the velocity, as if the step were longer.
        time = h + np.where(gap <= 0, self.time_step, 0.0)
        law = _Law(contacts, way, time, compliance, 1 / np.maximum(time * k * yields, 2 * compliance), GRAVITY / yields)
        acting = loads(h)
        push = (motion.momentum[free] / k + acting[free]).ravel()
        found = _newton(M / k, relative, push, law, np.asarray(before.ravel(), dtype=np.float64), self._scale)
        if found is None:
            return None
        V, x, iterations = found
        twist, mean, momentum = np.zeros((3, self._B, 6))
        twist[free] = V.reshape(-1, 6)
        mean[free] = (twist[free] + before) / 2
        momentum[free] = _turned(M, twist[free])
        work = float(x.ravel() @ (relative @ mean[free].ravel()))
        loaded = x[:, 0] > 0
        force = np.einsum("kai,ka->ki", frame[loaded], x[loaded])
        return Step(
            motion=Motion(self._moved(motion.placement, twist, h), momentum, h),
            contacts=replace(contacts, force=x),
            forces=ContactForces(i[loaded], j[loaded], (G[j] + arm_j)[loaded], force),
            impulse_time=k,
            twist=twist,
            mean=mean,
            dissipated_energy=-k * work,
            kinetic_energy=float((twist * momentum).sum()) / 2,
            iterations=iterations,
            loads=acting,
        )

    def _relative(self, contacts: Contacts, frame: Array, R: Array) -> Any:
        """Return the matrix (3 K, 6 F) of the relative velocities of contacts, plus block minus minus block."""
        F, K = len(self._free), len(frame)
        of_minus, of_plus = (
            frame @ R[block] @ lever @ R[block].transpose(0, 2, 1)
            for block, lever in ((contacts.minus, contacts.minus_lever), (contacts.plus, contacts.plus_lever))
        )
        parts = np.concatenate([-frame, -of_minus, frame, of_plus], 2)
        ends = self._slot[np.column_stack([contacts.minus, contacts.plus])]
        # The columns of supports are last, and left out.
        if 6 * F <= DENSE:
            dense = np.zeros((K, 3, F + 1, 6))
            for side in (0, 1):
                dense[np.arange(K), :, ends[:, side]] = parts[:, :, 6 * side : 6 * side + 6]
            return np.asarray(dense[:, :, :F].reshape(3 * K, 6 * F))
        columns = np.repeat((6 * ends[:, :, None] + np.arange(6)).reshape(K, 12), 3, axis=0)
        shape = (3 * K, 6 * F + 6)
        full = sp.csr_array((parts.ravel(), columns.ravel(), 12 * np.arange(3 * K + 1)), shape=shape)
        return sp.csr_array(full[:, : 6 * F])

    def _until_impact(self, h: float, gap: Array, nearing: Array, compliance: Array, energy: float) -> float:
        """Return the time until the first strong impact within a step h."""
        strong = (nearing > GRAVITY * SPLIT * self.time_step) & (nearing**2 > IMPACT * energy * compliance)
        time = gap[strong] / nearing[strong]
        first = float(time.min(initial=np.inf))
        short = SPLIT * self.time_step
        return min(h, max(first - 1.5 * short, short))

    def _centres(self, placement: Placement) -> Array:
        return np.asarray(placement.position + _turned(placement.rotation, self._masses.offset))

    def _moved(self, placement: Placement, twist: Array, h: float) -> Placement:
        """Return the placement after twists (B, 6) about the centres of mass for a time h."""
        G = self._centres(placement) + h * twist[:, :3]
        turned = Placement.at(G, h * twist[:, 3:]).rotation @ placement.rotation
        return Placement(G - _turned(turned, self._masses.offset), turned)


@dataclass(frozen=True, slots=True)
class _Law:
    """Forces of contacts: ``x = P(x + ρ C (x_0 − x) − ρ (g + t v))`` with the projection P onto their cones.

    Attributes
    ----------
    contacts : Contacts
        With the forces before, whose tangential part is ``x_0``.
    way : (K, 3) array, m
        Gap g, and the tangential way that does not follow from velocities.
    time : (K,) array, s
    compliance, rho : (K,) arrays, m/N and N/m
    unit : (K,) array, N
        Of forces that are missed.
    """

    contacts: Contacts
    way: Array
    time: Array
    compliance: Array
    rho: Array
    unit: Array

    def projected(self, x: Array, v: Array) -> tuple[Array, Array, float]:
        """Return the projection of forces (K, 3) at relative velocities (K, 3), its slope, and the largest change."""
        soft = (self.rho * self.compliance)[:, None]
        tried = (1 - soft) * x - self.rho[:, None] * (self.way + self.time[:, None] * v)
        tried[:, 1:] += soft * self.contacts.force[:, 1:]
        kept, slope = limited(tried, self.contacts.friction)
        return kept, slope, float((np.abs(kept - x) / self.unit[:, None]).max(initial=0.0))

    def linear(self, x: Array, kept: Array, slope: Array) -> tuple[Array, Array]:
        """Return the change of forces (K, 3) at the same velocities, and its derivative to them, negative."""
        local = np.eye(3) - (1 - self.rho * self.compliance)[:, None, None] * slope
        right = np.concatenate([slope * (self.time * self.rho)[:, None, None], (kept - x)[:, :, None]], axis=2)
        found = np.linalg.solve(local, right)
        return found[:, :, 3], found[:, :, :3]


def _newton(M: Array, relative: Any, push: Array, law: _Law, V: Array, scale: Array) -> tuple[Array, Array, int] | None:
    """Return velocities (6 F,), forces (K, 3) and the number of iterations; None without a solution."""
    x, K = law.contacts.force, len(law.contacts.force)
    blocks = sp.block_diag([sp.coo_array(M[0]), *M[1:]], format="csr") if sp.issparse(relative) else _diagonal(M)
    kept, slope, worst = law.projected(x, (relative @ V).reshape(K, 3))
    for iterations in range(ITERATIONS + 1):
        missed = push + relative.T @ x.ravel() - blocks @ V
        if worst <= SOLVED and np.abs(missed / scale).max() <= SOLVED:
            return V, x, iterations
        if iterations >= PATIENCE:
            slope[:, 1:, 0] /= 2
        change, E = law.linear(x, kept, slope)
        S = blocks + _weighted(relative, E)
        delta = _solved(S, missed + relative.T @ change.ravel())
        if delta is None:
            return None
        change = change - _turned(E, (relative @ delta).reshape(K, 3))
        share, best = 1.0, None
        while True:
            tried = V + share * delta, x + share * change
            judged = law.projected(tried[1], (relative @ tried[0]).reshape(K, 3))
            if best is None or judged[2] < best[1][2]:
                best = tried, judged
            if judged[2] < worst or iterations < PATIENCE or share < LEAST:
                break
            share /= 2
        (V, x), (kept, slope, worst) = best
        if not np.isfinite(worst):
            return None
    return None


def _diagonal(M: Array) -> Array:
    F = len(M)
    full = np.zeros((F, 6, F, 6))
    full[np.arange(F), :, np.arange(F)] = M
    return full.reshape(6 * F, 6 * F)


def _weighted(relative: Any, E: Array) -> Any:
    """Return ``Jᵀ E J`` for the blocks E (K, 3, 3)."""
    K = len(E)
    if isinstance(relative, np.ndarray):
        return np.asarray(relative.T @ (E @ relative.reshape(K, 3, -1)).reshape(3 * K, -1))
    weights = sp.bsr_array((E, np.arange(K), np.arange(K + 1)), shape=(3 * K, 3 * K))
    return relative.T @ (sp.csr_array(weights) @ relative)


def _solved(S: Any, b: Array) -> Array | None:
    if isinstance(S, np.ndarray):
        return np.asarray(np.linalg.solve(S, b))
    try:
        return np.asarray(sp.linalg.splu(sp.csc_array(S), permc_spec="MMD_AT_PLUS_A").solve(b))
    except RuntimeError:
        return None


def _turned(matrices: Array, vectors: Array) -> Array:
    """Return the products (n, r) of matrices (n, r, c) and vectors (n, c)."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])
