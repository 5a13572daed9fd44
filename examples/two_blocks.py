"""Two blocks on a base: define, solve, inspect every iteration, close, reload.

The blocks slide on their base at the friction coefficient 0.3, before anything rocks.
"""

import tempfile
from pathlib import Path

import blockstruct as bs
from blockstruct import Q_


def main(folder: str) -> float:
    stone = bs.Material("limestone", unit_weight=Q_(24, "kN/m^3"))
    joint = bs.JointMaterial("dry joint", friction_coefficient=0.3)
    base = bs.Block.box("base", origin=Q_([0, 0, -0.2], "m"), size=Q_([1, 1, 0.2], "m"), material=stone, fixed=True)
    lower = bs.Block.box("lower", origin=Q_([0, 0, 0], "m"), size=Q_([1, 1, 0.5], "m"), material=stone)
    upper = bs.Block.box("upper", origin=Q_([10, 10, 50], "cm"), size=Q_([80, 80, 50], "cm"), material=stone)
    blocks = [base, lower, upper]
    found = bs.detect_interfaces(blocks, joint_material=joint)
    model = bs.Model("two blocks", blocks, found)

    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    push = bs.LoadPattern("push +x", [bs.BodyForce(direction=(1, 0, 0))])
    case = bs.LimitCase("push +x", dead=dead, variable=push, flow="nonassociative")
    path = Path(folder) / "two-blocks.h5"
    bs.AnalysisManager(model, store=path).run([case])

    result = bs.open_analysis(path)["push +x"]
    print(result)
    print(result.history.load_factor.to_pandas())
    forces = result.resultants.force.isel(iteration=-1) / 1e3
    print(forces.to_pandas().round(3).to_string(), "kN")
    print(result.states.isel(iteration=-1).to_pandas().to_string())
    return result.load_factor


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        main(scratch)
