"""What a console shows of an object fits on a line."""

import blockstruct as bs


def test_everything_has_a_line(small_model, small_analysis):
    found = bs.detect_interfaces(small_model.blocks, joint_material=bs.JointMaterial("dry", 0.6))
    result = next(iter(small_analysis.values()))
    spread = bs.Spread.of({"as given": result}, None)
    for shown in (small_model, found.report, found, small_analysis, result, spread):
        text = repr(shown)
        assert "\n" not in text
        assert len(text) < 400, text
    assert repr(small_model).startswith(f"<Model {small_model.name!r}: ")
    assert result.name in repr(small_analysis)
    assert f"{result.load_factor:.4g}" in repr(result)
