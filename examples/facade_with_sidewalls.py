"""A façade pushed out of its plane: how much its sidewalls hold, bonded in or butted against it.

The façade and two sidewalls are one call; the push is along −y, away from the sidewalls. Associative flow bounds the
load factor from above. Without dilatancy it is the one that the loading path ends at.
"""

import blockstruct as bs
from blockstruct import Q_


def main() -> dict[tuple[str, str], float]:
    tuff = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
    joints = {"base|*": bs.JointMaterial("ground", 0.6), "*": bs.JointMaterial("lime mortar", 0.65)}
    door = bs.structures.Opening(start="1.2 m", sill="0 m", width="0.8 m", height="1.6 m")
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    push = bs.LoadPattern("push -y", [bs.BodyForce((0, -1, 0))])
    cases = [bs.LimitCase(flow, dead, push, flow) for flow in ("associative", "nonassociative")]
    factors = {}
    for name, bonded in (("bonded", True), ("butted", False)):
        sides = [bs.structures.Sidewall(n, at, "1.6 m", bonded=bonded) for n, at in (("left", "0 m"), ("right", "3 m"))]
        blocks = bs.wall(
            length="3.2 m",
            courses=12,
            unit_length="40 cm",
            unit_height="20 cm",
            thickness="20 cm",
            openings=[door],
            sidewalls=sides,
            material=tuff,
        )
        found = bs.detect_interfaces(blocks, joints)
        model = bs.Model(f"{name} sidewalls", blocks, found)
        print(f"{model.name}: {len(blocks)} blocks, {found.report.accepted} interfaces")
        # Without the effect of torsion, which would run the path again.
        for flow, result in bs.AnalysisManager(model, effects=False).run(cases).items():
            factors[name, flow] = result.load_factor
            print(f"  {flow}: {result.status}, load factor {result.load_factor:.4f}")
    return factors


if __name__ == "__main__":
    main()
