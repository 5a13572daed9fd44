"""A semicircular arch whose left abutment sinks until the arch collapses: reaction over settlement.

F. Portioli, L. Cascini (2017), Eng. Struct. 148: 485–496, follow masonry on settling supports in the same way, with
rigid blocks in their displaced positions.
"""

from pathlib import Path

import blockstruct as bs
from blockstruct import Q_
from blockstruct.views import figures


def main(folder: Path = Path()) -> float:
    """Return the largest settlement of the abutment, m; draw the reaction over the settlement."""
    stone = bs.Material("limestone", unit_weight=Q_(25, "kN/m^3"))
    blocks = bs.arch(span=Q_(3.4, "m"), thickness=Q_(0.6, "m"), depth=Q_(1, "m"), voussoirs=13, material=stone)
    model = bs.Model("arch", blocks, bs.detect_interfaces(blocks, bs.JointMaterial("dry joint", 0.6)))
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    case = bs.SettlementCase(
        "left abutment sinks", dead, supports=["left"], direction="-z", displacement="2.5 m", steps=40
    )
    result = bs.run(model, case)[case.name]
    print(result.describe())
    curve = result.capacity
    print(f"The reaction changes from {curve.reaction[0] / 1e3:.4g} to {curve.reaction.max() / 1e3:.4g} kN.")
    figures.capacity(result).figure.savefig(folder / "sinking_abutment.png")
    return float(curve.d0)


if __name__ == "__main__":
    main()
