"""Documents and drawings made to exhaust, to confuse or to break: each is read, or refused with one error of ours."""

import json

import pytest

import blockstruct as bs
from trials import attack

STONE = bs.Material("stone", "20 kN/m^3")
BASIC = """\
blockstruct: model-1
name: two blocks
materials: { stone: { unit_weight: 20 kN/m^3 } }
joint_materials: { dry: { friction_coefficient: 0.6 } }
blocks:
  - { name: base, material: stone, fixed: true, box: { origin: [0 m, 0 m, -1 m], size: [1 m, 1 m, 1 m] } }
  - { name: block, material: stone, box: { origin: [0 m, 0 m, 0 m], size: [1 m, 1 m, 1 m] } }
interfaces: { joint_material: dry }
load_patterns:
  dead: [{ kind: self_weight }]
  push: [{ kind: body_force, direction: [1, 0, 0] }]
cases: [{ name: push, dead: dead, variable: push }]
settings: { crushing_cells: 30 }
"""
LAUGHS = "a0: &a0 [lol, lol, lol, lol, lol, lol, lol, lol, lol]\n" + "".join(
    f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 20)
)


def changed(old, new):
    assert old in BASIC
    return BASIC.replace(old, new)


YAML = {
    "aliases upon aliases": LAUGHS,
    "aliases upon aliases in the settings": changed("{ crushing_cells: 30 }", "\n  " + LAUGHS.replace("\n", "\n  ")),
    "1,000 levels by aliases": "a0: &a0 [k]\n" + "".join(f"a{k}: &a{k} [*a{k - 1}]\n" for k in range(1, 1_000)),
    "an alias of itself": "a: &a [*a]",
    "100,000 lists": "[" * 100_000,
    "5,000 levels of indentation": "".join(f"{' ' * k}a:\n" for k in range(5_000)),
    "20,000 equal keys": "a: 1\n" * 20_000,
    "2,000 materials": changed(
        "{ stone: { unit", "{ " + "".join(f"m{k}: {{ density: 2 t/m^3 }}, " for k in range(2_000)) + "stone: { unit"
    ),
    "20,000 violations": "blocks:\n" + "- { name: 1 }\n" * 20_000,
    "a list as a key": "? [1, 2]\n: 3",
    "a key of 100,000 letters": changed("{ crushing_cells: 30 }", f"{{ {'k' * 100_000}: 1 }}"),
    "an object of Python": "!!python/object/apply:os.system ['true']",
    "5,000 digits": changed("[1, 0, 0]", f"[{'1' * 5_000}, 0, 0]"),
    "nan": changed("[1, 0, 0]", "[.nan, 0, 0]"),
    "1e999": changed("0.6", "1e999"),
    "a date as a name": changed("name: block,", "name: 2026-01-31,"),
    "a unit of 100,000 letters": changed("20 kN/m^3", f"20 {'k' * 100_000}"),
    "a power tower": changed("20 kN/m^3", "20 m**9**9**9"),
    "an expression": changed("20 kN/m^3", "__import__('os').system('true') m"),
    "absurdly heavy": changed("20 kN/m^3", "1e300 kN/m^3"),
    "absurdly large": changed("size: [1 m, 1 m, 1 m] } }\nint", "size: [1e29 m, 1e29 m, 1e29 m] } }\nint"),
    "a name of 100,000 letters": changed("name: block,", f"name: {'k' * 100_000},"),
    "a name of control characters": changed("name: block,", 'name: "a\\0\\e[2J",'),
    "a surrogate": changed("name: block,", 'name: "\\ud800",'),
    "faces of a million": changed(
        "box: { origin: [0 m, 0 m, 0 m], size: [1 m, 1 m, 1 m] }",
        "polyhedron: { unit: m, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces: "
        "[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 999999999999999999999999]] }",
    ),
    "a course of 1e9 units": changed(
        "interfaces:",
        "courses:\n"
        "  - { rows: [[1e-300, 1e9]], unit_length: 1 m, unit_height: 1 m, thickness: 1 m, material: stone }\n"
        "interfaces:",
    ),
    "NUL": "a: \0",
    "nothing": "",
    "a document after the document": BASIC + "---\n" + BASIC,
    "an unknown alias": "a: *b",
    "merged keys": changed("{ crushing_cells: 30 }", "{ <<: { path_step: 1 } }"),
}
JSON = {
    "100,000 lists": "[" * 100_000,
    "deep settings": json.dumps({"settings": {}}).replace("{}", '{"a":' * 900 + "1" + "}" * 900),
    "5,000 digits": '{"blockstruct": ' + "1" * 5_000 + "}",
    "NaN": '{"blockstruct": NaN}',
    "a surrogate": '{"name": "\\ud800"}',
    "null": "null",
}


def dxf(*blocks, inserts):
    """Drawing in DXF: names of blocks with what is in them, and what is in the model space."""
    import ezdxf

    drawing = ezdxf.new()
    for name, content in blocks:
        fill(drawing.blocks.new(name), content)
    fill(drawing.modelspace(), inserts)
    return drawing


def fill(layout, content):
    for name, rows, columns in content:
        if name is None:
            layout.add_lwpolyline([(0, 0), (1, 0), (1, 1), (0, 1)], close=True)
        else:
            attributes = {"row_count": rows, "column_count": columns, "row_spacing": 2, "column_spacing": 2}
            layout.add_blockref(name, (0, 0), dxfattribs=attributes)


STONES = [("stone", [(None, 1, 1)])]
NESTED = [(f"b{k}", [(f"b{k - 1}" if k else "stone", 1, 1)] * 10) for k in range(15)]
DRAWINGS = {
    "inserts upon inserts": lambda: dxf(*STONES, *NESTED, inserts=[("b14", 1, 1)]),
    "empty inserts upon inserts": lambda: dxf(("stone", []), *NESTED, inserts=[("b14", 1, 1)]),
    "30,000 times 30,000": lambda: dxf(*STONES, inserts=[("stone", 30_000, 30_000)]),
    "30,000 times 30,000 of themselves": lambda: dxf(
        *STONES, ("b", [("stone", 30_000, 30_000)]), inserts=[("b", 30_000, 30_000)]
    ),
    "a block in itself": lambda: dxf(("b", [(None, 1, 1), *[("b", 1, 1)] * 3]), inserts=[("b", 1, 1)]),
    "a block that is missing": lambda: dxf(inserts=[("b", 1, 1)]),
}


def read(path, content):
    path.write_text(content, encoding="utf-8", errors="surrogatepass")
    document = bs.read_document(path)
    settings = bs.ProcedureSettings.of(document.settings)
    bs.AnalysisManager(document.model, settings=settings).check(document.cases)
    return document.model


def trials(folder):
    for name, content in YAML.items():
        yield f"yaml: {name}", lambda c=content: read(folder / "m.yaml", c)
    for name, content in JSON.items():
        yield f"json: {name}", lambda c=content: read(folder / "m.json", c)
    for k, (name, made) in enumerate(DRAWINGS.items()):
        path = folder / f"{k}.dxf"
        made().saveas(path)
        yield f"dxf: {name}", lambda p=path: bs.imports.read_drawing(p, unit="m", material=STONE, thickness="1 m")


@pytest.mark.filterwarnings(
    "ignore::blockstruct.errors.GeometryWarning", "ignore::blockstruct.errors.UnusualValueWarning"
)
def test_hostile_documents(tmp_path, tell):
    assert len(read(tmp_path / "m.yaml", BASIC).interfaces) == 1
    found = attack(trials(tmp_path))
    tell("hostile documents and drawings", found.values())
    answered = {name for name, how in found.items() if how == "answered"}
    assert answered <= {"yaml: a date as a name", "yaml: 2,000 materials", "dxf: a block in itself"}
