"""One limit case of a model, non-dimensional."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.limit.ties import Ties
from blockstruct.model import LimitCase
from blockstruct.statics import ContactPoints, Statics, wrenches
from blockstruct.vocabulary import Flow

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LimitProblem:
    """Equilibrium, loads and strength of one limit case, non-dimensional.

    Lengths are in multiples of one characteristic length. Forces have local units, so that a pebble is solved and
    certified as exactly as a boulder beside it: the wrench of a block is in multiples of its own dead wrench, a
    contact force in multiples of that of the lighter of its two blocks.

    Attributes
    ----------
    A : (6 F, 3 K) sparse array
    w_D, w_L : (6 F,) arrays
        Dead and variable wrenches of the free blocks.
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
        Their strength in pure compression, ``f_c A``.
    length : float
        Unit of length, m.
    wrench_unit : (F,) array
        Unit of the wrenches of each free block, N.
    force_unit : (K,) array
        Unit of the force at each contact point, N.
    displacement_unit : float
        Unit of displacements along the loading path, m; NaN where no joint has a stiffness.
    ties : Ties
        Their prestress is part of the dead wrenches.
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

    @classmethod
    def of(cls, statics: Statics, case: LimitCase) -> Self:
        """Limit problem of a case.

        Raises
        ------
        ModelError
            If the variable load is zero on every free block, or a tie is prestressed without dead load.
        UnknownNameError
            If a load acts on a block that the model does not have.
        """
        scale = np.repeat([1.0, statics.length], 3)
        dead, variable = (
            wrenches(statics.model, p, case.dead)[statics.free] / scale for p in (case.dead, case.variable)
        )
        if not variable.any():
            msg = (
                f"limit case {case.name!r}: the variable load {case.variable.name!r} is zero on every free block; "
                "give it loads that act and do not cancel, and blocks of weight above zero if it is mass-proportional"
            )
            raise ModelError(msg)
        if statics.ties.prestress.any() and not dead.any():
            msg = (
                f"limit case {case.name!r}: ties have a prestress, but the dead load {case.dead.name!r}, with which it "
                "acts, is zero; give the loads that act in full"
            )
            raise ModelError(msg)
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
        return cls(
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
            displacement_unit=work_unit / float(np.linalg.norm(variable, axis=1).sum()),
            ties=ties,
        )

    @property
    def n_points(self) -> int:
        """Number K of contact points."""
        return len(self.friction)

    @property
    def crushes(self) -> NDArray[np.bool_]:
        """Whether the joint crushes, at each contact point, (K,)."""
        mask = np.isfinite(self.compression)
        mask[self.rectangles] = True
        return mask

    @property
    def dead_load_alone(self) -> Self:
        """The same joints and ties under a share ρ of the dead load alone: ``A x + ρ w_D = 0``, ``w_D·u = 1``."""
        return replace(self, w_D=np.zeros_like(self.w_D), w_L=self.w_D, ties=self.ties.with_variable_load)

    def unbalanced(self, x: Array, T: Array, alpha: float) -> Array:
        """``A x + Σ a_j T_j + w_D + α w_L`` of contact forces (K, 3) and tie forces (M,)."""
        beyond = T - self.ties.prestress(alpha)
        return np.asarray(self.A @ x.ravel() + self.ties.columns @ beyond + self.w_D + alpha * self.w_L)

    def work_scale(self, u: Array) -> float:
        """Size of the work of the dead load in a mechanism, in units of the load factor: ``Σ |w_D| |u|``.

        Without dead load it is that of the variable load.
        """
        w = self.w_D if self.w_D.any() else self.w_L
        of_load, of_u = (np.linalg.norm(a.reshape(-1, 6), axis=1) for a in (w, u))
        return float(of_load @ of_u)


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
    return float(np.linalg.norm(w.reshape(-1, 6), axis=1).sum())
