"""Model documents written and read back."""

import pytest
import yaml

import blockstruct as bs
from blockstruct import Q_
from refusals import refused
from structures import moved, rotation

TUFF = bs.Material("tuff", "12.3 kN/m^3")
ANGLES = {"friction_angle": "33 deg", "dilatancy_angle": "4.5 deg"}
STRENGTHS = {"cohesion": "0.11 MPa", "tensile_strength": "0.1 MPa", "compressive_strength": "4.7 MPa"}
LIME = bs.JointMaterial("lime: mortar", **ANGLES, **STRENGTHS)


@pytest.fixture
def model():
    size = {"unit_length": "37 cm", "unit_height": "17.5 cm", "thickness": "0.3333 m"}
    blocks = bs.courses([[1, 1], [0.5, 1, 0.5]], **size, material=TUFF)
    # Turned, so that no coordinate is a round number.
    blocks = moved(blocks, rotation((0, 0, 1), 0.3))
    return bs.Model("wall: turned", blocks, bs.detect_interfaces(blocks, joint_material=LIME).interfaces)


@pytest.fixture
def cases():
    corners = {"start": Q_([0, 0, 1 / 3], "m"), "end": Q_([1, 0.1, 1 / 3], "m")}
    dead = bs.LoadPattern(
        "dead",
        [
            bs.SelfWeight(),
            bs.Weight("2.1", Q_([1, 2, 3], "cm"), Q_(1 / 7, "kN"), mass_share=1 / 3),
            bs.LineLoad(Q_(1 / 7, "kN/m"), **corners, spanning=True),
            bs.LineLoad("1 kN/m", **corners, block="2.1"),
            bs.AreaLoad(Q_(1 / 7, "kPa"), **corners),
            bs.AreaLoad("1 kPa", block="2.1", mass_share=0),
            bs.FillLoad("18 kN/m^3", corners["start"], ["1 m", "1 m", "1 m"], lateral_coefficient=0.3),
            bs.FaceLoad("2.2", 1, unit_weight="9.81 kN/m^3", level="1.2 m"),
        ],
    )
    push = bs.LoadPattern(
        "push",
        [
            bs.FaceLoad("2.2", 1, pressure="-0.8 kPa"),
            bs.BodyForce((0.6, 0, 0.8), share=1 / 3),
            bs.PointLoad("2.1", Q_([1, 2, 3], "cm"), Q_([0, 0, -1 / 7], "kN")),
            bs.FaceLoad("2.2", 1, Q_([0, 0, -0.3], "kPa")),
            bs.Moment("1.1", Q_([0, 1e-5, 0], "kN*m")),
        ],
    )
    return [bs.LimitCase(f"push {flow}", dead, push, flow) for flow in bs.Flow]


@pytest.mark.parametrize("suffix", ["yaml", "yml", "json"])
def test_a_document_keeps_model_cases_and_settings_to_the_last_bit(tmp_path, model, cases, suffix):
    settings = bs.ProcedureSettings(crushing_cells=81, schedule=bs.FictitiousSchedule(max_programs=33))
    path = bs.write_document(tmp_path / f"m.{suffix}", model, cases, settings=settings)
    back = bs.read_document(path)
    assert back.model.hash == model.hash
    assert back.cases == tuple(cases)
    assert bs.ProcedureSettings.of(back.settings) == settings


def test_the_tolerance_is_kept(tmp_path, model, cases):
    apart = [b if b.name != "2.2" else moved([b], rotation((0, 0, 1), 0), (0, 0, 1e-4))[0] for b in model.blocks]
    found = bs.detect_interfaces(apart, joint_material=LIME, tolerance="0.2 mm")
    loose = bs.Model("loose", apart, found.interfaces)
    path = bs.write_document(tmp_path / "m.yaml", loose, cases, tolerance=Q_(0.2, "mm"))
    assert bs.read_document(path).model.hash == loose.hash
    # Without the tolerance the document lists the open joint.
    stated = bs.read_document(bs.write_document(tmp_path / "other.yaml", loose, cases)).model
    assert {i.name for i in stated.interfaces} == {i.name for i in loose.interfaces}


def test_other_interfaces_are_listed(tmp_path, model, cases):
    """Another joint material, and half of a bed."""
    first, second = model.interfaces[:2]
    a, b, c, d = first.polygon
    half = bs.Interface("half", first.minus, first.plus, Q_([a, (a + b) / 2, (c + d) / 2, d], "m"), LIME)
    other = second.with_joint_material(bs.JointMaterial("other", 0.5))
    mixed = bs.Model("mixed", model.blocks, [half, other, *model.interfaces[2:]])
    path = bs.write_document(tmp_path / "m.yaml", mixed, cases)
    assert len(yaml.safe_load(path.read_text(encoding="utf-8"))["interfaces"]["explicit"]) == 2
    # Listed interfaces come first, as here.
    assert bs.read_document(path).model.hash == mixed.hash


def test_a_draft_may_lack_supports(tmp_path, model, cases):
    free = [bs.Block(b.name, b.shape, b.material) for b in model.blocks]
    path = bs.documents.write_draft(tmp_path / "m.yaml", "free", free, LIME, cases)
    with refused(bs.errors.ModelError, "'free' fixed=True") as refusal:
        bs.read_document(path)
    assert "6 blocks, 9 interfaces" in "".join(refusal.value.__notes__)
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    content["blocks"][0]["fixed"] = True
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    assert bs.read_document(path).model.block("base").fixed


def test_bad_documents_are_not_written(tmp_path, model, cases):
    other = bs.LimitCase("other", bs.LoadPattern("dead", []), cases[0].variable)
    for error, words, name, written in [
        (bs.errors.DocumentError, "m.yaml /cases", "m.yaml", []),
        (bs.errors.ModelError, "m.txt .yaml", "m.txt", cases),
        (bs.errors.ModelError, "m.yaml patterns", "m.yaml", [*cases, other]),
        (bs.errors.ModelError, f"m.yaml {cases[0].name}", "m.yaml", [*cases, cases[0]]),
        (bs.errors.StorageError, "none/m.yaml", "none/m.yaml", cases),
    ]:
        with refused(error, words):
            bs.write_document(tmp_path / name, model, written)
    twice = bs.Block("2.3", model.blocks[-1].shape, bs.Material("tuff", "20 kN/m^3"))
    with refused(bs.errors.ModelError, "m.yaml materials"):
        bs.documents.write_draft(tmp_path / "m.yaml", "two tuffs", [*model.blocks[:-1], twice], LIME, cases)
    # A document cannot leave out an interface that detection finds.
    fewer = bs.Model("fewer", model.blocks, model.interfaces[1:])
    with refused(bs.errors.ModelError, f"'fewer' {model.interfaces[0].name!r}"):
        bs.write_document(tmp_path / "m.yaml", fewer, cases)
    assert list(tmp_path.iterdir()) == []
