"""Assumptions of an analysis, as sentences for a report."""

from collections.abc import Sequence

import numpy as np

from blockstruct.model import Case, LimitCase, Model, Pushover, RecordCase, SettlementCase
from blockstruct.vocabulary import FEW, Flow, Torsion


def assumption_sentences(
    model: Model,
    cases: Sequence[Case],
    cells: Sequence[str] = (),
    masses: Sequence[str] = (),
    *,
    has_curve: bool = False,
    rotates: bool = False,
    higher: str = "",
) -> list[str]:
    """Return the assumptions of an analysis.

    Parameters
    ----------
    model, cases
        The structure and its cases.
    cells, masses
        Sentences on joints that crush in cells, and on the masses of pushes.
    has_curve
        Whether a pushover or a settlement has a capacity curve.
    rotates
        Whether a check has the capacity curve of a body that turns about a hinge.
    higher
        Remark on parts of the structure that a check does not cover; empty without checks.
    """
    limit = [case for case in cases if isinstance(case, LimitCase)]
    settles, moves = (any(isinstance(case, kind) for case in cases) for kind in (SettlementCase, RecordCase))
    joints = model.joint_materials.values()
    finite = ["beyond the collapse state of a pushover" + " or a settlement" * settles] * has_curve
    finite += ["along the capacity curve of a check"] * rotates
    finite += ["in the response to a record"] * moves
    crushing = [np.isfinite(j.compressive_strength) for j in joints]
    texts = [
        (
            "Blocks are rigid and do not break; all deformation is in the joints between them. Supports do not move"
            f"{', except for those of a settlement case' if settles else ''}."
        ),
        (
            f"Displacements are small{', except ' * bool(finite)}{' and '.join(finite)}: equilibrium refers to the "
            f"undeformed structure. {'Imposed' if settles else 'Settlements, imposed'} deformations, stiffness "
            f"and dynamic effects are not considered{', except in the response to a record' * moves}."
        ),
        (
            "Joints are rigid and perfectly plastic, with unlimited ductility. Contacts are the interfaces of the "
            "model, plane or fitted by planes."
        ),
        (
            "Sliding follows Coulomb's law at the contact points of each interface, with the friction coefficients and "
            "cohesion of the joint materials."
        ),
        *_never_sliding(model),
        _torsion(model),
        "Joints bear tension up to the tensile strength of their material."
        if any(j.tensile_strength > 0 for j in joints)
        else "Joints bear no tension.",
        _crushing(model)
        if any(crushing)
        else "The compressive strength of joints and blocks is unlimited: crushing is not checked.",
        *cells,
    ]
    if any(crushing) and not all(crushing):
        texts.append("Joint materials with an unlimited compressive strength do not crush.")
    if model.ties:
        texts.append(
            "Ties bear tension alone, along the straight line between their ends. They are rigid up to their largest "
            "force and yield there without limit, unless an elongation limit is stated. Their weight is not considered."
        )
    ties = ", and ties break at their elongation limits" if model.ties else ""
    if has_curve:
        texts.append(
            "Beyond the collapse state a curve follows the blocks through finite displacements, slowly and without "
            "dynamic effects. Equilibrium and contacts refer to the displaced blocks; "
            f"{_corners(cases)}{ties}."
        )
    if moves:
        texts.append(f"Under a record blocks move with their mass and strike each other without bounce{ties}.")
    if rotates:
        texts.append(
            "Along the capacity curve of a check a body turns through finite angles about a fixed hinge, where its "
            "joints press at collapse."
        )
    if higher:
        texts.append(f"A check covers the mechanism found: {higher}.")
    if any(case.flow is Flow.NONASSOCIATIVE for case in limit):
        texts.append(
            "With non-associative flow the load factor is not unique: a certified load factor belongs to a collapse "
            "state, not necessarily to the lowest; it depends on the settings in the appendix."
        )
    if any(case.flow is Flow.ASSOCIATIVE for case in limit):
        texts.append(
            "With associative flow the load factor is unique, and an upper bound for all non-associative flow rules."
        )
    texts += masses if len(masses) <= FEW else [masses_below(len(masses))]
    if settles:
        texts.append(
            "The reaction of moving supports is the force that joints and ties bring to them, without their own "
            "weight: the least one of a state that is a mechanism. With non-associative flow it is not unique"
            f"{', either' * bool(limit)}, and not below the least that statics allows."
        )
    loads = "Load factors multiply the variable loads as modelled; n" if limit else "N"
    return [*texts, f"{loads}o partial safety factor is included."]


def masses_below(count: int) -> str:
    """Return the sentence that refers to the masses of many pushes."""
    return f"The section on loads states which masses each of {count} pushes moves."


def _never_sliding(model: Model) -> list[str]:
    names = [name for name, joint in model.joint_materials.items() if np.isinf(joint.friction_coefficient)]
    return [f"Joints of {', '.join(names)} never slide, not even where they open."] if names else []


def _torsion(model: Model) -> str:
    uniform = [n for n, j in model.joint_materials.items() if j.torsion is Torsion.UNIFORM_PRESSURE]
    if not uniform:
        return "Friction at the contact points of an interface limits the torque about its normal."
    return (
        f"Shear and torque in joints of {', '.join(uniform)} stay within an ellipsoid, with the torque of uniform "
        "pressure on the whole interface. In other joints friction at the contact points limits them."
    )


def _crushing(model: Model) -> str:
    both = any(j.tensile_strength > 0 and np.isfinite(j.compressive_strength) for j in model.joint_materials.values())
    outside = ", with the tensile strength of the joint, if any, outside it" if both else ""
    return f"Crushing is limited by a rectangular stress block of the compressive strength{outside}."


def _corners(cases: Sequence[Case]) -> str:
    radii = {case.name: case.corner_rounding for case in cases if isinstance(case, Pushover)}
    if not any(radii.values()):
        return "corners stay sharp"
    if len(set(radii.values())) == 1:
        return f"corners have a radius of {1e3 * max(radii.values()):.4g} mm"
    each = (f"{1e3 * radius:.4g} mm in {name}" if radius else f"none in {name}" for name, radius in radii.items())
    return f"corners have a radius of {', '.join(each)}"
