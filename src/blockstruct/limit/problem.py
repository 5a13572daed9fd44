"""One limit case of a model, non-dimensional."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.limit.settlement import Settlement
from blockstruct.limit.ties import Ties
from blockstruct.limit.torsion import UniformTorsion
from blockstruct.model import Case, SettlementCase
from blockstruct.statics import ContactPoints, Statics, magnitude, wrenches
from blockstruct.vocabulary import Flow

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LimitProblem:
    """Equilibrium, loads and strength of one case, non-dimensional.

    Lengths are in multiples of one characteristic length. Forces have local units, so that a pebble is solved and
    certified as exactly as a boulder beside it: the wrench of a block is in multiples of its own dead wrench, a
    contact force in multiples of that of the lighter of its two blocks.

    Attributes
    ----------
    A : (6 F, 3 K) sparse array
        Of a settlement with one more row, the last: :class:`Settlement`.
    w_D, w_L : (6 F,) arrays
        Dead and variable wrenches of the free blocks; of a settlement the variable one is the reaction alone.
    friction, cohesion, tension : (K,) arrays
        Friction coefficient μ, cohesion ``c A_k`` and tensile strength ``f_t A_k``.
    dilatancy : (K,) array
        tan ψ that the case flows with: the friction coefficient if associative, the joint's own otherwise.
    compression : (K,) array
        Compressive strength ``f_c A_k`` of a cell; infinite at corners.
    compliance : (K, 2) array
        Normal and shear compliance of the joint at each contact point, for the loading path; shear is NaN where no
        stiffness was given. Where no joint has one, all are equally stiff per area.
    rectangles : (R, 4) array
        Corners, in turn, of the interfaces that crush as rectangles.
    capacity : (R,) array
        Normal force between their pure tension and their pure compression, ``(f_c + f_t) A``.
    length : float
        Unit of length, m.
    wrench_unit : (F,) array
        Unit of the wrenches of each free block, N.
    force_unit : (K,) array
        Unit of the force at each contact point, N.
    displacement_unit : float
        Unit of displacements along the loading path, m: of the variable load, the mean of its points in its direction,
        with couples at the unit of length; of the supports of a settlement, if they turn at the unit of length from the
        axis. NaN where no joint has a stiffness.
    ties : Ties
        Their prestress is part of the dead wrenches.
    torsion : UniformTorsion
        The interfaces whose torsion is that of uniform pressure.
    settlement : Settlement or None
        The supports that give way, if the case is a settlement.
    load_unit : float
        Unit of the variable load: ``w_L`` is that of the case divided by it.
    is_associative : bool
        Whether joints flow by the normals of their conditions.
    """

    A: sp.csc_array
    w_D: Array
    w_L: Array
    friction: Array
    dilatancy: Array
    cohesion: Array
    tension: Array
    compression: Array
    compliance: Array
    rectangles: NDArray[np.int64]
    capacity: Array
    length: float
    wrench_unit: Array
    force_unit: Array
    displacement_unit: float
    ties: Ties
    torsion: UniformTorsion
    settlement: Settlement | None = None
    load_unit: float = 1.0
    is_associative: bool = False

    @classmethod
    def of(cls, statics: Statics, case: Case) -> Self:
        """Limit problem of a case.

        Raises
        ------
        ModelError
            If the variable load, or the dead load of a settlement, is zero on every free block; a tie is prestressed
            without dead load; supports of a settlement are free blocks, or carry nothing.
        UnknownNameError
            If a load acts on a block, or a settlement is one of a support, that the model does not have.
        """
        settles = isinstance(case, SettlementCase)
        scale = np.repeat([1.0, statics.length], 3)
        dead = wrenches(statics.model, case.dead, case.dead)[statics.free] / scale
        driving = dead if settles else wrenches(statics.model, case.patterns[-1], case.dead)[statics.free] / scale
        if not driving.any():
            kind, load = ("settlement", "dead") if settles else ("limit", "variable")
            msg = (
                f"{kind} case {case.name!r}: the {load} load {case.patterns[-1].name!r} is zero on every free block; "
                "give it loads that act and do not cancel, and blocks of weight above zero if it is mass-proportional"
            )
            raise ModelError(msg)
        if statics.ties.prestress.any() and not dead.any():
            msg = (
                f"limit case {case.name!r}: ties have a prestress, but the dead load {case.dead.name!r}, with which it "
                "acts, is zero; give the loads that act in full"
            )
            raise ModelError(msg)
        variable = np.zeros_like(dead) if settles else driving
        governing = np.linalg.norm(dead if dead.any() else variable, axis=1)
        # Blocks without load of their own count as average ones.
        wrench_unit = np.where(governing > 0, governing, governing[governing > 0].mean())

        points = statics.points
        unit_of_block = np.full(len(statics.model.blocks), np.inf)
        unit_of_block[statics.free] = wrench_unit
        force_unit = np.minimum(unit_of_block[points.minus], unit_of_block[points.plus])
        ties = Ties.of(statics.ties, statics.tie_columns, wrench_unit, unit_of_block)
        rows, columns = sp.diags_array(np.repeat(1 / wrench_unit, 6)), sp.diags_array(np.repeat(force_unit, 3))
        compliance, work_unit = _compliance(points, force_unit)
        of_rectangle = points.rectangles[:, 0]
        strength = (points.strength * points.area)[points.interface[of_rectangle]]
        strength = strength + points.tension[points.rectangles].sum(axis=1)
        problem = cls(
            A=sp.csc_array(rows @ statics.A @ columns),
            w_D=(dead / wrench_unit[:, None]).ravel() + ties.columns @ ties.prestress_D,
            w_L=(variable / wrench_unit[:, None]).ravel(),
            friction=points.friction,
            dilatancy=points.friction if case.flow is Flow.ASSOCIATIVE else points.dilatancy,
            cohesion=points.cohesion / force_unit,
            tension=points.tension / force_unit,
            compression=points.compression / force_unit,
            compliance=compliance,
            rectangles=points.rectangles,
            capacity=strength / force_unit[of_rectangle],
            length=statics.length,
            wrench_unit=wrench_unit,
            force_unit=force_unit,
            displacement_unit=work_unit,
            ties=ties,
            torsion=UniformTorsion.of(points),
            is_associative=case.flow is Flow.ASSOCIATIVE,
        )
        if isinstance(case, SettlementCase):
            return problem.releasing(Settlement.of(statics, case, wrench_unit))
        if np.isfinite(work_unit):
            size = magnitude(statics.model, case.patterns[-1], case.dead, statics.free, statics.length)
            return replace(problem, displacement_unit=work_unit / size)
        return problem

    def releasing(self, settlement: Settlement) -> Self:
        """The same joints and dead load, with supports that give way and their reaction as the variable load."""
        row = sp.csc_array((settlement.row * np.repeat(self.force_unit, 3) / settlement.force)[None])
        of_ties = settlement.tie_row * self.ties.force_unit / settlement.force
        reaction, force = np.zeros(self.A.shape[0] + 1), settlement.reaction_unit
        force = force / self.length if settlement.rotates else force
        reaction[-1] = force / settlement.force
        return replace(
            self,
            A=sp.csc_array(sp.vstack([self.A, row])),
            w_D=np.append(self.w_D, of_ties @ self.ties.prestress_D),
            w_L=reaction,
            displacement_unit=self.displacement_unit / force,
            ties=replace(self.ties, columns=sp.csc_array(sp.vstack([self.ties.columns, sp.csc_array(of_ties[None])]))),
            settlement=settlement,
        )

    @property
    def at_unit_load(self) -> Self:
        """The same problem with a variable load as large as the dead load of the blocks that it acts on.

        A multiple of the variable load gives the same problem, so that the procedure does not depend on its unit. The
        reaction of a settlement has a unit of its own.
        """
        if self.settlement is not None:
            return self
        size = _magnitudes(self.w_L) * self.wrench_unit
        unit = float(size.sum() / self.wrench_unit[size > 0].sum())
        return replace(
            self,
            w_L=self.w_L / unit,
            displacement_unit=self.displacement_unit * unit,
            load_unit=self.load_unit * unit,
        )

    @property
    def without_crushing(self) -> Self:
        """The same problem with rectangles that do not crush."""
        return replace(self, rectangles=self.rectangles[:0], capacity=self.capacity[:0])

    @property
    def held(self) -> Self:
        """The same problem with its supports held: without the row of a settlement, and without variable load."""
        if self.settlement is None:
            return self
        ties = replace(self.ties, columns=self.ties.columns[:-1])
        return replace(self, A=self.A[:-1], w_D=self.w_D[:-1], w_L=self.w_L[:-1], ties=ties, settlement=None)

    @property
    def groups(self) -> NDArray[np.int64]:
        """Which group each free block belongs to, (F,): groups touch each other nowhere, and share supports alone."""
        # Loaded here: it is slow to import.
        from scipy.sparse.csgraph import connected_components

        touches = self._touches
        return np.asarray(connected_components(touches @ touches.T, directed=False)[1], dtype=np.int64)

    @property
    def _touches(self) -> sp.csr_array:
        """Which free blocks each contact point and each tie acts on, (F, K + M)."""
        wrenches = sp.coo_array(sp.hstack([self.A, self.ties.columns]))
        row, column = wrenches.coords
        K = self.n_points
        of = np.where(column < 3 * K, column // 3, column - 2 * K)
        shape = (self.n_blocks, K + len(self.ties))
        return sp.csr_array((np.ones(len(row)), (row // 6, of)), shape=shape)

    def points_of(self, blocks: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether each contact point, (K,), acts on some of the free blocks, (F,)."""
        return np.asarray(self._touches[blocks].sum(axis=0))[: self.n_points] > 0

    def part(self, blocks: NDArray[np.bool_]) -> Self:
        """The problem of whole groups of free blocks, (F,), of one whose supports are held."""
        acts = np.asarray(self._touches[blocks].sum(axis=0)) > 0
        points, ties, rows = acts[: self.n_points], acts[self.n_points :], np.repeat(blocks, 6)
        number = np.cumsum(points) - 1
        rectangles = points[self.rectangles[:, 0]]
        joints = np.zeros(len(self.torsion), dtype=bool)
        joints[self.torsion.owner] = points[self.torsion.point]
        torsion = self.torsion.part(joints)
        return replace(
            self,
            A=sp.csc_array(self.A[rows][:, np.repeat(points, 3)]),
            w_D=self.w_D[rows],
            w_L=self.w_L[rows],
            friction=self.friction[points],
            dilatancy=self.dilatancy[points],
            cohesion=self.cohesion[points],
            tension=self.tension[points],
            compression=self.compression[points],
            compliance=self.compliance[points],
            rectangles=number[self.rectangles[rectangles]],
            capacity=self.capacity[rectangles],
            wrench_unit=self.wrench_unit[blocks],
            force_unit=self.force_unit[points],
            ties=self.ties.part(rows, ties),
            torsion=replace(torsion, point=number[torsion.point]),
        )

    def released(self, u: Array) -> Array:
        """Velocities of the held problem with those of supports at rest."""
        return u if self.settlement is None else np.append(u, 0.0)

    @property
    def n_points(self) -> int:
        """Number K of contact points."""
        return len(self.friction)

    @property
    def n_blocks(self) -> int:
        """Number F of free blocks."""
        return len(self.wrench_unit)

    @property
    def crushes(self) -> NDArray[np.bool_]:
        """Whether the joint crushes, at each contact point, (K,)."""
        mask = np.isfinite(self.compression)
        mask[self.rectangles] = True
        return mask

    def beyond_tension(self, n: Array) -> Array:
        """``n_k + f_t A_k`` at the corners of rectangles, (R, 4), of normal forces (K,)."""
        return np.asarray((n + self.tension)[self.rectangles])

    @property
    def is_plain(self) -> bool:
        """Whether joints have friction and nothing else: no strength, no crushing, no torsion, and no ties."""
        more = self.cohesion.any() or self.tension.any() or self.crushes.any()
        return not (more or len(self.torsion) or len(self.ties))

    @property
    def dead_load_alone(self) -> Self:
        """The same joints and ties under a share ρ of the dead load alone: ``A x + ρ w_D = 0``, ``w_D·u = 1``.

        Supports that give way are held.
        """
        own = self.held
        return replace(own, w_D=np.zeros_like(own.w_D), w_L=own.w_D, ties=own.ties.with_variable_load)

    @property
    def associated(self) -> Self:
        """The same problem with associative flow."""
        return replace(self, dilatancy=self.friction, is_associative=True)

    def unbalanced(self, x: Array, T: Array, alpha: float) -> Array:
        """``A x + Σ a_j T_j + w_D + α w_L`` of contact forces (K, 3) and tie forces (M,)."""
        beyond = T - self.ties.prestress(alpha)
        return np.asarray(self.A @ x.ravel() + self.ties.columns @ beyond + self.w_D + alpha * self.w_L)

    def slip(self, v: Array, n: Array) -> Array:
        """Rate at which each contact point slides, (K,), at relative velocities (K, 3) and normal forces (K,).

        It is ``‖v_t‖`` but in the interfaces of :attr:`torsion`.
        """
        return self.torsion.slip(v, self.cohesion + self.friction * n)

    def work_scale(self, u: Array) -> float:
        """Size of the work of the dead load in a mechanism, in units of the load factor: ``Σ |w_D| |u|``.

        Without dead load it is that of the variable load. Where supports give way it is at least that of the heaviest
        block that touches them, or hangs on them by a tie, moved along: if no block follows, the dead load does no
        work, and the reaction is none.
        """
        w = self.w_D if self.w_D.any() else self.w_L
        of_blocks = float(_magnitudes(w) @ _magnitudes(u))
        if self.settlement is None:
            return of_blocks
        at_joints = np.linalg.norm(self.settlement.row.reshape(-1, 3), axis=1) * self.force_unit
        at_ties = np.abs(self.settlement.tie_row) * self.ties.force_unit
        touching = float(np.append(at_joints, at_ties).max() / self.settlement.force)
        return max(of_blocks, touching * abs(float(u[-1])))

    def speed(self, v: Array, u: Array) -> float:
        """Largest velocity that tells whether something moves: of the joints, or of supports that give way."""
        of_joints = float((np.linalg.norm(v, axis=1) / self.force_unit).max())
        if self.settlement is None:
            return of_joints
        return float(np.maximum(of_joints, abs(u[-1]) / self.settlement.force * self.settlement.speed))

    def fastest(self, u: Array) -> float:
        """Largest velocity of the centroid of a block, in the unit of :meth:`speed`."""
        return float((np.linalg.norm(u.reshape(-1, 6)[:, :3], axis=1) / self.wrench_unit).max())

    @property
    def answer(self) -> str:
        """What the case asks for, in words."""
        return "load factor" if self.settlement is None else "reaction"

    def said(self, alpha: float) -> str:
        """A load factor in words; of a settlement, the reaction."""
        if self.settlement is None:
            return f"load factor {alpha:.6g}"
        return f"reaction {self.settlement.reaction(np.array(alpha)):.6g} {'N·m' if self.settlement.rotates else 'N'}"


def _compliance(points: ContactPoints, force_unit: Array) -> tuple[Array, float]:
    """Compliances (K, 2) of median one, and the work that is their unit, J."""
    normal, shear = points.normal_stiffness, points.shear_stiffness
    given = np.isfinite(normal)
    # Beside joints that give way, those without a stiffness are as stiff as the stiffest.
    normal = np.where(given, normal, normal[given].max(initial=1.0 if not given.any() else 0.0))
    soft = np.column_stack([1 / normal, np.where(given & np.isfinite(shear), 1 / shear, np.nan)])
    compliance = soft * (force_unit**2 / points.tributary_area)[:, None]
    unit = float(np.median(compliance[:, 0]))
    return compliance / unit, unit if given.any() else np.nan


def total(w: Array) -> float:
    """Sum of the magnitudes of the wrenches of all blocks."""
    return float(_magnitudes(w).sum())


def _magnitudes(w: Array) -> Array:
    """Of six rows a block, and of the one of a settlement after them."""
    of_blocks = len(w) // 6 * 6
    return np.concatenate([np.linalg.norm(w[:of_blocks].reshape(-1, 6), axis=1), np.abs(w[of_blocks:])])
