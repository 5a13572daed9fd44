"""Writes ``analysis-<version>.h5`` in the present version of the format; files of earlier versions stay as they are.

Run it from the root of the repository, once a version: ``python tests/data/write.py``.
"""

from pathlib import Path

import blockstruct as bs
from blockstruct.vocabulary import FORMAT_VERSION


def main() -> None:
    stone = bs.Material("stone", "20 kN/m^3")
    blocks = [
        bs.Block.box("ground", bs.Q_([-1, -1, -1], "m"), bs.Q_([3, 3, 1], "m"), stone, fixed=True),
        bs.Block.box("block", bs.Q_([0, 0, 0], "m"), bs.Q_([0.5, 1, 1], "m"), stone),
    ]
    joint = bs.JointMaterial("joint", 0.65, dilatancy_angle="5 deg")
    model = bs.Model("block", blocks, bs.detect_interfaces(blocks, joint_material=joint).interfaces)
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    along, across = (bs.LoadPattern(f"push {d}", [bs.BodyForce(d)]) for d in ((1, 0, 0), (0, 1, 0)))
    cases = [bs.LimitCase("rocking", dead, along, "associative"), bs.LimitCase("sliding", dead, across)]
    analysis = bs.AnalysisManager(model, tags=["kept"], document_hash="0" * 64).run(cases)
    # Not of the machine that happens to write it.
    analysis = analysis.replaced(versions={"blockstruct": bs.__version__})
    bs.save_analysis(analysis, Path(__file__).with_name(f"analysis-{FORMAT_VERSION}.h5"))


if __name__ == "__main__":
    main()
