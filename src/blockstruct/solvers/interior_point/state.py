"""A state of contact, what it misses, and the step that it belongs to."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from blockstruct.solvers.interior_point.cones import ConeVector

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ContactState:
    """Forces, multipliers, displacements and load factor, non-dimensional.

    Attributes
    ----------
    x : (N,) array
        Contact forces, then the auxiliary variables of crushing.
    y, z : ConeVector
        ``E x + e`` and its multipliers.
    u : (6 F,) array
        Displacements of the step.
    alpha : float
    """

    x: Array
    y: ConeVector
    z: ConeVector
    u: Array
    alpha: float

    def moved(self, d: "ContactState", t: float) -> "ContactState":
        """``self + t d``."""
        return ContactState(
            self.x + t * d.x, self.y + t * d.y, self.z + t * d.z, self.u + t * d.u, self.alpha + t * d.alpha
        )

    def scaled(self, ratio: float) -> "ContactState":
        """The same with displacements in another ratio."""
        return ContactState(self.x, self.y, ratio * self.z, ratio * self.u, self.alpha)

    def backwards(self) -> "ContactState":
        """The opposite direction."""
        return ContactState(-self.x, -1.0 * self.y, -1.0 * self.z, -self.u, -self.alpha)

    def longest_step(self, d: "ContactState") -> float:
        """Largest t for which ``self + t d`` stays inside the cones."""
        return min(self.y.longest_step(d.y), self.z.longest_step(d.z))


@dataclass(frozen=True, slots=True)
class Residuals:
    """What a state misses, and the complementarity gap ``y·z``."""

    equilibrium: Array
    flow: Array
    work: float
    forces: ConeVector
    gap: float

    def scaled(self, share: float) -> "Residuals":
        """A share of them."""
        return Residuals(share * self.equilibrium, share * self.flow, share * self.work, share * self.forces, self.gap)


@dataclass(frozen=True, slots=True)
class ContactSolution:
    """A state, and how far it is from solving its step.

    Attributes
    ----------
    state : ContactState
    unbalanced, incompatible, gap : float
        Largest residual of equilibrium and of forces in the cones; of displacements, relative to the largest; and
        the complementarity gap relative to the work of the step.
    iterations : int
        Factorisations.
    """

    state: ContactState
    unbalanced: float
    incompatible: float
    gap: float
    iterations: int

    def within(self, tolerance: float) -> bool:
        """Whether displacements and gap are within a tolerance, and forces within a tenth of it."""
        return self.unbalanced <= 0.1 * tolerance and self.incompatible <= tolerance and self.gap <= tolerance


@dataclass(frozen=True, slots=True)
class Step:
    """One step: what contacts remember, and the prescribed displacement.

    Attributes
    ----------
    reference : (N,) array
        Forces about which contacts are elastic.
    opening : (N,) array
        Opening before the step, in the rows of normal forces.
    displacement : float or None
        ``w_L·u``; None keeps the load factor.
    load_factor : float
        That which is kept.
    """

    reference: Array
    opening: Array
    displacement: float | None
    load_factor: float = 0.0
