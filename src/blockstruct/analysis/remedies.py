"""The effect of torsion, crushing and self-stress: cases run again by the remedy of a note."""

from dataclasses import replace
from typing import Any

import numpy as np

from blockstruct.limit import LimitProblem, ProcedureSettings
from blockstruct.model import Model
from blockstruct.model.fields import changed
from blockstruct.procedures import solve_limit_case
from blockstruct.results import CaseResult
from blockstruct.solvers import solver_of
from blockstruct.statics import Division, Statics
from blockstruct.vocabulary import Status, Torsion


def with_effects(result: CaseResult) -> CaseResult:
    """Return a result with the load factor that the remedy of each note gives.

    A note on torsion has joints with the torsion of uniform pressure as its remedy, a note on crushing about both axes
    the exact condition, and a note on self-stress another procedure. Each remedy takes one to three times as long as
    the case.
    """
    facts: dict[str, Any] = {}
    wanted = result.wanted_effects
    if "uniform_torsion" in wanted:
        facts["uniform_torsion"] = _load_factor(_uniform(result.model), result, result.settings)
    if "biaxial_crushing" in wanted:
        exact = replace(result.settings, crushing="conic", crushing_interaction="biaxial")
        facts["biaxial_crushing"] = _load_factor(result.model, result, exact)
    if "other_procedure" in wanted:
        other = "fictitious" if result.settings.procedure == "loading path" else "loading path"
        facts["other_procedure"] = _load_factor(result.model, result, replace(result.settings, procedure=other))
    return result.changed(outcome=replace(result.outcome, **facts)) if facts else result


def _uniform(model: Model) -> Model:
    """Return a model whose joints have the torsion of uniform pressure."""
    joints = {name: joint.varied(torsion=Torsion.UNIFORM_PRESSURE) for name, joint in model.joint_materials.items()}
    # The shapes are unchanged, and need no second check.
    other: Model = changed(
        model, interfaces=tuple(i.with_joint_material(joints[i.joint_material.name]) for i in model.interfaces)
    )
    return other


def _load_factor(model: Model, result: CaseResult, settings: ProcedureSettings) -> float:
    """Return the load factor of a case with another model and other settings; NaN without a settled one."""
    statics = Statics.of(model, Division(settings.crushing_cells))
    problem = LimitProblem.of(statics, result.case).at_unit_load
    steps = solve_limit_case(problem, result.case.flow, settings, solver_of(settings))
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            return float(stop.value.load_factor) if stop.value.status is Status.CONVERGED else np.nan
