"""A model accepts the interfaces of a detection, with its tolerances."""

import attrs
import numpy as np
import pytest

import blockstruct as bs
import structures
from blockstruct import Q_
from structures import push, solve
from warped import STONE, warped_vault

DRY = bs.JointMaterial("dry", 0.7)
GROUND = structures.box("ground", [-1, -1, -1], [4, 3, 1], fixed=True)


def box(name, origin, size=(0.3, 0.3, 0.3), *, fixed=False):
    return structures.box(name, origin, size, fixed=fixed)


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


@pytest.mark.parametrize("tolerance", [None, "1 cm"])
def test_penetration_beyond_the_tolerance_is_refused(tolerance):
    blocks = [GROUND, box("a", [0, 0, 0]), box("b", [0.28, 0, 0])]
    found = bs.detect_interfaces(blocks, DRY, tolerance)
    ((*names, depth),) = found.report.overlaps
    assert (names, depth) == (["a", "b"], pytest.approx(0.02))
    with pytest.raises(bs.errors.GeometryError, match=r"'a' and 'b' by 0.02 m"):
        bs.Model("wall", blocks, found)


@pytest.mark.parametrize("depth", [1e-4, 0.1])
@pytest.mark.parametrize("tolerance", [None, "1 mm"])
def test_supports_that_overlap_are_reported_and_accepted(depth, tolerance):
    blocks = [GROUND, box("pier", [0, 0, -depth], fixed=True), box("block", [0, 0, 0.3 - depth])]
    found = bs.detect_interfaces(blocks, DRY, tolerance)
    shared = [] if tolerance and depth < 1e-3 else [("ground", "pier")]
    assert [o[:2] for o in found.report.overlaps] == shared
    assert len(bs.Model("pier", blocks, found).interfaces) == 1


def test_a_contact_rejected_by_area_is_not_an_overlap():
    # The upper block reaches 5 mm over its neighbour, and 2 mm into it.
    blocks = [GROUND, box("a", [0, 0, 0]), box("b", [0.3, 0, 0]), box("c", [0.295, 0, 0.298])]
    found = bs.detect_interfaces(blocks, DRY, "4 mm", area_tolerance="20 cm^2")
    assert {(c.minus, c.plus) for c in found.report.contacts if c.reason == "area"} == {("a", "c")}
    model = bs.Model("wall", blocks, found)
    assert [i.name for i in model.interfaces] == ["ground|a", "ground|b", "a|b", "b|c"]


def test_deviation_of_a_face_from_its_mean_plane_is_not_an_overlap():
    """The contact lies within the tolerance of the mean planes, one corner does not."""
    warped = box("big", [0, 0, 0], (3, 3, 3)).shape.vertices.copy()
    warped[6, 2] += 0.02
    big = bs.Block.from_faces("big", Q_(warped, "m"), GROUND.shape.faces, STONE)
    small = [box(f"{x}{y}", [x, y, 3.0]) for x in (0, 2.7) for y in (0, 2.7)]
    base = box("base", [-1, -1, -1], [5, 5, 1], fixed=True)
    found = bs.detect_interfaces([base, big, *small], DRY, "1.6 cm")
    assert found.report.overlaps == ()
    assert found.report.accepted == 5
    bs.Model("table", [base, big, *small], found)


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


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_a_model_accepts_detections_of_many_shells(seed):
    rng = np.random.default_rng(seed)
    shape = {"stones": int(rng.integers(5, 9)), "rows": int(rng.integers(2, 4)), "thickness": rng.uniform(0.1, 0.4)}
    blocks = warped_vault(**shape, warp=10 ** rng.uniform(-5, -1.2), noise=10 ** rng.uniform(-6, -2), seed=seed)
    for tolerance in ("0.01 mm", "1 mm", "5 mm", "2 cm", "6 cm"):
        for angle in ("1 deg", "6 deg", "20 deg", "44 deg"):
            check_that_the_model_accepts(blocks, tolerance, angle)


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
    name, limit = refused
    with pytest.raises(bs.errors.GeometryError, match=rf"'bed'.* block '{name}'.*{limit} m inside"):
        bs.Model("block", blocks, [bed])


@pytest.mark.parametrize("times", [2, 3])
@pytest.mark.parametrize("corner", [0, 2])
def test_a_repeated_corner_counts_once(corner, times):
    corners = [[0, 0, 0], [0.3, 0, 0], [0.3, 0.3, 0], [0, 0.3, 0]]
    given = corners[corner:] + corners[: corner + 1] + [corners[corner]] * (times - 2)
    bed = bs.Interface("bed", "ground", "a", Q_(given, "m"), DRY)
    assert sorted(bed.polygon.tolist()) == sorted(corners)
    with pytest.raises(bs.errors.GeometryError, match="no area"):
        bs.Interface("bed", "ground", "a", Q_([corners[0]] * 3, "m"), DRY)


def crossing_piers():
    """Four piers on the ground whose corners nearly meet: two by a hair."""
    hair = 2e-4
    places = [(0, 0), (0.3, 0), (0.3 - hair, 0.3), (-hair, 0.3)]
    return [GROUND, *(box(f"p{k}", [x, y, 0], (0.3, 0.3, 1)) for k, (x, y) in enumerate(places))]


def test_the_recommended_area_tolerance_removes_slivers():
    blocks = crossing_piers()
    found = bs.detect_interfaces(blocks, DRY, area_tolerance="1 mm^2")
    report = found.report
    assert {frozenset((c.minus, c.plus)) for c in report.accepted_slivers} == {frozenset(("p0", "p2"))}
    (sliver,) = report.accepted_slivers
    assert sliver.area == pytest.approx(2e-4)
    assert report.sliver_tolerance == pytest.approx(2.1e-4)
    assert "an area tolerance of 0.00021 m^2 leaves them out" in str(report)
    table = report.table()
    assert table.loc[table["finding"] == "accepted sliver", "area"].item() == sliver.area
    without = bs.detect_interfaces(blocks, DRY, area_tolerance=Q_(report.sliver_tolerance, "m^2"))
    assert without.report.accepted_slivers == ()
    assert without.report.sliver_tolerance == 0.0
    names = {i.name for i in bs.Model("piers", blocks, without).interfaces}
    assert {i.name for i in found.interfaces} - names == {sliver.interface}


@pytest.mark.parametrize(("depth", "is_slight"), [(0.005, True), (0.3, False)])
def test_a_deep_overlap_is_not_answered_with_a_tolerance(depth, is_slight):
    blocks = [box("a", [0, 0, 0], [1, 1, 1], fixed=True), box("b", [0, 0, 1 - depth], [1, 1, 1])]
    with pytest.raises(bs.errors.GeometryError, match="overlapping blocks") as caught:
        bs.Model("m", blocks, bs.detect_interfaces(blocks, joint_material=bs.JointMaterial("j", 0.6)))
    assert ("tolerance above" in str(caught.value)) is is_slight
