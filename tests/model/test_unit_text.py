"""Units in texts, and objects that print and give them."""

import pickle

import attrs
import pytest

import blockstruct as bs
from blockstruct import Q_, model, units
from blockstruct.errors import UnitError
from refusals import refused


@pytest.mark.parametrize(
    ("typed", "unit"),
    [
        ("kN/m3", "kN/m**3"),
        ("KN/m³", "kN/m**3"),
        ("kN m-3", "kN/m**3"),
        ("N/mm2", "N/mm**2"),
        ("kgf/cm2", "kgf/cm**2"),
        ("kNm", "kN*m"),
        ("kN·m", "kN*m"),
        ("K", "K"),
        ("newton / meter ** 3", "N/m**3"),
        ("megapascal * meter ** 0.5", "MPa*m**0.5"),
        ("meter**-1.5", "1/m**1.5"),
    ],
)
def test_units_are_read_as_engineers_type_them(typed, unit):
    assert units.parse(f"1 {typed}", "value") == Q_(1.0, unit)


@pytest.mark.parametrize("unit", ["m ** 9 ** 9", "m ** 99", "m ** (2)", "m * * 2", "m ** n", "m ** 0.5.5", "m ** 1e5"])
def test_other_powers_of_units_are_refused(unit):
    with pytest.raises(UnitError, match="is not a unit"):
        units.parse(f"1 {unit}", "value")


STONE = bs.Material("tuff", "12 kN/m^3", source="a test")
BLOCK = bs.Block.box("b", ["0 m"] * 3, ["1 m", "2 m", "0.5 m"], STONE, fixed=True)
POLYGON = Q_([[0, 0, 0], [2, 0, 0], [2, 0.5, 0], [0, 0.5, 0]], "m")
LIME = bs.JointMaterial("lime", friction_angle="30 deg", dilatancy_angle="5 deg", compressive_strength="4 MPa")
POINT = "[0, 0, 3] m"
BAR = bs.Tie("t", ("b", POINT), ("c", "[4, 0, 3] m"), yield_force="40 kN")
PATTERN, ALONG = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("x", [bs.BodyForce("+x", 2)])
PUSHOVER = bs.Pushover("p", PATTERN, PATTERN, control=("b", "+x"), corner_rounding="2 cm")


@pytest.mark.parametrize(
    ("thing", "text"),
    [
        (STONE, "Material('tuff', unit_weight=12 kN/m³, source='a test')"),
        (LIME, "JointMaterial('lime', friction_coefficient=0.57735, dilatancy_angle=5°, compressive_strength=4 MPa)"),
        (bs.PointLoad("b", POINT, "[0, 0, -2500] N"), "PointLoad(block='b', point=(0, 0, 3) m, force=(0, 0, -2.5) kN)"),
        (bs.Weight("b", POINT, "8 kN", 0.5), "Weight(block='b', point=(0, 0, 3) m, weight=8 kN, mass_share=0.5)"),
        (bs.FaceLoad("b", 1, pressure="-300 Pa"), "FaceLoad(block='b', face=1, pressure=-300 Pa)"),
        (BAR, "Tie('t', start=('b', (0, 0, 3) m), end=('c', (4, 0, 3) m), yield_force=40 kN)"),
        (ALONG, "LoadPattern('x', loads=(BodyForce(direction=(1, 0, 0), share=2),))"),
    ],
)
def test_objects_print_their_units(thing, text):
    assert repr(thing) == text


@pytest.mark.parametrize(
    ("thing", "name", "quantity"),
    [
        (STONE, "unit_weight", Q_(12, "kN/m^3")),
        (LIME, "compressive_strength", Q_(4, "MPa")),
        (BLOCK, "weight", Q_(12, "kN")),
        (bs.Interface("i", "a", "b", POLYGON, LIME), "area", Q_(1, "m^2")),
        (BAR, "start", Q_([0, 0, 3], "m")),
        (bs.SettlementCase("s", PATTERN, "b", "-z", about="[1, 2, 3] m"), "about", Q_([1, 2, 3], "m")),
        (PUSHOVER, "corner_rounding", Q_(2, "cm")),
    ],
)
def test_objects_give_quantities(thing, name, quantity):
    assert units.Q_(thing.quantity(name)).m_as(quantity.units) == pytest.approx(quantity.magnitude)
    assert bs.FaceLoad("b", 1, pressure="1 kPa").quantity("level") is None
    with refused(bs.errors.UnknownNameError, "material 'tuff' 'weight' unit_weight"):
        STONE.quantity("weight")


@pytest.mark.parametrize("kind", [*model.LOAD_KINDS.values(), bs.Tie, bs.ties.BondedBar])
def test_every_physical_field_has_a_dimension(kind):
    plain = {"name", "block", "face", "spanning"}
    assert {f.name for f in attrs.fields(kind) if "dimension" not in f.metadata} <= plain


def test_objects_are_frozen_and_survive_pickle(small_model):
    for thing in (STONE, LIME, PATTERN, BAR, PUSHOVER):
        assert pickle.loads(pickle.dumps(thing)) == thing
        with pytest.raises(AttributeError):
            thing.name = "other"
    assert pickle.loads(pickle.dumps(small_model)).hash == small_model.hash
