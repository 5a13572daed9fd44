"""Loads that say nothing, or two things, are refused where they are made."""

import pytest

import blockstruct as bs

A, B, LOW, HIGH = ["0 m", "0 m", "2 m"], ["1 m", "1 m", "2 m"], ["0 m", "0 m", "1 m"], ["0 m", "0 m", "3 m"]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: bs.Weight("b", A, "-1 kN"),
            r"Weight on 'b': weight -1000 N; weights act downwards, give more than zero",
        ),
        (lambda: bs.Weight("b", A, "1 kN", mass_share=-1), "mass_share -1; give from 0"),
        (lambda: bs.LineLoad("1 kN/m", A, B, mass_share=1.001), r"mass_share 1.001; give from 0 .* to 1"),
        (lambda: bs.AreaLoad("1 kPa", block="b", mass_share=5), "mass_share 5; give from 0"),
        (lambda: bs.FillLoad("18 kN/m^3", LOW, B, mass_share=1000), "mass_share 1000; give from 0"),
        (lambda: bs.Weight("", A, "1 kN"), "a name must be a text"),
        (lambda: bs.LineLoad("0 kN/m", A, B), "weight_per_length 0 N/m"),
        (lambda: bs.LineLoad("1 kN/m", A, A), "are one point in plan; give a line, or a Weight"),
        (lambda: bs.LineLoad("1 kN/m", A, ["1 m", "0 m", "3 m"]), "give a level line, or name the block"),
        (lambda: bs.LineLoad("1 kN/m", A, B, spanning=1), "spanning is 1; give True or False"),
        (lambda: bs.AreaLoad("1 kPa"), "give start and end, opposite corners of a level rectangle, or the block"),
        (lambda: bs.AreaLoad("1 kPa", A), "give start and end"),
        (lambda: bs.AreaLoad("1 kPa", A, ["1 m", "1 m", "3 m"]), "give both at the level of the load"),
        (lambda: bs.AreaLoad("1 kPa", A, ["1 m", "0 m", "2 m"]), "there is no area"),
        (lambda: bs.AreaLoad("1 kPa", block="b", spanning=True), "without a rectangle there is nothing to span"),
        (lambda: bs.FillLoad("18 kN/m^3", A, B), "both at z = 2 m; give opposite corners of a box"),
        (lambda: bs.FillLoad("18 kN/m^3", LOW, HIGH), "there is no area"),
        (lambda: bs.FillLoad("18 kN/m^3", LOW, B, lateral_coefficient=-0.1), "lateral_coefficient -0.1"),
        (lambda: bs.FaceLoad("b", 1), "give a traction, a pressure, or a unit_weight with its level"),
        (lambda: bs.FaceLoad("b", 1, level="1 m"), "give both unit_weight and level"),
        (lambda: bs.FaceLoad("b", 1, unit_weight="9.81 kN/m^3"), "give both unit_weight and level"),
        (lambda: bs.FaceLoad("b", 1, unit_weight="-1 kN/m^3", level="1 m"), "unit_weight -1000 N/m"),
    ],
)
def test_loads_without_a_meaning_are_refused(make, words):
    with pytest.raises(bs.errors.ModelError, match=words):
        make()


@pytest.mark.parametrize("count", [2, 3])
def test_the_weight_of_the_blocks_is_given_once(count):
    with pytest.raises(bs.errors.ModelError, match=rf"load pattern 'd': SelfWeight .* {count} times.*; give it once"):
        bs.LoadPattern("d", [bs.SelfWeight(), *[bs.SelfWeight()] * (count - 1)])


def test_units_are_due():
    with pytest.raises(bs.errors.UnitError, match=r"weight_per_length.*Q_\(5, 'kN/m'\)"):
        bs.LineLoad(5, A, B)
    with pytest.raises(bs.errors.DimensionError, match=r"weight_per_area.*does not fit"):
        bs.AreaLoad("4 kN/m", A, B)


def test_the_face_that_looks_somewhere():
    stone = bs.Material("stone", "20 kN/m^3")
    block = bs.Block.box("b", ["0 m", "0 m", "0 m"], ["1 m", "1 m", "1 m"], stone)
    assert [block.face_towards(d) for d in ("-z", "+z", "-y", "+x", "+y", "-x")] == list(range(6))
    with pytest.raises(bs.errors.GeometryError, match=r"no faces look towards .* is nearest, 36\.9 degrees off"):
        block.face_towards((0.6, 0.8, 0))
    with pytest.raises(bs.errors.ModelError, match="has the length 2, not 1"):
        block.face_towards((2, 0, 0))
