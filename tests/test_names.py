"""The names that files are written to: checked at the start, and never the loss of another file."""

import contextlib
import errno
import os
import shutil
import tempfile

import pytest

import blockstruct as bs
from blockstruct.analysis import CaseFinished, CaseStarted
from blockstruct.storage import run_folder
from blockstruct.views.output import write_text
from structures import SELF_WEIGHT, model_of, push, single_block

CASE = bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0), "associative")


@pytest.fixture(scope="module")
def model():
    return model_of(*single_block(0.5, 1.0), name="block")


@pytest.fixture(scope="module")
def done(model):
    return bs.AnalysisManager(model).run([CASE])


class Killed(BaseException):
    """Ends a run as a kill would."""


def kill_run(model, path, at=CaseFinished):
    """Leave a run behind that was killed at an event."""

    def kill(event):
        if isinstance(event, at):
            raise Killed

    with contextlib.suppress(Killed):
        bs.AnalysisManager(model, path, listeners=[kill]).run([CASE])
    assert (path.parent / f"{path.name}.partial" / "plan").is_file()


@pytest.mark.parametrize("name", ["wall", "wall.h5.txt"])
def test_names_without_the_suffix_are_refused(model, done, tmp_path, name):
    for write in (lambda: bs.AnalysisManager(model, tmp_path / name), lambda: bs.save_analysis(done, tmp_path / name)):
        with pytest.raises(
            bs.errors.StorageError, match=rf"{name}: the name of an analysis ends in \.h5.*write .*{name}\.h5"
        ):
            write()
    assert not any(tmp_path.iterdir())


def test_a_name_too_long_is_refused_before_the_run(model, done, tmp_path):
    name = "w" * 250 + ".h5"
    for write in (lambda: bs.AnalysisManager(model, tmp_path / name), lambda: bs.save_analysis(done, tmp_path / name)):
        with pytest.raises(bs.errors.StorageError, match="name is too long"):
            write()
    longest = tmp_path / ("w" * 244 + ".h5")
    bs.AnalysisManager(model, longest).run([CASE])
    assert bs.open_analysis(longest)["rocks"].load_factor == pytest.approx(0.5, rel=1e-6)


@pytest.mark.parametrize("path", ["a\0b.h5", "", 3, None, b"\xff.h5"])
def test_what_is_no_path_is_refused(done, path):
    with pytest.raises(bs.errors.StorageError):
        bs.save_analysis(done, path)


@pytest.mark.parametrize("content", [b"foreign", None], ids=["foreign", "analysis"])
def test_a_file_that_appears_during_the_run_is_kept(model, done, tmp_path, content):
    path, other = tmp_path / "block.h5", bs.save_analysis(done, tmp_path / "other.h5")

    def meddle(event):
        if isinstance(event, CaseStarted):
            path.write_bytes(content or other.read_bytes())

    with pytest.raises(
        bs.errors.StorageError, match="another file has appeared at this name, and is not replaced; move it"
    ):
        bs.AnalysisManager(model, path, listeners=[meddle]).run([CASE])
    assert path.read_bytes() == (content or other.read_bytes())
    with pytest.raises(bs.errors.StorageError, match="another file has appeared"):
        bs.recover(path)
    path.rename(tmp_path / "mine")
    assert bs.recover(path)["rocks"].status == "converged"
    assert bs.open_analysis(path)["rocks"].status == "converged"


def test_a_copied_run_is_refused_before_anything_is_solved(model, done, tmp_path):
    """The copy of the file that it was to replace is another file: nothing tells that nobody wants to keep it."""
    original, copy = tmp_path / "original", tmp_path / "copy"
    bs.save_analysis(done, original / "block.h5")
    kill_run(model, original / "block.h5")
    shutil.copytree(original, copy)
    events = []
    for go_on in (lambda path: bs.AnalysisManager.resume(path, listeners=[events.append]), bs.recover):
        with pytest.raises(bs.errors.StorageError, match="another file has appeared"):
            go_on(copy / "block.h5")
    assert not events
    (copy / "block.h5").unlink()
    for path in (copy / "block.h5", original / "block.h5"):
        assert bs.AnalysisManager.resume(path)["rocks"].status == "converged"


def test_a_kill_behind_the_finished_file_is_recovered(model, tmp_path, monkeypatch):
    """The file is in place, its working data are not removed yet: it is known as the run's own."""
    path = tmp_path / "block.h5"
    monkeypatch.setattr("blockstruct.storage.run_folder.clear", lambda folder: None)
    kill_run(model, path, at=CaseFinished)
    monkeypatch.undo()

    def kill(folder):
        raise Killed

    monkeypatch.setattr("blockstruct.storage.run_folder.clear", kill)
    with contextlib.suppress(Killed):
        bs.recover(path)
    monkeypatch.undo()
    assert path.is_file()
    assert bs.recover(path)["rocks"].status == "converged"
    assert [p.name for p in tmp_path.iterdir()] == ["block.h5"]


def test_a_symbolic_link_stays_one(model, done, tmp_path):
    (tmp_path / "far").mkdir()
    target = bs.save_analysis(done, tmp_path / "far" / "block.h5")
    link = tmp_path / "link.h5"
    link.symlink_to(target)
    before = target.stat().st_ino
    bs.AnalysisManager(model, link).run([CASE])
    assert link.is_symlink()
    assert target.stat().st_ino != before
    assert bs.open_analysis(link)["rocks"].status == "converged"
    kill_run(model, tmp_path / "far" / "block.h5")
    assert bs.recover(link)["rocks"].n_iterations


def test_a_file_system_without_locks_is_named(model, tmp_path, monkeypatch):
    def none(stream):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(run_folder, "_take", none)
    with pytest.raises(bs.errors.StorageError, match=r"has no locks \(No locks available\).*local disk"):
        bs.AnalysisManager(model, tmp_path / "block.h5").run([CASE])


@pytest.fixture
def unprivileged():
    """Rights count, as they do not for root."""
    if os.geteuid():
        yield
        return
    os.seteuid(65534)
    yield
    os.seteuid(0)


@pytest.fixture
def open_folder(done):
    """A folder that others may look into, with an analysis."""
    with tempfile.TemporaryDirectory() as name:
        os.chmod(name, 0o755)  # noqa: PTH101
        yield bs.save_analysis(done, f"{name}/block.h5").parent
        os.chmod(name, 0o755)  # noqa: PTH101


def test_read_only_places(model, done, open_folder, unprivileged):
    path = open_folder / "block.h5"
    assert bs.open_analysis(path)["rocks"].history.sizes["iteration"]
    for write in (
        lambda: bs.AnalysisManager(model, path),
        lambda: bs.save_analysis(done, path),
        lambda: bs.AnalysisManager(model, open_folder / "sub" / "block.h5"),
    ):
        with pytest.raises(bs.errors.StorageError, match=r"cannot be written \(Permission denied\); choose a folder"):
            write()
    # What view and report end with.
    with pytest.raises(bs.errors.StorageError, match=r"cannot be written \(Permission denied\); choose another file"):
        write_text("page", path.with_suffix(".html"))


def test_unreadable_files_and_locked_folders(model, open_folder, request):
    path = open_folder / "block.h5"
    shutil.copy(path, open_folder / "secret.h5")
    (open_folder / "secret.h5").chmod(0)
    (open_folder / "locked").mkdir(0o700)
    kill_run(model, open_folder / "killed.h5")
    (open_folder / "killed.h5.partial").chmod(0o700)
    request.getfixturevalue("unprivileged")
    with pytest.raises(bs.errors.StorageError, match=r"secret\.h5: cannot be read \(Permission denied\)"):
        bs.open_analysis(open_folder / "secret.h5")
    problems = bs.Archive(open_folder).table().set_index("path")["problem"]
    assert problems["block.h5"] == ""
    assert "cannot be read (Permission denied)" in problems["secret.h5"]
    assert "cannot be looked into" in problems["locked"]
    assert "cannot be looked into" in problems["killed.h5"]
    for go_on in (bs.recover, bs.AnalysisManager.resume):
        with pytest.raises(bs.errors.StorageError, match=r"killed\.h5\.partial: cannot be looked into"):
            go_on(open_folder / "killed.h5")
