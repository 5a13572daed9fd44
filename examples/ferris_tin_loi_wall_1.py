"""Wall 1 of Ferris & Tin-Loi, 33 dry-jointed units pushed in plane.

M. C. Ferris, F. Tin-Loi (2001), "Limit analysis of frictional block assemblies as a mathematical program with
complementarity constraints", Int. J. Mech. Sci. 43: 209–224.
Published load factors: 0.643 with associative and 0.640 with non-associative sliding.
"""

import blockstruct as bs
from blockstruct import Q_


def main() -> tuple[float, float]:
    tuff = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
    dry = bs.JointMaterial("dry joint", friction_coefficient=0.65)
    rows = [[0.5, 1, 1, 1, 1, 0.5], [1, 1, 1, 1, 1]] * 3
    blocks = bs.courses(
        rows, unit_length=Q_(0.4, "m"), unit_height=Q_(0.175, "m"), thickness=Q_(0.1, "m"), material=tuff
    )
    found = bs.detect_interfaces(blocks, joint_material=dry)
    print(found.report)
    model = bs.Model("Ferris & Tin-Loi wall 1", blocks, found)

    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    push = bs.LoadPattern("push +x", [bs.BodyForce(direction=(1, 0, 0))])
    cases = [bs.LimitCase(flow, dead, push, flow) for flow in ("associative", "nonassociative")]
    analysis = bs.AnalysisManager(model).run(cases)
    for result in analysis.values():
        print(result)
        print(result.certificate)
    return analysis["associative"].load_factor, analysis["nonassociative"].load_factor


if __name__ == "__main__":
    main()
