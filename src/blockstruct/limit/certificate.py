"""Certify a collapse state by the measures (19) to (22) of docs/theory.md."""

from dataclasses import dataclass, field, fields

import numpy as np

from blockstruct.arrays import Array, Flags
from blockstruct.limit import crushing
from blockstruct.limit.division import sliding as rates_of_sliding
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.notebook import html_table

#: Name of each of the four measures, and the words around its value.
_JUDGED = {
    "equilibrium_residual": ("equilibrium", "off by at most {} of a block's weight"),
    "yield_excess": ("strength", "exceeded by at most {} of a block's weight, or of the force there if larger"),
    "interpenetration": ("contact", "blocks penetrate by at most {} of the largest motion"),
    "flow_rule_gap": ("flow rule", "missed by {} of the load factor, or of the dead load for a reaction"),
}


@dataclass(frozen=True, slots=True)
class Certificate:
    """Proof of a collapse state (x, u, α) against the true conditions.

    The conditions of any single program do not matter. If all four measures are zero, the state is an exact solution:

    - The forces are in equilibrium and within the strength of every joint.
    - The mechanism is kinematically admissible.
    - The joints dissipate the work of the loads.

    ``print(certificate)`` shows each measure with its tolerance.

    Attributes
    ----------
    equilibrium_residual : float
        ``‖A x + Σ a_j T_j + w_D + α w_L‖∞``, for each block in multiples of its dead wrench.
    yield_excess : float
        Largest violation of a strength condition; negative inside. At joints it is the largest of
        ``‖(s, t)‖ − c A_k − μ n``, ``−f_t A_k − n`` and the excess over crushing. The unit is the dead wrench of the
        lighter of the two blocks, or the local normal force if larger. The local normal force is the force of the
        contact point or of the crushing rectangle.
        At ties it is the violation of ``T0 ≤ T ≤ T_y`` and of the bond. The unit is the unit of force of the tie, or
        the tie force, whichever is larger.
    interpenetration : float
        Largest ``tan ψ ‖v_t‖ − v_n`` at contact points that do not crush, and largest ``‖v_t‖`` at points that never
        slide. Both are relative to the largest relative velocity.
    flow_rule_gap : float
        Work by which the state misses the flow rule, in units of the load factor because ``w_L·u = 1``. It is the sum
        of four parts. Contact points: ``Σ_k |(n + f_t A_k)(v_n − tan ψ ‖v_t‖)| + |(c A_k + μ n) ‖v_t‖ + (s, t)·v_t|``.
        Crushing joints: largest possible dissipation less the actual work. Ties: ``T_y ė`` of yielding ties less their
        work ``T ė``. Equilibrium residual r: ``Σ |u_i r_i|``.
    flow_rule_gap_limit : float
        Gap tolerance of the settings times the load factor, or times a thousandth of the work scale of the mechanism,
        whichever is larger.
    holds : bool
        Whether all four measures are within the tolerances of the settings.
    settings : ProcedureSettings
        Settings with the tolerances.
    """

    equilibrium_residual: float
    yield_excess: float
    interpenetration: float
    flow_rule_gap: float
    flow_rule_gap_limit: float
    holds: bool
    settings: ProcedureSettings = field(repr=False, compare=False)

    @property
    def measures(self) -> dict[str, float | bool]:
        """Numbers that a file stores, and whether the certificate holds."""
        return {name: getattr(self, name) for name in CERTIFICATE_MEASURES}

    @property
    def tolerances(self) -> dict[str, float]:
        """Tolerance of each of the four measures."""
        s = self.settings.numerics
        limits = (s.equilibrium_tolerance, s.yield_tolerance, s.interpenetration_tolerance, self.flow_rule_gap_limit)
        return dict(zip(_JUDGED, limits, strict=True))

    @property
    def is_within_tolerances(self) -> bool:
        """Whether the four measures are within their tolerances.

        A certificate that holds is always within its tolerances.
        """
        # A NaN fails every comparison.
        return all(getattr(self, name) <= limit for name, limit in self.tolerances.items())

    @property
    def is_of_a_state(self) -> bool:
        """Whether there is a state: a program without a solution has NaN measures."""
        return not np.isnan([getattr(self, name) for name in CERTIFICATE_MEASURES]).any()

    @property
    def admissible(self) -> bool:
        """Whether the forces satisfy equilibrium and the true conditions.

        The mechanism does not matter.
        """
        return bool(are_admissible(self.equilibrium_residual, self.yield_excess, self.settings))

    @property
    def verdict(self) -> str:
        """Whether the certificate holds, in words."""
        return f"certificate {'holds' if self.holds else 'does not hold'}"

    def __str__(self) -> str:
        lines = [f"  {name + ':':<13}{text} (tolerance {limit})" for name, text, limit in self.rows]
        return "\n".join([self.verdict, *lines])

    def _repr_html_(self) -> str:
        return html_table(self.verdict, ["", "", "tolerance"], self.rows)

    @property
    def texts(self) -> dict[str, tuple[str, str]]:
        """Each of the four measures and its tolerance, as text to two digits; a strength that is not exceeded is 0."""
        return {
            measure: (_said(max(getattr(self, measure), 0.0)), _said(limit))
            for measure, limit in self.tolerances.items()
        }

    @property
    def rows(self) -> list[tuple[str, str, str]]:
        """Name of each measure, its sentence and its tolerance."""
        rows = [(*_JUDGED[measure], *texts) for measure, texts in self.texts.items()]
        return [(name, sentence.format(value), limit) for name, sentence, value, limit in rows]


def are_admissible(residual: Array | float, excess: Array | float, settings: ProcedureSettings) -> Flags:
    """Return whether forces satisfy equilibrium and the true conditions.

    The arguments are the equilibrium residuals and the yield excesses of states.
    """
    # A NaN fails every comparison, so a state with a NaN is never admissible.
    numerics = settings.numerics
    return np.asarray((residual <= numerics.equilibrium_tolerance) & (excess <= numerics.yield_tolerance))


def _said(value: float) -> str:
    """Return a small number as text to two digits.

    >>> _said(0.0), _said(1e-6), _said(2.5e-4)
    ('0', '1e-06', '2.5e-04')
    """
    return f"{value:.1e}".replace(".0e", "e") if value else "0"


#: Names of the fields of a certificate that a file stores.
CERTIFICATE_MEASURES = tuple(f.name for f in fields(Certificate) if f.name != "settings")


def certify(  # noqa: PLR0913
    problem: LimitProblem,
    x: Array,
    u: Array,
    alpha: float,
    settings: ProcedureSettings,
    T: Array | None = None,
    *,
    gap: Array | float = 0.0,
    slack: Array | float = 0.0,
    speed: float = 0.0,
) -> Certificate:
    """Return the certificate of a state.

    Parameters
    ----------
    problem
        The limit problem, with the dilatancy of the flow rule.
    x : (K, 3) array
        Contact forces (n, s, t).
    u : (6 F,) array
        Velocities with ``w_L·u = 1``.
    alpha
        Load factor.
    settings
        Tolerances.
    T : (M,) array
        Tie forces; needed if the problem has ties.
    gap : (K,) array
        Open distance before the velocities act for a unit of time, in the unit of relative velocities.
    slack : (M,) array
        Elongation before ties pull, in the unit of their rates of elongation.
    speed
        Least reference velocity of interpenetration, for slower contact points.
    """
    T = np.zeros(0) if T is None else T
    biaxial = settings.crushing_interaction == "biaxial"
    unbalanced = problem.unbalanced(x, T, alpha)
    residual = float(np.abs(unbalanced).max())
    v = (problem.A.T @ u).reshape(-1, 3)
    n, v_n = x[:, 0], v[:, 0]
    apart = v_n + gap
    sliding = rates_of_sliding(problem, x, np.column_stack([apart, v[:, 1:]]), biaxial=biaxial)
    resistance = problem.cohesion + problem.friction * n
    corners = problem.rectangles
    beyond_tension = problem.beyond_tension(n)
    beyond_crushing = crushing.excess(beyond_tension, problem.capacity, biaxial=biaxial)
    beyond_prestress = T - problem.ties.prestress(alpha)
    at_point, at_rectangle = np.maximum(n, 1.0), np.maximum(n[corners].sum(axis=1), 1.0)
    excesses = (
        (np.linalg.norm(x[:, 1:], axis=1) - resistance) / at_point,
        (-problem.tension - n) / at_point,
        (n - problem.compression) / at_point,
        beyond_crushing / at_rectangle,
        problem.ties.excess(beyond_prestress, T),
        problem.torsion.excess(x, resistance) / np.maximum(problem.torsion.total(n), 1.0),
    )
    # Unlike the built-in max, numpy propagates a NaN.
    every = np.concatenate(excesses)
    excess = float(every.max()) if len(every) else 0.0
    opening = apart - problem.dilatancy * sliding
    rigid = ~problem.crushes
    # Velocities have local units of force; penetration is relative to the fastest point.
    largest = max(problem.speed(v, u), speed)
    never = problem.never_slides
    penetration = (-opening / problem.force_unit)[rigid].max(initial=0.0)
    penetration = np.maximum(penetration, (sliding / problem.force_unit)[never].max(initial=0.0))
    # A NaN stays a NaN.
    interpenetration = 0.0 if largest == 0 else float(penetration / largest)

    # Largest possible work of each part of a joint at these velocities, less the actual work.
    at_rigid = (n + problem.tension)[rigid] * opening[rigid]
    cell = np.isfinite(problem.compression)
    most = np.where(opening[cell] > 0, problem.tension[cell], -problem.compression[cell]) * opening[cell]
    at_cells = most + n[cell] * opening[cell]
    # In one half of a structure, two corners of a rectangle may share a contact point and the motion there.
    rates = -(opening / np.maximum(np.bincount(corners.ravel(), minlength=len(n)), 1))[corners]
    at_rectangles = crushing.dissipation(rates, problem.capacity, biaxial=biaxial) - (beyond_tension * rates).sum(
        axis=1
    )
    resisted = np.where(never, 0.0, resistance) * sliding
    friction = problem.torsion.by_joint(resisted + np.einsum("kj,kj->k", x[:, 1:], v[:, 1:]))
    at_ties = problem.ties.missed_work(beyond_prestress, problem.ties.elongation(u) - slack)
    missed = (at_rigid, at_cells, at_rectangles, friction, at_ties, unbalanced * u)
    gap = float(sum(np.abs(part).sum() for part in missed))
    gap_limit = settings.numerics.gap_tolerance * max(abs(alpha), 1e-3 * problem.work_scale(u))
    # A NaN fails every comparison, so the certificate of a state with a NaN never holds.
    holds = (
        are_admissible(residual, excess, settings)
        and interpenetration <= settings.numerics.interpenetration_tolerance
        and gap <= gap_limit
        and abs(problem.w_L @ u - 1) < 1e-6
    )
    return Certificate(residual, excess, interpenetration, gap, float(gap_limit), holds=bool(holds), settings=settings)
