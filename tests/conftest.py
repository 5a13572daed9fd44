"""Structures the tests share."""

import os
import shutil
import sys

import pytest
from hypothesis import settings

import blockstruct as bs
import properties  # noqa: F401 - the profiles of hypothesis
from blockstruct import Q_, cli

# An option --hypothesis-profile is read after this.
settings.load_profile("usual")


@pytest.fixture(scope="session")
def tuff() -> bs.Material:
    return bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))


@pytest.fixture(scope="session")
def dry() -> bs.JointMaterial:
    return bs.JointMaterial("dry", friction_coefficient=0.65)


@pytest.fixture(scope="session")
def dead() -> bs.LoadPattern:
    return bs.LoadPattern("dead", [bs.SelfWeight()])


@pytest.fixture(scope="session")
def small_model(tuff: bs.Material, dry: bs.JointMaterial) -> bs.Model:
    rows = [[1, 1], [0.5, 1, 0.5], [1, 1]]
    blocks = bs.courses(rows, unit_length="0.4 m", unit_height="0.2 m", depth="0.2 m", material=tuff)
    found = bs.detect_interfaces(blocks, joint_material=dry)
    return bs.Model("small wall", blocks, found.interfaces, detection=found.report)


@pytest.fixture(scope="session")
def small_cases(dead: bs.LoadPattern) -> list[bs.LimitCase]:
    push = bs.LoadPattern(
        "push", [bs.BodyForce((1, 0, 0)), bs.PointLoad("3.1", ["0.2 m", "0.1 m", "0.6 m"], ["10 N", "0 N", "0 N"])]
    )
    return [bs.LimitCase(f"push {flow}", dead, push, flow) for flow in bs.Flow]


@pytest.fixture(scope="session")
def small_analysis(small_model: bs.Model, small_cases: list[bs.LimitCase]) -> bs.Analysis:
    return bs.AnalysisManager(small_model).run(small_cases)


@pytest.fixture
def call(monkeypatch, capsys):
    """Call the command; gives exit code, standard output and standard error."""

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["blockstruct", *map(str, words)])
        with pytest.raises(SystemExit) as stop:
            cli.main()
        captured = capsys.readouterr()
        return stop.value.code or 0, captured.out, captured.err

    return run


def chromium():
    named = os.environ.get("BLOCKSTRUCT_CHROMIUM")
    return named or next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@pytest.fixture(scope="session")
def browser():
    path = chromium()
    if path is None:
        pytest.skip("no Chromium: apt install chromium, or name one in BLOCKSTRUCT_CHROMIUM")
    from playwright.sync_api import sync_playwright

    # WebGL without a graphics card, and as root in a container.
    options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as play:
        found = play.chromium.launch(executable_path=path, args=options)
        yield found
        found.close()
