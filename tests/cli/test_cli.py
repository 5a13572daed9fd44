"""The command: what it prints, its exit codes, and imports."""

import io
import json
import os
import re
import shutil
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import ezdxf
import numpy as np
import pandas as pd
import pytest
from rich.console import Console

import blockstruct as bs
from blockstruct.analysis import IterationDone
from blockstruct.views import console, figures
from blockstruct.views.console import following
from meshes import CUBE, objects_text, saved
from structures import SELF_WEIGHT, model_of, push, single_block, stopping

WALL = Path(__file__).parents[2] / "examples" / "ferris_tin_loi_wall_1.yaml"

#: What they show is tested with the views.
pytestmark = pytest.mark.usefixtures("blank_pictures")


def written(folder, case):
    """A block that rocks at 0.5, as a model document."""
    return bs.write_document(folder / "block.yaml", model_of(*single_block(0.5, 1.0), name="block"), [case])


@pytest.fixture
def document(tmp_path):
    return written(tmp_path, bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative"))


@pytest.fixture(scope="module")
def file(small_analysis, tmp_path_factory):
    return bs.save_analysis(small_analysis, tmp_path_factory.mktemp("cli") / "small.h5")


def test_demo(call, tmp_path):
    target = tmp_path / "demo.h5"
    code, out, err = call("demo", "-o", target)
    assert code == 0
    # Without a terminal, progress is a line per iteration.
    assert not re.search(r"^ *# ", out, re.MULTILINE)
    assert f"next: blockstruct view {target}, blockstruct report {target}, or" in out
    _, table, _ = call("history", target, "push +x, nonassociative")
    assert max(map(len, table.splitlines())) <= 80
    result = bs.open_analysis(target)["push +x, nonassociative"]
    assert (result.status, result.outcome.procedure, result.settled) == ("converged", "loading path", True)
    assert str(result.headline) in out
    assert len(err.splitlines()) > result.n_iterations


def test_a_run_names_the_extras_of_next_commands(done, file, monkeypatch):
    monkeypatch.setattr("blockstruct.cli.runs.find_spec", lambda name: None if name == "plotly" else name)
    (needs,) = done("resume", file).partition("\nnext: ")[2].splitlines()[1:]
    assert needs == 'view needs: pip install "blockstruct[viz]"'


def test_a_run_writes_beside_its_document(call, fails, document, tmp_path):
    """Quietly, it prints nothing at all."""
    assert call("run", document, "--quiet") == (0, "", "")
    assert bs.open_analysis(document.with_suffix(".h5"))["push"].load_factor == pytest.approx(0.5, rel=1e-6)
    out = call("show", document.with_suffix(".h5"))[1]
    assert [words for words in ("2 blocks, 1 interface\n", "collapses at load factor 0.5") if words not in out] == []
    fails("there is no folder", "run", document, "-o", tmp_path / "none" / "block.h5")
    assert not (tmp_path / "none").exists()


def test_the_last_iteration_and_one_interface_of_a_history(call, fails, file, tmp_path, small_analysis):
    name = "push nonassociative"
    assert call("history", file)[1].splitlines() == list(small_analysis)
    history = small_analysis[name].history
    _, out, _ = call("history", file, name, "--last")
    assert [line.split()[0] for line in out.splitlines()] == ["#", str(history.sizes["iteration"] - 1)]
    force = history.isel(iteration=slice(-1, None)).blockstruct.frame("force")
    of_joint = force[force.index.get_level_values("interface") == "base|1.1"]
    assert call("history", file, name, "--last", "--interface", "base|1.1")[1] == f"{of_joint.to_string()}\n"
    words, table = ("--interface", "base|1.1", "--last"), tmp_path / "t.csv"
    call("history", file, name, "--variable", "contact_force", *words, "--csv", table)
    of_points = history["contact_force"].sel(contact_point="base|1.1")[-1]
    rows = pd.read_csv(table)["contact_force [newton]"]
    assert rows.tolist() == pytest.approx(of_points.to_numpy().ravel().tolist())
    fails("no 'base|1.9'; did you mean", "history", file, name, "--interface", "base|1.9")
    fails("not one of interfaces", "history", file, name, "--variable", "block_velocity", *words)


def test_a_case_without_load_factor_exits_with_3(call, document, tmp_path):
    """JSON is the only output then, with None for numbers that there are not."""
    down = document.read_text(encoding="utf-8").replace("direction: [1.0, 0.0, 0.0]", "direction: [0, 0, -1]")
    document.write_text(down, encoding="utf-8")
    code, out, err = call("run", document, "-o", tmp_path / "m.h5", "--json", "--quiet")
    assert (code, err) == (3, "")
    (case,) = json.loads(out)["cases"]
    assert (case["status"], case["load_factor"], case["certificate"]) == ("unbounded", None, None)
    assert (tmp_path / "m.h5").exists()


def test_an_interrupted_study_continues(call, done, tmp_path, monkeypatch):
    def interrupt(progress):
        if progress.done:
            raise KeyboardInterrupt

    words = ("study", WALL.with_name("friction_study.yaml"), "-o", tmp_path / "runs", "--workers", 1)
    with monkeypatch.context() as patched:
        patched.setattr(console, "study_following", lambda *_, **__: nullcontext([interrupt]))
        code, _, err = call(*words)
    assert (code, err.splitlines()[0]) == (130, "interrupted")
    assert len(list((tmp_path / "runs").glob("*.h5"))) == 1
    done(*words)


def test_an_interrupted_run_exits_with_130(call, document, tmp_path, monkeypatch):
    monkeypatch.setattr(bs.analysis, "print_lines", stopping)
    code, out, _ = call("run", document, "-o", tmp_path / "wall.h5")
    assert code == 130
    assert f"next: blockstruct resume {tmp_path / 'wall.h5'} for the rest" in out
    assert bs.open_analysis(tmp_path / "wall.h5").status == "interrupted"
    for words in (("--last",), ("--last", "--variable", "load_factor"), ("--last", "--interface", "ground|block")):
        assert call("history", tmp_path / "wall.h5", "push", *words)[::2] == (0, "")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps the folder that is worked in")
@pytest.mark.parametrize("words", [["run", WALL, "-o", "x.h5"], ["view", "FILE", "-o", "x.html"]])
def test_an_output_in_a_folder_that_was_deleted_names_it(call, file, tmp_path, monkeypatch, words):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    code, _, err = call(*(file if w == "FILE" else w for w in words))
    assert (code, err.startswith(f"error: {words[-1]}: ")) == (2, True)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["history", "FILE", "nothing"], "'nothing'"),
        (["history", "FILE", "push nonassociative", "--variable", "colour"], "'colour' load_factor"),
        (["history", "FILE", "push nonassociative", "--csv", "FILE"], "small.h5 .csv"),
        (["show", "missing.h5"], "missing.h5 no such file"),
        (["run", str(WALL), "-o", "/proc/x/y.h5"], "folder /proc/x"),
        (["run", str(WALL), "-o", str(WALL)], "not replaced"),
        (["view", "FILE", "-o", "/proc/x/y.html"], "/proc/x/y.html written"),
        (["view", "FILE", "-o", "view.pdf"], "view.pdf .html"),
        (["view", "FILE", "-o", f"{'a' * 250}.html"], "written too long"),
        (["report", "FILE", "-o", "r.docx"], "r.docx .html .pdf"),
        (["report", "FILE", "--project", "noeq"], "--project 'noeq'"),
        (["archive", ".", "--where", "colour == 1"], "colour"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(call, file, tmp_path, monkeypatch, words, expected):
    monkeypatch.chdir(tmp_path)
    code, _, err = call(*(file if w == "FILE" else w for w in words))
    assert code == 2
    assert err.startswith("error: ")
    assert [word for word in expected.split() if word not in err] == []
    assert list(tmp_path.iterdir()) == []


def killed_run(path, small_model, small_cases):
    stop = stopping(IterationDone, at=4, case=small_cases[1].name, error=RuntimeError)
    with pytest.raises(RuntimeError):
        bs.AnalysisManager(small_model, path, listeners=[stop]).run(small_cases)


def test_recover_and_resume(call, fails, done, small_model, small_cases, small_analysis, tmp_path):
    path = tmp_path / "x.h5"
    killed_run(path, small_model, small_cases)
    for command in ("show", "view", "report"):
        fails(f"blockstruct recover {path}", command, path)
    code, _, err = call("run", WALL, "-o", path)
    assert (code, "(blockstruct resume)" in err, "(blockstruct recover)" in err) == (2, True, True)
    for command in ("show", "validate", "recover", "resume"):
        fails(f"give the name of its file, {path}", command, f"{path}.partial")
    assert f"written: {path}" in done("recover", path)
    cut = bs.open_analysis(path)[small_cases[1].name]
    assert (cut.status, cut.outcome.reason, cut.n_iterations) == ("interrupted", "killed", 5)
    code, out, err = call("resume", path)
    assert (code, "load factor" in err, f"written: {path}" in out) == (0, True, True)
    assert bs.results.compare(bs.open_analysis(path), small_analysis).agrees()
    fails("no working data", "recover", path)
    killed_run(path, small_model, small_cases)
    assert call("resume", path, "--quiet") == (0, "", "")
    assert bs.results.compare(bs.open_analysis(path), small_analysis).agrees()


def test_archive(done, file, tmp_path):
    (tmp_path / "sub").mkdir()
    shutil.copy(file, tmp_path / "sub" / "a.h5")
    (tmp_path / "b.h5").write_text("notes")
    out = done("archive", tmp_path)
    for word in ("sub/a.h5", "push nonassociative", "converged", "b.h5", "not a readable HDF5"):
        assert word in out
    out = done("archive", tmp_path, "--where", "flow == 'associative'")
    assert ("push associative" in out, "push nonassociative" in out) == (True, False)
    done("archive", tmp_path, "--csv", tmp_path / "t.csv")
    assert len(pd.read_csv(tmp_path / "t.csv")) == 3


def test_diff(call, fails, done, file, small_model, small_cases, tmp_path):
    other = tmp_path / "b" / "small.h5"
    bs.AnalysisManager(small_model, other).run(small_cases)
    assert "the same model, 2 cases" in done("diff", file, other)
    bs.AnalysisManager(small_model, other, settings=bs.ProcedureSettings(path_step=0.4)).run(small_cases)
    code, out, _ = call("diff", file, other, "--tolerance", "0")
    assert (code, "path_step 0.5, other 0.4" in out) == (1, True)
    assert "relative_difference" in done("diff", file.parent, other.parent, "--tolerance", "1")
    assert call("diff", file, tmp_path / "none.h5")[0] == 2
    fails("give a number of zero or more", "diff", file, file, "--tolerance", "nan")


def test_validate(call, done, file, document):
    done("validate", file)
    done("validate", document)
    text = document.read_text(encoding="utf-8")
    for wrong, words in (
        (text.replace("polyhedron:", "polyhedra:"), "/blocks/0"),
        (text + "settings: { max_program: 3 }\n", "max_program"),
        (text.replace("dead: dead", "dead: live"), "'live'"),
    ):
        document.write_text(wrong, encoding="utf-8")
        code, out, _ = call("validate", document)
        assert (code, words in out) == (4, True), out
    assert call("validate", __file__)[0] == 4


def test_the_installed_command():
    def printed(*words):
        return subprocess.run(words, check=True, capture_output=True, text=True, timeout=60).stdout

    shown = printed(Path(sys.executable).with_name("blockstruct"), "--help")
    names = "demo run show history archive diff recover resume validate migrate import check view figures report"
    assert [name for name in (*names.split(), "Exit codes") if name not in shown] == []
    assert printed(sys.executable, "-m", "blockstruct", "--version").strip() == bs.__version__


def test_figures_are_written_into_a_folder(done, file, tmp_path, monkeypatch):
    monkeypatch.setattr(figures.sheet.Drawing, "picture", lambda drawing, *_: b"drawn")
    out = done("figures", file, "-o", tmp_path, "--format", "svg", "--look", "x")
    written = [p.name for p in tmp_path.iterdir()]
    assert out.count("written: ") == len(written)
    assert "push-nonassociative-mechanism.svg" in written


def test_view_and_report_write_next_to_the_file(done, file):
    for command, name in (("view", "small.html"), ("report", "small-report.html")):
        out = done(command, file)
        target = file.with_name(name)
        assert f"written: {target}, {target.stat().st_size / 1e6:.1f} MB" in out
        assert "small wall" in target.read_text(encoding="utf-8")
        target.unlink()


def test_a_view_never_replaces_its_input(fails, file, tmp_path):
    template, page = tmp_path / "own.html", shutil.copy(file, tmp_path / "analysis.html")
    template.write_text("{{ name }}", encoding="utf-8")
    before = [path.read_bytes() for path in (file, page, template)]
    own = ("report", file, "--template", template, "-o", template)
    for words in (("view", file, "-o", file), ("report", file, "-o", file), ("view", page), own):
        fails("choose another one with --output", *words)
    assert [path.read_bytes() for path in (file, page, template)] == before


def test_analyses_and_pipes_are_no_targets(fails, file, tmp_path):
    commands = {".html": ("view", file, "-o"), ".csv": ("history", file, "push nonassociative", "--csv")}
    for suffix, command in commands.items():
        other, pipe = shutil.copy(file, tmp_path / f"other{suffix}"), tmp_path / f"pipe{suffix}"
        os.mkfifo(pipe)
        for target, words in ((other, "it is an HDF5 file"), (pipe, "it is not a regular file")):
            fails(f"cannot be written ({words}", *command, target)
        assert pipe.is_fifo()
        assert other.read_bytes() == file.read_bytes()


def test_names_that_the_output_cannot_carry_are_escaped(document):
    document.write_text(document.read_text("utf-8").replace("name: block", "name: Mauer α", 1), encoding="utf-8")
    command = [Path(sys.executable).with_name("blockstruct"), "check", document]
    done = subprocess.run(command, capture_output=True, check=False, env={**os.environ, "PYTHONIOENCODING": "cp1252"})
    assert (done.returncode, b"Mauer \\u03b1" in done.stdout) == (0, True), done.stderr


def test_a_bar_shows_case_and_iteration(small_model, small_cases):
    """Names of cases are not markup there."""
    stream, case = io.StringIO(), small_cases[1].renamed("push [/x] [red]")
    with following(Console(file=stream, force_terminal=True, width=120), quiet=False) as listeners:
        bs.AnalysisManager(small_model, listeners=[*listeners, lambda _: time.sleep(0.1)]).run([case])
    assert re.search(r"push \[/x\] \[red\]: numerical iteration \d, load factor 0\.\d{4}", stream.getvalue())


@pytest.mark.filterwarnings("default::blockstruct.errors.UnusualValueWarning")
def test_a_warning_is_one_line(call, document):
    text = document.read_text(encoding="utf-8")
    document.write_text(re.sub(r"20000.0 N/m\^3", "12 kN/mm^3", text), encoding="utf-8")
    code, out, err = call("check", document)
    assert (code, "ready to run" in out) == (0, True)
    assert err.startswith("warning: material 'stone': unit_weight 1.2e+10 kN/m³")
    assert len(err.splitlines()) == 1


def test_a_pushover_without_a_curve_exits_with_3(call, tmp_path):
    document = written(tmp_path, bs.Pushover("p", SELF_WEIGHT, push(1, 0, 0), control=("block", "+y")))
    assert call("run", document, "-o", tmp_path / "m.h5", "--quiet") == (3, "", "")
    assert bs.open_analysis(tmp_path / "m.h5")["p"].status == "converged"
    _, out, _ = call("show", tmp_path / "m.h5", "--json")
    (warning,) = json.loads(out)["cases"][0]["warnings"]
    assert warning.startswith("pushover: the control point at block 'block' does not move along +y")


def test_corners_too_round_are_refused_before_the_run(call, done, tmp_path):
    control = {"control": ("block", "+x"), "corner_rounding": "0.247 m"}
    document = written(tmp_path, bs.Pushover("p", SELF_WEIGHT, push(1, 0, 0), **control))
    done("check", document)
    text = document.read_text(encoding="utf-8")
    document.write_text(text.replace("corner_rounding: 0.247 m", "corner_rounding: 2 m"), encoding="utf-8")
    for command, expected in (("check", 2), ("validate", 4), ("run", 2)):
        code, out, err = call(command, document)
        # The limit is half of the width of 0.5 m, less rounding.
        assert (code, "give a radius of at most 0.247 m" in out + err) == (expected, True)
    assert [path.name for path in tmp_path.iterdir()] == [document.name]


def test_tables_of_a_narrow_terminal_are_folded_and_cut_no_number(done, tmp_path, monkeypatch):
    heights = ("0.512345 m", "0.623456 m")
    for name, height in zip(("a wall of which the name is long.h5", "b.h5"), heights, strict=True):
        case = bs.Pushover("pushed over", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=3)
        parameters = {"height_of_the_opening": bs.Q_(height)}
        bs.AnalysisManager(model_of(*single_block(0.5, 1.0)), tmp_path / name, parameters=parameters).run([case])
    rows = bs.Archive(tmp_path).table().to_dict("records")
    numbers = {height.split()[0] for height in heights}
    numbers |= {f"{row[name]:.6g}" for row in rows for name in ("load_factor", "n_iterations")}
    for width in (30, 60, 80):
        # A console keeps the width that the environment had when it was made.
        monkeypatch.setattr("blockstruct.cli.app.out", Console(highlight=False, width=width))
        out = done("archive", tmp_path)
        assert "…" not in out
        assert numbers <= set(out.split())
        assert width < 60 or max(map(len, out.splitlines())) <= width


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_output_that_nobody_reads_ends_a_command_silently(file):
    """As ``show FILE | head`` once head has what it wants: as a command that SIGPIPE ends, and without a word."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [Path(sys.executable).with_name("blockstruct"), "show", file]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False, timeout=60)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, b"")


STONE = ["--unit-weight", "20 kN/m^3", "--friction", "0.6"]


@pytest.fixture
def stack(tmp_path):
    """Three cubes of 0.5 m, in mm."""
    cubes = {f"stone {k}": [(500 * x, 500 * y, 500 * (z + k)) for x, y, z in CUBE] for k in range(3)}
    return saved(tmp_path, "stack.obj", objects_text(cubes))


def test_import_check_and_run(call, done, stack, tmp_path):
    model = tmp_path / "stack.yaml"
    code, out, err = call("import", stack, "-o", model, "--unit", "mm", *STONE, "--fix", "lowest")
    assert (code, err) == (0, "")
    assert "3 blocks of 18 faces, 1 fixed" in out
    assert "2 interfaces, 0.5 m^2" in out
    assert "ready to run: push +x" in done("check", model)
    done("run", model, "-o", tmp_path / "stack.h5")
    # Two stones of slenderness 2 on the third: they rock together at width / height.
    assert bs.open_analysis(tmp_path / "stack.h5")["push +x"].load_factor == pytest.approx(0.5, rel=1e-4)


def test_joints_opened_by_repairs_are_closed_and_listed_and_no_others(call, tmp_path):
    # Two stones on a slab, 2 mm apart; a corner of the one is 2 mm too low, in the slab.
    stones = [[(x * 0.9 + k * 0.902, y, z * 0.5) for x, y, z in CUBE] for k in range(2)]
    stones[0][0] = (0, 0, -0.002)
    slab = [(3 * x - 0.5, 2 * y - 0.5, z * 0.3 - 0.3) for x, y, z in CUBE]
    path = saved(tmp_path, "a.obj", objects_text({"slab": slab, "low": stones[0], "level": stones[1]}))
    model = tmp_path / "m.yaml"
    code, out, err = call("import", path, "-o", model, "--unit", "m", "--fix", "slab", *STONE)
    assert (code, err) == (0, "")
    assert "1 joint closed that repairs of its faces opened" in out
    assert "slab | low: " in out
    found = {(i.minus, i.plus) for i in bs.read_document(model).model.interfaces}
    assert found == {("slab", "low"), ("slab", "level")}


def test_directions_flow_and_the_angle_of_a_tilting_table(call, done, stack, tmp_path):
    model = tmp_path / "m.yaml"
    words = ["--unit", "mm", "--fix", "lowest", *STONE, "--flow", "associative", "--tilt"]
    done("import", stack, "-o", model, *words, "--direction", "-y", "--direction", "3,4,0")
    cases = bs.read_document(model).cases
    assert [(case.name, case.flow) for case in cases] == [("tilt -y", "associative"), ("tilt (3,4,0)", "associative")]
    assert [case.variable.loads[0].direction for case in cases] == [(0, -1, 0), pytest.approx((0.6, 0.8, 0))]
    # Two stones of slenderness 2 rock about an edge at a load factor of 1/2.
    angle = f"on a tilting table: falls at {np.degrees(np.arctan(0.5)):.4g} deg"
    assert angle in call("run", model, "-o", tmp_path / "m.h5")[1]
    # With cohesion the weight across the joints counts less than the weight along them.
    text, friction = model.read_text(encoding="utf-8"), "friction_coefficient: 0.6"
    model.write_text(text.replace(friction, f"{friction}, cohesion: 1 kPa"), encoding="utf-8")
    code, out, _ = call("run", model, "-o", tmp_path / "glued.h5")
    assert (code, "on a tilting table" in out) == (0, False)
    assert bs.read_document(model).model.interfaces[0].joint_material.cohesion == 1000


def test_a_drawing_and_a_mesh_in_one_import(done, stack, tmp_path):
    drawing = ezdxf.new()
    drawing.header["$INSUNITS"] = 4
    for layer, y in (("GROUND", 0), ("WALL", 200)):
        corners = [(2000, y), (2500, y), (2500, y + 200), (2000, y + 200)]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    drawing.saveas(path := tmp_path / "wall.dxf")
    words = ["--unit", "mm", "--thickness", "30 cm", "--friction", "0.6", "--fix-layer", "GROUND"]
    layers = ["--unit-weight", "WALL=20 kN/m^3", "--unit-weight", "GROUND=25 kN/m^3"]
    assert "1 interface, 0.15 m^2" in done("import", path, "-o", tmp_path / "m.yaml", *words, *layers)
    assert bs.read_document(tmp_path / "m.yaml").model.block("WALL.1").weight == pytest.approx(600)
    words = ["--unit", "mm", "--fix", "lowest", *STONE, "--thickness", "50 cm"]
    done("import", stack, path, "-o", tmp_path / "both.yaml", *words)
    names = [b.name for b in bs.read_document(tmp_path / "both.yaml").model.blocks]
    assert names == ["stack.stone 0", "stack.stone 1", "stack.stone 2", "wall.GROUND.1", "wall.WALL.1"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["LOOSE"], "no block is fixed"),
        (["STACK", "STACK", "--unit-weight", "A=30 kN/m^3"], "--unit-weight: give it once"),
        (["STACK", "--closing", "1 mm"], "closing belongs to .dxf"),
        (["STACK", "--override-unit"], "override_unit belongs to .dxf and .3dm"),
        (["STACK", "--up", "w"], "up is 'w'; give the axis"),
        (["STACK", "--exclude", "brick*"], "no block 'brick*' to exclude"),
        (["STACK", "--direction", "north"], "--direction 'north': give +x"),
        (["STACK", "--direction", "+z", "--tilt"], "a table tilts to a level direction"),
    ],
)
def test_bad_input_is_one_message_and_no_document(call, stack, tmp_path, words, expected):
    fixed = [] if words == ["LOOSE"] else ["--fix", "lowest"]
    words = [stack if w in ("STACK", "LOOSE") else w for w in words]
    code, _, err = call("import", *words, *fixed, "-o", tmp_path / "m.yaml", "--unit", "mm", *STONE)
    assert code == 2
    assert err.startswith("error: ")
    assert expected in err
    assert not (tmp_path / "m.yaml").exists()


def test_a_document_is_never_replaced(fails, stack, tmp_path):
    stack.with_suffix(".yaml").write_text("mine", encoding="utf-8")
    fails("exists and is not replaced", "import", stack, "-o", stack.with_suffix(".yaml"), "--unit", "mm", *STONE)
    assert stack.with_suffix(".yaml").read_text(encoding="utf-8") == "mine"
    fails("not the name of a model document", "import", stack, "-o", tmp_path / "m.txt", "--unit", "mm", *STONE)
