"""Runs the campaign, and writes docs/validation.jsonl and the tables and figures of docs/validation.md.

``make validation`` calls it. A run that was stopped continues with the structures that are missing; delete
docs/validation.jsonl to begin again.
"""

import argparse
import json
import math
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from statistics import median

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import blockstruct as bs

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests" / "support"))
import campaign  # noqa: E402 - of a folder that is not a package
import published  # noqa: E402
from campaign import Findings, Run  # noqa: E402
from random_structures import KINDS, names, structure  # noqa: E402

NUMBERS, PAGE = HERE / "validation.jsonl", HERE / "validation.md"
#: The procedures that are compared, and their colours.
PROCEDURES = {"path": ("loading path", "#0072b2"), "fictitious": ("fictitious conditions", "#d55e00")}
STATUSES = ("converged", "unstable_under_dead_load", "unbounded")
#: Structures of each kind in the long table, and those whose paths are drawn.
LISTED = 3
DRAWN = ("openings 0", "front 2", "dome 0")
#: Difference beyond which a number counts as another one.
APART = 0.01


def warm_up() -> None:
    """Load what the first case of a process loads, whose time is no case's own."""
    campaign.findings(structure("by hand 0"))


def run(wanted: Iterable[str], workers: int) -> None:
    """Add the structures that are missing to the numbers."""
    done = {found.name for found in read()}
    missing = [structure(name) for name in wanted if name not in done]
    with NUMBERS.open("a", encoding="utf-8") as stream, ProcessPoolExecutor(workers, initializer=warm_up) as pool:
        for found in pool.map(campaign.findings, missing):
            stream.write(json.dumps(asdict(found)) + "\n")
            stream.flush()
            print(found.name, found.path.status, found.path.load_factor, found.reference, flush=True)


def read() -> list[Findings]:
    """All numbers, in the order of the structures."""
    if not NUMBERS.exists():
        return []
    rows = [json.loads(line) for line in NUMBERS.read_text(encoding="utf-8").splitlines()]
    for row in rows:
        row |= {key: Run(**row[key]) for key in ("associative", *PROCEDURES)}
        row["variants"] = {key: Run(**value) for key, value in row["variants"].items()}
    order = names()
    return sorted((Findings(**row) for row in rows), key=lambda found: order.index(found.name))


def errors(rows: list[Findings], procedure: str) -> np.ndarray:
    """Relative errors of a procedure where there is a reference."""
    found = np.array([r.error(getattr(r, procedure)) for r in rows])
    return found[np.isfinite(found)]


def times(rows: list[Findings]) -> str:
    """Median processor times of whole cases, in those of the associative case."""
    return ", ".join(
        f"{median(getattr(r, procedure).seconds / r.associative.seconds for r in rows):.1f}" for procedure in PROCEDURES
    )


def percent(value: float) -> str:
    return "" if math.isnan(value) else f"{100 * value:+.2f}".replace("-0.00", "+0.00")


def table(headings: list[str], rows: Iterable[list[object]]) -> str:
    """A table of texts and numbers, the first column to the left."""
    lines = [headings, ["---", *["---:"] * (len(headings) - 1)], *rows]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)


def facts(rows: list[Findings]) -> str:
    """What holds for all structures, counted."""
    converged = [r for r in rows if r.path.status == "converged"]
    certified = sum(r.path.certified for r in converged)
    above = max(r.path.load_factor / r.associative.load_factor - 1 for r in converged)
    gaps = [r.path.gap / r.path.load_factor for r in converged if r.path.settled]
    known = np.abs(errors(rows, "path"))
    raised = [r.path.load_factor / r.without_crushing - 1 for r in rows if math.isfinite(r.without_crushing)]
    return "\n".join(
        [
            f"- {len(rows)} structures, no exception. {certified} of {len(converged)} converged states are certified.",
            f"- The load factor passes the associative bound by {max(above, 0):.1e} at most.",
            f"- Flow-rule gap over load factor of settled states: median {median(gaps):.0e}, at most {max(gaps):.0e}.",
            f"- {len(raised)} structures crush: {percent(max(raised))} % from those without crushing, or less.",
            f"- {len(known)} structures have a reference. The path is within 1 % of {sum(known <= APART)} of them.",
        ]
    )


def by_kind(rows: list[Findings]) -> str:
    headings = ["kind", "structures", "blocks", "converge / fall / unbounded / other", "settled", "compared"]
    headings += ["path: median, worst %", "fictitious: median, worst %", "time: path, fictitious"]
    lines = []
    for kind in [*KINDS, "all"]:
        own = [r for r in rows if kind in (r.kind, "all")]
        if own:
            statuses = [r.path.status for r in own]
            counts = [statuses.count(status) for status in STATUSES]
            ended = " / ".join(map(str, [*counts, len(own) - sum(counts)]))
            settled, blocks = sum(r.path.settled for r in own), [r.blocks for r in own]
            line = [kind, len(own), f"{min(blocks)}–{max(blocks)}", ended, settled, len(errors(own, "path"))]
            for procedure in PROCEDURES:
                error = errors(own, procedure)
                worst = percent(max(error, key=abs, default=math.nan))
                line.append(f"{100 * np.median(np.abs(error)):.3f}, {worst}" if len(error) else "")
            lines.append([*line, times(own)])
    return table(headings, lines)


def by_variant(rows: list[Findings]) -> str:
    lines = []
    for variant in (*campaign.SAME, *campaign.STEPS):
        apart = {r.name: r.differs(variant) for r in rows if r.path.settled and variant in r.variants}
        furthest = max(apart, key=lambda name: apart[name], default="")
        beyond = sum(difference > APART for difference in apart.values())
        lines.append([variant, len(apart), beyond, f"{100 * apart.get(furthest, 0):.2f} %, {furthest}"])
    return table(["variant", "structures", "more than 1 % apart", "furthest"], lines)


def by_structure(rows: list[Findings]) -> str:
    headings = ["structure", "blocks", "associative", "path", "fictitious", "reference"]
    headings += ["error of path, %", "of fictitious, %", "time: path, fictitious"]
    lines = []
    for kind in KINDS:
        known = [r for r in rows if r.kind == kind and math.isfinite(r.error(r.path))]
        for r in known[:LISTED]:
            factors = [f"{run.load_factor:.4g}" for run in (r.associative, r.path, r.fictitious)]
            how = "path" if r.exact is None else "hand"
            error = [percent(r.error(run)) for run in (r.path, r.fictitious)]
            lines.append([r.name, r.blocks, *factors, f"{r.reference:.4g}, {how}", *error, times([r])])
    return table(headings, lines)


def by_published() -> str:
    """Published walls: associative and lowest known load factors, and the two paths."""
    headings = ["wall", "associative, published", "found", "error, %", "lowest known", "fictitious", "error, %"]
    lines = []
    for wall, (_, _, _, upper, lowest) in published.WALLS.items():
        found = campaign.findings(published.wall(wall), variants=False)
        line: list[object] = [wall]
        for known, run in ((upper, found.associative), (lowest, found.fictitious)):
            line += [known, f"{run.load_factor:.5g}", percent(run.load_factor / known - 1)]
        line += [f"{found.path.load_factor:.5g}", f"{found.independent:.5g}", percent(found.error(found.path))]
        lines.append(line)
    return table([*headings, "path", "independent path", "error, %"], lines)


def write_page(tables: dict[str, str]) -> None:
    """Replace the tables between the marks of the page."""
    text = PAGE.read_text(encoding="utf-8")
    for mark, lines in tables.items():
        begin, end = f"<!-- {mark} -->\n", f"\n<!-- end of {mark} -->"
        before, _, rest = text.partition(begin)
        text = before + begin + lines + end + rest.partition(end.strip())[2]
    PAGE.write_text(text, encoding="utf-8")


def draw_errors(rows: list[Findings]) -> None:
    figure = Figure(figsize=(6.2, 3.0), layout="constrained")
    ax = figure.add_subplot()
    bins = np.logspace(-6, 0, 25)
    for procedure, (label, colour) in PROCEDURES.items():
        size = np.clip(np.abs(errors(rows, procedure)), bins[0], bins[-1])
        ax.hist(size, bins, alpha=0.5, color=colour, label=label)
    ax.set_xscale("log")
    ax.set(xlabel="relative error of the load factor, 1e-6 and below in the first bar", ylabel="structures")
    ax.legend()
    save(figure, "validation-errors")


def draw_paths() -> None:
    figure = Figure(figsize=(6.2, 2.8), layout="constrained")
    label, colour = PROCEDURES["path"]
    for ax, name in zip(figure.subplots(1, len(DRAWN)), DRAWN, strict=True):
        case = structure(name)
        path = campaign.path_of(case)
        settings = bs.ProcedureSettings(procedure="loading path")
        limit_case = bs.LimitCase("case", case.dead, case.variable)
        history = bs.AnalysisManager(case.model, settings=settings).run([limit_case])["case"].history
        steps = history.isel(iteration=np.flatnonzero(history.stage.to_numpy() == "loading_path"))
        ax.plot(path.displacement[1:], path.load_factor[1:], color="0.6", label="independent path")
        ax.plot(steps.displacement[1:], steps.load_factor[1:], "o", color=colour, markersize=3, label=label)
        ax.axhline(float(history.load_factor[-1]), color=colour, linewidth=0.8, linestyle="--", label="closed")
        ax.set_xscale("log")
        ax.set(title=name, xlabel="elastic displacements")
        ax.set_ylim(bottom=0)
    figure.axes[0].set_ylabel("load factor")
    figure.axes[0].legend(fontsize="small")
    save(figure, "validation-paths")


def save(figure: Figure, name: str) -> None:
    target = HERE / "pictures" / f"{name}.png"
    figure.savefig(target, dpi=110, pil_kwargs={"optimize": True})
    print(f"{target.name}: {target.stat().st_size / 1e3:.0f} kB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=1000, help="structures of each kind, all by default")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    arguments = parser.parse_args()
    mpl.use("Agg")
    run([name for name in names() if int(name.rpartition(" ")[2]) < arguments.each], arguments.workers)
    rows = read()
    write_page(
        {
            "facts": facts(rows),
            "kinds": by_kind(rows),
            "variants": by_variant(rows),
            "published": by_published(),
            "structures": by_structure(rows),
        }
    )
    draw_errors(rows)
    draw_paths()


if __name__ == "__main__":
    main()
