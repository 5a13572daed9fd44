"""Ties, settlements, carried loads and directions in one document: written, read, run and stored."""

import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.documents import read_document, write_document
from blockstruct.model import direction_cases
from structures import box, model_of, push

#: Height of the tie over the foot of the wall, m.
Z = 2.8


@pytest.fixture(scope="module")
def model():
    """A wall of three blocks, 0.5 m thick, tied to a pier."""
    blocks = [
        box("ground", [-2, 0, -1], [5, 1, 1], fixed=True),
        box("pier", [-1.5, 0, 0], [0.5, 1, 3], fixed=True),
        *(box(f"wall {k}", [0, 0, k], [0.5, 1, 1]) for k in range(3)),
    ]
    tie = bs.Tie(
        "tie", ("pier", f"[-1, 0.5, {Z}] m"), ("wall 2", f"[0, 0.5, {Z}] m"), yield_force="4 kN", prestress="1 kN"
    )
    return model_of(blocks, bs.JointMaterial("joint", 0.6), "tied").with_ties([tie])


@pytest.fixture(scope="module")
def dead():
    """The weight of the wall, and a roof of 10 kN on its middle."""
    roof = bs.LineLoad("10 kN/m", start=["0.25 m", "0 m", "3 m"], end=["0.25 m", "1 m", "3 m"])
    return bs.LoadPattern("dead", [bs.SelfWeight(), roof])


@pytest.fixture(scope="module")
def cases(dead):
    away = bs.SettlementCase("pier spreads", dead, ["pier"], "-x", flow="associative")
    return [*direction_cases(dead, Q_([0, 180], "deg"), flow="associative"), away]


def test_load_factors_equal_hand_calculations(model, dead, cases):
    """Overturning about either edge of the foot, with the mass of the roof, and with the tie or its prestress."""
    analysis = bs.run(model, cases)
    overturning = 30 * 1.5 + 10 * 3
    assert analysis["push 0 deg"].load_factor == pytest.approx((40 * 0.25 + 4 * Z) / overturning, rel=1e-6)
    assert analysis["push 180 deg"].load_factor == pytest.approx((40 * 0.25 - 1 * Z) / overturning, rel=1e-6)
    # The pier can pull the wall over by less than the tie bears.
    assert analysis["pier spreads"].reaction.m_as("kN") == pytest.approx(-40 * 0.25 / Z, rel=1e-6)


def test_the_least_tie_force_includes_the_push_on_the_roof(model, dead):
    case = bs.LimitCase("push", dead, push(1, 0, 0))
    least = bs.ties.least_tie_force(model, case, ["tie"], load_factor=0.5)
    assert least.proven
    assert least.total == pytest.approx(1e3 * (0.5 * (30 * 1.5 + 10 * 3) - 40 * 0.25) / Z, rel=1e-6)


def test_documents_and_files_keep_everything(model, cases, tmp_path):
    read = read_document(write_document(tmp_path / "tied.yaml", model, cases))
    assert (read.model.ties, read.cases, read.model.hash) == (model.ties, tuple(cases), model.hash)
    made = bs.run(read.model, read.cases, store=tmp_path / "tied.h5")
    kept = bs.open_analysis(tmp_path / "tied.h5")
    assert kept.cases == tuple(cases)
    assert all(str(kept[name].headline) == str(made[name].headline) for name in kept)
    assert all(kept[name].ties.equals(made[name].ties) for name in kept)
