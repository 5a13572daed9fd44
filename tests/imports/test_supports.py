"""Supports as people draw them: a single face, level ground, and names with wildcards."""

import json

import numpy as np
import pytest

import blockstruct as bs
from meshes import CUBE, QUADS, objects_text, saved
from refusals import refused
from structures import STONE, model_of, push, solve

JOINT = bs.JointMaterial("joint", 0.65)
#: A block 0.5 m × 1 m × 1 m turned about y, and the face that it stands on, drawn wider; m.
TURN = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
FACE = np.array([(-1, -1, 0), (1.5, -1, 0), (1.5, 2, 0), (-1, 2, 0)], dtype=float)
BODY = np.array(CUBE) * [0.5, 1.0, 1.0]


def compas(path, *, turn=None, down=False, support=True):
    """An assembly of a block on a face that looks up or down."""
    turn = np.eye(3) if turn is None else turn

    def mesh(points, faces, **marks):
        data = {"vertices": (points @ turn.T).tolist(), "faces": faces, "attributes": marks}
        return {"dtype": "compas.datastructures/Mesh", "data": data}

    loop = [3, 2, 1, 0] if down else [0, 1, 2, 3]
    path.write_text(json.dumps([mesh(FACE, [loop], name="face", is_support=support), mesh(BODY, QUADS, name="b")]))
    return path


def read(path, **options):
    read_one = bs.imports.read_assembly if path.suffix == ".json" else bs.imports.read_mesh
    return read_one(path, unit="m", material=STONE, **options)


def mesh(path, shift=0.0):
    """Two blocks, one on the other."""
    bodies = {f"pier {k + 1}": np.add(BODY, [0, 0, k + shift]) for k in range(2)}
    return saved(path.parent, path.name, objects_text(bodies))


@pytest.mark.parametrize("down", [False, True])
@pytest.mark.parametrize("turn", [None, TURN])
def test_a_support_of_one_face_is_a_block_behind_it(tmp_path, turn, down):
    found = read(compas(tmp_path / "a.json", turn=turn, down=down))
    face, block = found.blocks
    assert found.report.supports == ("face",)
    assert found.report.warnings == ()
    up = np.eye(3)[2] if turn is None else turn[:, 2]
    assert (face.shape.vertices @ up).max() == pytest.approx(0.0, abs=1e-12)
    (joint,) = bs.detect_interfaces([face, block], joint_material=JOINT).interfaces
    assert joint.area == pytest.approx(0.5)


def test_a_face_that_is_no_support_is_told_to_be_one(tmp_path):
    path = compas(tmp_path / "a.json", support=False)
    with refused(bs.errors.GeometryFileError, "'face' open --fix"):
        read(path)
    assert read(path, fixed=["fa*"]).report.supports == ("face",)


def test_ground_is_a_fixed_block_under_all(tmp_path):
    found = read(mesh(tmp_path / "a.obj", shift=2.0), fixed="ground")
    assert found.report.supports == ("ground",)
    assert found.blocks[0].shape.vertices[:, 2].max() == pytest.approx(2.0)
    model = model_of(found.blocks, JOINT)
    assert {(i.minus, i.plus) for i in model.interfaces} == {("ground", "pier 1"), ("pier 1", "pier 2")}
    # Two blocks of 0.5 m × 1 m on each other tip about the lowest edge.
    assert solve(model, push(1, 0, 0)).load_factor == pytest.approx(0.25, rel=1e-6)


def test_ground_has_a_level(tmp_path):
    path = mesh(tmp_path / "a.obj")
    assert read(path, fixed=["ground -20 cm"]).blocks[0].shape.vertices[:, 2].max() == pytest.approx(-0.2)
    with refused(bs.errors.GeometryFileError, "'pier 1' below 0.5"):
        read(path, fixed=["ground 0.5 m"])


def test_supports_of_some_motions(tmp_path):
    path = mesh(tmp_path / "a.obj")
    found = read(path, fixed=["pier 1", "pier 2:x, ry"])
    assert [b.held for b in found.blocks] == [bs.vocabulary.MOTIONS, ("x", "ry")]
    assert found.report.supports == ("pier 1",)
    together = read(path, fixed=["pier *:x", "lowest:y"])
    assert [b.held for b in together.blocks] == [("x", "y"), ("x",)]
    with refused(bs.errors.UnknownNameError, "no block 'pier 2:u' to fix NAME:x,z"):
        read(path, fixed=["pier 2:u"])


def test_the_command_holds_a_wall_at_its_head(done, tmp_path):
    words = ("--unit", "m", "--unit-weight", "20 kN/m3", "--friction", "1.2", "--ground", "0 m", "--fix", "pier 2:x")
    out = done("import", mesh(tmp_path / "a.obj"), "-o", tmp_path / "a.yaml", *words)
    assert "pier 2 (holds x)" in out
    out = done("run", tmp_path / "a.yaml")
    # As tests/validation/test_rollers.py: t (3 a + 2 c) / a², and −W (α + t / c).
    assert "collapses at load factor 2.5 " in out
    assert "Support pier 2 holds x with -30 kN." in out
