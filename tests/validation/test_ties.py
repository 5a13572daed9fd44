"""Ties against closed forms: the same in every procedure and solver, whatever the units, frame and numbering."""

import math

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, box, model_of, moved, push, rotation, solve

PROCEDURES = {
    "associative": {"flow": "associative"},
    "fictitious": {"flow": "nonassociative"},
    "shifted": {"flow": "nonassociative", "procedure": "shifted"},
    "loading path": {"flow": "nonassociative", "procedure": "loading path"},
    "cvxpy, associative": {"flow": "associative", "solver": "cvxpy:CLARABEL"},
    "cvxpy, fictitious": {"flow": "nonassociative", "solver": "cvxpy:CLARABEL"},
}


def tied_blocks(*heights, b=0.5):
    """Blocks of depth 1 m on top of each other, and a pier to tie them to."""
    levels = np.cumsum([0.0, *heights])
    blocks = [box(f"b{k}", [0, 0, z], [b, 1, h]) for k, (z, h) in enumerate(zip(levels[:-1], heights, strict=True))]
    supports = ("ground", [-2, 0, -1], [4 + b, 1, 1]), ("pier", [-1.5, 0, 0], [0.5, 1, 4])
    return [*(box(*of, fixed=True) for of in supports), *blocks]


def tie_at(z, to, name="tie", **given):
    return bs.Tie(name, ("pier", Q_([-1, 0.5, z], "m")), (to, Q_([0, 0.5, z], "m")), **given)


def tied(blocks, ties, mu=0.8, **joint):
    return model_of(blocks, bs.JointMaterial("joint", mu, **joint), "tied").with_ties(ties)


@pytest.mark.parametrize("procedure", PROCEDURES)
@pytest.mark.parametrize("kilonewton", [2.0, 15.0], ids=["overturns", "slides"])
def test_single_block(procedure, kilonewton):
    # W = 20 kN; overturning about the toe with the tie at 1.9 m, or sliding.
    T, W, z = kilonewton, 20.0, 1.9
    model = tied(tied_blocks(2.0), [tie_at(z, "b0", yield_force=Q_(T, "kN"))])
    result = solve(model, push(1, 0, 0), **PROCEDURES[procedure])
    overturns, slides = (W * 0.25 + T * z) / (W * 1.0), 0.8 + T / W
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(min(overturns, slides), rel=1e-5)
    row = result.ties.loc["tie"]
    assert row["force [newton]"] == pytest.approx(T * 1e3, rel=1e-4)
    assert (row["state"], row["governing"]) == ("yielding", "yield")
    if overturns < slides:
        # The mechanism is scaled to a centroid that moves by one: it turns by 1/√(0.25² + 1²).
        assert row["elongation"] == pytest.approx(z / math.hypot(0.25, 1.0), rel=1e-4)


@pytest.mark.parametrize("procedure", PROCEDURES)
def test_two_hinge_wall(procedure):
    """The top is held: the wall opens hinges at its foot and at the joint (virtual work of the two bodies)."""
    b, h1, h2, z = 0.5, 1.6, 1.4, 1.2
    W1, W2 = (20e3 * b * h for h in (h1, h2))
    model = tied(tied_blocks(h1, h2), [tie_at(h1 + z, "b1", yield_force="200 kN")])
    result = solve(model, push(1, 0, 0), **PROCEDURES[procedure])
    alpha = (W1 * b / 2 + W2 * (b + b * h1 / (2 * z))) / (W1 * h1 / 2 + W2 * (h1 - h1 * h2 / (2 * z)))
    assert result.load_factor == pytest.approx(alpha, rel=1e-5)
    # Moments of the upper body about the hinge: the tie holds it, and does not yield.
    row = result.ties.loc["tie"]
    assert row["force [newton]"] * z == pytest.approx(alpha * W2 * h2 / 2 + W2 * b / 2, rel=1e-4)
    assert row["state"] == "stressed"
    assert abs(row["elongation"]) < 1e-4


@pytest.mark.parametrize("procedure", ["associative", "fictitious", "loading path", "cvxpy, associative"])
@pytest.mark.parametrize(("last", "governs"), [(0.3, "its end"), (2.0, "the blocks behind")])
def test_bonded_bar_with_one_governing_segment(procedure, last, governs):
    # A row on the ground: a support, a heavy block, and one that is pushed away. Bond of 20 kN a metre.
    lengths, mu = (0.4, 0.5, last), 0.3
    x = np.cumsum([0.0, *lengths])
    ground = box("ground", [-1, 0, -1], [6, 1, 1], fixed=True)
    heavy = box("heavy", [x[1], 0, 0], [lengths[1], 1, 4])
    row = [ground, box("anchor", [0, 0, 0], [lengths[0], 1, 0.4], fixed=True), heavy]
    row.append(box("last", [x[2], 0, 0], [last, 1, 0.4]))
    given = {"diameter": "20 mm", "bond_strength": Q_(20e3 / (math.pi * 0.02), "Pa"), "yield_force": "100 kN"}
    bar = bs.ties.BondedBar("bar", "[-0.1, 0.5, 0.2] m", Q_([x[3], 0.5, 0.2], "m"), **given)
    blow = bs.LoadPattern("blow", [bs.PointLoad("last", Q_([x[2] + last / 2, 0.5, 0.2], "m"), Q_([1, 0, 0], "kN"))])
    result = solve(tied(row, [bar], mu), blow, **PROCEDURES[procedure])
    T = 20e3 * (last if governs == "its end" else lengths[0] + lengths[1])
    # The fictitious iteration ends where its load factor has settled to 3e-4.
    accuracy = 3e-4 if procedure == "fictitious" else 1e-5
    assert result.load_factor * 1e3 == pytest.approx(mu * 20e3 * last * 0.4 + T, rel=accuracy)
    table = result.ties
    assert list(table.index) == ["bar [anchor|heavy]", "bar [heavy|last]"]
    assert table["force [newton]"].iloc[1] == pytest.approx(T, rel=1e-4)
    assert table["state"].iloc[1] == "slipping"
    if governs != "its end":
        assert table["force [newton]"].iloc[0] == pytest.approx(20e3 * lengths[0], rel=1e-4)
        assert table["state"].iloc[0] == "slipping"


@pytest.mark.parametrize("crushing", [{}, {"crushing": "linearised"}, {"crushing_interaction": "biaxial"}], ids=str)
@pytest.mark.parametrize("procedure", ["associative", "fictitious", "loading path"])
def test_a_tied_block_whose_foot_crushes(procedure, crushing):
    """The tie is horizontal, the foot carries the weight: ``α = (b (1 − W / (f_c b t)) W / 2 + T z) / (W h / 2)``."""
    W, b, h, z, T = 20e3, 0.5, 2.0, 1.8, 2e3
    model = tied(tied_blocks(h), [tie_at(z, "b0", yield_force="2 kN")], compressive_strength="200 kPa")
    found = solve(model, push(1, 0, 0), **{"procedure": "fictitious"} | PROCEDURES[procedure] | crushing)
    expected = (W * b / 2 * (1 - W / (200e3 * b)) + T * z) / (W * h / 2)
    assert found.load_factor == pytest.approx(expected, rel=1e-5 if procedure == "associative" else 3e-4)


def test_strip_at_the_surface():
    # Over the joint at the foot, on the face that opens: lever b instead of z.
    foot = box("foot", [0, 0, -1], [0.5, 1, 1], fixed=True)
    ends = ("foot", "[0, 0.5, -0.1] m"), ("b0", "[0, 0.5, 0.2] m")
    strip = bs.ties.Strip("strip", *ends, area="10 mm^2", strength="300 MPa")
    result = solve(tied([foot, box("b0", [0, 0, 0], [0.5, 1, 2])], [strip]), push(1, 0, 0))
    assert result.load_factor == pytest.approx((20.0 * 0.25 + 3.0 * 0.5) / 20.0, rel=1e-6)


@pytest.mark.parametrize("procedure", PROCEDURES)
def test_a_tie_takes_no_compression(procedure):
    model = tied(tied_blocks(2.0), [tie_at(1.9, "b0", yield_force="5 kN")])
    result = solve(model, push(-1, 0, 0), **PROCEDURES[procedure])
    assert (result.load_factor, result.ties.loc["tie", "state"]) == (pytest.approx(0.25, rel=1e-5), "slack")


@pytest.mark.parametrize("procedure", ["fictitious", "loading path"])
def test_prestress_presses_a_joint_that_slides_without_dilatancy(procedure):
    block = box("block", [0, 0, 0], [2, 1, 1])
    ground = box("ground", [-1, 0, -1], [4, 1, 1], fixed=True)
    ends = ("ground", Q_([1, 0.5, -0.5], "m")), ("block", Q_([1, 0.5, 1], "m"))
    # Sliding does not make it longer: it keeps its prestress. Dilatant, it yields.
    tie = bs.Tie("tie", *ends, yield_force="20 kN", prestress="8 kN")
    model = tied([ground, block], [tie], 0.3)
    result = solve(model, push(1, 0, 0), **PROCEDURES[procedure])
    assert result.load_factor == pytest.approx(0.3 * (1 + 8 / 40), rel=1e-3)
    assert solve(model, push(1, 0, 0)).load_factor == pytest.approx(0.3 * (1 + 20 / 40), rel=1e-6)


def test_a_tie_or_its_prestress_decides_whether_the_structure_stands():
    # A block that overhangs its support by more than half, held down by a vertical tie or not.
    ground, block = box("ground", [0, 0, -2], [0.4, 1, 2], fixed=True), box("block", [0, 0, 0], [1.0, 1, 0.5])
    bare = model_of([ground, block], bs.JointMaterial("joint", 0.5))
    assert solve(bare, push(-1, 0, 0)).status == "unstable_under_dead_load"
    ends = ("ground", Q_([0.1, 0.5, -0.5], "m")), ("block", Q_([0.1, 0.5, 0.5], "m"))
    # W (0.5 − 0.4) = T 0.3 about the edge: 3.333 kN for 10 kN.
    for force, status in (("3.3 kN", "unstable_under_dead_load"), ("3.4 kN", "converged")):
        assert solve(bare.with_ties([bs.Tie("tie", *ends, yield_force=force)]), push(-1, 0, 0)).status == status
    # And a prestress that pulls it down beside its support: W (0.6 − 0.5) = T0 (0.9 − 0.6), again 3.333 kN.
    ends = ("foot", Q_([0.9, 0.5, -2], "m")), ("block", Q_([0.9, 0.5, 0.0], "m"))
    supports = ("ground", [0, 0, -2], [0.6, 1, 2]), ("foot", [0.8, 0, -2.5], [0.2, 1, 0.5])
    wide = model_of([*(box(*of, fixed=True) for of in supports), block], bs.JointMaterial("joint", 0.5))
    for force, status in (("3.3 kN", "converged"), ("3.4 kN", "unstable_under_dead_load")):
        model = wide.with_ties([bs.Tie("tie", *ends, yield_force="50 kN", prestress=force)])
        analysis = bs.run(model, bs.LimitCase("c", SELF_WEIGHT, push(-1, 0, 0), "associative"))
        assert (analysis["c"].status, bs.results.contradictions(analysis)) == (status, [])
    # The share of dead load and prestress that is in equilibrium.
    assert analysis["c"].ties["force [newton]"].iloc[0] < 3.4e3


def two_ties():
    """Two blocks, tied a little at two levels."""
    places = ("low", 0.9, "b0"), ("high", 1.9, "b1")
    return tied(tied_blocks(1.0, 1.0), [tie_at(z, to, name, yield_force="1 kN") for name, z, to in places])


def least(model, names, wanted, direction=1, flow="associative", **settings):
    """Least forces of ties for a push along x."""
    case = bs.LimitCase("push", SELF_WEIGHT, push(direction, 0, 0), flow)
    return bs.ties.least_tie_force(model, case, names, wanted, **settings)


def test_least_tie_force_against_bisection():
    model, wanted, (low, high) = two_ties(), 0.6, (2e3, 10e3)
    found = least(model, ["high"], wanted)
    while high - low > 1e-5 * high:
        middle = (low + high) / 2
        trial = tie_at(1.9, "b1", "high", yield_force=Q_(middle, "N"))
        reached = solve(model.with_ties([model.ties[0], trial]), push(1, 0, 0)).load_factor >= wanted
        low, high = (low, middle) if reached else (middle, high)
    assert found.proven
    assert found.forces["high"] == pytest.approx(high, rel=2e-5)


def test_least_tie_force_of_several_ties_is_what_they_need():
    model, wanted = two_ties(), 0.7
    other = bs.ProcedureSettings(numerics=bs.Numerics(solver="cvxpy:CLARABEL"))
    assert least(model, ["high"], wanted, settings=other).proven
    both, *alone = (least(model, names, wanted) for names in (["low", "high"], ["low"], ["high"]))
    assert both.proven
    # The other one keeps its strength of 1 kN where it is not sought.
    assert both.total <= min(one.total + 1e3 for one in alone if one.proven) * (1 + 1e-6)
    strong = [bs.Tie(t.name, *ends(t), yield_force=Q_(max(both.forces[t.name], 1e-3), "N")) for t in model.ties]
    assert solve(model.with_ties(strong), push(1, 0, 0)).load_factor == pytest.approx(wanted, rel=1e-6)


def test_least_tie_force_where_none_is_needed_or_none_will_do():
    model = two_ties()
    unneeded = least(model.with_ties(model.ties[:1]), [model.ties[1]], 0.1, flow="nonassociative")
    assert (unneeded.proven, unneeded.total) == (True, 0.0)
    assert "without dilatancy" in str(unneeded)
    stressed = tie_at(1.9, "b1", "high", yield_force="1 kN", prestress="0.2 kN")
    kept = least(model.with_ties([stressed]), ["high"], 0.1)
    assert (kept.proven, kept.forces) == (True, pytest.approx({"high": 200.0}))
    assert not least(model, ["high"], 0.5, -1).proven


def leaning():
    """A block 0.2 m too far out on another one, held back to a pier by ``t`` at its middle; a slab held by ``w``."""
    fixed = ("ground", [-3, 0, -1], [6, 1, 1]), ("pier", [-3, 0, 0], [0.5, 1, 3]), ("post", [2.5, 0, 0], [0.3, 1, 2])
    free = ("a", [0, 0, 0]), ("b", [0.7, 0, 1]), ("slab", [-1.5, 0, 0], [0.3, 1, 2])
    blocks = [*(box(*of, fixed=True) for of in fixed), *(box(*of) for of in free)]
    places = {"t": [("pier", -2.5, 1.5), ("b", 0.7, 1.5)], "w": [("post", 2.5, 1.9), ("slab", -1.2, 1.9)]}
    ends = {name: [(to, Q_([x, 0.5, z], "m")) for to, x, z in of] for name, of in places.items()}
    return tied(blocks, [bs.Tie(name, *both, yield_force="20 kN") for name, both in ends.items()], mu=0.7)


@pytest.mark.parametrize("wanted", [0.1, 0.3, 0.6])
def test_ties_that_the_dead_load_needs_are_not_left_out(wanted):
    """Moments about the edge of the lower block: T · 0.5 m = 20 kN · 0.2 m, while the push does the work of the tie."""
    model = tied([b for b in leaning().blocks if b.name not in ("slab", "post")], leaning().ties[:1], mu=0.7)
    back, out = (least(model, ["t"], wanted, direction) for direction in (-1, 1))
    assert back.forces["t"] == pytest.approx(8e3, rel=1e-6)
    assert (back.proven, back.governing) == (True, "dead load")
    assert out.forces["t"] == pytest.approx(8e3 + 20e3 * wanted, rel=1e-6)
    assert (out.proven, out.governing) == (True, "load factor")


def test_ties_that_two_loads_need_are_enough_but_not_proven_to_be_the_least():
    model, wanted = leaning(), 0.3
    found = least(model, ["t", "w"], wanted, -1)
    # The slab: T · 1.9 m = W (0.3 · 1 m − 0.15 m) with W = 12 kN.
    slab = 12e3 * (wanted - 0.15) / 1.9
    assert found.forces == pytest.approx({"t": 8e3, "w": slab}, rel=1e-5)
    assert (found.proven, found.governing) == (False, "both")
    strong = [bs.Tie(t.name, *ends(t), yield_force=Q_(found.forces[t.name] * (1 + 1e-5), "N")) for t in model.ties]
    assert solve(model.with_ties(strong), push(-1, 0, 0)).load_factor == pytest.approx(wanted, rel=1e-4)


def ends(tie):
    return [(block, Q_(point, "m")) for block, point in (tie.start, tie.end)]


def in_frame(model, R, shift, scale, order):
    """The same structure in another frame, of other units of length and another numbering."""
    blocks = [moved([model.blocks[k]], R, shift)[0] for k in order]

    def placed(points):
        return Q_((np.asarray(points) @ R.T + shift) * scale, "mm")

    ties = []
    for tie in model.ties:
        if isinstance(tie, bs.ties.BondedBar):
            bar = {"diameter": Q_(tie.diameter * 1e3, "mm"), "bond_strength": Q_(tie.bond_strength / 1e6, "MPa")}
            start, end = placed([tie.start, tie.end])
            ties.append(bs.ties.BondedBar(tie.name, end, start, yield_force=Q_(tie.yield_force / 1e3, "kN"), **bar))
        else:
            start, end = ((block, placed(point)) for block, point in (tie.start, tie.end))
            force, least = Q_(tie.yield_force / 1e3, "kN"), Q_(tie.prestress / 1e3, "kN")
            ties.append(bs.Tie(tie.name, end, start, yield_force=force, prestress=least))
    joint = model.interfaces[0].joint_material
    return model_of(blocks, joint, model.name).with_ties(ties[::-1])


@pytest.mark.parametrize("procedure", ["associative", "fictitious", "loading path"])
def test_units_frame_and_numbering_do_not_matter(procedure):
    tie = tie_at(2.3, "b1", yield_force="6 kN", prestress="1 kN")
    given = {"diameter": "10 mm", "bond_strength": "0.2 MPa", "yield_force": "5 kN"}
    bar = bs.ties.BondedBar("bar", "[0.2, 0.4, -0.5] m", "[0.2, 0.4, 2.3] m", **given)
    model = tied(tied_blocks(1.0, 1.5), [tie, bar])
    here = solve(model, push(1, 0.2, 0), **PROCEDURES[procedure])
    R = rotation((1, 2, 3), 0.7)
    other = in_frame(model, R, np.array([5.0, -3.0, 2.0]), 1e3, [3, 1, 0, 2])
    gravity = bs.LoadPattern("dead", [bs.BodyForce(R @ [0, 0, -1])])
    there = solve(other, push(*(R @ [1, 0.2, 0])), dead=gravity, **PROCEDURES[procedure])
    assert here.certificate.holds
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-6 if procedure == "associative" else 2e-3)
    assert there.load_factor > 1.2 * solve(model.with_ties(()), push(1, 0.2, 0), **PROCEDURES[procedure]).load_factor


@pytest.mark.parametrize("force", ["20 MN", "20 GN"])
def test_a_strength_far_beyond_the_weights_is_certified_as_well(force):
    model = tied(tied_blocks(1.6, 1.4), [tie_at(2.8, "b1", yield_force=force)])
    models = model, model.with_ties([tie_at(2.8, "b1", yield_force="1 MN")])
    strong, enough = (solve(of, push(1, 0, 0)) for of in models)
    assert strong.load_factor == pytest.approx(enough.load_factor, rel=1e-6)
    assert strong.ties.loc["tie", "state"] == "stressed"
