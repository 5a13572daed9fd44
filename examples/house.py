"""A house of 125 blocks in four directions: one verdict, one table and a report to sign.

Two storeys, a front with two windows a storey and two sidewalls bonded to it; a roof on the sidewalls, and a tie.
"""

from pathlib import Path

import blockstruct as bs
from blockstruct import Q_

HEIGHT = Q_(6, "m")


def house() -> bs.Model:
    tuff = bs.Material("tuff", unit_weight=Q_(16, "kN/m^3"))
    lime = bs.JointMaterial("lime mortar", friction_coefficient=0.6, compressive_strength=Q_(2, "MPa"))
    windows = [
        bs.structures.Opening(start=start, sill=sill, width="0.9 m", height="1.2 m")
        for start in ("1.5 m", "4.2 m")
        for sill in ("1.2 m", "3.6 m")
    ]
    sides = [bs.structures.Sidewall(name, at, length="3.6 m") for name, at in (("west", "0 m"), ("east", "6 m"))]
    size = {"unit_length": "1.2 m", "unit_height": "0.6 m", "thickness": "0.6 m", "material": tuff}
    blocks = bs.wall(length="6.6 m", height=HEIGHT, openings=windows, sidewalls=sides, **size)
    tie = bs.Tie(
        "tie",
        start=("west.10.1", Q_([0.3, 0, 5.7], "m")),
        end=("west.10.4", Q_([0.3, 4.2, 5.7], "m")),
        yield_force="20 kN",
    )
    return bs.Model("house", blocks, bs.detect_interfaces(blocks, joint_material=lime), ties=[tie])


def roof() -> bs.LoadPattern:
    sides = [Q_([[x, 0, 6], [x, 4.2, 6]], "m") for x in (0.3, 6.3)]
    return bs.LoadPattern(
        "dead", [bs.SelfWeight(), *(bs.LineLoad("7.5 kN/m", start=start, end=end) for start, end in sides)]
    )


def main(folder: Path | None = None) -> bs.assess.Building:
    site = bs.assess.ntc_spectrum(ag=Q_(0.1, "g_0"), F0=2.4, Tc=Q_(0.3, "s"), soil="B")
    found = bs.assess.building(house(), roof(), site, knowledge_level="LC1")
    if folder is not None:
        found.report(folder / "house.pdf", project={"client": "Town of Lucca"})
    return found


if __name__ == "__main__":
    print(main(Path()))
