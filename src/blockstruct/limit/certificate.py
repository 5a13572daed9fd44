"""The certificate: why to believe a load factor."""

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import crushing
from blockstruct.limit.division import sliding as rates_of_sliding
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.notebook import html_table

Array = NDArray[np.float64]

#: The four measures: what each is called, and what it is a multiple of.
_JUDGED = {
    "equilibrium_residual": ("equilibrium residual", "dead wrenches of the block"),
    "yield_excess": ("yield excess", "dead wrenches of the lighter block, or the normal force there"),
    "interpenetration": ("interpenetration", "largest relative velocities"),
    "flow_rule_gap": ("flow-rule gap", "units of the load factor; of the dead load, if a reaction"),
}
#: Residual of equilibrium, and yield excess, with which the certificate of a state of a pushover holds.
FORCES = 1e-5


@dataclass(frozen=True, slots=True)
class Certificate:
    """Proof of a collapse state (x, u, α), measured against the true conditions and not those of any program.

    A state whose four measures are zero is an exact solution: forces in equilibrium that no joint refuses, a
    mechanism that no block blocks, and as much work dissipated as the loads do.
    ``print(certificate)`` shows each measure with its tolerance.

    Attributes
    ----------
    equilibrium_residual : float
        ``‖A x + Σ a_j T_j + w_D + α w_L‖∞``, for each block in multiples of its own dead wrench.
    yield_excess : float
        Largest of ``‖(s, t)‖ − c A_k − μ n``, ``−f_t A_k − n`` and the excess over crushing, in multiples of the dead
        wrench of the lighter of the two blocks or, where that is larger, of the normal force there: of the contact
        point, or of the rectangle that crushes; and of what tie forces miss of ``T0 ≤ T ≤ T_y`` and of their bond,
        likewise. Negative inside.
    interpenetration : float
        Largest of ``tan ψ ‖v_t‖ − v_n`` at contact points that do not crush, relative to the largest relative
        velocity.
    flow_rule_gap : float
        ``Σ_k |(n + f_t A_k)(v_n − tan ψ ‖v_t‖)| + |(c A_k + μ n) ‖v_t‖ + (s, t)·v_t|``, and where joints crush the
        work they dissipate at most (:class:`~blockstruct.limit.crushing.CrushingFlow`) less the work they do; of
        ties, ``T_y ė`` of those that yield less their work ``T ė``; and the work ``Σ |u_i r_i|`` of the equilibrium
        residual r. It is the work by which the state misses the flow rule, in units of the load factor, because
        ``w_L·u = 1``.
    flow_rule_gap_limit : float
        The gap tolerance of the settings times the load factor, or times a thousandth of the work scale of the
        mechanism where that is larger.
    holds : bool
        Whether all four are within the tolerances of the settings.
    settings : ProcedureSettings
        The settings, whose tolerances these are.
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
        """What a file keeps of it: its numbers, and whether it holds."""
        return {name: getattr(self, name) for name in CERTIFICATE_MEASURES}

    @property
    def tolerances(self) -> dict[str, float]:
        """Tolerance of each of the four measures."""
        s = self.settings.numerics
        limits = (s.equilibrium_tolerance, s.yield_tolerance, s.interpenetration_tolerance, self.flow_rule_gap_limit)
        return dict(zip(_JUDGED, limits, strict=True))

    @property
    def admissible(self) -> bool:
        """Whether forces are in equilibrium inside the true conditions, whatever the mechanism."""
        return bool(are_admissible(self.equilibrium_residual, self.yield_excess, self.settings))

    @property
    def verdict(self) -> str:
        """Whether it holds, in words."""
        return f"certificate {'holds' if self.holds else 'does not hold'}"

    def __str__(self) -> str:
        lines = [f"  {name:<21}{value:>9} (tolerance {limit}) {unit}" for name, value, limit, unit in self._rows()]
        return "\n".join([self.verdict, *lines])

    def _repr_html_(self) -> str:
        return html_table(self.verdict, ["measure", "value", "tolerance", "measured in"], self._rows())

    @property
    def texts(self) -> dict[str, tuple[str, str]]:
        """Each of the four measures and its tolerance, to two digits."""
        return {measure: (_said(getattr(self, measure)), _said(limit)) for measure, limit in self.tolerances.items()}

    def _rows(self) -> list[tuple[str, str, str, str]]:
        return [(_JUDGED[measure][0], *texts, _JUDGED[measure][1]) for measure, texts in self.texts.items()]


def are_admissible(residual: Array | float, excess: Array | float, settings: ProcedureSettings) -> NDArray[np.bool_]:
    """Whether forces are in equilibrium inside the true conditions, by their residuals and their yield excesses."""
    # A NaN fails every comparison, so a state that is not a number never is.
    numerics = settings.numerics
    return np.asarray((residual <= numerics.equilibrium_tolerance) & (excess <= numerics.yield_tolerance))


def _said(value: float) -> str:
    """A small number to two digits.

    >>> _said(0.0), _said(1e-6), _said(2.5e-4)
    ('0', '1e-06', '2.5e-04')
    """
    return f"{value:.1e}".replace(".0e", "e") if value else "0"


#: What a file keeps of a certificate.
CERTIFICATE_MEASURES = tuple(f.name for f in fields(Certificate) if f.name != "settings")


def certify(
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
    """Certificate of a state.

    Parameters
    ----------
    problem
        The limit problem, whose dilatancy is that of the flow rule.
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
        Distance that is open before the velocities act for a unit of time, in the unit of relative velocities.
    slack : (M,) array
        Elongation of ties, likewise, before they pull.
    speed
        To which interpenetration is relative where the contact points are slower.
    """
    T = np.zeros(0) if T is None else T
    biaxial = settings.crushing_interaction == "biaxial"
    unbalanced = problem.unbalanced(x, T, alpha)
    residual = float(np.abs(unbalanced).max())
    v = (problem.A.T @ u).reshape(-1, 3)
    n, v_n = x[:, 0], v[:, 0]
    apart = v_n + gap
    flow = crushing.CrushingFlow.of(problem, n, biaxial=biaxial)
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
    # Unlike max, numpy passes a NaN on.
    excess = float(np.concatenate(excesses).max())
    opening = apart - problem.dilatancy * sliding
    rigid = ~problem.crushes
    # Velocities are relative to local units of force; what penetrates is measured against the fastest point.
    largest = max(problem.speed(v, u), speed)
    penetration = (-opening / problem.force_unit)[rigid].max(initial=0.0)
    interpenetration = float(penetration / largest) if largest > 0 else 0.0

    # Work each part of a joint could do at most at these velocities, less the work it does.
    at_rigid = (n + problem.tension)[rigid] * opening[rigid]
    cell = np.isfinite(problem.compression)
    most = np.where(opening[cell] > 0, problem.tension[cell], -problem.compression[cell]) * opening[cell]
    at_cells = most + n[cell] * opening[cell]
    rates = -opening[corners]
    at_rectangles = flow.dissipation(rates) - (beyond_tension * rates).sum(axis=1)
    friction = problem.torsion.by_joint(resistance * sliding + np.einsum("kj,kj->k", x[:, 1:], v[:, 1:]))
    at_ties = problem.ties.missed_work(beyond_prestress, problem.ties.elongation(u) - slack)
    missed = (at_rigid, at_cells, at_rectangles, friction, at_ties, unbalanced * u)
    gap = float(sum(np.abs(part).sum() for part in missed))
    gap_limit = settings.numerics.gap_tolerance * max(abs(alpha), 1e-3 * problem.work_scale(u))
    # A NaN fails every comparison, so a state that is not a number never holds.
    holds = (
        are_admissible(residual, excess, settings)
        and interpenetration <= settings.numerics.interpenetration_tolerance
        and gap <= gap_limit
        and abs(problem.w_L @ u - 1) < 1e-6
    )
    return Certificate(residual, excess, interpenetration, gap, float(gap_limit), holds=bool(holds), settings=settings)
