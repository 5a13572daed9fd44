"""A façade on one tie, pushed beyond collapse: the tie yields and breaks, then the façade rocks until it falls."""

import numpy as np

import blockstruct as bs
from blockstruct import Q_


def main() -> bs.CaseResult:
    stone = bs.Material("tuff", unit_weight=Q_(16, "kN/m^3"))
    dry = bs.JointMaterial("dry joint", friction_coefficient=0.7)
    blocks = [
        bs.Block.box("ground", Q_([-2, -1, -0.5], "m"), Q_([6, 8, 0.5], "m"), stone, fixed=True),
        bs.Block.box("back wall", Q_([0, 5, 0], "m"), Q_([4, 0.6, 6], "m"), stone, fixed=True),
        bs.Block.box("façade", Q_([0, 0, 0], "m"), Q_([4, 0.5, 5], "m"), stone),
    ]
    bar = bs.Tie(
        "bar",
        start=("façade", Q_([2, 0, 4], "m")),
        end=("back wall", Q_([2, 5, 4], "m")),
        yield_force=Q_(15, "kN"),
        elongation_limit=Q_(60, "mm"),
    )
    model = bs.Model("tied façade", blocks, bs.detect_interfaces(blocks, joint_material=dry), ties=[bar])

    dead, push = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce("-y")])
    case = bs.Pushover("outwards", dead=dead, variable=push, control=("façade", (0, -1, 0)), steps=30)
    result = bs.run(model, case)["outwards"]

    curve = result.capacity
    for d, alpha in zip(curve.displacement.to_numpy(), curve.load_factor.to_numpy(), strict=True):
        print(f"{1e3 * d:6.1f} mm {alpha:8.4f}")
    print(
        f"the load factor is zero at {Q_(float(curve.d0), 'm').to('mm'):.4g~P}; certified: {bool(np.all(curve.holds))}"
    )
    return result


if __name__ == "__main__":
    main()
