"""Builders: volumes, contacts and masses in closed form, and refused arguments."""

import math
from itertools import pairwise

import numpy as np
import pytest

import blockstruct as bs
from refusals import refused

STONE, DRY = bs.Material("stone", "20 kN/m^3"), bs.JointMaterial("dry", 0.65)
BRICK = {"unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm", "material": STONE}
ARCH = {"span": "4 m", "thickness": "0.5 m", "depth": "1 m", "material": STONE}


def checked(blocks):
    """Report on blocks with unique names that fit exactly and make a model."""
    assert len({b.name for b in blocks}) == len(blocks)
    found = bs.detect_interfaces(blocks, DRY)
    assert found.report.rejected == found.report.overlaps == found.report.floating == ()
    bs.Model("built", blocks, found.interfaces)
    return found.report


def volume(blocks):
    return math.fsum(b.volume for b in blocks if not b.fixed)


def by_name(blocks, name):
    return next(b for b in blocks if b.name == name)


@pytest.mark.parametrize("rise", [None, "1 m", "0 m"])
@pytest.mark.parametrize("voussoirs", [2, 9])
def test_an_arch_is_a_chain_of_wedges(rise, voussoirs):
    blocks = bs.arch(**ARCH, rise=rise, voussoirs=voussoirs)
    report = checked(blocks)
    assert report.accepted == voussoirs + 1
    chain = ["left", *(str(k + 1) for k in range(voussoirs)), "right"]
    assert [{c.minus, c.plus} for c in report.contacts] == [{a, b} for a, b in pairwise(chain)]


def test_an_arch_has_its_rise_and_the_volume_of_its_wedges():
    # Straight-sided wedges: each is the sector times sin(β)/β.
    n, r1, r2 = 27, 2.0, 2.5
    fine = bs.arch(**ARCH, voussoirs=n)
    assert volume(fine) == pytest.approx(n * math.sin(math.pi / n) * (r2**2 - r1**2) / 2, rel=1e-12)
    assert checked(fine).total_area == pytest.approx((n + 1) * 0.5)
    for rise in (1.0, 2.0, 3.0):
        blocks = bs.arch(**ARCH, rise=f"{rise} m", voussoirs=10)
        joint = by_name(blocks, "5").shape.vertices
        assert joint[np.isclose(joint[:, 0], 0)][:, 2].min() == pytest.approx(rise)
    flat = bs.arch(**ARCH, rise="0 m", skewback="15 deg", voussoirs=5)
    ends = by_name(flat, "5").shape.vertices
    assert ends[:, 0].max() == pytest.approx(2 + 0.5 * math.tan(math.radians(15)))


PIERS = ARCH | {"pier_width": "1 m", "pier_height": "2 m", "pier_courses": 3, "voussoirs": 10}


@pytest.mark.parametrize(("rise", "springers"), [("1 m", 2), (None, 0), ("3 m", 0), ("0 m", 2)])
def test_arches_on_piers_have_springers_if_inclined(rise, springers):
    blocks = bs.structures.arch_on_piers(**PIERS, rise=rise)
    assert sum("springer" in b.name for b in blocks) == springers
    assert checked(blocks).accepted == 2 * 3 + springers + 11


def test_a_barrel_vault_has_the_volume_of_its_arch_times_its_length():
    size = {"span": "4 m", "thickness": "0.5 m", "material": STONE, "voussoirs": 9}
    vault = bs.structures.barrel_vault(**size, length="3 m", units=4)
    assert volume(vault) == pytest.approx(3 * volume(bs.arch(**size, depth="1 m")), rel=1e-12)
    heads = 5 * 3 + 4 * 4
    beds = 8 * 8 + 4 + 4
    assert checked(vault).accepted == heads + beds


@pytest.mark.parametrize(("staggered", "a_unit"), [(True, 2), (False, 1)])
@pytest.mark.parametrize("keystone", [True, False])
@pytest.mark.parametrize("rise", [None, "5 m"])
def test_a_dome_has_the_contacts_of_its_closed_form(staggered, a_unit, keystone, rise):
    rings, n = 4, 8
    blocks = bs.structures.dome(
        span="8 m", thickness="0.8 m", courses=rings, units=n, oculus="2 m", material=STONE,
        staggered=staggered, keystone=keystone, rise=rise,
    )  # fmt: skip
    report = checked(blocks)
    # Side joints, facets between courses, the springing (one plane), the seat of the keystone.
    assert report.accepted == rings * n + (rings - 1) * a_unit * n + n + keystone * a_unit * n
    top = by_name(blocks, f"{rings}.1").shape.vertices
    assert np.linalg.norm(top[:, :2], axis=1).min() == pytest.approx(1.0)


def test_the_volume_of_a_fine_dome_converges_to_the_shell():
    blocks = bs.structures.dome(
        span="8 m", thickness="1 m", courses=24, units=40, oculus="2 m", material=STONE, staggered=False
    )
    # A spherical shell from the springing up to a cone with its apex at the centre.
    exact = 2 / 3 * math.pi * (5**3 - 4**3) * math.sqrt(1 - (1 / 4) ** 2)
    assert volume(blocks) == pytest.approx(exact, rel=6e-3)
    assert volume(blocks) < exact


def test_a_cross_vault_is_symmetric_and_closed():
    blocks = bs.structures.cross_vault(span="4 m", thickness="0.5 m", courses=6, units=4, material=STONE)
    checked(blocks)
    free = [b for b in blocks if not b.fixed]
    centre = sum(b.volume * b.centroid for b in free) / volume(free)
    assert centre[:2] == pytest.approx([0, 0], abs=1e-12)
    webs = [volume([b for b in free if b.name.startswith(f"{w}.")]) for w in range(1, 9)]
    assert webs == pytest.approx([webs[0]] * 8, rel=1e-12)
    # Half webs of the first quarter lie on +x at +y and, mirrored in the groin, on +y at +x.
    assert all(b.centroid[0] > b.centroid[1] > 0 for b in free if b.name.startswith("1."))
    assert all(b.centroid[1] > b.centroid[0] > 0 for b in free if b.name.startswith("2."))


def test_a_tapered_column():
    blocks = bs.structures.column(height="6 m", diameter="1 m", top_diameter="0.8 m", drums=5, sides=24, material=STONE)
    assert checked(blocks).accepted == 5
    area = 24 / 2 * math.sin(2 * math.pi / 24)
    assert volume(blocks) == pytest.approx(area * 6 * (0.5**2 + 0.5 * 0.4 + 0.4**2) / 3, rel=1e-3)


def test_shifted_and_tilted_stacks():
    straight = bs.structures.stack(3, size=["0.4 m", "0.3 m", "0.2 m"], shift=["5 cm", "-1 cm"], material=STONE)
    assert checked(straight).total_area == pytest.approx(0.4 * 0.3 + 2 * 0.35 * 0.29)
    there = bs.structures.tilted(straight, "20 deg", axis=(1, 2, 0), about=["1 m", "0 m", "0 m"])
    assert checked(there).total_area == pytest.approx(0.4 * 0.3 + 2 * 0.35 * 0.29)
    back = bs.structures.tilted(there, "-20 deg", axis=(1, 2, 0), about=["1 m", "0 m", "0 m"])
    for one, other in zip(straight, back, strict=True):
        assert other.shape.vertices == pytest.approx(one.shape.vertices, abs=1e-12)
    # About +y the top moves towards +x.
    assert bs.structures.tilted(straight, "5 deg")[3].centroid[0] > straight[3].centroid[0]


def test_a_plain_wall_equals_its_courses():
    rows = [[1] * 6 if j % 2 == 0 else [0.5, *[1] * 5, 0.5] for j in range(5)]
    here = bs.wall(length="2.4 m", courses=5, **BRICK)
    there = bs.courses(rows, **BRICK)
    assert [b.name for b in here] == [b.name for b in there]
    for one, other in zip(here, there, strict=True):
        assert one.shape.vertices == pytest.approx(other.shape.vertices, abs=1e-12)


DOOR = bs.structures.Opening("1.2 m", "0 m", "0.8 m", "1.6 m")
RETURNS = [
    bs.structures.Sidewall("left", "0 m", "2 m"),
    bs.structures.Sidewall("right", "3 m", "2 m"),
    bs.structures.Sidewall("cross", "2.2 m", "1.1 m"),
]


def test_a_facade_with_sidewalls_has_the_exact_volume():
    blocks = bs.wall(length="3.2 m", courses=12, openings=[DOOR], sidewalls=RETURNS, **BRICK)
    report = checked(blocks)
    assert volume(blocks) == pytest.approx(0.2 * (3.2 * 2.4 - 0.8 * 1.6 + 2.4 * (2 + 2 + 1.1)))
    # Beds are complete except in the opening and under the lintel.
    plan = 0.2 * (3.2 + 2 + 2 + 1.1)
    assert report.area_by_orientation["bed"] == pytest.approx(12 * plan - 9 * 0.2 * 0.8)
    lintel = by_name(blocks, "9.lintel1")
    assert np.ptp(lintel.shape.vertices[:, 0]) == pytest.approx(0.8 + 2 * 0.2)


def test_bonded_sidewalls_extend_through_every_second_course():
    for bonded, reach in ((True, 0.0), (False, 0.2)):
        sides = [bs.structures.Sidewall("side", "0 m", "2 m", bonded=bonded)]
        blocks = bs.wall(length="3.2 m", courses=4, sidewalls=sides, **BRICK)
        least = [by_name(blocks, f"side.{j}.1").shape.vertices[:, 1].min() for j in (1, 2)]
        assert least == pytest.approx([0.2, reach])
        checked(blocks)


def test_leaves_are_tied_by_headers():
    size = BRICK | {"thickness": "40 cm"}
    blocks = bs.wall(length="3.2 m", courses=8, leaves=2, header_every=4, **size)
    checked(blocks)
    assert {b.name[-1] for b in blocks if b.name.startswith("3.")} == {"a", "b"}
    headers = [b for b in blocks if b.name.startswith("4.")]
    assert all(np.ptp(b.shape.vertices[:, 1]) == pytest.approx(0.4) for b in headers)
    assert volume(blocks) == pytest.approx(3.2 * 1.6 * 0.4)


@pytest.mark.parametrize(("pier", "bays", "storeys"), [(1.0, 3, 2), (0.3, 2, 1)])
def test_piers_and_spandrels_have_the_exact_volume(pier, bays, storeys):
    """Also with piers narrower than a unit, which two lintels share."""
    blocks = spandrels(pier_width=f"{pier} m", bays=bays, storeys=storeys)
    checked(blocks)
    length, height = (bays + 1) * pier + bays * 0.8, 1.8 * storeys
    assert volume(blocks) == pytest.approx(0.2 * (length * height - bays * storeys * 0.8 * 1.2))


OPENING = {"sill": "0 m", "width": "0.8 m", "height": "0.4 m"}
CUBE = {"size": ["1 m", "1 m", "1 m"], "material": STONE}
NARROW, TALL = {"pier_width": "0.4 m"}, {"height": "9 m"}


@pytest.mark.parametrize(
    ("words", "make"),
    [
        ("arch 9 voussoirs even", lambda: bs.arch(**ARCH, voussoirs=9, rise="3 m")),
        ("arch rise -1 m", lambda: bs.arch(**ARCH, voussoirs=9, rise="-1 m")),
        ("arch voussoirs 1 2", lambda: bs.arch(**ARCH, voussoirs=1)),
        ("arch skewback 80 deg", lambda: bs.arch(**ARCH, voussoirs=5, rise="0 m", skewback="80 deg")),
        ("arch_on_piers pier_width 0.4 m 0.5 m", lambda: bs.structures.arch_on_piers(**PIERS | NARROW)),
        ("dome rise 3 m 4 m", lambda: dome(rise="3 m")),
        ("dome oculus span", lambda: dome(oculus="8 m")),
        ("spandrel_height 0.5 m 0.2 m", lambda: spandrels(spandrel_height="0.5 m")),
        ("stack count 1000000000 100000", lambda: bs.structures.stack(10**9, **CUBE)),
        ("tilted axis", lambda: bs.structures.tilted([], "5 deg", axis=(0, 0, 0))),
        ("wall blocks 100000", lambda: bs.wall(**BRICK, length="1e5 m", courses=12)),
        ("wall length 1e+12 m 1e+06 m", lambda: bs.wall(**BRICK, length="1e9 km", courses=12)),
        ("wall material 'tuff' Material", lambda: bs.wall(**BRICK | {"material": "tuff"}, length="1 m", courses=2)),
        ("opening 1 3.8 m 3.2 m", lambda: wall(openings=[bs.structures.Opening("3 m", **OPENING)])),
        ("opening 1 sill 0.3 m", lambda: wall(openings=[bs.structures.Opening("1 m", **OPENING | {"sill": "0.3 m"})])),
        ("opening 1 head 9 m 2.4 m", lambda: wall(openings=[bs.structures.Opening("1 m", **OPENING | TALL)])),
        ("opening 2 overlaps 1.2 m", lambda: wall(openings=[DOOR, bs.structures.Opening("1 m", **OPENING)])),
        ("'s' 3.1 m 3 m", lambda: wall(sidewalls=[bs.structures.Sidewall("s", "3.1 m", "1 m")])),
        ("'s' opening 1.2 m", lambda: wall(sidewalls=[bs.structures.Sidewall("s", "1.3 m", "1 m")], openings=[DOOR])),
        ("'b' 'a' 0.1 m", lambda: wall(sidewalls=[bs.structures.Sidewall(n, "0.1 m", "1 m") for n in "ab"])),
    ],
)
def test_refused_structures(words, make):
    with refused(bs.errors.BlockstructError, words):
        make()


def dome(**sizes):
    return bs.structures.dome(
        **{"span": "8 m", "thickness": "1 m", "courses": 4, "units": 8, "oculus": "2 m", "material": STONE} | sizes
    )


def wall(**parts):
    return bs.wall(length="3.2 m", courses=12, **BRICK, **parts)


def spandrels(**sizes):
    size = {"pier_width": "1 m", "opening_width": "0.8 m", "opening_height": "1.2 m", "spandrel_height": "0.6 m"}
    return bs.structures.pier_spandrel(**{"bays": 3, "storeys": 2, **size, **BRICK} | sizes)
