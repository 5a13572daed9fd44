"""Files of strangers: what they are is asked before they are read, and each is refused by one message."""

import os
import shutil
import sys

import pytest

import blockstruct as bs
from blockstruct.analysis import IterationDone
from structures import SELF_WEIGHT, STONE, model_of, push, single_block

READERS = {
    "a.obj": bs.imports.read_mesh,
    "a.stl": bs.imports.read_mesh,
    "a.ply": bs.imports.read_mesh,
    "a.dxf": bs.imports.read_drawing,
    "a.json": bs.imports.read_assembly,
}
posix = pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")


def put(path, kind):
    """Something at a path that is no regular file."""
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/zero")


@posix
@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
@pytest.mark.parametrize("name", READERS)
def test_imports_open_regular_files_only(tmp_path, name, kind):
    put(tmp_path / name, kind)
    with pytest.raises(
        bs.errors.StorageError, match=rf"{name}: is (a folder|not a regular file but a pipe or a device)"
    ):
        READERS[name](tmp_path / name, unit="m", material=STONE)


@pytest.mark.parametrize("name", READERS)
def test_imports_refuse_files_larger_than_any_mesh(tmp_path, name):
    with (tmp_path / name).open("wb") as stream:
        stream.truncate(1 << 40)
    with pytest.raises(bs.errors.StorageError, match="larger than 500 MB"):
        READERS[name](tmp_path / name, unit="m", material=STONE)


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """Folder with a run that was stopped after two iterations."""

    def stop(event):
        if isinstance(event, IterationDone) and event.index == 1:
            raise RuntimeError

    folder = tmp_path_factory.mktemp("killed")
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "nonassociative")
    with pytest.raises(RuntimeError):
        bs.AnalysisManager(model_of(*single_block(0.5, 1.0)), folder / "a.h5", listeners=[stop]).run([case])
    return folder


@posix
@pytest.mark.parametrize("name", ["target", "draft", "target.draft", "0.journal", "plan"])
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_run_with_pipes_in_its_folder_resumes_or_is_refused(killed, tmp_path, name, kind):
    shutil.copytree(killed, tmp_path / "run")
    path = tmp_path / "run" / "a.h5.partial" / name
    path.unlink(missing_ok=True)
    put(path, kind)
    if name in ("0.journal", "plan"):
        with pytest.raises(bs.errors.StorageError):
            bs.AnalysisManager.resume(tmp_path / "run" / "a.h5")
    else:
        assert bs.AnalysisManager.resume(tmp_path / "run" / "a.h5")["push"].load_factor == pytest.approx(0.5, rel=1e-4)
