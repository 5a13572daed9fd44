"""The console command, called as a user would."""

import csv
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import attrs
import pytest
from rich.console import Console
from rich.progress import Progress, TextColumn

import blockstruct as bs
from blockstruct import views
from blockstruct.analysis import IterationDone
from blockstruct.cli import runs as cli_runs
from blockstruct.views import archive_table, summary_table
from blockstruct.views.progress import bar, following
from structures import SELF_WEIGHT, box, model_of, push, settings_of, single_block

DRY = bs.JointMaterial("dry", 0.65)
WALL = Path(__file__).parents[2] / "examples" / "ferris_tin_loi_wall_1.yaml"

#: What they show is tested with the views.
pytestmark = pytest.mark.usefixtures("blank_pictures")


@pytest.fixture(scope="module")
def file(small_analysis, tmp_path_factory):
    return bs.save_analysis(small_analysis, tmp_path_factory.mktemp("cli") / "small.h5")


def test_demo(call, tmp_path):
    code, out, err = call("demo", "-o", tmp_path / "demo.h5")
    assert code == 0
    # Without a terminal, progress is a line per iteration.
    assert not re.search(r"^ *# ", out, re.MULTILINE)
    assert "39 blocks, 86 interfaces" in out
    target = tmp_path / "demo.h5"
    assert f"next: blockstruct view {target}, blockstruct report {target}, or" in out
    _, table, _ = call("history", target, "push +x, nonassociative")
    assert max(map(len, table.splitlines())) <= 80
    result = bs.open_analysis(target)["push +x, nonassociative"]
    assert (result.status, result.outcome.procedure, result.settled) == ("converged", "loading path", True)
    assert str(result.headline) in out
    assert len(err.splitlines()) > result.n_iterations


@pytest.mark.parametrize(
    ("missing", "words"),
    [
        ((), ""),
        (("plotly",), 'view needs: pip install "blockstruct[viz]"'),
        (("plotly", "matplotlib"), 'view and report need: pip install "blockstruct[report,viz]"'),
    ],
)
def test_a_run_names_the_extras_of_next_commands(call, small_model, small_cases, tmp_path, monkeypatch, missing, words):
    path = tmp_path / "wall.h5"
    bs.AnalysisManager(small_model, path).run(small_cases[:1])
    find = importlib.util.find_spec
    monkeypatch.setattr(cli_runs, "find_spec", lambda name: None if name in missing else find(name))
    code, out, _ = call("resume", path)
    assert code == 0
    lines = out.splitlines()
    said = lines[1 + next(k for k, line in enumerate(lines) if line.startswith("next: ")) :]
    assert said == ([words] if words else [])


def test_run_and_show(call, tmp_path):
    target = tmp_path / "wall.h5"
    code, out, _ = call("run", WALL, "-o", target)
    assert code == 0
    assert f"written: {target}" in out
    code, out, _ = call("show", target)
    assert code == 0
    assert "time [s]" in out
    assert "Ferris & Tin-Loi wall 1: 34 blocks, 83 interfaces" in out
    for word in ("0.642859", "nonassociative", "equilibrium:", "flow rule:", "tolerance"):
        assert word in out


def test_a_history_without_a_case_lists_the_cases(call, file, small_analysis):
    code, out, _ = call("history", file)
    assert (code, out.splitlines()) == (0, list(small_analysis))


def test_a_run_writes_beside_its_document(call, tmp_path):
    blocks, joint = single_block(0.5, 1.0)
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative")
    bs.documents.write_draft(tmp_path / "block.yaml", "block", blocks, joint, [case])
    code, _, err = call("run", tmp_path / "block.yaml", "--quiet")
    assert code == 0, err
    assert bs.open_analysis(tmp_path / "block.h5")["push"].load_factor == pytest.approx(0.5, rel=1e-6)
    code, _, err = call("run", tmp_path / "block.yaml", "-o", tmp_path / "none" / "block.h5")
    assert code == 2
    assert "there is no folder" in err
    assert not (tmp_path / "none").exists()


def test_the_last_iteration_and_one_interface_of_a_history(call, file, tmp_path, small_analysis):
    name = "push nonassociative"
    history = small_analysis[name].history
    _, out, _ = call("history", file, name, "--last")
    assert [line.split()[0] for line in out.splitlines()] == ["#", str(history.sizes["iteration"] - 1)]
    _, out, _ = call("history", file, name, "--last", "--interface", "base|1.1")
    force = history.blockstruct.frame("force")
    at = (force.index.get_level_values("iteration") == history.sizes["iteration"] - 1) & (
        force.index.get_level_values("interface") == "base|1.1"
    )
    assert out == f"{force[at].to_string()}\n"
    assert at.sum() == 3
    table = tmp_path / "t.csv"
    call("history", file, name, "--variable", "contact_force", "--interface", "base|1.1", "--last", "--csv", table)
    with table.open(newline="", encoding="utf-8") as stream:
        assert {row["interface_of_contact_point"] for row in csv.DictReader(stream)} == {"base|1.1"}
    for words, said in (
        (["--interface", "base|1.9"], "no 'base|1.9'; did you mean"),
        (["--variable", "block_velocity", "--interface", "base|1.1"], "not one of interfaces"),
    ):
        code, _, err = call("history", file, name, *words)
        assert (code, said in err) == (2, True), err


def test_the_last_iteration_of_a_case_that_has_none(call, small_model, small_cases, tmp_path):
    def stop(event):
        if isinstance(event, bs.analysis.IterationDone):
            raise KeyboardInterrupt

    bs.AnalysisManager(small_model, tmp_path / "cut.h5", listeners=[stop]).run(small_cases)
    for words in (("--last",), ("--last", "--variable", "load_factor"), ("--last", "--interface", "base|1.1")):
        code, out, err = call("history", tmp_path / "cut.h5", small_cases[1].name, *words)
        assert (code, err) == (0, "")
        assert out


def test_a_case_without_load_factor_exits_with_3(call, tmp_path):
    document = tmp_path / "m.yaml"
    document.write_text(WALL.read_text(encoding="utf-8").replace("[1, 0, 0]", "[0, 0, -1]"), encoding="utf-8")
    code, out, _ = call("run", document, "-o", tmp_path / "m.h5")
    assert code == 3
    assert "unbounded" in out
    assert (tmp_path / "m.h5").exists()


def test_tables_cut_no_status_off(tmp_path):
    """On a terminal of 80 columns: a block on an edge that its centroid is beyond."""
    model = model_of([box("ground", [0, 0, -1], [0.4, 1, 1], fixed=True), box("block", [0, 0, 0], [1, 1, 1])], DRY)
    analysis = bs.AnalysisManager(model, tmp_path / "x.h5").run([bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))])
    for table in (summary_table(analysis), archive_table(bs.Archive(tmp_path).table())):
        console = Console(width=80)
        with console.capture() as capture:
            console.print(table)
        rows = capture.get().splitlines()
        start = rows[0].index("status")
        parts = [row[start:].partition("  ")[0].strip() for row in rows[1:]]
        assert " ".join(filter(None, parts)) == "unstable under dead load"


def test_statuses_have_no_underscores_in_texts(call, tmp_path):
    """In everything that a person reads; files and JSON keep the names."""
    model = model_of([box("ground", [0, 0, -1], [0.4, 1, 1], fixed=True), box("block", [0, 0, 0], [1, 1, 1])], DRY)
    one = tmp_path / "one" / "x.h5"
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    result = bs.AnalysisManager(model, one).run([case])["push"]
    (tmp_path / "two").mkdir()
    (tmp_path / "two" / "x.h5").write_bytes(one.read_bytes())
    site = ["--spectrum", "ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B", "--knowledge-level", "LC1"]
    said = [
        call("show", one),
        call("archive", one.parent),
        call("diff", one, tmp_path / "two" / "x.h5"),
        call("diff", one.parent, tmp_path / "two"),
        call("assess", one, *site),
        call("assess", one, *site, "--case", "push"),
        call("history", one, "push", "--pushover"),
    ]
    texts = [f"{out}{err}" for _, out, err in said]
    texts += [str(result), repr(result), result._repr_html_(), str(result.headline), str(bs.open_analysis(one))]
    for text in texts:
        assert "unstable_under" not in text
        assert re.search("unstable under dead load|does not stand under its dead load", " ".join(text.split()))
    assert '"status": "unstable_under_dead_load"' in call("show", one, "--json")[1]
    assert call("archive", one.parent, "--where", "status == 'unstable_under_dead_load'")[1].count("x.h5") == 1


def test_an_interrupted_study_continues(call, tmp_path, monkeypatch):
    def interrupt(progress):
        if progress.done:
            raise KeyboardInterrupt

    words = ("study", WALL.with_name("friction_study.yaml"), "-o", tmp_path / "runs", "--workers", 1)
    with monkeypatch.context() as patched:
        patched.setattr(views, "study_following", lambda *_, **__: nullcontext([interrupt]))
        code, _, err = call(*words)
    assert (code, err.splitlines()[0]) == (130, "interrupted")
    assert "runs keeps what was done; the same command goes on" in err
    assert len(list((tmp_path / "runs").glob("*.h5"))) == 1
    assert call(*words)[0] == 0


def test_an_interrupted_run_exits_with_130(call, tmp_path, monkeypatch):
    def interrupt(event):
        raise KeyboardInterrupt

    monkeypatch.setattr(bs, "print_lines", lambda: interrupt)
    code, out, _ = call("run", WALL, "-o", tmp_path / "wall.h5")
    assert code == 130
    assert "interrupted" in out
    assert f"next: blockstruct resume {tmp_path / 'wall.h5'} for the rest" in out
    assert bs.open_analysis(tmp_path / "wall.h5").status == "interrupted"


def test_history(call, file, tmp_path):
    code, out, _ = call("history", file, "push nonassociative")
    assert code == 0
    assert "admissible" in out
    code, out, _ = call("history", file, "push nonassociative", "--variable", "load_factor")
    assert code == 0
    assert "load_factor" in out
    table = tmp_path / "f.csv"
    code, _, _ = call("history", file, "push nonassociative", "--variable", "contact_force", "--csv", table)
    assert code == 0
    with table.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    history = bs.open_analysis(file)["push nonassociative"].history
    assert len(rows) == history.contact_force.size
    assert float(rows[0]["contact_force [newton]"]) == pytest.approx(float(history.contact_force[0, 0, 0]))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps the folder that is worked in")
@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["run", WALL, "-o", "x.h5"], "x.h5: the working folder has been deleted; change to another one, or give an"),
        (["view", "FILE", "-o", "x.html"], "x.html: cannot be written (No such file or directory); choose another"),
        (["report", "FILE", "-o", "x.html"], "x.html: cannot be written (No such file or directory); choose another"),
    ],
)
def test_an_output_in_a_folder_that_was_deleted_names_it_and_the_remedy(call, file, tmp_path, monkeypatch, words, told):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    code, _, err = call(*(file if w == "FILE" else w for w in words))
    assert code == 2
    assert err.startswith(f"error: {told}")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["history", "FILE", "nothing"], "no case 'nothing'"),
        (["history", "FILE", "push nonassociative", "--variable", "colour"], "no variable 'colour'"),
        (["history", "FILE", "push nonassociative", "--csv", "/proc/x/y.csv"], "cannot be written"),
        (["show", "missing.h5"], "no such file"),
        (["show", str(WALL)], "not a readable HDF5 file"),
        (["run", "missing.yaml", "-o", "x.h5"], "missing.yaml: no such file; give the path of a YAML"),
        (["run", str(WALL), "-o", "/proc/x/y.h5"], "there is no folder /proc/x"),
        (["run", str(WALL), "-o", str(WALL)], "is not replaced"),
        (["run", "FILE", "-o", "x.h5"], "is not text"),
        (["show", "."], "is a folder"),
        (["history", "FILE", "push nonassociative", "--csv", "FILE"], "ends in .csv"),
        (["view", "missing.h5"], "no such file"),
        (["view", "FILE", "-o", "/proc/x/y.html"], "cannot be written"),
        (["report", "FILE", "-o", "/proc/x/y.html"], "cannot be written"),
        (["report", "FILE", "--template", "missing.j2"], "not a usable template"),
        (["report", "FILE", "--project", "noeq"], "as in 'client=Town of Lucca'"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(call, file, words, expected):
    code, _, err = call(*(file if w == "FILE" else w for w in words))
    assert code == 2
    assert err.startswith("error: ")
    assert expected in err


@pytest.mark.parametrize("variable", ["state", "force", "eccentricity"])
def test_history_of_interfaces(call, file, tmp_path, variable):
    code, _, _ = call("history", file, "push nonassociative", "--variable", variable, "--csv", tmp_path / "t.csv")
    assert code == 0
    header = (tmp_path / "t.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.startswith("iteration,interface")
    assert variable in header


def test_contact_points_carry_the_name_of_their_interface(call, file, tmp_path):
    call("history", file, "push nonassociative", "--variable", "contact_force", "--csv", tmp_path / "t.csv")
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as stream:
        assert next(csv.DictReader(stream))["interface_of_contact_point"] == "base|1.1"


def killed_run(path, small_model, small_cases):
    def stop(event):
        if isinstance(event, IterationDone) and event.case is small_cases[1] and event.index == 4:
            raise RuntimeError

    with pytest.raises(RuntimeError):
        bs.AnalysisManager(small_model, path, listeners=[stop]).run(small_cases)


def test_recover_and_resume(call, small_model, small_cases, small_analysis, tmp_path):
    path = tmp_path / "x.h5"
    killed_run(path, small_model, small_cases)
    for command in ("show", "view", "report"):
        code, _, err = call(command, path)
        assert code == 2
        assert f"blockstruct recover {path}" in err
    for command in ("show", "validate", "recover", "resume"):
        code, _, err = call(command, f"{path}.partial")
        assert code == 2
        assert f"x.h5.partial: is a folder with the working data of a run; give the name of its file, {path}" in err
    code, out, _ = call("recover", path)
    assert code == 0
    assert f"written: {path}" in out
    cut = bs.open_analysis(path)[small_cases[1].name]
    assert (cut.status, cut.outcome.reason, cut.n_iterations) == ("interrupted", "killed", 5)
    code, out, err = call("resume", path)
    assert code == 0
    assert "load factor" in err
    assert f"written: {path}" in out
    assert bs.results.compare(bs.open_analysis(path), small_analysis).agrees()
    code, _, err = call("recover", path)
    assert code == 2
    assert "no working data" in err
    killed_run(path, small_model, small_cases)
    assert call("resume", path, "--quiet") == (0, "", "")
    assert bs.results.compare(bs.open_analysis(path), small_analysis).agrees()


def test_archive(call, file, tmp_path):
    (tmp_path / "sub").mkdir()
    shutil.copy(file, tmp_path / "sub" / "a.h5")
    (tmp_path / "b.h5").write_text("notes")
    code, out, _ = call("archive", tmp_path)
    assert code == 0
    for word in ("sub/a.h5", "push nonassociative", "converged", "b.h5", "not a readable HDF5"):
        assert word in out
    code, out, _ = call("archive", tmp_path, "--where", "flow == 'associative'")
    assert code == 0
    assert "push associative" in out
    assert "push nonassociative" not in out
    assert call("archive", tmp_path, "--where", "colour == 1")[0] == 2
    assert call("archive", tmp_path, "--csv", tmp_path / "t.csv")[0] == 0
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == 3


def test_diff(call, file, small_model, small_cases, tmp_path):
    other = tmp_path / "b" / "small.h5"
    bs.AnalysisManager(small_model, other).run(small_cases)
    code, out, _ = call("diff", file, other)
    assert code == 0
    assert "the same model, 2 cases" in out
    bs.AnalysisManager(small_model, other, settings=bs.ProcedureSettings(path_step=0.4)).run(small_cases)
    code, out, _ = call("diff", file, other, "--tolerance", "0")
    assert code == 1
    assert "path_step 0.5, other 0.4" in out
    code, out, _ = call("diff", file.parent, other.parent, "--tolerance", "1")
    assert code == 0
    assert "relative_difference" in out
    assert call("diff", file, tmp_path / "none.h5")[0] == 2
    for tolerance in ("-1", "nan"):
        code, _, err = call("diff", file, file, "--tolerance", tolerance)
        assert (code, "give a number of zero or more" in err) == (2, True)


def test_diff_of_folders(call, file, small_model, tmp_path):
    """Cases without a load factor agree with themselves; damaged files, other models and statuses never do."""
    dead, down = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("down", [bs.BodyForce((0, 0, -1))])
    case = bs.LimitCase("down", dead, down, "associative")
    one, other = tmp_path / "one", tmp_path / "other"
    for folder in (one, other):
        bs.AnalysisManager(small_model, folder / "wall.h5").run([case])
    assert call("diff", one, other)[0] == 0
    (other / "wall.h5").write_bytes((one / "wall.h5").read_bytes()[:-100])
    code, out, _ = call("diff", one, other)
    assert code == 1
    assert "damaged" in out
    (one / "wall.h5").write_bytes((other / "wall.h5").read_bytes())
    assert call("diff", one, other)[0] == 1
    renamed = bs.Model("another", small_model.blocks, small_model.interfaces)
    for folder, model in ((one, small_model), (other, renamed)):
        (folder / "wall.h5").unlink()
        bs.AnalysisManager(model, folder / "wall.h5").run([case])
    assert call("diff", one, other)[0] == 1


def test_version_and_help(call, capsys):
    assert call("--version")[1].strip() == bs.__version__
    assert "demo" in call()[1]


def test_validate_checks_what_run_would(call, tmp_path):
    text = WALL.read_text(encoding="utf-8")
    for wrong in (
        text + "settings: { max_program: 3 }\n",
        text.replace("name: nonassociative", "name: associative"),
        text.replace(
            "{ kind: body_force, direction: [1, 0, 0] }",
            '{ kind: moment, block: x, moment: ["1 N*m", "0 N*m", "0 N*m"] }',
        ),
    ):
        broken = tmp_path / "broken.yaml"
        broken.write_text(wrong, encoding="utf-8")
        assert call("validate", broken)[0] == 4


def test_validate(call, file, tmp_path):
    assert call("validate", file)[0] == 0
    one = bs.AnalysisManager(model_of(*single_block(0.5, 1.0)), store=tmp_path / "one.h5")
    one.run([bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative")])
    assert "a valid analysis of 1 case\n" in call("validate", tmp_path / "one.h5")[1]
    assert "2 blocks, 1 interface\n" in call("show", tmp_path / "one.h5")[1]
    assert call("validate", WALL)[0] == 0
    broken = tmp_path / "broken.yaml"
    broken.write_text(WALL.read_text(encoding="utf-8").replace("rows:", "lines:"), encoding="utf-8")
    code, out, _ = call("validate", broken)
    assert code == 4
    assert "/courses/0" in out
    assert call("validate", __file__)[0] == 4


def test_the_installed_command():
    command = Path(sys.executable).with_name("blockstruct")
    out = subprocess.run([command, "--help"], check=True, capture_output=True, text=True, timeout=60).stdout
    names = (
        "demo",
        "run",
        "show",
        "history",
        "archive",
        "diff",
        "recover",
        "resume",
        "validate",
        "migrate",
        "import",
        "check",
    )
    for name in (*names, "view", "figures", "report", "Exit codes"):
        assert name in out


def test_figures_are_written_into_a_folder(call, file, tmp_path):
    folder = tmp_path / "figures"
    code, out, _ = call("figures", file, "-o", folder, "--format", "svg", "--look", "x")
    assert code == 0
    written = sorted(p.name for p in folder.iterdir())
    assert "push-nonassociative-mechanism.svg" in written
    assert out.count("written: ") == len(written)
    code, _, err = call("figures", file, "-o", folder, "--look", "front")
    assert code == 2
    assert "give 'x' or 'y' for an elevation" in err


def test_view_and_report_write_next_to_the_file(call, file):
    for command, name in (("view", "small.html"), ("report", "small-report.html")):
        code, out, _ = call(command, file)
        assert code == 0
        target = file.with_name(name)
        assert f"written: {target}, {target.stat().st_size / 1e6:.1f} MB" in out
        assert "small wall" in target.read_text(encoding="utf-8")
        target.unlink()


def test_a_view_has_the_name_of_a_page(call, file):
    target = file.with_name("view.pdf")
    code, _, err = call("view", file, "-o", target)
    assert (code, "give a name that ends in .html" in err) == (2, True)
    assert not target.exists()


def test_a_view_never_replaces_its_input(call, file, tmp_path):
    content, template = file.read_bytes(), tmp_path / "own.html"
    template.write_text("{{ name }}", encoding="utf-8")
    page = shutil.copy(file, tmp_path / "analysis.html")
    for words in (
        ("view", file, "-o", file),
        ("report", file, "-o", file),
        ("view", page),
        ("report", file, "--template", template, "-o", template),
    ):
        code, _, err = call(*words)
        assert code == 2
        assert "choose another one with --output" in err
    assert (file.read_bytes(), page.read_bytes()) == (content, content)
    assert template.read_text(encoding="utf-8") == "{{ name }}"


def test_analyses_and_pipes_are_no_targets(call, file, tmp_path):
    other, pipe = shutil.copy(file, tmp_path / "other.csv"), tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    for target, words in ((other, "it is an HDF5 file"), (pipe, "it is not a regular file")):
        for command in (("view", file, "-o", target), ("history", file, "push nonassociative", "--csv", target)):
            code, _, err = call(*command)
            assert code == 2
            assert f"cannot be written ({words}" in err
    assert pipe.is_fifo()
    assert other.read_bytes() == file.read_bytes()


@pytest.mark.parametrize(
    ("target", "words"), [("/", "it is not a regular file"), (".", "it is not"), (f"{'a' * 250}.html", "too long")]
)
def test_targets_that_cannot_be_are_one_message(call, file, tmp_path, monkeypatch, target, words):
    monkeypatch.chdir(tmp_path)
    code, _, err = call("view", file, "-o", target)
    assert (code, err.startswith(f"error: {target}: cannot be written (")) == (2, True)
    assert words in err
    assert list(tmp_path.iterdir()) == []


def test_quiet_prints_nothing(call, tmp_path):
    assert call("run", WALL, "-o", tmp_path / "wall.h5", "--quiet") == (0, "", "")
    assert "34 blocks" in call("show", tmp_path / "wall.h5")[1]


@pytest.mark.parametrize("encoding", [pytest.param("ascii", marks=pytest.mark.slow), "cp1252"])
def test_names_that_the_output_cannot_carry_are_escaped(tmp_path, encoding):
    document = tmp_path / "m.yaml"
    document.write_text(WALL.read_text().replace("name: Ferris", "name: Mauer α, Ferris", 1), encoding="utf-8")
    command = [Path(sys.executable).with_name("blockstruct"), "check", document]
    done = subprocess.run(command, capture_output=True, check=False, env={**os.environ, "PYTHONIOENCODING": encoding})
    assert (done.returncode, b"Mauer \\u03b1, Ferris" in done.stdout) == (0, True), done.stderr


def test_json_is_the_only_output(call, file, tmp_path):
    document = tmp_path / "m.yaml"
    document.write_text(WALL.read_text(encoding="utf-8").replace("[1, 0, 0]", "[0, 0, -1]"), encoding="utf-8")
    code, out, err = call("run", document, "-o", tmp_path / "m.h5", "--json", "--quiet")
    assert (code, err) == (3, "")
    unbounded = json.loads(out)["cases"][0]
    assert unbounded["status"] == "unbounded"
    assert unbounded["load_factor"] is None
    assert unbounded["certificate"] is None
    shown = json.loads(call("show", file, "--json")[1])
    result = bs.open_analysis(file)["push nonassociative"]
    assert shown["cases"][1]["load_factor"] == result.load_factor
    assert shown["cases"][1]["certificate"]["holds"] is True


def test_names_of_cases_are_no_markup_in_the_bar(small_model, small_cases):
    stream = io.StringIO()
    case = attrs.evolve(small_cases[0], name="push [/x] [red]")
    with following(Console(file=stream, force_terminal=True, width=120), quiet=False) as listeners:
        bs.AnalysisManager(small_model, listeners=listeners).run([case])
    assert "push [/x] [red]" in stream.getvalue()


def test_a_bar_shows_iteration_and_remaining_time(small_model, small_cases):
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, width=120)
    with Progress(TextColumn("{task.description}"), TextColumn("{task.fields[rest]}"), console=console) as progress:
        listener = bar(progress)
        seen = []

        def listen(event):
            listener(event)
            seen.append((progress.tasks[0].description, progress.tasks[0].fields["rest"], progress.tasks[0].completed))

        bs.AnalysisManager(small_model, listeners=[listen]).run(small_cases[1:] + small_cases[:1])
    texts = [text for text, _, _ in seen]
    assert any(
        re.fullmatch(r"case 1 of 2, push nonassociative: numerical iteration 1, α = 0\.\d{4}, gap \de[+-]\d+", t)
        for t in texts
    )
    assert seen[1][1].startswith("about ")
    assert seen[-1][1:] == ("", 1)


@pytest.mark.filterwarnings("default::blockstruct.errors.UnusualValueWarning")
def test_a_warning_is_one_line(call, tmp_path):
    wall = (Path(__file__).parents[2] / "examples" / "ferris_tin_loi_wall_1.yaml").read_text(encoding="utf-8")
    (tmp_path / "m.yaml").write_text(wall.replace("12 kN/m^3", "12 kN/mm^3"), encoding="utf-8")
    code, out, err = call("check", tmp_path / "m.yaml")
    assert (code, "ready to run" in out) == (0, True)
    assert err.startswith("warning: material 'tuff': unit_weight 1.2e+10 kN/m³")
    assert len(err.splitlines()) == 1


@pytest.mark.filterwarnings("default::blockstruct.errors.UnusualValueWarning")
@pytest.mark.parametrize(
    ("loads", "code", "message"),
    [
        ("[{ kind: self_weight }, { kind: self_weight }]", 2, "SelfWeight (self_weight) appears 2 times"),
        ("[]", 0, "has no loads, and joints without cohesion"),
        ("[{ kind: moment, block: '1.1', moment: [0 N*m, 0 N*m, 0 N*m] }]", 0, "is zero on every free block, and"),
    ],
)
def test_an_unusual_dead_load_has_a_message(call, tmp_path, loads, code, message):
    wall = WALL.read_text(encoding="utf-8").replace("dead: [{ kind: self_weight }]", f"dead: {loads}")
    (tmp_path / "m.yaml").write_text(wall, encoding="utf-8")
    found, _, err = call("check", tmp_path / "m.yaml")
    assert found == code
    assert message in err
    assert err.count("error:") + err.count("warning:") == 1


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_tables_mark_unsettled_cases(call, small_model, tmp_path):
    settings = settings_of(procedure="fictitious", patience=3, load_factor_tolerance=1e-15)
    around = bs.directions(small_model, SELF_WEIGHT, 2, settings=settings, store=tmp_path / "drifts" / "a.h5")
    assert all(result.drifts for result in around.analysis.values())
    assert str(around).count("NOT SETTLED") == 2
    _, out, _ = call("archive", tmp_path / "drifts")
    assert " ".join(out.split()).count("NOT SETTLED") == 2
    table = bs.Archive(tmp_path / "drifts").select("settled == False")
    assert table["status"].tolist() == ["converged"] * 2
    settles = bs.directions(small_model, SELF_WEIGHT, 2, store=tmp_path / "settles" / "a.h5")
    assert "NOT SETTLED" not in str(settles)
    _, out, _ = call("archive", tmp_path / "settles")
    assert "NOT SETTLED" not in out
    assert bs.Archive(tmp_path / "settles").table()["settled"].tolist() == [True] * 2


def test_the_table_of_a_study_marks_unsettled_cases(call, tmp_path):
    drifting = "settings: { procedure: fictitious, schedule: { patience: 3, load_factor_tolerance: 1.0e-15 } }"
    wall = WALL.read_text(encoding="utf-8")
    for name, more in (("drifts", drifting), ("settles", "")):
        (tmp_path / "wall.yaml").write_text(f"{wall}\n{more}\n", encoding="utf-8")
        (tmp_path / "study.yaml").write_text(
            "blockstruct: study-1\nmodel: wall.yaml\nparameters:\n"
            "  joint_materials.dry joint.friction_coefficient: [0.65]\n",
            encoding="utf-8",
        )
        code, out, err = call("study", tmp_path / "study.yaml", "-o", tmp_path / name, "--workers", 1)
        assert code == 0, err
        assert ("NOT SETTLED" in " ".join(out.split())) == (name == "drifts")


def test_a_pushover_without_a_curve_exits_with_3(call, tmp_path):
    case = "{ kind: pushover, name: p, dead: dead, variable: push +x, control: {block: '6.1', direction: [-1, 0, 0]} }"
    wall = WALL.read_text(encoding="utf-8")
    (tmp_path / "m.yaml").write_text(f"{wall[: wall.index('cases:')]}cases:\n  - {case}\n", encoding="utf-8")
    code, out, err = call("run", tmp_path / "m.yaml", "-o", tmp_path / "m.h5", "--quiet")
    assert (code, out, err) == (3, "", "")
    assert bs.open_analysis(tmp_path / "m.h5")["p"].status == "converged"
    _, out, _ = call("show", tmp_path / "m.h5", "--json")
    (warning,) = json.loads(out)["cases"][0]["warnings"]
    assert warning.startswith("pushover: the control point at block '6.1' does not move along (-1, 0, 0)")


def test_jumps_of_a_curve_are_warnings_of_its_json(call, tmp_path):
    """A block slides until it meets a stop."""
    blocks = [
        box("ground", [-1, 0, -0.5], [3, 1, 0.5], fixed=True),
        box("block", [0, 0, 0], [0.4, 1, 0.5]),
        box("stop", [0.5, 0, 0], [0.1, 1, 0.05], fixed=True),
    ]
    model = model_of(blocks, bs.JointMaterial("dry", 0.2))
    case = bs.Pushover("p", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=20)
    bs.AnalysisManager(model, tmp_path / "p.h5").run([case])
    _, out, _ = call("show", tmp_path / "p.h5", "--json")
    rises, jumps = json.loads(out)["cases"][0]["warnings"]
    assert rises.startswith("pushover: the load factor rises from 0.2 to ")
    assert jumps.startswith("pushover: the load factor jumps from 0.2 to ")


def test_corners_too_round_are_refused_before_the_run(call, tmp_path):
    case = "{ kind: pushover, name: p, dead: dead, variable: push +x, control: {block: '6.1', direction: [1, 0, 0]}"
    wall = WALL.read_text(encoding="utf-8")
    document = f"{wall[: wall.index('cases:')]}cases:\n  - {case}, steps: 3, corner_rounding: RADIUS }}\n"
    for command in ("check", "validate", "run"):
        (tmp_path / "m.yaml").write_text(document.replace("RADIUS", "2 m"), encoding="utf-8")
        words = ("-o", tmp_path / "m.h5") if command == "run" else ()
        code, out, err = call(command, tmp_path / "m.yaml", *words)
        assert code == (4 if command == "validate" else 2)
        # The limit is half of the depth of 0.1 m.
        assert "pushover 'p': corner_rounding: block '" in out + err
        assert "give a radius of at most 0.0495 m" in out + err
    assert [path.name for path in tmp_path.iterdir()] == ["m.yaml"]
    (tmp_path / "m.yaml").write_text(document.replace("RADIUS", "0.0495 m"), encoding="utf-8")
    code, _, err = call("check", tmp_path / "m.yaml")
    assert code == 0, err


def test_the_remedy_for_a_killed_run_is_a_command(call, tmp_path, small_model, small_cases):
    class KilledError(BaseException):
        pass

    def die(event):
        if isinstance(event, IterationDone):
            raise KilledError

    with pytest.raises(KilledError):
        bs.AnalysisManager(small_model, tmp_path / "m.h5", listeners=[die]).run(small_cases)
    code, _, err = call("run", WALL, "-o", tmp_path / "m.h5")
    assert code == 2
    assert "(blockstruct resume), keep what it found by recover (blockstruct recover)" in err
    code, _, err = call("resume", tmp_path / "m.h5")
    assert code == 0, err


@pytest.mark.parametrize("name", ["r.docx", "r", "r.htm"])
def test_a_report_is_a_page_or_a_pdf(call, file, tmp_path, name):
    code, _, err = call("report", file, "-o", tmp_path / name)
    assert code == 2
    assert f"{name}: a report is a page or a PDF; give a name that ends in .html or .pdf" in err
    assert list(tmp_path.iterdir()) == []


def test_a_report_without_its_packages_names_the_extra_of_each_kind(call, file, tmp_path, monkeypatch):
    for name in [name for name in sys.modules if name.startswith("blockstruct.views.report")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "jinja2", None)
    code, _, err = call("report", file, "-o", tmp_path / "r.pdf")
    assert code == 2
    assert 'jinja2 is not installed; it comes with: pip install "blockstruct[report]"' in err
    assert 'PDF needs more, all of which comes with: pip install "blockstruct[pdf]"' in err


@pytest.mark.parametrize("width", [30, 60, 80])
def test_tables_of_a_narrow_terminal_are_folded_and_cut_no_number(call, tmp_path, monkeypatch, width):
    # A console keeps the width that the environment had when it was made.
    monkeypatch.setattr("blockstruct.cli.app.out", Console(highlight=False, width=width))
    heights = ("0.512345 m", "0.623456 m")
    for name, height in zip(("a wall of which the name is long.h5", "b.h5"), heights, strict=True):
        model = model_of(*single_block(0.5, 1.0))
        case = bs.Pushover("pushed over", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=3)
        manager = bs.AnalysisManager(model, tmp_path / name, parameters={"height_of_the_opening": bs.Q_(height)})
        manager.run([case])
    code, out, err = call("archive", tmp_path)
    assert code == 0, err
    assert "…" not in out
    for height in heights:
        assert height.split()[0] in out.split()
    rows = bs.Archive(tmp_path).table()
    for row in rows.to_dict("records"):
        assert {f"{row['load_factor']:.6g}", f"{row['n_iterations']:.0f}"} <= set(out.split())
    if width >= 60:
        assert max(map(len, out.splitlines())) <= width


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("show",), subprocess.PIPE),
        pytest.param(("show", "--json"), subprocess.PIPE, marks=pytest.mark.slow),
        pytest.param(("recover",), None, marks=pytest.mark.slow),
    ],
)
def test_output_that_nobody_reads_ends_a_command_silently(file, words, told):
    """As ``show FILE | head`` once head has what it wants: as a command that SIGPIPE ends, and without a word.

    The last one is refused, for want of working data, and nobody reads that either.
    """
    reader, writer = os.pipe()
    os.close(reader)
    command = [Path(sys.executable).with_name("blockstruct"), *words, file]
    try:
        done = subprocess.run(command, stdout=writer, stderr=told or writer, check=False, timeout=60)
    finally:
        os.close(writer)
    assert (done.returncode, done.stderr or b"") == (141, b"")


def test_module_runs_as_a_command():
    ran = subprocess.run([sys.executable, "-m", "blockstruct", "--version"], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == bs.__version__


def test_tables_stay_whole_in_pipes(call, small_model, small_cases, tmp_path):
    long = attrs.evolve(small_cases[0], name=" ".join(["a name of many words"] * 10))
    bs.AnalysisManager(small_model, tmp_path / "a.h5").run([long])
    _, out, _ = call("show", tmp_path / "a.h5")
    assert any(line.startswith(long.name) and line.split()[-1][0].isdigit() for line in out.splitlines())
