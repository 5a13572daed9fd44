"""Effect of ties: results with and without ties, and least strengths.

>>> import blockstruct as bs
>>> from blockstruct import Q_
>>> stone, dry = bs.Material("stone", "20 kN/m^3"), bs.JointMaterial("dry", 0.8)
>>> ground = bs.Block.box("ground", Q_([-2, 0, -1], "m"), Q_([4, 1, 1], "m"), stone, fixed=True)
>>> wall = bs.Block.box("wall", Q_([0, 0, 0], "m"), Q_([0.5, 1, 2], "m"), stone)
>>> pier = bs.Block.box("pier", Q_([-1.5, 0, 0], "m"), Q_([0.5, 1, 2], "m"), stone, fixed=True)
>>> tie = bs.Tie("tie", ("pier", "[-1, 0.5, 1.9] m"), ("wall", "[0, 0.5, 1.9] m"), yield_force="5 kN")
>>> blocks = [ground, wall, pier]
>>> model = bs.Model("tied wall", blocks, bs.detect_interfaces(blocks, joint_material=dry), ties=[tie])
>>> dead, push = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce("+x")])
>>> case = bs.LimitCase("push", dead, push, flow="associative")
>>> print(with_and_without(model, [case]))
push: 0.725 with ties, 0.25 without
>>> print(least_tie_force(model, case, ["tie"], load_factor=0.725))
load factor 0.725: 5 kN in all (tie 5 kN)
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np
import pandas as pd

from blockstruct.analysis.manager import AnalysisManager
from blockstruct.errors import ModelError, UnknownNameError, shown
from blockstruct.limit import Certificate, LimitProblem
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import (
    TIE_QUANTITIES,
    AnyTie,
    BondedBar,
    LimitCase,
    Model,
    Strip,
    Tie,
    TieSegment,
    checked_tuple,
    given_quantities,
    tie_kind_of,
    tie_segments,
)
from blockstruct.procedures import least_ties
from blockstruct.results.analysis import Analysis
from blockstruct.results.ties import tie_state, ties_at_collapse
from blockstruct.solvers import solver_of
from blockstruct.statics.contacts import Division
from blockstruct.statics.statics import Statics
from blockstruct.text.mechanism import least_ties_sentence
from blockstruct.vocabulary import Flow, SolverStatus, TieState

__all__ = ["BondedBar", "Strip", "Tie"]
__all__ += ["TIE_QUANTITIES", "TieSegment", "given_quantities", "tie_kind_of", "tie_segments"]
__all__ += ["TieState", "tie_state", "ties_at_collapse"]
__all__ += ["LeastTieForce", "WithAndWithout", "least_tie_force", "with_and_without"]


@dataclass(frozen=True, slots=True, eq=False)
class WithAndWithout:
    """The same cases of a structure with its ties and without.

    Attributes
    ----------
    with_ties, without_ties : Analysis
    """

    with_ties: Analysis
    without_ties: Analysis

    @property
    def table(self) -> pd.DataFrame:
        """Return load factors and statuses with and without ties, by case.

        One column has the ratio of the two load factors.
        """
        rows = {}
        for name, tied in self.with_ties.items():
            bare = self.without_ties[name]
            ratio = tied.load_factor / bare.load_factor if bare.load_factor > 0 else np.nan
            rows[name] = {
                "load_factor_with": tied.load_factor,
                "load_factor_without": bare.load_factor,
                "ratio": ratio,
                "status_with": tied.status.value,
                "status_without": bare.status.value,
            }
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("case")

    def __str__(self) -> str:
        return "\n".join(
            f"{name}: {tied.headline.number} with ties, {self.without_ties[name].headline.number} without"
            for name, tied in self.with_ties.items()
        )


def with_and_without(
    model: Model, cases: Iterable[LimitCase], *, settings: ProcedureSettings | None = None, **run: Any
) -> WithAndWithout:
    """Run cases of a structure with its ties and without.

    Parameters
    ----------
    model
        A structure with ties.
    cases
        The cases.
    settings
        Settings of the procedure.
    **run
        Other arguments of :meth:`blockstruct.AnalysisManager.run`.

    Raises
    ------
    ModelError
        If the model has no ties.
    """
    if not model.ties:
        msg = f"with_and_without: model {model.name!r} has no ties; give it some, Model(…, ties=[…])"
        raise ModelError(msg)
    cases = checked_tuple(cases, LimitCase, "with_and_without: cases")
    with_ties, without = (
        AnalysisManager(m, settings=settings, effects=False).run(cases, **run) for m in (model, model.with_ties(()))
    )
    return WithAndWithout(with_ties, without)


@dataclass(frozen=True, slots=True)
class LeastTieForce:
    """Least tie strengths that carry the dead load and a load factor.

    Attributes
    ----------
    load_factor : float
    flow : Flow
        Flow of the case. The strengths always belong to associative flow.
    forces : mapping
        Strength of each requested tie, N; NaN if no strength of these ties is enough.
    certificate : Certificate or None
        Certificate of the structure with ties of these strengths. Its load factor is the requested one. If the dead
        load alone governs, it is a load factor of the dead load. None if the ties are not needed, or no strength is
        enough.
    proven : bool
        Whether the certificate holds and its mechanism proves that weaker ties are not enough. Without a certificate:
        whether forces in equilibrium prove that no ties are needed.
    solver_status : SolverStatus
        ``infeasible`` if no strength of these ties is enough.
    governing : "load factor", "dead load" or "both"
        The requirement that sets these strengths. With ``"dead load"``, the strengths for the load factor alone do not
        carry the dead load. With ``"both"``, each requirement needs different strengths: these carry both, but a
        smaller sum may also do.
    """

    load_factor: float
    flow: Flow
    forces: Mapping[str, float]
    certificate: Certificate | None
    proven: bool
    solver_status: SolverStatus
    governing: str = "load factor"

    @property
    def total(self) -> float:
        """Return the sum of the strengths, N."""
        return float(sum(self.forces.values()))

    def __str__(self) -> str:
        return least_ties_sentence(
            self.load_factor,
            self.forces,
            self.solver_status,
            self.governing,
            is_associative=self.flow is Flow.ASSOCIATIVE,
            proven=self.proven,
        )


def least_tie_force(
    model: Model,
    case: LimitCase,
    ties: Iterable[AnyTie | str],
    load_factor: float,
    *,
    settings: ProcedureSettings | None = None,
) -> LeastTieForce:
    """Return the ties of least total strength that carry a load factor.

    Conic programs give the strengths. With them the structure also carries the dead load, and any load factor in
    between. The strengths are exact for associative flow. Without dilatancy they are a lower bound, because the load
    factor of the same structure is at most the associative one. Run the case with ties of these strengths to check.

    Parameters
    ----------
    model
        The structure. Its other ties keep their strengths.
    case
        Loads; either flow.
    ties
        Names of ties of the model, or ties to add. Their strengths are the unknowns; any given strengths are ignored.
    load_factor
        Load factor that the structure is to carry.
    settings
        Tolerances and solver.

    Raises
    ------
    UnknownNameError
        If the model does not have the tie.
    ModelError
        If a tie is a bonded bar (its force differs from stretch to stretch), or the load factor is not above zero.
    """
    settings = settings or ProcedureSettings()
    for value, kind in ((model, Model), (case, LimitCase), (settings, ProcedureSettings)):
        if not isinstance(value, kind):
            msg = f"least_tie_force: {shown(value)} is not a {kind.__name__}; give model, case, ties and load_factor"
            raise ModelError(msg)
    if isinstance(load_factor, bool) or not isinstance(load_factor, Real) or not 0 < load_factor < np.inf:
        msg = f"least_tie_force: load factor {shown(load_factor)}; give a number above zero"
        raise ModelError(msg)
    requested = checked_tuple(ties, AnyTie | str, "least_tie_force: ties")
    by_name = {tie.name: tie for tie in model.ties} | {tie.name: tie for tie in requested if not isinstance(tie, str)}
    names = list(dict.fromkeys(tie if isinstance(tie, str) else tie.name for tie in requested))
    unknown = [name for name in names if name not in by_name]
    if unknown or not names:
        which = ", ".join(map(repr, unknown)) or "at all"
        msg = f"least_tie_force: no tie {which}; the model has {', '.join(by_name) or 'none'}"
        raise UnknownNameError(msg)
    bars = [name for name in names if isinstance(by_name[name], BondedBar)]
    if bars:
        msg = f"least_tie_force: the force of a bonded bar, {', '.join(bars)}, is not one; give ties or strips"
        raise ModelError(msg)
    statics = Statics.of(model.with_ties(by_name.values()), Division(settings.crushing_cells))
    problem = LimitProblem.of(statics, case)
    sought = np.isin(np.array(statics.ties.name), names)
    least = least_ties(problem, sought, float(load_factor), settings, solver_of(settings))
    force = least.tie_force * problem.ties.force_unit
    c = least.certificate
    beyond_prestress = float((force - statics.ties.prestress)[sought].sum())
    rounding = settings.numerics.yield_tolerance * float(problem.wrench_unit.sum())
    needed = beyond_prestress > rounding
    if beyond_prestress <= rounding:
        force = statics.ties.prestress
    forces = dict(zip(statics.ties.name, np.maximum(force, 0.0).tolist(), strict=True))
    return LeastTieForce(
        load_factor=float(load_factor),
        flow=case.flow,
        forces={name: forces[name] for name in names},
        certificate=c if needed else None,
        proven=c.holds and least.least if needed else c.admissible,
        solver_status=least.solver_status,
        governing=least.governing,
    )
