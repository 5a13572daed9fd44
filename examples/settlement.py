"""A semicircular arch whose left abutment gives way: what is left of its reactions, and the range of its thrust.

J. Heyman (1966), Int. J. Solids Struct. 2: 249–279: an arch on abutments that spread takes the state of least
thrust; its thrust lies between that and the one of abutments that are pushed together.
"""

import blockstruct as bs
from blockstruct import Q_


def main() -> dict[str, tuple[float, float]]:
    """Least and largest reaction in kN of each case."""
    stone = bs.Material("limestone", unit_weight=Q_(25, "kN/m^3"))
    blocks = bs.arch(span=Q_(3.7, "m"), thickness=Q_(0.3, "m"), depth=Q_(1, "m"), voussoirs=27, material=stone)
    model = bs.Model("arch", blocks, bs.detect_interfaces(blocks, bs.JointMaterial("dry joint", 0.6)))
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    cases = [
        bs.SettlementCase("left abutment spreads", dead=dead, supports=["left"], direction="-x"),
        bs.SettlementCase("left abutment goes down", dead=dead, supports=["left"], direction="-z"),
    ]
    analysis = bs.run(model, cases)
    ranges = {}
    for result in analysis.values():
        print(result.describe(), end="\n\n")
        least, largest = result.reaction_range.to("kN").magnitude
        ranges[result.name] = (least, largest)
        print(f"{result.name}: {result.reaction.to('kN'):.4g~P} left, of {least:.4g} to {largest:.4g} kN\n")
    return ranges


if __name__ == "__main__":
    main()
