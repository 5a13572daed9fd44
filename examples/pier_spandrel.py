"""A full-scale pier–spandrel sub-assemblage of tuff, pushed at its spandrel until it collapses.

Two piers 1.70 m wide either side of an opening of 1.70 × 2.30 m, a lintel and a spandrel above it, 0.31 m thick, with
200 kN on top of each pier: the scale of the structure in section 8 of F. Portioli, C. Casapulla, L. Cascini (2015),
Int. J. Solids Struct. 69–70: 252–266. Dimensions are approximate: an example, not a validation.
"""

import blockstruct as bs
from blockstruct import Q_

TUFF = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
MORTAR = bs.JointMaterial("mortar", friction_coefficient=0.6)
PUSH = Q_(1, "kN")


def assemblage(mortar: bs.JointMaterial = MORTAR) -> bs.Model:
    # In units of 0.30 × 0.10 m: piers of 5 2/3 units, 23 courses of opening, 3 of lintel, 10 of spandrel.
    pier = [[1, 1, 1, 1, 1, 2 / 3], [2 / 3, 1, 1, 1, 1, 1]]
    beside = [[1, 1, 1, 1, 5 / 6], [2 / 3, 1, 1, 1, 1 + 1 / 6]]
    spandrel = [[1] * 17, [0.5] + [1] * 16 + [0.5]]
    rows = [pier[j % 2] + [-17 / 3] + pier[j % 2][::-1] for j in range(23)]
    rows += [beside[j % 2] + [-22 / 3] + beside[j % 2][::-1] for j in range(3)]
    rows += [spandrel[j % 2] for j in range(10)]
    depth = Q_(0.31, "m")
    blocks = bs.courses(rows, unit_length=Q_(0.3, "m"), unit_height=Q_(0.1, "m"), thickness=depth, material=TUFF)
    lintel = bs.Block.box("lintel", Q_([1.45, 0, 2.3], "m"), Q_([2.2, 0.31, 0.3], "m"), TUFF)
    beams = [bs.Block.box(f"beam at {x} m", Q_([x, 0, 3.6], "m"), Q_([1.7, 0.31, 0.02], "m"), TUFF) for x in (0, 3.4)]
    blocks += [lintel, *beams]
    found = bs.detect_interfaces(blocks, joint_material=mortar)
    return bs.Model("pier and spandrel", blocks, found)


def pushed() -> bs.LimitCase:
    weights = [
        bs.PointLoad(f"beam at {x} m", Q_([x + 0.85, 0.155, 3.62], "m"), Q_([0, 0, -200], "kN")) for x in (0, 3.4)
    ]
    ends = [
        bs.PointLoad(f"{j}.1", Q_([0, 0.155, j / 10 - 0.05], "m"), [PUSH / 10, 0 * PUSH, 0 * PUSH])
        for j in range(27, 37)
    ]
    dead = bs.LoadPattern("self-weight and 200 kN on each pier", [bs.SelfWeight(), *weights])
    return bs.LimitCase("push +x", dead, bs.LoadPattern("1 kN at the spandrel", ends))


def main(strengths: tuple[str | None, ...] = (None, "4 MPa", "2 MPa")) -> dict[str, float]:
    shear = {}
    for strength in strengths:
        model = assemblage(MORTAR.varied(compressive_strength=strength))
        print(f"{model.name}: {len(model.blocks)} blocks, {len(model.interfaces)} interfaces")
        result = bs.run(model, pushed(), listeners=[bs.analysis.print_lines()])["push +x"]
        name = strength or "infinite"
        shear[name] = float(result.load_factor * PUSH.m_as("kN"))
        print(f"f_c {name}: {result.status}, base shear {result.load_factor * PUSH:.4~P}")
    return shear


if __name__ == "__main__":
    main()
