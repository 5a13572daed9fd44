"""Files of strangers: what they are is asked before they are read, and each is refused by one message."""

import json
import os
import re
import shutil
import sys
import time

import ezdxf
import pytest

import blockstruct as bs
from blockstruct.analysis import IterationDone
from meshes import CUBE, QUADS, ascii_stl, obj_text, ply_text
from structures import SELF_WEIGHT, STONE, edited, model_of, push, single_block, stopping

READERS = dict.fromkeys(("a.obj", "a.stl", "a.ply"), bs.imports.read_mesh)
READERS |= {"a.dxf": bs.imports.read_drawing, "a.json": bs.imports.read_assembly}
posix = pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")


def read(path):
    """Read a file by the suffix of its name."""
    if path.suffix == ".yaml":
        return bs.read_document(path)
    return READERS[path.name](path, unit="m", material=STONE)


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
@pytest.mark.parametrize("name", [*READERS, "a.yaml"])
def test_readers_open_regular_files_only(tmp_path, name, kind):
    put(tmp_path / name, kind)
    with pytest.raises(bs.errors.StorageError, match=rf"{name}: is (a folder|not a regular file but a pipe or)"):
        read(tmp_path / name)


@pytest.mark.parametrize("name", READERS)
def test_imports_refuse_files_larger_than_any_mesh(tmp_path, name):
    with (tmp_path / name).open("wb") as stream:
        stream.truncate(1 << 40)
    with pytest.raises(bs.errors.StorageError, match="larger than 500 MB"):
        read(tmp_path / name)


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """Folder with a run that was stopped after two iterations."""
    stop = stopping(IterationDone, at=1, error=RuntimeError)
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


def compas_mesh():
    """A cube as COMPAS writes it."""
    data = {"vertices": [list(map(float, p)) for p in CUBE], "faces": QUADS}
    return json.dumps([{"dtype": "compas.datastructures/Mesh", "data": data}])


@pytest.mark.parametrize("number", ["1_0", "１", "1e400", "1e308", "nan", "0x1"])
@pytest.mark.parametrize("name", ["a.obj", "a.stl", "a.ply", "a.json"])
def test_numbers_of_text_formats_are_read_strictly(tmp_path, name, number):
    stone = single_block(1.0, 1.0)[0][1]
    text = {"a.obj": obj_text(), "a.stl": ascii_stl([stone]), "a.ply": ply_text([stone]), "a.json": compas_mesh()}[name]
    corner = rf"\g<1>{number}, 1, 1" if name == "a.json" else rf"\g<1>{number} 1 1"
    changed = re.sub(r"(?m)(^v |^vertex |^|\[)1(\.0)?,? 1(\.0)?,? 1(\.0)?(?=$|\])", corner, text)
    assert number in changed
    (tmp_path / name).write_text(changed, encoding="utf-8")
    with pytest.raises(bs.errors.GeometryFileError):
        read(tmp_path / name)


@pytest.mark.parametrize("code", ["10", "1_0"])
def test_numbers_of_drawings_are_read_strictly(tmp_path, code):
    path = tmp_path / "a.dxf"
    document = ezdxf.new()
    document.modelspace().add_lwpolyline([(0, 0), (1, 0), (1, 7.5), (0, 7.5)], close=True)
    document.saveas(path)
    text = path.read_text(encoding="utf-8")
    assert text.count(" 20\n7.5\n") == 2
    path.write_text(text.replace(" 20\n7.5\n", f" 20\n7.5\n {code}\n1_0\n", 1), encoding="utf-8")
    with pytest.raises(bs.errors.GeometryFileError, match="'1_0' in line"):
        bs.imports.read_drawing(path, unit="m", material=STONE, thickness="1 m")


def test_continued_lines_take_linear_time(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("\\\n" * 500_000 + "vn\\\n" + " 5\\\n" * 200_000 + "\n" + obj_text(), encoding="utf-8")
    start = time.process_time()
    assert read(path).blocks[0].volume == pytest.approx(1)
    # Reading every line anew from the first took 100 s for 500,000 lines.
    assert time.process_time() - start < 20


#: Texts that erase a line, set the title of the window, change colours, turn the direction, or hide what was printed.
TERMINAL = ["\x1b[2K\x1b[1A", "\x1b]0;title\x07", "\x9b31m", "wall\u202e", "wall\rnothing"]


def test_texts_of_an_analysis_are_printable(tmp_path):
    model = model_of(*single_block(0.5, 1.0))
    for text in (*TERMINAL, "a\0b", "\ud800", "two\nlines"):
        for given in ({"tags": [text]}, {"parameters": {"a": text}}, {"parameters": {text: 1}}, {"study": text}):
            with pytest.raises(bs.errors.ModelError, match="printable"):
                bs.AnalysisManager(model, tmp_path / "a.h5", **given)
    assert not list(tmp_path.iterdir())


def in_a_file(place, folder, text, analysis):
    """Commands for an analysis file with a text in one place, sealed again."""
    path = bs.save_analysis(analysis.replaced(tags=["north"], study="s", parameters={"a": "b"}), folder / "a.h5")
    with edited(path) as file:
        match place:
            case "tag":
                file.attrs["tags"] = json.dumps([text])
            case "parameter":
                file.attrs["parameters"] = json.dumps({text: text})
            case "study":
                file.attrs["study"] = text
            case "case":
                next(iter(file["cases"].values())).attrs["name"] = text
            case "block":
                file["model"]["block"][0] = text
    return [("show", path), ("archive", folder), ("diff", path, path), ("validate", path)]


def in_an_import(place, folder, text, _):
    """Commands for a mesh with a text in its name, or in the names of its bodies."""
    path = folder / (f"{text}.obj" if place == "file name" else "a.obj")
    good = f"o {text}\n{obj_text()}"
    words = ("-o", folder / "m.yaml", "--unit", "m", "--friction", "0.6", "--fix", "lowest")
    words += ("--unit-weight", "20 kN/m3")
    path.write_text(good if place == "body" else f"{good}f 1 2 99\n", encoding="utf-8")
    return [("import", path, *words)]


def in_a_document(_, folder, text, analysis):
    """Commands for a model document with a text as the name of a block."""
    path = bs.write_document(folder / "a.json", analysis.model, [result.case for result in analysis.values()])
    name = json.dumps(analysis.model.blocks[1].name)
    path.write_text(path.read_text(encoding="utf-8").replace(name, json.dumps(text)), encoding="utf-8")
    return [("validate", path), ("check", path), ("run", path, "-o", folder / "b.h5")]


@pytest.mark.parametrize("texts", [TERMINAL[:1], pytest.param(TERMINAL, marks=pytest.mark.slow)], ids=len)
@pytest.mark.parametrize(
    ("place", "made"),
    [
        *((place, in_a_file) for place in ("tag", "parameter", "study", "case", "block")),
        *((place, in_an_import) for place in ("file name", "body")),
        ("document", in_a_document),
    ],
)
def test_no_text_of_a_stranger_reaches_the_terminal_raw(call, tmp_path, tell, small_analysis, place, made, texts):
    outcomes = []
    for k, text in enumerate(texts):
        folder = tmp_path / f"{k}"
        folder.mkdir()
        said = ["".join(call(*words)[1:]) for words in made(place, folder, text, small_analysis)]
        raw = {c for c in "".join(said) if not c.isprintable() and c != "\n"}
        outcomes.append("wrong" if raw else "raw" if "Traceback" in "".join(said) else "escaped")
        print(place, ascii(text), raw, said[0][:200])
    tell("texts at a terminal", outcomes)
