"""What one random structure shows: every procedure, its variants, and an independent path."""

import math
import time
import warnings
from dataclasses import dataclass, field, replace

import numpy as np

import blockstruct as bs
import independent_path
from random_structures import Structure

#: Blocks up to which the independent path is affordable.
AFFORDABLE = 80
#: Range over the last decade of displacement up to which an independent path has come to its end.
AT_REST = 1e-2
#: Largest error of a settled load factor against an independent path. Most are below 1e-3, domes come
#: near it.
NEAR = 0.02
#: Structures that must have the load factor of the first one, and steps and stiffness that may change it.
SAME = ("mirrored", "rotated", "renumbered")
STEPS = {
    "half steps": {"path_step": 0.25, "path_growth": 2**0.5},
    "shear ratio 0.2": {"shear_stiffness_ratio": 0.2},
    "shear ratio 1": {"shear_stiffness_ratio": 1.0},
}


@dataclass(frozen=True)
class Run:
    """How one case ended."""

    status: str
    load_factor: float
    settled: bool
    certified: bool
    gap: float
    seconds: float


@dataclass(frozen=True)
class Findings:
    """Load factors of one structure, found in different ways."""

    name: str
    kind: str
    blocks: int
    exact: float | None
    associative: Run
    path: Run
    fictitious: Run
    variants: dict[str, Run] = field(default_factory=dict)
    #: Load factor of the independent path, NaN if there is none, and its range over the last decade.
    independent: float = math.nan
    independent_change: float = math.nan
    #: Load factor of the path if the joints do not crush, NaN if they never do.
    without_crushing: float = math.nan

    @property
    def reference(self) -> float:
        """Load factor by hand, or that of an independent path that has come to its end; NaN without either."""
        if self.exact is not None:
            return self.exact
        return self.independent if self.independent_change <= AT_REST else math.nan

    def error(self, run: Run) -> float:
        """Relative error of a run against the reference."""
        return run.load_factor / self.reference - 1

    def differs(self, variant: str) -> float:
        """Relative difference of a variant from the path."""
        return abs(self.variants[variant].load_factor / self.path.load_factor - 1)


def solved(model: bs.Model, case: Structure, flow: str = "nonassociative", **settings: object) -> Run:
    """One case of a model, with its processor time."""
    limit_case = bs.LimitCase("case", case.dead, case.variable, flow)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bs.errors.LoadFactorWarning)
        start = time.process_time()
        result = bs.AnalysisManager(model, settings=bs.ProcedureSettings(**settings)).run([limit_case])["case"]
    seconds = time.process_time() - start
    certificate = result.certificate
    certified, gap = (False, math.nan) if certificate is None else (certificate.holds, certificate.flow_rule_gap)
    return Run(str(result.status), result.load_factor, result.settled, bool(certified), float(gap), seconds)


def path_of(case: Structure) -> independent_path.Path | None:
    """The independent path of a structure, None if it does not stand."""
    return independent_path.follow(independent_path.Structure.of(case.model, case.dead, case.variable))


def findings(case: Structure, *, variants: bool = True) -> Findings:
    """Everything found about a structure."""
    model = case.model
    found = Findings(
        name=case.name,
        kind=case.kind,
        blocks=sum(not b.fixed for b in model.blocks),
        exact=case.exact,
        associative=solved(model, case, "associative"),
        path=solved(model, case, procedure="loading path"),
        fictitious=solved(model, case, procedure="fictitious"),
    )
    if found.path.status != "converged":
        return found
    if variants:
        quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
        same = {
            "mirrored": case.turned(np.diag([-1.0, 1, 1])),
            "rotated": case.turned(quarter),
            "renumbered": case.renumbered(7),
        }
        runs = {key: solved(other.model, other, procedure="loading path") for key, other in same.items()}
        runs |= {key: solved(model, case, procedure="loading path", **changes) for key, changes in STEPS.items()}
        found = replace(found, variants=runs)
    if math.isfinite(case.joint.compressive_strength):
        # The independent path takes crushing in cells, whose friction resists less torsion than that of corners.
        hard = replace(case, joint=bs.JointMaterial("hard", case.joint.friction_coefficient))
        run = solved(hard.model, hard, procedure="loading path")
        found = replace(found, without_crushing=run.load_factor)
    elif found.blocks <= AFFORDABLE:
        path = path_of(case)
        if path is not None and path.finished:
            found = replace(found, independent=path.last, independent_change=path.change)
    return found
