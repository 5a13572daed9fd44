"""Draws every picture of the README and of docs/gallery.md: ``make pictures``."""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct import Q_
from blockstruct.views import figures

HERE = Path(__file__).parent
TUFF = bs.Material("tuff", unit_weight=Q_(18, "kN/m^3"))
LIME = bs.JointMaterial("lime mortar", friction_coefficient=0.65)
DEAD = bs.LoadPattern("dead", [bs.SelfWeight()])
PUSH = bs.LoadPattern("push +x", [bs.BodyForce((1, 0, 0))])
#: Faces of a body between two quadrilaterals, 0 1 2 3 and 4 5 6 7.
FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]

Drawn = tuple[bs.Model, bs.CaseResult]


def solved(
    name: str,
    blocks: list[bs.Block],
    variable: bs.LoadPattern = PUSH,
    dead: bs.LoadPattern = DEAD,
    joint: bs.JointMaterial = LIME,
) -> Drawn:
    model = bs.Model(name, blocks, bs.detect_interfaces(blocks, joint_material=joint).interfaces)
    result = bs.AnalysisManager(model).run([bs.LimitCase(name, dead, variable)])[name]
    print(f"{len(model.blocks)} blocks, {result}")
    return model, result


def wall_with_opening() -> Drawn:
    solid, half = [1, 1, 1, 1], [0.5, 1, 1, 1, 0.5]
    jamb, toothed = [0.5, 1, -1, 1, 0.5], [1, 0.5, -1, 0.5, 1]
    rows = [solid, half, solid, jamb, toothed, jamb, [1, 2, 1], half, solid]
    size = {"unit_length": "0.4 m", "unit_height": "0.175 m", "depth": "0.3 m"}
    return solved("wall with an opening, pushed", bs.courses(rows, **size, material=TUFF))


def arch(voussoirs: int = 15, radius: float = 2.0, thickness: float = 0.36) -> Drawn:
    angles = np.linspace(np.pi, 0, voussoirs + 1)
    r = radius + thickness * np.array([-0.5, 0.5])
    x, z = (np.outer(f(angles), r) for f in (np.cos, np.sin))

    def voussoir(k: int) -> bs.Block:
        corners = [(k, 0), (k, 1), (k + 1, 1), (k + 1, 0)]
        vertices = [(x[c], y, z[c]) for y in (0.0, 0.6) for c in corners]
        return bs.Block.from_faces(f"voussoir {k + 1}", Q_(vertices, "m"), FACES, TUFF)

    blocks = [voussoir(k) for k in range(voussoirs)]
    blocks += [
        bs.Block.box(f"abutment at {at} m", Q_([at - 0.3, 0, -0.3], "m"), Q_([0.6, 0.6, 0.3], "m"), TUFF, fixed=True)
        for at in (-radius, radius)
    ]
    load = bs.PointLoad("voussoir 5", Q_(blocks[4].centroid, "m"), "[0, 0, -1] kN")
    return solved("arch under a load at its quarter", blocks, bs.LoadPattern("1 kN", [load]))


def dome(sectors: int = 16, rings: int = 7, radius: float = 2.5, thickness: float = 0.3) -> Drawn:
    """A dome with an oculus; its lowest ring is fixed."""
    around = np.linspace(0, 2 * np.pi, sectors + 1)
    up = np.radians(np.linspace(0, 78, rings + 1))
    r = radius + thickness * np.array([-0.5, 0.5])

    def point(i: int, j: int, k: int) -> tuple[float, float, float]:
        return (
            r[k] * np.cos(up[j]) * np.cos(around[i]),
            r[k] * np.cos(up[j]) * np.sin(around[i]),
            r[k] * np.sin(up[j]),
        )

    def voussoir(i: int, j: int) -> bs.Block:
        vertices = [point(i + di, j + dj, k) for k in (0, 1) for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
        return bs.Block.from_faces(f"{j + 1}.{i + 1}", Q_(vertices, "m"), FACES, TUFF, fixed=j == 0)

    return solved("dome, pushed", [voussoir(i, j) for j in range(rings) for i in range(sectors)])


def pier_spandrel() -> Drawn:
    """The example of that name, with mortar that crushes at 4 MPa."""
    sys.path.insert(0, str(HERE.parent / "examples"))
    from pier_spandrel import assemblage

    mortar = bs.JointMaterial("mortar", friction_coefficient=0.6, compressive_strength="4 MPa")
    piers = [bs.PointLoad(f"beam at {x} m", Q_([x + 0.85, 0.155, 3.62], "m"), "[0, 0, -200] kN") for x in (0, 3.4)]
    push = [bs.PointLoad(f"{j}.1", Q_([0, 0.155, j / 10 - 0.05], "m"), "[0.1, 0, 0] kN") for j in range(27, 37)]
    dead = bs.LoadPattern("self-weight and 200 kN on each pier", [bs.SelfWeight(), *piers])
    blocks = list(assemblage().blocks)
    return solved("pier and spandrel, crushing", blocks, bs.LoadPattern("1 kN", push), dead, mortar)


def save(name: str, draw: Callable[..., Axes], size: tuple[float, float] = (5.2, 3.2), look: str | None = None) -> None:
    figure = Figure(figsize=size, layout="constrained")
    ax = figure.add_subplot(projection="3d" if look == "3d" else None)
    draw(ax=ax, **({} if look is None else {"look": look}))
    if look == "3d":
        ax.set_axis_off()
    target = HERE / "pictures" / f"{name}.png"
    figure.savefig(target, dpi=110, pil_kwargs={"optimize": True})
    print(f"{target.name}: {target.stat().st_size / 1e3:.0f} kB")


def main() -> None:
    mpl.use("Agg")
    (HERE / "pictures").mkdir(exist_ok=True)
    for name, build, look in (
        ("wall", wall_with_opening, "y"),
        ("arch", arch, "y"),
        ("dome", dome, "3d"),
        ("pier-spandrel", pier_spandrel, "y"),
    ):
        model, result = build()
        save(f"{name}-mechanism", partial(figures.mechanism, model, result), look=look)
        save(f"{name}-states", partial(figures.structure, model, result), look=look)
        if name == "arch":
            save(f"{name}-forces", partial(figures.forces, model, result), look=look)
        if name == "wall":
            save("wall-convergence", partial(figures.convergence, result))
            save("wall-certificate", partial(figures.certificate, result), size=(6.2, 3.2))
        if name == "pier-spandrel":
            moments = abs(result.resultants["moment"].isel(iteration=-1).sel(component=["s", "t"]))
            most, about = np.unravel_index(np.argmax(moments.to_numpy()), moments.shape)
            joint = {"interface": str(moments.interface.to_numpy()[most]), "about": "st"[about]}
            save(f"{name}-utilisation", partial(figures.structure, model, result, colour="crushing"), look=look)
            save(f"{name}-domain", partial(figures.crushing_domain, model, result, **joint))


if __name__ == "__main__":
    main()
