"""Checks of local mechanisms from the command line."""

import pytest

import blockstruct as bs
from blockstruct.cli.verification import demand_of
from structures import SELF_WEIGHT, box, model_of, push, single_block

SITE = "ag=0.15 g_0, F0=2.4, Tc=0.3 s, soil=B"
MODE = "T=0.4 s, participation=1.3, shape=0.9, damping=0.1"

#: What they show is tested with the views.
pytestmark = pytest.mark.usefixtures("blank_pictures")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    cases = [
        bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0)),
        bs.LimitCase("down", SELF_WEIGHT, bs.LoadPattern("more weight", push(0, 0, -1).loads)),
    ]
    found = bs.run(model_of(*single_block(0.4, 4.0)), cases)
    return bs.save_analysis(found, tmp_path_factory.mktemp("runs") / "block.h5")


def test_every_case_with_a_load_factor_is_checked(done, file):
    out = done("assess", file, "--spectrum", SITE, "--confidence-factor", "1.35")
    assert out.count("relied on: SLV, linear: capacity / demand = 0.823, not satisfied") == 1
    assert "[C8.7.1.2.1.5 (C8.7.1.8)]" in out
    assert "down" not in out.replace("down to", "")
    out = done("assess", file, "--spectrum", SITE, "--case", "rocks", "--method", "displacement")
    assert "relied on: SLV, by displacement" in out


def test_a_site_and_modes_are_read_from_texts(done, file):
    ground = bs.assess.ntc_spectrum("0.15 g_0", 2.4, "0.3 s", "B", "T2")
    mode = bs.assess.Mode("0.4 s", participation=1.3, shape=0.9, damping=0.1)
    assert demand_of(f"{SITE}, topography=T2", [MODE, MODE]) == bs.assess.floor_spectrum(ground, [mode, mode])
    words = ("--spectrum", SITE, "--mode", MODE, "--case", "rocks", "--knowledge-level", "LC1")
    out = done("assess", file, *words)
    assert "largest acceleration at z" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--spectrum", "ag=0.15 g_0"], "no F0, Tc, soil"),
        (["--spectrum", f"{SITE}, soils=C"], "did you mean soil?"),
        (["--spectrum", SITE.replace("0.15 g_0", "0.15")], "as in '0.15 g_0'"),
        (["--spectrum", SITE, "--mode", "T=0.4 s"], "--mode 'T=0.4 s': no participation, shape"),
        (["--spectrum", SITE, "--mode", MODE.replace("0.9", "top")], "shape=top is not a number"),
        (["--spectrum", SITE, "--case", "down"], "--case 'down': unbounded, without a load factor to check"),
        (["--spectrum", SITE, "--confidence-factor", "1"], "1.35"),
    ],
)
def test_refused_checks_are_one_message(fails, file, words, message):
    fails(message, "assess", file, *words)


def test_options_of_a_check_without_a_site_are_refused(fails, file, tmp_path):
    words = ["--confidence-factor", "1.35", "--mode", MODE, "--method", "linear", "--case", "rocks"]
    err = fails("--spectrum", "report", file, "-o", tmp_path / "r.html", *words)
    assert [word for word in words if word.startswith("--") and word not in err] == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["assess", pytest.param("report", marks=pytest.mark.slow)])
def test_cases_without_a_check_by_displacement_do_not_hide_those_with_one(call, done, tmp_path, command):
    """Two bodies move against each other, which has no straight curve: the pushover beside has one, and is named."""
    blocks = [box("ground", [-1, 0, -1], [6, 1, 1], fixed=True), box("tall", [0, 0, 0], [0.5, 1, 2])]
    blocks += [box("low", [0.5, 0, 0], [0.5, 1, 1])]
    case = bs.LimitCase("two bodies", SELF_WEIGHT, push(1, 0, 0))
    pushed = bs.Pushover("pushed", SELF_WEIGHT, push(1, 0, 0), control=("tall", "+x"), steps=10)
    file = tmp_path / "both.h5"
    bs.run(model_of(blocks, bs.JointMaterial("joint", 0.6)), [case, pushed], file, progress=False)
    target = ("-o", tmp_path / "r.html") if command == "report" else ()
    words = (command, file, *target, "--spectrum", SITE, "--confidence-factor", "1.35", "--method", "displacement")
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert "case 'two bodies': no capacity curve: 2 bodies move" in err
    assert "no check of two bodies; the other cases have one: --case 'pushed'" in err
    done(*words, "--case", "pushed")


def test_settlements_and_cases_that_fall_are_named_and_not_checked(call, fails, done, tmp_path):
    model = model_of(*single_block(0.4, 4.0))
    away = bs.LoadPattern("away", [bs.SelfWeight(), bs.BodyForce((1, 0, 0), share=0.2)])
    cases = {
        "settles": bs.SettlementCase("settles", SELF_WEIGHT, ["ground"], "-z", flow="associative"),
        "rocks": bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0)),
        "falls": bs.LimitCase("falls", away, push(1, 0, 0)),
    }

    def stored(*names):
        ran = bs.run(model, [cases[name] for name in names])
        return bs.save_analysis(ran, tmp_path / f"{'-'.join(names)}.h5")

    words = ("--spectrum", SITE, "--knowledge-level", "LC1")
    both, target = stored("settles", "rocks"), tmp_path / "r.html"
    out = done("assess", both, *words)
    assert out.startswith("not checked: settles (a settlement has no push)\n")
    assert out.count("relied on: SLV, linear") == 1
    assert "not checked: settles" in done("report", both, "-o", target, *words)
    assert "capacity / demand 0.823 of “rocks”" in target.read_text(encoding="utf-8")
    done("report", both, "-o", target, *words, "--case", "rocks")
    fails("case 'settles': a SettlementCase has no push", "assess", both, *words, "--case", "settles")
    fails("(settles: a settlement has no push)", "assess", stored("settles"), *words)
    code, out, _ = call("assess", stored("rocks", "falls"), *words)
    assert code == 3
    assert "not checked without a load factor: falls (unstable under dead load)" in " ".join(out.split())


def test_a_model_document_gives_one_verdict_and_a_report(fails, done, tmp_path):
    """The block of the file, in two directions: the verdict of the weaker one, the same in print and on the page."""
    case = bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0))
    model = bs.write_document(tmp_path / "block.yaml", model_of(*single_block(0.4, 4.0)), [case])
    words = ("--spectrum", SITE, "--knowledge-level", "LC1", "--direction", "+x", "--direction", "+y")
    out = done("assess", model, *words, "-o", tmp_path / "r.html")
    assert "push +x: SLV, linear: capacity / demand = 0.823, not satisfied" in out
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "Relied on: capacity / demand 0.823 of “push +x” (SLV, linear)" in page
    fails("give --direction for a model document", "assess", model, *words, "--case", "rocks")
