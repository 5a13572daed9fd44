"""What an engineer must state with a result."""

from collections.abc import Sequence

import numpy as np

import blockstruct as bs
from blockstruct.views.words import cells_of

#: Sentences on masses that the first page of a report has room for.
_FEW = 2


def pushed_masses(model: bs.Model, results: Sequence[bs.CaseResult]) -> list[str]:
    """Which masses every push moves, each once."""
    return list(dict.fromkeys(filter(None, (bs.results.pushed_masses(model, r.case) for r in results))))


def _corners(results: Sequence[bs.CaseResult]) -> str:
    """What the corners of blocks are in pushovers, in words."""
    radii = {r.name: r.case.corner_rounding for r in results if isinstance(r.case, bs.Pushover)}
    if not any(radii.values()):
        return "corners stay sharp"
    if len(set(radii.values())) == 1:
        return f"corners have a radius of {1e3 * max(radii.values()):.4g} mm"
    said = ", ".join(
        f"{1e3 * radius:.4g} mm in {name}" if radius else f"none in {name}" for name, radius in radii.items()
    )
    return f"corners have a radius of {said}"


def _rotates(check: bs.assess.LocalMechanismCheck) -> bool:
    """Whether the capacity curve of a check is that of a body that turns, and not that of a pushover."""
    return check.curve is not None and check.result.capacity is None


def assumptions(
    model: bs.Model, results: Sequence[bs.CaseResult], checks: Sequence[bs.assess.LocalMechanismCheck] = ()
) -> list[str]:
    """Sentences that hold for the model, the cases and their checks."""
    rotates = any(_rotates(check) for check in checks)
    joints = model.joint_materials.values()
    settles = any(isinstance(r.case, bs.SettlementCase) for r in results)
    limit = [r for r in results if not isinstance(r.case, bs.SettlementCase)]
    pushed = any(r.capacity is not None for r in results)
    finite = ["beyond the collapse state of a pushover"] * pushed + ["along the capacity curve of a check"] * rotates
    crushing = any(np.isfinite(j.compressive_strength) for j in joints)
    said = [
        (
            "Blocks are rigid and do not break; all deformation is in the joints between them. Supports do not move"
            f"{', but for those that give way in a settlement case' if settles else ''}."
        ),
        (
            f"Displacements are small{', but ' * bool(finite)}{' and '.join(finite)}: equilibrium is that of the "
            "undeformed structure. "
            f"{'Imposed' if settles else 'Settlements, imposed'} deformations, stiffness and dynamic effects are not "
            "considered."
        ),
        (
            "Joints are rigid and perfectly plastic, with unlimited ductility; contacts are the interfaces of the "
            "model, plane or fitted by planes, in the state it gives them."
        ),
        (
            "Sliding follows Coulomb's law at the contact points of each interface, with the friction coefficients and "
            "cohesion of the joint materials."
        ),
        _torsion(model),
        _tension(model),
        f"Crushing is limited by a rectangular stress block of the compressive strength{_beside(model)}."
        if crushing
        else "The compressive strength of joints and blocks is unlimited: crushing is not checked.",
    ]
    said += cells_of(results)
    if crushing and not all(np.isfinite(j.compressive_strength) for j in joints):
        said.append("Joint materials whose compressive strength is unlimited do not crush.")
    if model.ties:
        said.append(
            "Ties bear tension alone, along the straight line between their ends; they are rigid up to their largest "
            "force and yield there without limit, unless an elongation limit is stated. Their weight is not considered."
        )
    if pushed:
        corners = _corners(results)
        there = f"{corners}, and ties break at their elongation limits" if model.ties else f"and {corners}"
        said.append(
            "Beyond the collapse state a pushover follows the blocks through finite displacements, slowly and without "
            f"dynamic effects: equilibrium is that where the blocks are, contacts are found anew there, {there}."
        )
    if rotates:
        said.append(
            "Along the capacity curve of a check a body turns through finite angles about a hinge that stays where "
            "its joints press at collapse."
        )
    if checks:
        said.append(f"A check is of the mechanism found: {bs.assess.lines.HIGHER}.")
    if any(r.case.flow == bs.Flow.NONASSOCIATIVE for r in limit):
        said.append(
            "With non-associative flow the load factor is not unique: a certified load factor is that of a collapse "
            "state, not necessarily of the lowest; it depends on the settings in the appendix."
        )
    if any(r.case.flow == bs.Flow.ASSOCIATIVE for r in limit):
        said.append(
            "With associative flow the load factor is unique, and an upper bound of those of all non-associative flow "
            "rules."
        )
    masses = pushed_masses(model, results)
    said += (
        masses
        if len(masses) <= _FEW
        else [f"The section on loads states which masses each of {len(masses)} pushes moves."]
    )
    if settles:
        said.append(
            "The reaction of supports that give way is what joints and ties bring to them, without their own weight: "
            "the least of a state that is a mechanism. With non-associative flow it is not unique"
            f"{', either' * bool(limit)}, and not below the least that statics allows."
        )
    loads = "Load factors multiply the variable loads as modelled; n" if limit else "N"
    said.append(f"{loads}o partial safety factor is included.")
    return said


def _torsion(model: bs.Model) -> str:
    uniform = [n for n, j in model.joint_materials.items() if str(j.torsion) == "uniform pressure"]
    if not uniform:
        return "The torque about the normal of an interface is limited by friction at its contact points."
    return (
        f"Shear and torque in joints of {', '.join(uniform)} keep to an ellipsoid with the torque of uniform pressure "
        "on the whole interface; in other joints friction at the contact points alone limits them."
    )


def _beside(model: bs.Model) -> str:
    both = any(j.tensile_strength > 0 and np.isfinite(j.compressive_strength) for j in model.joint_materials.values())
    return ", beside which the joint bears its tensile strength, if it has one" if both else ""


def _tension(model: bs.Model) -> str:
    if any(j.tensile_strength > 0 for j in model.joint_materials.values()):
        return "Joints bear tension up to the tensile strength of their material."
    return "Joints bear no tension."
