"""Values of the library: choice, source, storage."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.views.report import report_html
from refusals import refused
from structures import SELF_WEIGHT, bonded, push

BRICK = bs.library.masonry("solid brick and lime mortar")


@pytest.mark.parametrize(("choice", "strength"), [("min", 2.6e6), ("mean", 3.45e6), ("max", 4.3e6), ("3 MPa", 3e6)])
def test_choices_within_a_range(choice, strength):
    joint = BRICK.joint_material(friction_coefficient=0.6, compressive_strength=choice, cohesion="max")
    assert (joint.compressive_strength, joint.cohesion) == pytest.approx((strength, 0.27e6))
    soft = bs.library.masonry("Muratura irregolare di pietra tenera")
    assert soft.material(unit_weight="mean").unit_weight == pytest.approx(14.5e3)


def test_nothing_is_chosen_by_default():
    plain = BRICK.joint_material("joint", friction_coefficient=0.6)
    assert np.isinf(plain.compressive_strength)
    assert plain.cohesion == 0
    assert plain.source == "friction coefficient given by the author of the model"
    with pytest.raises(TypeError):
        BRICK.material()
    with pytest.raises(TypeError):
        bs.library.joint("basalt, dry").joint_material()


def test_the_source_contains_choice_and_reference():
    joint = BRICK.joint_material(friction_coefficient=0.6, compressive_strength="min", cohesion="0.2 MPa")
    assert joint.name == "solid brick and lime mortar"
    assert joint.source == (
        "solid brick and lime mortar: compressive strength f = 2.6 MPa, min of 2.6 to 4.3 MPa; cohesion fv0 = 0.2 MPa "
        "within 0.13 to 0.27 MPa (Circolare 21 January 2019 n. 7 C.S.LL.PP. (Italy), Table C8.5.I); friction "
        "coefficient given by the author of the model"
    )
    changed = joint.varied(friction_coefficient=0.5)
    assert changed.source == f"{joint.source}; then changed: friction_coefficient"
    dry = bs.library.joint("limestone, dry").joint_material(friction_angle="mean", compressive_strength="4 MPa")
    assert dry.friction_coefficient == pytest.approx(np.tan(np.radians(34)))
    assert "friction_angle = 34 deg, mean of 31 to 37 deg (N. Barton, V. Choubey" in dry.source
    assert dry.source.endswith("given by the author: compressive_strength")


@pytest.mark.parametrize("known", [bs.library.MASONRY, bs.library.JOINTS], ids=["masonry", "joints"])
def test_every_entry_is_complete(known):
    for name, entry in known.items():
        assert entry.name == name
        assert entry.source
        assert entry.verified
        assert str(entry).startswith(name)
        for found in entry.ranges.values():
            assert 0 < found.low <= found.high


def test_moduli_of_the_table_are_consistent():
    """In the table G is E / 3, or E / 4 for hollow units; only one rounded value is off by a sixteenth."""
    for entry in bs.library.MASONRY.values():
        E, G = (np.array(entry.ranges[symbol].ends) for symbol in ("E", "G"))
        part = 4 if "cement" in entry.name else 3
        np.testing.assert_allclose(G * part / E, 1, atol=0.075)


RUBBLE, WET = bs.library.masonry("irregular rubble"), bs.library.joint("gneiss, wet")
UNKNOWN, MODEL = bs.errors.UnknownNameError, bs.errors.ModelError


@pytest.mark.parametrize(
    ("error", "words", "make"),
    [
        (UNKNOWN, "morter solid brick and lime mortar", lambda: bs.library.masonry("solid brick and lime morter")),
        (UNKNOWN, "'limestone' limestone, wet", lambda: bs.library.joint("limestone")),
        (UNKNOWN, "'irregular rubble' 'fv0'", lambda: RUBBLE.joint_material(friction_coefficient=0.6, cohesion="min")),
        (MODEL, "w 'medium' 'mean'", lambda: BRICK.material(unit_weight="medium")),
        (MODEL, "w 24 18 kN/m³", lambda: BRICK.material(unit_weight="24 kN/m^3")),
        (MODEL, "friction_coefficient", lambda: BRICK.joint_material(friction_coefficient=None)),
        (MODEL, "friction_angle 30 deg 23 to 26", lambda: WET.joint_material(friction_angle="30 deg")),
        (MODEL, "'j' source", lambda: bs.JointMaterial("j", 0.6, source="two\nlines")),
    ],
)
def test_refused_choices(error, words, make):
    with refused(error, words):
        make()


@pytest.fixture(scope="module")
def analysis():
    tuff = bs.library.masonry("regular soft stone").material("tuff", unit_weight="mean")
    joint = bs.library.joint("limestone, dry").joint_material("joint", friction_angle="min")
    blocks = bonded(2, 2, material=tuff)
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint))
    return bs.AnalysisManager(model).run([bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative")])


def test_the_source_is_stored_written_and_reported(tmp_path, analysis):
    model = analysis.model
    kept = bs.open_analysis(bs.save_analysis(analysis, tmp_path / "wall.h5")).model
    bs.write_document(tmp_path / "wall.yaml", model, [analysis["push"].case])
    written = bs.read_document(tmp_path / "wall.yaml").model
    for other in (kept, written):
        assert other.materials == model.materials
        assert other.joint_materials == model.joint_materials
        assert other.materials["tuff"].source == model.materials["tuff"].source != ""
    html = report_html(analysis)
    html = html.replace("\u00a0", " ")
    assert "source of the values" in html
    assert "mean of 13 to 16 kN/m³ (Circolare 21 January 2019 n. 7" in html
    assert "friction_angle = 31 deg, min of 31 to 37 deg" in html


def test_the_source_does_not_change_the_hash_of_a_model(analysis):
    model = analysis.model
    tuff = bs.Material("tuff", "14.5 kN/m^3")
    bare = [bs.Block(b.name, b.shape, tuff, b.fixed) for b in model.blocks]
    joint = bs.JointMaterial("joint", model.joint_materials["joint"].friction_coefficient)
    assert bs.Model("wall", bare, bs.detect_interfaces(bare, joint)).hash == model.hash
