"""The import arrows of the house: one way, from the model to the views."""

import ast
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "blockstruct"
GROUND = {"errors", "keywords", "units", "vocabulary", "schema", "files"}
MAY_IMPORT = {
    "errors": set(),
    "vocabulary": set(),
    "keywords": {"errors"},
    "schema": {"keywords"},
    "files": {"errors"},
    "units": {"errors"},
    "geometry": {"errors"},
    "model": {"geometry"} | GROUND,
    "contacts": {"model", "geometry"} | GROUND,
    "structures": {"model", "geometry"} | GROUND,
    "imports": {"model", "geometry"} | GROUND,
    "documents": {"model", "contacts", "structures"} | GROUND,
    "statics": {"model", "geometry"} | GROUND,
    "limit": {"statics", "model"} | GROUND,
    "solvers": {"limit"} | GROUND,
    "procedures": {"limit", "solvers"} | GROUND,
    "results": {"limit", "statics", "model"} | GROUND,
    "storage": {"results", "model", "geometry"} | GROUND,
    "analysis": {"procedures", "limit", "solvers", "results", "storage", "statics", "model"} | GROUND,
    "views": {"analysis", "units", "files"},
    "cli": {"analysis", "views"},
}
FILES = sorted(p for p in SOURCE.rglob("*.py") if p != SOURCE / "__init__.py")


def imported_rooms(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("blockstruct."):
            yield node.module.split(".")[1]
        if isinstance(node, ast.Import):
            yield from (n.name.split(".")[1] for n in node.names if n.name.startswith("blockstruct."))


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_import_arrows(path):
    room = path.relative_to(SOURCE).parts[0].removesuffix(".py")
    assert room in MAY_IMPORT, f"{room} is no room of the house"
    assert set(imported_rooms(path)) - {room} <= MAY_IMPORT[room]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_no_room_is_cluttered(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 400


def test_every_room_of_the_house_exists():
    rooms = {p.stem for p in SOURCE.iterdir() if p.suffix == ".py" or (p / "__init__.py").is_file()}
    assert rooms - {"__init__"} == set(MAY_IMPORT)


def test_pint_stops_at_the_model():
    beyond = [p for p in FILES if "import pint" in p.read_text(encoding="utf-8")]
    assert {p.relative_to(SOURCE).as_posix() for p in beyond} <= {"units.py"}
