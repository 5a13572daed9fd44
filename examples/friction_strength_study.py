"""A wall whose friction and compressive strength are not known: how much its load factor depends on each."""

from pathlib import Path

import blockstruct as bs
from blockstruct import Q_


def build(friction, strength):
    """A slender wall, pushed out of its plane: its toe crushes where it is weak, it slides where it is smooth."""
    tuff = bs.Material("tuff", unit_weight="16 kN/m^3")
    lime = bs.JointMaterial("lime mortar", friction, compressive_strength=strength)
    blocks = bs.courses(
        [[1, 1], [0.5, 1, 0.5], [1, 1], [0.5, 1, 0.5]],
        unit_length="0.5 m",
        unit_height="0.25 m",
        thickness="0.3 m",
        material=tuff,
    )
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint_material=lime))
    push = bs.LoadPattern("push", [bs.BodyForce("+y")])
    return model, bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")


def main(folder="runs"):
    """Load factors over friction and strength; the figure is written beside the runs."""
    store = Path(folder, "friction-strength")
    parameters = {"friction": [0.15, 0.25, 0.3, 0.6], "strength": Q_([0.05, 0.1, 0.5], "MPa")}
    data = bs.study(build, parameters, store, workers=1)
    try:
        from blockstruct.views import figures
    except bs.errors.MissingExtraError:
        return data
    ax = None
    for strength in data.strength.to_numpy():
        alpha = data.load_factor.sel(case="push", strength=strength)
        ax = figures.curve(alpha, label=f"f_c = {strength:g} MPa", ax=ax)
    ax.figure.savefig(store / "load-factors.png", dpi=150)
    return data


if __name__ == "__main__":
    print(main().load_factor.sel(case="push").to_pandas().round(4))
