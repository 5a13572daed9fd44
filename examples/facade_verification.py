"""A façade that leans on nothing: from its collapse state to the check of its local mechanism, and a report to sign."""

from pathlib import Path

import blockstruct as bs
from blockstruct import Q_


def main(folder: Path | None = None) -> bs.assess.LocalMechanismCheck:
    tuff = bs.Material("tuff", unit_weight=Q_(16, "kN/m^3"))
    lime = bs.JointMaterial("lime mortar", friction_coefficient=0.6, compressive_strength=Q_(2, "MPa"))
    size = {"unit_length": "1 m", "unit_height": "0.5 m", "thickness": "0.6 m", "material": tuff}
    blocks = bs.wall(length="5 m", courses=12, **size)
    model = bs.Model("façade", blocks, bs.detect_interfaces(blocks, joint_material=lime))

    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    push = bs.LoadPattern("push -y", [bs.BodyForce("-y")])
    case = bs.LimitCase("out of plane", dead=dead, variable=push)
    analysis = bs.AnalysisManager(model).run([case], spread=True)
    spread = analysis.spread("out of plane")

    site = bs.assess.ntc_spectrum(ag=Q_(0.15, "g_0"), F0=2.4, Tc=Q_(0.3, "s"), soil="B")
    edge = Q_([[0, 0, 0], [5, 0, 0]], "m")
    (body,) = spread.given.macro_blocks
    hand = bs.assess.overturning(model, case, body, edge, compressive_strength=Q_(2, "MPa"))
    check = bs.assess.local_mechanism(spread, spectrum=site, knowledge_level="LC2", method="displacement", beside=hand)
    if folder is not None:
        from blockstruct.views.report import write_report

        write_report(analysis, folder / "façade.pdf", project={"client": "Town of Lucca"}, checks=[check])
    return check


if __name__ == "__main__":
    print(main(Path()))
