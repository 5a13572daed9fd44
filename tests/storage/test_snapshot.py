"""Opening: the seal first, one snapshot, histories when they are looked at, and what is left of a damaged file."""

import gc
import shutil
import warnings
from pathlib import Path

import h5py
import pytest

import blockstruct as bs
from blockstruct.storage import file as storage_file
from blockstruct.storage.file import AnalysisFile
from structures import seal_again


@pytest.fixture(scope="module")
def path(small_analysis, tmp_path_factory):
    return bs.save_analysis(small_analysis, tmp_path_factory.mktemp("snapshot") / "small.h5")


@pytest.fixture
def copy(path, tmp_path):
    return shutil.copy(path, tmp_path / "copy.h5")


@pytest.fixture(params=["in memory", "by its descriptor"])
def kept(request, monkeypatch):
    """Both ways of keeping what a file was."""
    if request.param == "by its descriptor":
        monkeypatch.setattr(storage_file, "_SMALL", 1)


def test_no_byte_of_a_damaged_file_reaches_libhdf5(copy, small_model, monkeypatch):
    content = bytearray(copy.read_bytes())
    content[1000] ^= 1
    copy.write_bytes(content)

    def opened(*_, **__):
        raise AssertionError

    monkeypatch.setattr(h5py, "File", opened)
    with pytest.raises(bs.errors.FormatError, match=r"do not match its seal.*verify=False"):
        bs.open_analysis(copy)
    with pytest.raises(bs.errors.FormatError, match="do not match its seal"):
        bs.check_file(copy)
    with pytest.raises(bs.errors.StorageError, match="not a blockstruct analysis, or a damaged one"):
        bs.AnalysisManager(small_model, copy)
    assert "do not match its seal" in bs.Archive(copy.parent).table()["problem"][0]


@pytest.mark.parametrize("change", ["replaced", "removed"])
def test_what_is_opened_stays_what_it_was(copy, small_analysis, kept, change):
    stored = bs.open_analysis(copy)
    if change == "replaced":
        name = "push associative"
        bs.save_analysis(small_analysis.replaced(results={name: small_analysis[name]}), copy)
    else:
        copy.unlink()
    for name, result in small_analysis.items():
        assert stored[name].history.identical(result.history)


def test_a_file_that_is_written_to_while_it_is_open_is_refused(copy, monkeypatch):
    monkeypatch.setattr(storage_file, "_SMALL", 1)
    stored = bs.open_analysis(copy)
    with copy.open("r+b") as file:
        file.write(b"x")
    with pytest.raises(bs.errors.FormatError, match="was written to by another program while it was open"):
        stored["push associative"].history.load()


def test_histories_are_read_when_they_are_looked_at(path, small_analysis, kept, monkeypatch):
    read = []
    plain = AnalysisFile.group
    monkeypatch.setattr(AnalysisFile, "group", lambda self, place, part: read.append(place) or plain(self, place, part))
    stored = bs.open_analysis(path)
    assert not any("history" in name for name in read)
    result = stored["push associative"]
    assert result.n_iterations == small_analysis["push associative"].n_iterations
    assert repr(result)
    assert not any("history" in name for name in read)
    assert result.history is result.history
    assert [name for name in read if "history" in name] == ["/cases/push associative/history"]


def test_descriptors_are_closed(copy, monkeypatch):
    monkeypatch.setattr(storage_file, "_SMALL", 1)
    gc.collect()
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(5):
        bs.open_analysis(copy)["push associative"].history.load()
    gc.collect()
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_a_file_with_an_addition_is_opened_on_demand(copy, small_analysis):
    with h5py.File(copy, "r+") as file:
        file.attrs["note"] = "mine"
    with pytest.raises(bs.errors.FormatError, match="verify=False"):
        bs.open_analysis(copy)
    with pytest.warns(bs.errors.UnverifiedWarning, match="its numbers are not verified"):
        found = bs.open_analysis(copy, verify=False)
    assert found["push associative"].history.identical(small_analysis["push associative"].history)
    seal_again(copy)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bs.open_analysis(copy, verify=False)


@pytest.mark.parametrize(
    "group", ["/", "/model", "/cases", "/cases/push associative", "/cases/push associative/history"]
)
def test_absurdly_many_groups_are_refused_without_a_look_into_them(copy, group, monkeypatch):
    with h5py.File(copy, "r+") as file:
        for k in range(2_000):
            file[group].create_group(f"{k}")
    seal_again(copy)
    looked = []
    plain = h5py.Group.__getitem__
    monkeypatch.setattr(h5py.Group, "__getitem__", lambda self, name: looked.append(name) or plain(self, name))
    for read in (bs.check_file, lambda path: [r.history for r in bs.open_analysis(path).values()]):
        with pytest.raises(bs.errors.FormatError, match=r"absurd|not those that the attribute cases"):
            read(copy)
    assert len(looked) < 1000
