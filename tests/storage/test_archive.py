"""Folders of analyses: tables, selections, lazy histories, damaged files."""

import os
import shutil
import sys

import attrs
import h5py
import numpy as np
import pandas as pd
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import CaseStarted
from structures import SELF_WEIGHT, edited, model_of, push, single_block


@pytest.fixture(scope="module")
def folder(small_analysis, tmp_path_factory):
    """Two walls, and in a subfolder a block that rocks at b / h = 0.5."""
    folder = tmp_path_factory.mktemp("archive")
    for name, day, tags in (("wall", "2025-03-01", ["north"]), ("wall-2", "2026-03-01", ["north", "survey 2"])):
        dated = small_analysis.replaced(created_at=f"{day}T10:00:00.000+00:00", tags=tags)
        bs.save_analysis(dated, folder / f"{name}.h5")
    model = model_of(*single_block(0.5, 1.0), name="block")
    case = bs.LimitCase("rocks / x", SELF_WEIGHT, push(1, 0, 0))
    bs.AnalysisManager(model, folder / "sub" / "block.h5", tags=["block"]).run([case])
    return folder


@pytest.fixture
def damaged(folder, tmp_path):
    """The folder, and files of every kind of damage."""
    shutil.copytree(folder, tmp_path / "a")
    content = (folder / "wall.h5").read_bytes()
    (tmp_path / "a" / "cut.h5").write_bytes(content[:20_000])
    (tmp_path / "a" / "text.h5").write_text("notes")
    with h5py.File(tmp_path / "a" / "other.h5", "w") as file:
        file["x"] = [1.0]
    with edited(folder / "wall.h5", tmp_path / "a" / "linked.h5") as file:
        del file["/cases/push associative/load_factor"]
        file["/cases/push associative/load_factor"] = h5py.ExternalLink("wall.h5", "/cases/push associative/duration")
    return tmp_path / "a"


def test_one_row_a_case(folder, small_analysis):
    table = bs.Archive(folder).table(all_columns=True)
    assert table["path"].tolist() == ["sub/block.h5", *["wall-2.h5"] * 2, *["wall.h5"] * 2]
    row = table.iloc[0]
    expected = {"case": "rocks / x", "model": "block", "status": "converged", "flow": "nonassociative", "holds": True}
    expected |= {"tags": ("block",), "problem": "", "settings_crushing": "conic", "version": bs.__version__}
    assert row[list(expected)].to_dict() == expected
    assert row["load_factor"] == pytest.approx(0.5, rel=1e-3)
    assert row["started_at"] <= pd.Timestamp.now(tz="UTC")
    assert table.attrs["units"]["duration"] == "second"
    for name, result in small_analysis.items():
        of_case = table[(table["case"] == name) & (table["path"] == "wall.h5")].iloc[0]
        stored = of_case[["load_factor", "flow_rule_gap", "n_iterations", "model_hash"]].tolist()
        gap = result.certificate.flow_rule_gap
        assert stored == [result.load_factor, gap, result.n_iterations, small_analysis.model.hash]


def test_select(folder):
    """By days and times; other comparisons are tested with the hostile ones."""
    archive = bs.Archive(folder)
    assert set(archive.select("created_at < '2025-03-02'")["path"]) == {"wall.h5"}
    assert set(archive.select("'2025-03-02' <= created_at <= '2026-03-01T10:00'")["path"]) == {"wall-2.h5"}
    assert archive.select("created_at < '2025-03-01'").empty
    assert len(archive.select()) == 5


def test_bad_and_empty_folders(tmp_path, small_model):
    for tags in ("north", [1]):
        with pytest.raises(bs.errors.ModelError, match="tags"):
            bs.AnalysisManager(small_model, tags=tags)
    with pytest.raises(bs.errors.StorageError, match="no such folder"):
        bs.Archive(tmp_path / "none")
    empty = bs.Archive(tmp_path)
    assert empty.table().empty
    assert "load_factor" in empty.table()
    assert empty.select("load_factor < 1").empty


def test_damaged_files_are_listed_with_the_reason(damaged):
    table = bs.Archive(damaged).table().set_index("path")
    assert table.index.nunique() == 7
    for name, reason in {
        "cut.h5": "do not match its seal",
        "text.h5": "not a readable HDF5 file",
        "other.h5": "is not a blockstruct analysis",
        "linked.h5": "/cases/push associative/load_factor: 'load_factor' is missing, or a link to elsewhere",
    }.items():
        assert reason in table.loc[name, "problem"]
        assert table.loc[name, "case"] is None or pd.isna(table.loc[name, "case"])
    assert bs.Archive(damaged).select("problem == ''").shape[0] == 5
    assert bs.Archive(damaged).select("load_factor > 0").shape[0] == 5


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
@pytest.mark.parametrize(
    ("name", "reason"),
    [("pipe.h5", "a pipe or"), ("zero.h5", "a device"), ("nowhere.h5", "no such file"), ("x.h5.partial/plan", None)],
)
def test_what_is_no_file_has_a_row_and_is_never_opened(folder, tmp_path, name, reason):
    """A pipe waits for its other end, and a device never comes to its own: each question is answered at once."""
    shutil.copytree(folder, tmp_path / "a")
    path = tmp_path / "a" / name
    path.parent.mkdir(exist_ok=True)
    if name in ("zero.h5", "nowhere.h5"):
        path.symlink_to("/dev/zero" if name == "zero.h5" else "nowhere")
    else:
        os.mkfifo(path)
    archive = bs.Archive(tmp_path / "a")
    told = archive.table().set_index("path")["problem"].loc[lambda problem: problem != ""]
    assert list(told.index) == ([] if reason is None else [name])
    assert all(reason in problem for problem in told)
    assert len(archive.select("load_factor > 0")) == 5


def test_runs_under_way_are_listed(folder, tmp_path, small_model, small_cases):
    seen = []

    def look(event):
        if isinstance(event, CaseStarted):
            seen.append(bs.Archive(tmp_path).table())

    bs.AnalysisManager(small_model, tmp_path / "x.h5", listeners=[look]).run(small_cases[:1])
    assert seen[0]["path"].tolist() == ["x.h5"]
    assert "under way" in seen[0]["problem"][0]
    assert bs.Archive(tmp_path).table()["problem"].tolist() == [""]


def test_tables_follow_the_files(folder, tmp_path, small_analysis):
    shutil.copytree(folder, tmp_path / "a")
    archive = bs.Archive(tmp_path / "a")
    archive.table()
    bs.save_analysis(small_analysis.replaced(tags=["new"]), tmp_path / "a" / "wall.h5")
    (tmp_path / "a" / "wall-2.h5").unlink()
    assert archive.select("'new' in tags")["path"].tolist() == ["wall.h5"] * 2
    assert "wall-2.h5" not in set(archive.table()["path"])


def test_histories_are_one_lazy_tree(folder, small_analysis):
    archive = bs.Archive(folder)
    tree = archive.history("load_factor > 0")
    assert len(tree.leaves) == 5
    name = "push nonassociative"
    history = tree[f"wall.h5/{name}"]
    force = history["contact_force"]
    assert not any(v.variable._in_memory for v in history.ds.data_vars.values())
    expected = small_analysis[name].history.contact_force.isel(iteration=3, contact_point=5)
    np.testing.assert_array_equal(force.isel(iteration=3, contact_point=5), expected)
    assert not force.variable._in_memory
    block = tree["sub/block.h5/rocks %2F x"]
    assert float(block["load_factor"][-1]) == pytest.approx(0.5, rel=1e-3)
    tree.close()


def test_histories_of_damaged_files_are_refused(damaged):
    archive = bs.Archive(damaged)
    rows = archive.select("path == 'wall.h5'")
    with edited(damaged / "wall.h5") as file:
        del file["/cases/push associative/history/contact_force"]
    with pytest.raises(bs.errors.FormatError, match=r"push associative.*contact_force"):
        archive.history(rows)


def test_the_difference_of_two_archives(folder, tmp_path, small_analysis):
    shutil.copytree(folder, tmp_path / "a")
    name = "push associative"
    # The same question with a load 1 % smaller: an answer 1 % larger.
    less = [bs.BodyForce("+x", share=1 / 1.01)]
    less += [bs.PointLoad("3.1", ["0.2 m", "0.1 m", "0.6 m"], Q_([10 / 1.01, 0, 0], "N"))]
    case = small_analysis[name].case
    weaker = attrs.evolve(case, variable=bs.LoadPattern(case.variable.name, less))
    higher = bs.AnalysisManager(small_analysis.model).run([weaker]).replaced(tags=small_analysis.tags)
    bs.save_analysis(higher, tmp_path / "a" / "wall.h5")
    (tmp_path / "a" / "wall-2.h5").unlink()
    found = bs.Archive(folder).difference(bs.Archive(tmp_path / "a"))
    assert len(found) == 5
    assert found.loc[("wall.h5", name), "relative_difference"] == pytest.approx(0.01, rel=1e-5)
    assert found.loc[("sub/block.h5", "rocks / x"), "relative_difference"] == 0
    assert np.isnan(found.loc[("wall-2.h5", name), "load_factor_other"])
