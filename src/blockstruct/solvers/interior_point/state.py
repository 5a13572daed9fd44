"""Define a state of contact, its residuals and its step."""

from dataclasses import dataclass

from blockstruct.arrays import Array
from blockstruct.solvers.interior_point.cones import ConeVector


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
        Load factor.
    """

    x: Array
    y: ConeVector
    z: ConeVector
    u: Array
    alpha: float

    def moved(self, d: "ContactState", t: float) -> "ContactState":
        """Return ``self + t d``."""
        return ContactState(
            self.x + t * d.x, self.y + t * d.y, self.z + t * d.z, self.u + t * d.u, self.alpha + t * d.alpha
        )

    def scaled(self, ratio: float) -> "ContactState":
        """Return the state with multipliers and displacements scaled."""
        return ContactState(self.x, self.y, ratio * self.z, ratio * self.u, self.alpha)

    def backwards(self) -> "ContactState":
        """Return the opposite direction."""
        return ContactState(-self.x, -1.0 * self.y, -1.0 * self.z, -self.u, -self.alpha)

    def longest_step(self, d: "ContactState") -> float:
        """Return the largest t for which ``self + t d`` stays in the cones."""
        return min(self.y.longest_step(d.y), self.z.longest_step(d.z))


@dataclass(frozen=True, slots=True)
class Residuals:
    """Residuals of a state, and the complementarity gap ``y·z``."""

    equilibrium: Array
    flow: Array
    work: float
    forces: ConeVector
    gap: float

    def scaled(self, share: float) -> "Residuals":
        """Return a share of the residuals, with the same gap."""
        return Residuals(share * self.equilibrium, share * self.flow, share * self.work, share * self.forces, self.gap)


@dataclass(frozen=True, slots=True)
class ContactSolution:
    """State with the errors of its step.

    Attributes
    ----------
    state : ContactState
        The state.
    unbalanced, incompatible, gap : float
        Largest residual of equilibrium and of forces in the cones. Largest residual of displacements, relative to the
        largest displacement. Complementarity gap relative to the work of the step.
    iterations : int
        Factorisations.
    """

    state: ContactState
    unbalanced: float
    incompatible: float
    gap: float
    iterations: int

    def within(self, tolerance: float) -> bool:
        """Return whether displacements and gap are within a tolerance.

        Forces must be within a tenth of the tolerance.
        """
        return self.unbalanced <= 0.1 * tolerance and self.incompatible <= tolerance and self.gap <= tolerance


@dataclass(frozen=True, slots=True)
class Step:
    """Data of one step: memory of contacts and prescribed displacement.

    Attributes
    ----------
    reference : (N,) array
        Forces about which contacts are elastic.
    opening : (N,) array
        Opening before the step, in the rows of normal forces.
    displacement : float or None
        ``w_L·u``; None keeps the load factor at zero.
    """

    reference: Array
    opening: Array
    displacement: float | None
