"""Tilting table: the angle at which a dry wall collapses, for walls of growing slenderness.

On a table tilted by θ the weight W has the components W cos θ into it and W sin θ along it, so a load factor α of
the weight turned sideways stands for θ = arctan α. Each wall is analysed and stored; the angles are read back from
the files alone.
"""

import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import blockstruct as bs
from blockstruct import Q_


def store_walls(folder: Path) -> None:
    tuff = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
    dry = bs.JointMaterial("dry joint", friction_coefficient=0.65)
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    case = bs.LimitCase("tilt", dead, bs.LoadPattern("tilt +x", [bs.BodyForce((1, 0, 0))]))
    for courses in (4, 8, 12):
        rows = [[1, 1, 1], [0.5, 1, 1, 0.5]] * (courses // 2)
        blocks = bs.courses(rows, unit_length="0.4 m", unit_height="0.2 m", thickness="0.2 m", material=tuff)
        model = bs.Model(f"{courses} courses", blocks, bs.detect_interfaces(blocks, joint_material=dry).interfaces)
        bs.AnalysisManager(model, store=folder / f"wall-{courses:02}.h5").run([case])


def main(folder: str) -> dict[str, float]:
    store_walls(Path(folder))
    angles = {}
    for path in sorted(Path(folder).glob("wall-*.h5")):
        analysis = bs.open_analysis(path)
        result = analysis["tilt"]
        angles[analysis.model.name] = float(np.degrees(np.arctan(result.load_factor)))
        states = Counter(result.states.isel(iteration=-1).to_numpy().tolist())
        print(f"{analysis.model.name}: {result.status} at {angles[analysis.model.name]:.2f}°, joints {dict(states)}")
    return angles


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        main(scratch)
