"""Checks of local mechanisms from the command line."""

import pytest

import blockstruct as bs
from blockstruct.cli.verification import demand_of
from structures import SELF_WEIGHT, model_of, push, single_block

SITE = "ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B"
MODE = "T=0.4 s, participation=1.3, shape=0.9, damping=0.1"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    blocks, joint = single_block(0.4, 4.0)
    cases = [
        bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0)),
        bs.LimitCase("down", SELF_WEIGHT, bs.LoadPattern("more weight", push(0, 0, -1).loads)),
    ]
    path = tmp_path_factory.mktemp("runs") / "block.h5"
    return bs.save_analysis(bs.AnalysisManager(model_of(blocks, joint)).run(cases), path)


def test_a_site_is_read_from_a_text():
    assert demand_of(f"{SITE}, topography=T2") == bs.assess.ntc_spectrum("0.15 g_0", 2.4, "0.3 s", "B", "T2")


def test_every_case_with_a_load_factor_is_checked(call, file):
    code, out, err = call("assess", file, "--spectrum", SITE, "--confidence-factor", "1.35")
    assert code == 0, err
    assert out.count("relied on: SLV, linear: capacity / demand = 0.823, not satisfied") == 1
    assert "[C8.7.1.2.1.5 (C8.7.1.8)]" in out
    assert "down" not in out.replace("down to", "")
    code, out, _ = call("assess", file, "--spectrum", SITE, "--case", "rocks", "--method", "displacement")
    assert code == 0
    assert "relied on: SLV, by displacement" in out


def test_modes_of_the_building_give_the_spectrum_at_a_height(call, file):
    ground = bs.assess.ntc_spectrum("0.15 g_0", 2.4, "0.3 s", "B")
    mode = bs.assess.Mode("0.4 s", participation=1.3, shape=0.9, damping=0.1)
    assert demand_of(SITE, [MODE, MODE]) == bs.assess.floor_spectrum(ground, [mode, mode])
    words = ("--spectrum", SITE, "--mode", MODE, "--case", "rocks", "--knowledge-level", "LC1")
    code, out, err = call("assess", file, *words)
    assert code == 0, err
    assert "largest acceleration at z" in out
    code, _, err = call("report", file, "--mode", MODE)
    assert code == 2
    assert "give --spectrum, too" in err


def test_the_report_has_the_check(call, file, tmp_path):
    target = tmp_path / "r.html"
    code, _, err = call("report", file, "-o", target, "--spectrum", SITE, "--knowledge-level", "LC1")
    assert code == 0, err
    assert "Relied on: capacity / demand 0.823 of “rocks” (SLV, linear)" in target.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--spectrum", "ag=0.15 g_0"], "no F0, Tc, soil"),
        (["--spectrum", f"{SITE}, soils=C"], "did you mean soil?"),
        (["--spectrum", SITE.replace("2.4", "many")], "F0=many is not a number"),
        (["--spectrum", SITE.replace("0.15 g_0", "0.15")], "as in '0.15 g_0'"),
        (["--spectrum", SITE, "--mode", "T=0.4 s"], "--mode 'T=0.4 s': no participation, shape"),
        (["--spectrum", SITE, "--mode", MODE.replace("0.9", "top")], "shape=top is not a number"),
        (["--spectrum", SITE, "--case", "rock"], "did you mean rocks?"),
        (["--spectrum", SITE, "--case", "down"], "no case has a load factor to check"),
        (["--spectrum", SITE, "--confidence-factor", "1"], "FC is 1.35"),
    ],
)
def test_what_is_no_check_is_one_message(call, file, words, message):
    code, _, err = call("assess", file, *words)
    assert code == 2
    assert message in err


def test_a_factor_without_a_site_is_refused(call, file):
    code, _, err = call("report", file, "--confidence-factor", "1.35")
    assert code == 2
    assert "give --spectrum, too" in err
