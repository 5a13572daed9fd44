"""Several directions in one call, and several sizes of units."""

import pickle
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.limit import Outcome
from structures import SELF_WEIGHT, STONE, box, model_of, push, single_block

SITE = bs.assess.ntc_spectrum(Q_(0.1, "g_0"), 2.4, "0.3 s", "B")
DRY = bs.JointMaterial("dry", 0.7)
RATIO = "capacity / demand"
UNSTABLE = Outcome(bs.Status.UNSTABLE, np.nan, bs.vocabulary.Reason.DEAD_LOAD_NOT_CARRIED, carried=0.5)


def block():
    """A block 0.5 m along x and 1 m along y, 2 m high: α0 = 0.25 and 0.5."""
    return model_of(single_block(0.5, 2.0)[0], DRY)


def checked_building(*directions, **more):
    directions = {"directions": list(directions)} if directions else {}
    return bs.assess.building(block(), SELF_WEIGHT, SITE, **directions, **{"progress": False} | more)


@pytest.fixture(scope="module")
def found():
    return checked_building()


def test_the_weakest_direction_governs(found):
    """By hand: α0 g / 1.35 over 0.06 g."""
    assert found.table["ratio"].tolist() == pytest.approx([0.25 / 1.35 / 0.06] * 2 + [0.5 / 1.35 / 0.06] * 2, rel=1e-5)
    assert (found.verdict.ratio, found.verdict.satisfied) == (found.table["ratio"].min(), True)
    assert found.verdict.direction in ("+x", "−x")
    assert found.table["governs"].sum() == 1


def test_a_house_of_four_rigid_walls_by_hand():
    """Each wall overturns alone about its outer edge: walls of 20 kN/m³, 3 m high, on dry joints, smooth at corners.

    Push −y: the façade, 6 m long, 0.4 m thick and W = 144 kN, with a tie of T = 10 kN at 2.5 m:
    α0 = (144 · 0.2 + 10 · 2.5) / (144 · 1.5) = 53.8 / 216 = 0.24907.
    Push +y: the back wall, 0.6 m thick and W = 216 kN, with the same tie: (216 · 0.3 + 25) / (216 · 1.5) = 0.27716.
    Push ±x: the left wall, 4.2 m long, 0.5 m thick and W = 126 kN, with a roof of 5 kN/m, Q = 21 kN, 0.2 m from its
    outer edge. Outwards (126 · 0.25 + 21 · 0.2) / (126 · 1.5 + 21 · 3) = 35.7 / 252 = 0.14167, and inwards
    (31.5 + 21 · 0.3) / 252 = 0.15. The right wall, 0.6 m / 3 m = 0.2, comes later.
    One body has e* = 1, so a0* = α0 g / FC. The demand is 0.1 g · 1.2 / 2 = 0.06 g, the ratio α0 / (1.35 · 0.06).
    """
    walls = {"front": ([0, 0, 0], [6, 0.4, 3]), "back": ([0, 4.6, 0], [6, 0.6, 3])}
    walls |= {"left": ([0, 0.4, 0], [0.5, 4.2, 3]), "right": ([5.4, 0.4, 0], [0.6, 4.2, 3])}
    blocks = [box("ground", [-1, -1, -1], [8, 7, 1], fixed=True), *(box(name, *at) for name, at in walls.items())]
    smooth = bs.JointMaterial("smooth", 0.0)
    found = bs.detect_interfaces(blocks, joint_material=lambda i: DRY if "ground" in (i.minus, i.plus) else smooth)
    tie = bs.Tie("tie", start="[3, 0, 2.5] m", end="[3, 5.2, 2.5] m", yield_force="10 kN")
    roof = bs.LineLoad("5 kN/m", start="[0.2, 0.4, 3] m", end="[0.2, 4.6, 3] m")
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), roof])
    house = bs.assess.building(bs.Model("house", blocks, found, ties=[tie]), dead, SITE, progress=False)
    alpha = np.array([37.8 / 252, 35.7 / 252, 89.8 / 324, 53.8 / 216])
    assert house.table["α"].to_numpy() == pytest.approx(alpha, rel=1e-6)
    assert house.table["a0* [meter / second ** 2]"].to_numpy() == pytest.approx(alpha * 9.80665 / 1.35, rel=1e-6)
    assert house.table["ratio"].to_numpy() == pytest.approx(alpha / 1.35 / 0.06, rel=1e-6)
    assert [check.e_star for check in house.checks.values()] == pytest.approx([1.0] * 4)
    assert (house.verdict.direction, house.governing.notes) == ("−x", ())


def test_an_estimated_effect_may_decide_which_direction_governs(monkeypatch):
    """Along y a block is twice as safe. If a remedy leaves it a fifth, the variants are run there."""

    def noted(run, *, is_estimate=False, hear=None):
        low = 0.2 * run.load_factor if run.case.variable.name == "push +y" else np.nan
        return run.changed(outcome=replace(run.outcome, uniform_torsion=low, estimated=is_estimate))

    monkeypatch.setattr(sys.modules["blockstruct.assess.building"], "with_effects", noted)
    found = checked_building("+x", "+y")
    assert (found.verdict.direction, list(found.analysis.spreads)) == ("+y", ["push +y"])
    assert found.verdict.ratio == pytest.approx(0.2 * 0.5 / 1.35 / 0.06, rel=1e-5)
    assert not found.governing.result.outcome.estimated


def test_the_run_of_a_remedy_is_relied_on_and_drawn(monkeypatch, tmp_path):
    """The check is of the run of the remedy, with its own motion; its range reaches the case as given."""

    def noted(run, *, is_estimate=False, hear=lambda *_: None):
        if run.of_case:
            return run
        low = run.changed(outcome=replace(run.outcome, load_factor=0.9 * run.load_factor))
        hear("uniform_torsion", low)
        return run.changed(outcome=replace(run.outcome, uniform_torsion=low.load_factor, estimated=is_estimate))

    monkeypatch.setattr(sys.modules["blockstruct.assess.building"], "with_effects", noted)
    found = checked_building("+x", "+y")
    verdict, relied = found.verdict, found.governing.governing
    given = found.analysis["push +x"].load_factor
    assert (relied.name, verdict.run) == ("push +x [torsion of uniform pressure]", "torsion of uniform pressure")
    assert relied.load_factor == verdict.governing.alpha == pytest.approx(0.9 * given)
    assert verdict.alphas == pytest.approx((0.9 * given, given))
    assert verdict.relied_on in str(found)
    page = found.report(tmp_path / "block.html").read_text(encoding="utf-8")
    assert "How “push +x [torsion of uniform pressure]” moves" in page


def test_an_interrupted_building_continues_from_its_store(monkeypatch, tmp_path):
    store, begun = tmp_path / "house.h5", []
    run_case = bs.AnalysisManager.run_case

    def counted(self, before, *rest):
        begun.append(before.name)
        if len(begun) in (2, 5):
            raise KeyboardInterrupt
        return run_case(self, before, *rest)

    monkeypatch.setattr(bs.AnalysisManager, "run_case", counted)
    for ended in ("1 run ended (push +x)", "3 runs ended"):
        with pytest.raises(KeyboardInterrupt) as interrupt:
            checked_building("+x", "+y", store=store)
        assert ended in interrupt.value.__notes__[0]
        assert f"{store} keeps" in interrupt.value.__notes__[0]
    found = checked_building("+x", "+y", store=store)
    # Two runs were interrupted, and no other one was made twice.
    assert len(begun) == len(found.analysis) + 2
    again = checked_building("+x", "+y", store=store)
    assert (len(begun), again.verdict.ratio) == (len(found.analysis) + 2, found.verdict.ratio)
    assert found.verdict.ratio == checked_building("+x", "+y").verdict.ratio
    with pytest.raises(bs.errors.StorageError, match="another model"):
        checked_building("-x", store=store)


def test_a_direction_that_has_not_settled_opens_the_verdict_and_leaves_the_lowest_ratio(found):
    """A ratio of 3.5 that had not settled stood above a settled one of 2.2."""
    name = max(found.checks, key=lambda name: found.checks[name].verdict.share)
    result = found.checks[name].result
    # Self-stress of its only free block is a warning of its own.
    drifting = result.changed(outcome=replace(result.outcome, settled=False, jammed=(0,)))
    check = replace(found.checks[name], result=drifting, notes=drifting.notes)
    open_one = replace(found, checks={**found.checks, name: check})
    assert (open_one.verdict.ratio, open_one.verdict.satisfied) == (found.verdict.ratio, False)
    # It would govern if it fell to the ratio that is relied on, from 0.5 to 0.25 here.
    assert ["50%" in str(note) for note in open_one.verdict.open if name in str(note)] == [True, False]
    # Each warning stands once, and names its direction.
    assert len(open_one.verdict.open) == 2


def test_only_the_direction_that_governs_has_its_variants_and_its_history(found, tmp_path):
    name = found.verdict.case
    assert list(found.analysis.spreads) == [name]
    lengths = {n: r.n_iterations for n, r in found.analysis.items() if not r.of_case}
    assert all(length <= 2 for n, length in lengths.items() if n != name)
    assert lengths[name] > 2
    bs.save_analysis(found.analysis, tmp_path / "block.h5")
    assert bs.open_analysis(tmp_path / "block.h5").headlines.keys() == found.analysis.headlines.keys()


def test_a_direction_without_a_load_factor_leaves_the_verdict_open():
    found = checked_building("+x")
    ended = {"push +y": found.analysis["push +x"].changed(outcome=UNSTABLE)}
    more = bs.Analysis(found.analysis.model, {**found.analysis, **ended}, "", {})
    verdict = bs.assess.Building(more, found.checks).verdict
    assert [note.code for note in verdict.open] == ["direction_without"]
    assert not verdict.satisfied
    assert found.verdict.satisfied


def test_print_notebook_and_table_have_the_same_number(found):
    assert str(pickle.loads(pickle.dumps(found))) == str(found)
    title, ratio = f"{found.governing.result.name}: {found.verdict}", found.verdict.state.ratio_text()
    for shown in (str(found), repr(found), found._repr_html_(), found.governing._repr_html_()):
        assert title in shown.replace("&#x27;", "'")
    rows = [row for row in found._repr_html_().split("<tr>") if f"<td>{ratio}</td>" in row]
    assert (len(rows), len(found.table)) == (2, 4)


def test_one_page_has_the_table_and_the_number(found, no_pictures):
    from blockstruct.views.report import report_html

    sizes = bs.assess.unit_sizes(columns, ["1 m", "0.5 m"])
    page = report_html(found.analysis, checks=found.checks.values(), unit_sizes=sizes)
    assert page.count(f"<b>{found.governing.verdict.state.ratio_text()}</b>") == 1
    assert "A fine bond would give about" in page.replace("\u00a0", " ")


def columns(size):
    """A stack whose blocks never part: its load factor does not depend on their size."""
    blocks = bs.wall(length="1 m", height="2 m", unit_length="1 m", unit_height=size, thickness="0.5 m", material=STONE)
    return model_of(blocks, DRY), bs.LimitCase("push", SELF_WEIGHT, push(0, -1, 0))


def test_units_of_any_size_turn_as_one_wall():
    """α0 = 0.5 m / 2 m at every size, so a fine bond gives the same, without scatter."""
    found = bs.assess.unit_sizes(columns, ["0.5 m", "1 m", "0.25 m"])
    assert found.table["size [meter]"].tolist() == [1.0, 0.5, 0.25]
    assert found.table["load factor"].to_numpy() == pytest.approx(0.25, rel=1e-4)
    assert (found.fine, found.scatter) == pytest.approx((0.25, 0.0), abs=1e-4)
    with pytest.raises(bs.errors.ModelError, match="two at least"):
        bs.assess.unit_sizes(columns, ["1 m"])
    check = partial(bs.assess.local_mechanism, spectrum=SITE)
    ratios = bs.assess.unit_sizes(columns, ["1 m", "0.5 m"], check=check)
    assert ratios.fine == pytest.approx(0.25 / 1.35 / 0.06, rel=1e-3)
    assert np.isnan(ratios.scatter)
    assert found.notes == ratios.notes == ()


def test_a_ratio_below_one_with_other_units_leaves_the_verdict_open(found):
    table = pd.DataFrame({"size [meter]": [1.0, 0.5], RATIO: [1.1, 0.9], "settled": True})
    sizes = bs.assess.UnitSizes(RATIO, table, 0.7, np.nan)
    other = checked_building("+x", unit_sizes=sizes)
    assert [note.code for note in other.verdict.open] == ["unit_size"]
    assert (found.verdict.satisfied, other.verdict.satisfied, other.governing.satisfied) == (True, False, False)
    assert other.verdict.ratio == pytest.approx(found.verdict.ratio)
