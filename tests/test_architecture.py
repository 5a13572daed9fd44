"""The import arrows of the house: one way, from the model to the views."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import blockstruct as bs

SOURCE = Path(__file__).parents[1] / "src" / "blockstruct"
API = "the public interface"
GROUND = {"arrays", "errors", "units", "vocabulary", "notebook", "schema", "files"}
MAY_IMPORT = {
    "arrays": set(),
    "errors": set(),
    "vocabulary": set(),
    "notebook": set(),
    "schema": {"errors"},
    "files": {"errors"},
    "units": {"errors"},
    "geometry": {"arrays", "errors"},
    "model": {"geometry"} | GROUND,
    "contacts": {"model", "geometry"} | GROUND,
    "structures": {"model", "geometry"} | GROUND,
    "library": {"model"} | GROUND,
    "imports": {"structures", "model", "geometry"} | GROUND,
    "documents": {"model", "contacts", "structures"} | GROUND,
    "statics": {"model", "geometry"} | GROUND,
    "limit": {"statics", "model"} | GROUND,
    "solvers": {"limit"} | GROUND,
    "procedures": {"limit", "solvers"} | GROUND,
    "motion": {"solvers", "limit", "statics", "model"} | GROUND,
    "text": {"motion", "limit", "statics", "model"} | GROUND,
    "results": {"text", "motion", "limit", "statics", "model"} | GROUND,
    "assess": {"views", "analysis", "results", "text", "solvers", "limit", "statics", "model"} | GROUND,
    "storage": {"results", "motion", "limit", "model", "geometry"} | GROUND,
    "studies": {"analysis", "storage", "results", "text", "limit", "model", "documents"} | GROUND,
    "analysis": {"procedures", "motion", "limit", "solvers", "results", "text", "storage", "statics", "model"} | GROUND,
    "adapters": {API, "arrays", "imports", "geometry", "units"},
    "views": {API, "analysis", "arrays", "text", "geometry", "units", "vocabulary", "files"},
    "__main__": {"cli"},
    "cli": {API, "errors", "vocabulary", "analysis", "text", "views"},
}
FILES = sorted(p for p in SOURCE.rglob("*.py") if p != SOURCE / "__init__.py")
ROOMS: dict[str, list[Path]] = {}
for _path in FILES:
    ROOMS.setdefault(_path.relative_to(SOURCE).parts[0].removesuffix(".py"), []).append(_path)


def room_of(module):
    """Room of a dotted name; the package itself is the public interface."""
    parts = module.split(".")
    if parts[0] != "blockstruct":
        return None
    return parts[1] if len(parts) > 1 and parts[1] in ROOMS else API


def imported_rooms(source, package):
    """Rooms that a text imports, wherever the import stands and however it is written."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (room_of(name.name) for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            module = ".".join([*base, *filter(None, [node.module])])
            if module == "blockstruct":
                yield from (room_of(f"blockstruct.{name.name}") for name in node.names)
            else:
                yield room_of(module)


@pytest.mark.parametrize("room", ROOMS)
def test_import_arrows(room):
    assert room in MAY_IMPORT, f"{room} is not a room of the house"
    for path in ROOMS[room]:
        package = ".".join(["blockstruct", *path.relative_to(SOURCE).parts[:-1]])
        found = set(imported_rooms(path.read_text(encoding="utf-8"), package)) - {room, None}
        assert found <= MAY_IMPORT[room], path


def test_every_way_to_write_an_import_is_seen():
    ways = ["import blockstruct.views", "from blockstruct.views import figures", "from blockstruct import views"]
    ways += ["from ..views import figures", "from .. import views", "def f():\n    from blockstruct.views import page"]
    assert all(set(imported_rooms(text, "blockstruct.results")) == {"views"} for text in ways)


def test_the_whole_package_is_an_arrow_too():
    assert set(imported_rooms("import blockstruct as bs\nimport numpy", "blockstruct.results")) == {API, None}
    assert set(imported_rooms("from blockstruct import Model", "blockstruct.results")) == {API}


def test_sections_of_docstrings_hold_entries_alone():
    """Numpydoc takes a sentence after the parameters for one more of them, and prints its markup raw."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    texts = (
        ast.get_docstring(node) or ""
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, documented)
    )
    listed = re.compile(r"^(?:Parameters|Attributes|Raises|Warns)\n-+\n((?:.*\n?)*?)(?=^\w+\n-+$|\Z)", re.MULTILINE)
    lines = [line for text in texts for block in listed.findall(text) for line in block.splitlines()]
    entries = [line for line in lines if re.match(r"\S", line)]
    assert len(entries) > 500
    assert [e for e in entries if not re.fullmatch(r"[\w.*]+(, [\w.*]+)*( : .+)?", e)] == []


def test_every_room_of_the_house_exists():
    rooms = {p.stem for p in SOURCE.iterdir() if p.suffix == ".py" or (p / "__init__.py").is_file()}
    assert rooms - {"__init__"} == set(MAY_IMPORT)


def test_pint_stops_at_the_model():
    beyond = [p for p in FILES if "import pint" in p.read_text(encoding="utf-8")]
    assert {p.relative_to(SOURCE).as_posix() for p in beyond} <= {"units.py"}


#: What takes long to load, and only some who import blockstruct need.
OTHERS = (
    "IPython cvxpy dask ezdxf h5netcdf h5py jinja2 jsonschema matplotlib plotly pyvista rich shapely trimesh typer yaml"
)
HEAVY = {*OTHERS.split(), *(f"scipy.{name}" for name in ("optimize", "sparse", "spatial", "stats"))}
HEAVY |= {f"blockstruct.{room}" for room in ROOMS if room not in ("errors", "units", "vocabulary")}


def test_the_import_is_light():
    """Nothing heavy is loaded beyond what xarray and pint load, and the registry of units reads no definitions."""
    said = (
        "import sys, numpy, scipy, xarray, pint; before = set(sys.modules); import blockstruct; "
        f"print(({HEAVY} - before) & set(sys.modules), type(blockstruct.units.ureg).__name__)"
    )
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set() LazyRegistry"


def test_the_help_of_the_console_loads_no_room_but_its_own():
    code = "import sys; sys.argv[1:] = ['--help']; from blockstruct.cli import main\ntry: main()\n"
    code += "finally: print(list(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {"numpy", "pint", *(f"blockstruct.{room}" for room in ROOMS)} & set(
        ast.literal_eval(done.stdout.splitlines()[-1])
    )
    assert loaded == {f"blockstruct.{room}" for room in ("cli", "errors", "vocabulary")}


def test_what_is_loaded_later_is_there():
    assert set(bs.__all__) <= set(dir(bs))
    with pytest.raises(AttributeError, match="no attribute 'read_documents'"):
        _ = bs.read_documents
