"""Draws every picture of the README and of docs/gallery.md: ``make pictures``."""

import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct import Q_
from blockstruct.structures import Buttress, RoundOpening
from blockstruct.views import figures

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "examples"))
import pier_spandrel as example  # noqa: E402 - of a folder that is not a package

TUFF = bs.Material("tuff", unit_weight=Q_(18, "kN/m^3"))
LIME = bs.JointMaterial("lime mortar", friction_coefficient=0.65)
DEAD = bs.LoadPattern("dead", [bs.SelfWeight()])
PUSH = bs.LoadPattern("push +x", [bs.BodyForce((1, 0, 0))])

Drawn = tuple[bs.Model, bs.CaseResult]


def solved(name: str, blocks: list[bs.Block], variable: bs.LoadPattern = PUSH) -> Drawn:
    found = bs.detect_interfaces(blocks, joint_material=LIME)
    model = bs.Model(name, blocks, found)
    return run(model, bs.LimitCase(name, DEAD, variable))


def run(model: bs.Model, case: bs.LimitCase) -> Drawn:
    result = bs.AnalysisManager(model).run([case])[case.name]
    print(f"{len(model.blocks)} blocks, {result}")
    return model, result


def carried_out(page: Path) -> dict[str, Any]:
    """Run the cells of a page, and return its names."""
    cells = re.findall(r"```{code-cell} ipython3\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile("\n".join(cells), page.name, "exec"), names)
    return names


def of_page(name: str) -> Drawn:
    """Return model and result of a page of the gallery."""
    names = carried_out(HERE / "gallery" / f"{name}.md")
    return names["model"], names["result"]


def dome() -> Drawn:
    blocks = bs.structures.dome(span="5 m", thickness="0.35 m", courses=7, units=14, oculus="1 m", material=TUFF)
    return solved("dome, pushed", blocks)


def pier_spandrel() -> Drawn:
    """The example of that name, with mortar that crushes at 4 MPa."""
    whole = example.assemblage()
    mortar = example.MORTAR.varied(compressive_strength=Q_(4, "MPa"))
    joints = [i.with_joint_material(mortar) for i in whole.interfaces]
    return run(bs.Model("pier and spandrel, crushing", whole.blocks, joints), example.pushed())


def church_front() -> Drawn:
    """A front with a portal, a round window, a gable and buttresses, which carries a nave roof and a bell."""
    portal = bs.structures.Opening("2 m", "0 m", "1.5 m", "1.5 m", rise="0.75 m", ring="0.3 m", voussoirs=13)
    window = RoundOpening(["2.75 m", "3.75 m"], diameter="0.7 m", ring="0.2 m", voussoirs=12)
    piers = [
        Buttress(name, at=at, width="0.5 m", courses=10, projection="1 m", top_projection="0.4 m")
        for name, at in (("west", "0.25 m"), ("east", "4.75 m"))
    ]
    size = {"length": "5.5 m", "courses": 14, "unit_length": "0.5 m", "unit_height": "0.25 m", "thickness": "0.5 m"}
    blocks = bs.wall(**size, material=TUFF, openings=[portal, window], buttresses=piers, gable="1.25 m")
    model = bs.Model("church front, pushed outwards", blocks, bs.detect_interfaces(blocks, joint_material=LIME))
    apex = max(blocks, key=lambda block: block.shape.vertices[:, 2].max())
    bell = bs.Weight(apex.name, Q_(apex.centroid + np.array([0, 0, 0.8]), "m"), "8 kN")
    tie_beams = [
        bs.LineLoad("12 kN/m", [f"{x} m", "0.5 m", "3.5 m"], [f"{x + 0.5} m", "0.5 m", "3.5 m"]) for x in (0.25, 4.75)
    ]
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bell, *tie_beams])
    push = bs.LoadPattern("push -y", [bs.BodyForce("-y")])
    return run(model, bs.LimitCase(model.name, dead, push))


def curves(model: bs.Model) -> None:
    """Load factor of the wall over the friction and the strength of its joints."""
    case = bs.LimitCase("push", DEAD, PUSH)

    def build(**properties: Any) -> tuple[bs.Model, bs.LimitCase]:
        joints = [i.with_joint_material(i.joint_material.varied(**properties)) for i in model.interfaces]
        return bs.Model(model.name, model.blocks, joints), case

    strengths = [None, *(Q_(f, "kPa") for f in (1000, 500, 250, 150, 100, 75, 60))]
    for name, values in (
        ("friction_coefficient", [0.3, 0.4, 0.5, 0.6, 0.7, 0.8]),
        ("compressive_strength", strengths),
    ):
        load_factor = bs.study(build, {name: values}, workers=1).load_factor.sel(case="push")
        save(f"wall-{name.partition('_')[0]}", partial(figures.curve, load_factor), (6.2, 3.0))


def save(name: str, draw: Callable[..., Axes], size: tuple[float, float] = (6.2, 3.8)) -> None:
    figure = Figure(figsize=size, layout="constrained")
    draw(ax=figure.add_subplot())
    target = HERE / "pictures" / f"{name}.png"
    figure.savefig(target, dpi=110, pil_kwargs={"optimize": True})
    print(f"{target.name}: {target.stat().st_size / 1e3:.0f} kB")


def thumbnails() -> None:
    """Run the pages of the gallery and draw the last figure of each, small."""
    size = (3.2, 2.4)
    for page in sorted((HERE / "gallery").glob("*.md")):
        # Figures that keep no size of their own are laid out for this one.
        with mpl.rc_context({"figure.figsize": size}):
            carried_out(page)
        plt.gcf().set_size_inches(size)
        plt.gcf().savefig(HERE / "pictures" / f"gallery-{page.stem}.png", dpi=90, pil_kwargs={"optimize": True})
        plt.close("all")


def main() -> None:
    mpl.use("Agg")
    thumbnails()
    (HERE / "pictures").mkdir(exist_ok=True)
    for name, build in (
        ("wall", partial(of_page, "wall")),
        ("arch", partial(of_page, "arch")),
        ("dome", dome),
        ("pier-spandrel", pier_spandrel),
        ("church-front", church_front),
    ):
        model, result = build()
        save(f"{name}-mechanism", partial(figures.mechanism, result))
        save(f"{name}-states", partial(figures.structure, result))
        if name == "arch":
            save(f"{name}-forces", partial(figures.forces, result))
        if name == "wall":
            save("wall-convergence", partial(figures.convergence, result), size=(6.2, 3.0))
            save("wall-certificate", partial(figures.certificate, result), size=(6.2, 3.0))
            curves(model)
        if name == "church-front":
            save(f"{name}-loads", partial(figures.loads, result, look=(-60, 20)))
        if name == "pier-spandrel":
            moments = abs(result.resultants["moment"].isel(iteration=-1).sel(component=["s", "t"])).to_numpy()
            most, about = np.unravel_index(np.argmax(moments), moments.shape)
            joint = {"interface": model.interfaces[most].name, "about": "st"[about]}
            save(f"{name}-utilisation", partial(figures.structure, result, colour="crushing"))
            save(f"{name}-domain", partial(figures.crushing_domain, result, **joint), size=(6.2, 3.2))


if __name__ == "__main__":
    main()
