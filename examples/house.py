"""A house of two storeys in four directions: one verdict, one table and a report to sign.

Four walls with two windows a storey in front, a roof on the walls left and right, and a tie from front to back. Nobody
has seen the bond of the corners, so the walls only touch there.
"""

from pathlib import Path

import blockstruct as bs
from blockstruct import Q_


def house() -> bs.Model:
    tuff = bs.Material("tuff", unit_weight=Q_(16, "kN/m^3"))
    lime = bs.JointMaterial("lime mortar", friction_coefficient=0.6, compressive_strength=Q_(4, "MPa"))
    windows = [
        bs.structures.Opening(start=start, sill=sill, width="0.9 m", height="1.5 m")
        for start in ("1.5 m", "4.2 m")
        for sill in ("0.75 m", "3.75 m")
    ]
    size = {"thickness": "0.6 m", "unit_length": "1.5 m", "unit_height": "0.75 m", "material": tuff}
    plan = {"length": "6.6 m", "width": "5.4 m", "height": "6 m", "bonded": False}
    blocks = bs.room(openings={"front": windows}, **plan, **size)
    tie = bs.Tie("tie", start="[3.3, 0, 5.6] m", end="[3.3, 5.4, 5.6] m", yield_force="20 kN")
    return bs.Model("house", blocks, bs.detect_interfaces(blocks, joint_material=lime), ties=[tie])


def weights() -> bs.LoadPattern:
    roof = [bs.LineLoad("7.5 kN/m", start=f"[{x}, 0, 6] m", end=f"[{x}, 5.4, 6] m") for x in (0.3, 6.3)]
    return bs.LoadPattern("dead", [bs.SelfWeight(), *roof])


def main(folder: Path | None = None) -> bs.assess.Building:
    site = bs.assess.ntc_spectrum(ag=Q_(0.1, "g_0"), F0=2.4, Tc=Q_(0.3, "s"), soil="B")
    found = bs.assess.building(house(), weights(), site, knowledge_level="LC1")
    if folder is not None:
        found.report(folder / "house.pdf", project={"client": "Town of Lucca"})
    return found


if __name__ == "__main__":
    print(main(Path()))
