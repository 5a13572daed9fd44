"""Time and size of the views of a wall of 2,400 blocks and 20 iterations: ``make bench-views``.

What is drawn does not depend on how good the answer is: the one associative program of the wall is solved and its
iteration repeated, so that the benchmark is of the views and not of the solver.
"""

import argparse
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from playwright.sync_api import sync_playwright

import blockstruct as bs
from blockstruct.views import figures
from blockstruct.views.page import write_page
from blockstruct.views.paraview import write_paraview
from blockstruct.views.report import write_report


def wall(columns: int, rows: int, iterations: int) -> bs.Analysis:
    tuff, dry = bs.Material("tuff", unit_weight="12 kN/m^3"), bs.JointMaterial("dry", friction_coefficient=0.65)
    bond = [[1] * columns if j % 2 == 0 else [0.5] + [1] * (columns - 1) + [0.5] for j in range(rows)]
    blocks = bs.courses(bond, unit_length="0.4 m", unit_height="0.175 m", thickness="0.2 m", material=tuff)
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint_material=dry).interfaces)
    dead, push = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))])
    analysis = bs.AnalysisManager(model).run([bs.LimitCase("push", dead, push, "associative")])
    result = analysis["push"]
    history = result.history.isel(iteration=np.zeros(iterations, dtype=int))
    history = history.assign_coords(iteration=np.arange(iterations))
    # No two iterations alike: equal ones would compress.
    noise = np.random.default_rng(1).normal(1, 0.1, history["contact_force"].shape)
    history["contact_force"] = history["contact_force"] * noise
    results = {"push": replace(result, history=history)}
    return bs.Analysis(model, results, analysis.created_at, analysis.versions)


def timed(name: str, step: Callable[[], object]) -> None:
    start = perf_counter()
    made = step()
    seconds = perf_counter() - start
    size = sum(p.stat().st_size for p in made.parent.rglob("*") if p.is_file()) / 1e6 if isinstance(made, Path) else 0.0
    print(f"{name:<24}{seconds:7.2f} s" + (f"{size:9.2f} MB" if size else ""))
    plt.close("all")


def slider(page: Path, steps: int = 10) -> None:
    """Time of a step of the slider of the mechanism, in a browser that draws without a graphics card."""
    path = shutil.which("chromium")
    if path is None:
        print("no Chromium: the slider of the page is not timed")
        return
    with sync_playwright() as play:
        options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        tab = play.chromium.launch(executable_path=path, args=options).new_page()
        tab.goto(page.as_uri())
        tab.wait_for_selector("body[data-ready=yes]", timeout=120_000)
        profiler = tab.context.new_cdp_session(tab)
        profiler.send("Profiler.enable")
        profiler.send("Profiler.start")
        seconds = tab.evaluate(
            """async steps => {
                const view = document.getElementById("view"), slider = document.getElementById("amplitude");
                const start = performance.now();
                for (let k = 1; k <= steps; k++) {
                    const drawn = new Promise(done => view.once("plotly_afterplot", done));
                    slider.value = 0.2 * k / steps;
                    slider.dispatchEvent(new Event("input"));
                    await drawn;
                }
                return (performance.now() - start) / 1e3;
            }""",
            steps,
        )
        profile = profiler.send("Profiler.stop")["profile"]
    # Reading pixels back waits for the picture, which here the processor draws.
    drawing = {n["id"] for n in profile["nodes"] if n["callFrame"]["functionName"] == "readPixels"}
    waited = sum(t for n, t in zip(profile["samples"], profile["timeDeltas"], strict=True) if n in drawing) / 1e6
    print(f"{'a step of the slider':<24}{seconds / steps:7.2f} s, {waited / steps:.2f} s of it drawing without a GPU")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--columns", type=int, default=40)
    parser.add_argument("--rows", type=int, default=60)
    parser.add_argument("--iterations", type=int, default=20)
    size = parser.parse_args()
    mpl.use("Agg")
    analysis = wall(size.columns, size.rows, size.iterations)
    model, result = analysis.model, analysis["push"]
    print(f"{len(model.blocks)} blocks, {len(model.interfaces)} interfaces, {result.n_iterations} iterations")

    def drawn(draw: Callable[..., object], **options: object) -> Callable[[], None]:
        return lambda: draw(result, **options).figure.canvas.draw()  # type: ignore[attr-defined]

    with tempfile.TemporaryDirectory() as scratch:
        folders = [Path(scratch) / name for name in ("page", "report", "paraview")]
        for folder in folders:
            folder.mkdir()
        for look in ("y", "3d"):
            for draw in (figures.structure, figures.mechanism, figures.forces):
                timed(f"{draw.__name__}, {look}", drawn(draw, look=look))
        page = folders[0] / "wall.html"
        timed("page", lambda: write_page(analysis, page))
        slider(page)
        timed("report", lambda: write_report(analysis, folders[1] / "wall.html"))
        timed("paraview", lambda: write_paraview(analysis["push"], folders[2] / "wall.pvd"))


if __name__ == "__main__":
    main()
