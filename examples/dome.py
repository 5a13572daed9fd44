"""A staggered hemispherical dome with an oculus, pushed sideways and dried out.

Friction alone ties the rings: the collapse load of the dome falls with the friction of its joints.
"""

import blockstruct as bs
from blockstruct import Q_


def main() -> dict[float, float]:
    stone = bs.Material("limestone", unit_weight=Q_(22, "kN/m^3"))
    blocks = bs.structures.dome(
        span=Q_(8, "m"), thickness=Q_(60, "cm"), courses=6, units=10, oculus=Q_(1.6, "m"), material=stone
    )
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    push = bs.LoadPattern("push +x", [bs.BodyForce((1, 0, 0))])
    case = bs.LimitCase("push +x", dead, push, "nonassociative")
    factors = {}
    for friction in (0.7, 0.5):
        found = bs.detect_interfaces(blocks, bs.JointMaterial("dry joint", friction))
        model = bs.Model("dome", blocks, found)
        result = bs.AnalysisManager(model).run([case])["push +x"]
        factors[friction] = result.load_factor
        print(f"friction {friction}: {result.status}, load factor {result.load_factor:.4f}")
    print(found.report)
    return factors


if __name__ == "__main__":
    main()
