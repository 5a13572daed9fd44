"""Least thickness of a semicircular arch of 27 voussoirs under its own weight, by bisection.

The arch stands as long as some forces inside the friction cones carry its weight; the case says so by its status.
G. Cocchetti, E. Rizzi (2020), Frattura ed Integrità Strutturale 51: 356–375: thickness over centreline radius
0.107426 for a continuous arch and friction that does not matter.
"""

import blockstruct as bs
from blockstruct import Q_


def stands(thickness: float, friction: float) -> bool:
    """Whether an arch of centreline radius 10 m and a thickness in m carries its own weight."""
    stone = bs.Material("limestone", unit_weight=Q_(25, "kN/m^3"))
    blocks = bs.arch(
        span=Q_(20 - thickness, "m"), thickness=Q_(thickness, "m"), depth=Q_(1, "m"), voussoirs=27, material=stone
    )
    found = bs.detect_interfaces(blocks, bs.JointMaterial("dry joint", friction))
    model = bs.Model(f"arch {thickness:.4f} m", blocks, found)
    push = bs.LoadPattern("push +x", [bs.BodyForce((1, 0, 0))])
    case = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")
    return bs.AnalysisManager(model).run([case])["push"].status != "unstable_under_dead_load"


def main() -> dict[float, float]:
    least = {}
    for friction in (0.6, 0.35):
        low, high = 0.9, 2.0
        while high - low > 1e-3:
            middle = (low + high) / 2
            low, high = (low, middle) if stands(middle, friction) else (middle, high)
        least[friction] = high / 10
        print(f"friction {friction}: stands with thickness / radius {high / 10:.4f}, falls with {low / 10:.4f}")
    return least


if __name__ == "__main__":
    main()
