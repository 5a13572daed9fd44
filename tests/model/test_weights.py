"""Loads without a meaning, or with two: the error names the load, the field and the value."""

import pytest

import blockstruct as bs
from refusals import refused
from structures import box

A, B, LOW = ["0 m", "0 m", "2 m"], ["1 m", "1 m", "2 m"], ["0 m", "0 m", "1 m"]
MODEL, FILL = bs.errors.ModelError, "18 kN/m^3"


@pytest.mark.parametrize(
    ("error", "words", "make"),
    [
        (MODEL, "Weight 'b' weight -1 kN PointLoad", lambda: bs.Weight("b", A, "-1 kN")),
        (MODEL, "Weight block ''", lambda: bs.Weight("", A, "1 kN")),
        (MODEL, "LineLoad mass_share 1.001", lambda: bs.LineLoad("1 kN/m", A, B, mass_share=1.001)),
        (MODEL, "LineLoad weight_per_length 0 N/m", lambda: bs.LineLoad("0 kN/m", A, B)),
        (MODEL, "LineLoad start end (0.0, 0.0, 2.0) Weight", lambda: bs.LineLoad("1 kN/m", A, A)),
        (MODEL, "LineLoad z = 2 m 3 m block", lambda: bs.LineLoad("1 kN/m", A, ["1 m", "0 m", "3 m"])),
        (MODEL, "LineLoad spanning 1 True", lambda: bs.LineLoad("1 kN/m", A, B, spanning=1)),
        (MODEL, "AreaLoad start end block", lambda: bs.AreaLoad("1 kPa")),
        (MODEL, "AreaLoad (0, 0) (1, 0) area", lambda: bs.AreaLoad("1 kPa", A, ["1 m", "0 m", "2 m"])),
        (MODEL, "AreaLoad 'b' spanning rectangle", lambda: bs.AreaLoad("1 kPa", block="b", spanning=True)),
        (MODEL, "FillLoad z = 2 m box", lambda: bs.FillLoad(FILL, A, B)),
        (MODEL, "FillLoad lateral_coefficient -0.1", lambda: bs.FillLoad(FILL, LOW, B, lateral_coefficient=-0.1)),
        (MODEL, "FaceLoad 'b' traction pressure unit_weight level", lambda: bs.FaceLoad("b", 1)),
        (MODEL, "FaceLoad 'b' face -1", lambda: bs.FaceLoad("b", -1, pressure="1 kPa")),
        (MODEL, "FaceLoad 'b' unit_weight level", lambda: bs.FaceLoad("b", 1, unit_weight="9.81 kN/m^3")),
        (MODEL, "FaceLoad unit_weight -1 kN/m³", lambda: bs.FaceLoad("b", 1, unit_weight="-1 kN/m^3", level="1 m")),
        (bs.errors.UnitError, "LineLoad weight_per_length 5 kN/m", lambda: bs.LineLoad(5, A, B)),
        (bs.errors.DimensionError, "AreaLoad weight_per_area", lambda: bs.AreaLoad("4 kN/m", A, B)),
    ],
)
def test_refused_loads(error, words, make):
    with refused(error, words):
        make()


def test_the_face_towards_a_direction():
    block = box("b", [0, 0, 0])
    assert [block.face_towards(d) for d in ("-z", "+z", "-y", "+x", "+y", "-x")] == list(range(6))
    with refused(bs.errors.GeometryError, "'b' face 4 36.9 degrees"):
        block.face_towards((0.6, 0.8, 0))
    with refused(MODEL, "'b' direction length 2"):
        block.face_towards((2, 0, 0))
