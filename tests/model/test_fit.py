"""A model accepts the interfaces of a detection, with its tolerances."""

from functools import partial
from itertools import pairwise

import attrs
import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from meshes import QUADS
from refusals import refused
from structures import STONE, push, solve
from structures import box as box_of

DRY = bs.JointMaterial("dry", 0.7)
GROUND = box_of("ground", [-1, -1, -1], [4, 3, 1], fixed=True)
box = partial(box_of, size=(0.3, 0.3, 0.3))


def triangles(rng: np.random.Generator) -> list[list[int]]:
    """Every quadrilateral divided along one of its diagonals."""
    halves = []
    for a, b, c, d in QUADS:
        halves += [[a, b, c], [a, c, d]] if rng.random() < 0.5 else [[a, b, d], [b, c, d]]
    return halves


def warped_vault(stones, rows, warp=0.0, noise=0.0):
    """Barrel vault of 2 m radius and 0.25 m in bond, on its springers, as surveyed or rounded one stone at a time.

    Corners that neighbours share move by up to ``warp``, m, along each axis: joints warp, and stay closed. ``noise`` is
    the same of each stone by itself: joints gape and stones penetrate each other.
    """
    rng = np.random.default_rng(0)
    angle, y, radius = np.meshgrid(
        np.pi * np.arange(stones + 1) / stones, np.linspace(0, 2, 2 * rows + 1), [2.0, 2.25], indexing="ij"
    )
    nodes = np.stack([-radius * np.cos(angle), y, radius * np.sin(angle)], axis=-1)
    nodes += rng.uniform(-warp, warp, nodes.shape)
    blocks = []
    for i in range(stones):
        cuts = range(0, 2 * rows + 1, 2) if i % 2 == 0 else [0, *range(1, 2 * rows, 2), 2 * rows]
        for a, b in pairwise(cuts):
            corners = np.array([nodes[k, j, r] for k in (i, i + 1) for j, r in ((a, 0), (b, 0), (b, 1), (a, 1))])
            points = Q_(corners + rng.uniform(-noise, noise, corners.shape), "m")
            name, fixed = f"{i}.{a}", i in (0, stones - 1)
            blocks.append(bs.Block.from_faces(name, points, triangles(rng), STONE, fixed=fixed))
    return blocks


def test_penetration_within_the_tolerance_of_detection_is_accepted():
    blocks = [GROUND, box("a", [0, 0, 0]), box("b", [0.296, 0, 0])]
    found = bs.detect_interfaces(blocks, DRY, tolerance="1 cm")
    assert found.report.overlaps == ()
    model = bs.Model("wall", blocks, found)
    assert [i.name for i in model.interfaces] == ["ground|a", "ground|b", "a|b"]
    assert model.detection is found.report
    assert bs.Model("wall", blocks=blocks, interfaces=found).hash == model.hash
    # Interfaces alone do not contain the tolerance of the detection.
    with pytest.raises(bs.errors.GeometryError, match=r"'a' and 'b' by 0.004 m; .*interfaces=found"):
        bs.Model("wall", blocks, found.interfaces)
    assert bs.Model("wall", blocks, found.interfaces, detection=found.report).hash == model.hash


@pytest.mark.parametrize(
    ("depth", "tolerance", "is_slight"), [(0.002, None, True), (0.02, "1 cm", False), (0.1, None, False)]
)
def test_penetration_beyond_the_tolerance_is_refused(depth, tolerance, is_slight):
    """A larger tolerance is named where the overlap is slight."""
    blocks = [GROUND, box("a", [0, 0, 0]), box("b", [0.3 - depth, 0, 0])]
    found = bs.detect_interfaces(blocks, DRY, tolerance)
    ((*names, measured),) = found.report.overlaps
    assert (names, measured) == (["a", "b"], pytest.approx(depth))
    with refused(bs.errors.GeometryError, f"'a' 'b' {depth} m") as caught:
        bs.Model("wall", blocks, found)
    assert ("tolerance above" in str(caught.value)) is is_slight


@pytest.mark.parametrize("depth", [1e-4, 0.1])
@pytest.mark.parametrize("tolerance", [None, "1 mm"])
def test_supports_that_overlap_are_reported_and_accepted(depth, tolerance):
    blocks = [GROUND, box("pier", [0, 0, -depth], fixed=True), box("block", [0, 0, 0.3 - depth])]
    found = bs.detect_interfaces(blocks, DRY, tolerance)
    shared = [] if tolerance and depth < 1e-3 else [("ground", "pier")]
    assert [o[:2] for o in found.report.overlaps] == shared
    assert len(bs.Model("pier", blocks, found).interfaces) == 1


def check_that_the_model_accepts(blocks, tolerance, angle):
    """Whether there is a model. Only overlapping or floating blocks in the report prevent it."""
    found = bs.detect_interfaces(blocks, DRY, tolerance, angle_tolerance=angle, area_tolerance="1 cm^2")
    supports = {b.name for b in blocks if b.fixed}
    deep = [o for o in found.report.overlaps if not supports.issuperset(o[:2])]
    gap, measured = found.report.tolerances.gap, {}
    for contact in found.report.contacts:
        measured.setdefault(frozenset((contact.minus, contact.plus)), []).append(abs(contact.gap))
    # Blocks that share space deeper than the tolerance do so at some contact left out for it, or at none.
    assert all(max(measured.get(frozenset(o[:2]), [np.inf])) > gap for o in deep)
    try:
        model = bs.Model("vault", blocks, found)
    except bs.errors.ModelError as error:
        refused = str(error)
    else:
        assert len(model.interfaces) == found.report.accepted
        return True
    assert deep or found.report.floating
    assert ("overlapping blocks" if deep else "floating blocks") in refused
    return False


@pytest.mark.parametrize(("warp", "noise"), [(3e-3, 1e-3), pytest.param(0.06, 0.01, marks=pytest.mark.slow)])
def test_a_model_accepts_detections_of_a_warped_vault(warp, noise):
    """Stones warped and disturbed by up to centimetres, with tolerances from tiny to large."""
    blocks = warped_vault(5, 2, warp=warp, noise=noise)
    tolerances = ["0.01 mm", "1 mm", "5 mm", "2 cm", "15 cm"]
    made = [check_that_the_model_accepts(blocks, t, a) for t in tolerances for a in ("6 deg", "40 deg")]
    assert made[-1]
    assert not made[0]


def test_a_warped_vault_has_a_certified_load_factor():
    blocks = warped_vault(5, 2, warp=6e-3, noise=3e-3)
    assert not bs.detect_interfaces(blocks, DRY).report.accepted
    found = bs.detect_interfaces(blocks, DRY, "2 cm", angle_tolerance="8 deg", area_tolerance="1 cm^2")
    assert max(np.degrees(c.angle) for c in found.report.contacts) > 5
    model = bs.Model("vault", blocks, found)
    bound = solve(model, push(1, 0, 0))
    result = solve(model, push(1, 0, 0), "nonassociative")
    assert bound.status == result.status == "converged"
    # Near the load factor of the exact vault: its stones are equal to a hundredth of their size.
    exact = warped_vault(5, 2)
    true = solve(bs.Model("vault", exact, bs.detect_interfaces(exact, DRY)), push(1, 0, 0))
    assert bound.load_factor == pytest.approx(true.load_factor, rel=0.05)
    assert result.load_factor <= bound.load_factor + 1e-6


def test_a_measured_interface_moved_off_its_blocks_is_refused():
    """The tolerance of a report applies to the measured position of an interface."""
    blocks = [GROUND, box("a", [0, 0, 0])]
    found = bs.detect_interfaces(blocks, DRY, "1 mm")
    (bed,) = found.interfaces
    beside = bs.Interface(bed.name, bed.minus, bed.plus, Q_(np.add(bed.polygon, [0.1, 0, 0]), "m"), DRY)
    with pytest.raises(bs.errors.GeometryError, match=r"'ground\|a'.*'a'"):
        bs.Model("wall", blocks, attrs.evolve(found, interfaces=(beside,)))


@pytest.mark.parametrize(
    ("gap", "height", "refused"), [(0.02, 0.01, ()), (0, 0.012, ("a", 0.003)), (0, -0.05, ("ground", 0.003))]
)
def test_an_interface_may_be_in_a_wide_joint_but_not_in_a_block(gap, height, refused):
    """By 0.012 m within a cube of 0.3 m, it would tip at `0.15 / (0.15 - 0.012) = 1.087` instead of 1."""
    blocks = [GROUND, box("a", [0, 0, gap])]
    corners = np.array([[0, 0, height], [0.3, 0, height], [0.3, 0.3, height], [0, 0.3, height]])
    bed = bs.Interface("bed", "ground", "a", Q_(corners, "m"), DRY)
    if not refused:
        assert bs.Model("block", blocks, [bed]).interfaces == (bed,)
        return
    # A repeated corner counts once.
    again = bs.Interface("bed", "ground", "a", Q_([*corners, corners[0], corners[0]], "m"), DRY)
    assert sorted(again.polygon.tolist()) == sorted(bed.polygon.tolist())
    name, limit = refused
    with pytest.raises(bs.errors.GeometryError, match=rf"'bed'.* block '{name}'.*{limit} m inside"):
        bs.Model("block", blocks, [bed])


def crossing_piers():
    """Four piers on the ground whose corners nearly meet: two by a hair."""
    hair = 2e-4
    places = [(0, 0), (0.3, 0), (0.3 - hair, 0.3), (-hair, 0.3)]
    return [GROUND, *(box(f"p{k}", [x, y, 0], size=(0.3, 0.3, 1)) for k, (x, y) in enumerate(places))]


def test_the_recommended_area_tolerance_removes_slivers():
    blocks = crossing_piers()
    found = bs.detect_interfaces(blocks, DRY, area_tolerance="1 mm^2")
    report = found.report
    (sliver,) = report.accepted_slivers
    assert {sliver.minus, sliver.plus} == {"p0", "p2"}
    assert (sliver.area, report.sliver_tolerance) == pytest.approx((2e-4, 2.1e-4))
    assert "an area tolerance of 0.00021 m² leaves them out" in str(report)
    table = report.table()
    assert table.loc[table["finding"] == "accepted sliver", "area"].item() == sliver.area
    without = bs.detect_interfaces(blocks, DRY, area_tolerance=Q_(report.sliver_tolerance, "m^2"))
    assert (without.report.accepted_slivers, without.report.sliver_tolerance) == ((), 0.0)
    names = {i.name for i in bs.Model("piers", blocks, without).interfaces}
    assert {i.name for i in found.interfaces} - names == {sliver.interface}
