"""Structures the tests share."""

import gc
import os
import shutil
import sys
from functools import lru_cache
from io import BytesIO

import pytest
from hypothesis import settings
from matplotlib.figure import Figure

import blockstruct as bs
import properties  # noqa: F401 - the profiles of hypothesis
from blockstruct import Q_, cli
from blockstruct.views.figures.sheet import Drawing
from structures import bonded

#: The table of the attack.
pytest_plugins = ("attack_table",)

# Tests start many interpreters: what one has compiled the others need not.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
# An option --hypothesis-profile is read after this.
settings.load_profile("usual")


def pytest_collection_finish():
    """Keep the collector of garbage from modules and tests, which live on: it took a fifth of the time."""
    gc.freeze()


def kind_of(result):
    """Facts of a result on which its sentences depend."""
    model, outcome = result.model, result.outcome
    joints = model.joint_materials.values()
    facts = (type(result.case), result.case.flow, outcome.status, outcome.reason, outcome.procedure, outcome.settled)
    facts += (outcome.path_end, bool(result.hung), bool(result.jammed), bool(model.ties))
    return (*facts, frozenset((j.torsion, j.compressive_strength < float("inf")) for j in joints))


@pytest.fixture(scope="session", autouse=True)
def _describes_every_result(pytestconfig):
    """Describe every kind of result that tests find, whatever its structure; with slow tests every result."""
    run, known = bs.AnalysisManager._run, set()
    every = pytestconfig.option.markexpr != "not slow"

    def described(self, *args, **keywords):
        analysis = run(self, *args, **keywords)
        # A result in a file is read at its first use, which tests observe.
        for result in () if self.store else analysis.values():
            kind = kind_of(result)
            assert (kind in known and not every) or result.describe()
            known.add(kind)
        return analysis

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bs.AnalysisManager, "_run", described)
        yield


@pytest.fixture(autouse=True)
def _confirmed(request, monkeypatch):
    """Whatever a procedure or a motion finds must stand the checks of a file."""
    run = bs.AnalysisManager.run

    def checked(manager, *args, **options):
        analysis = run(manager, *args, **options)
        assert bs.results.contradictions(analysis) == []
        return analysis

    if request.path.parent.name in ("motion", "procedures"):
        monkeypatch.setattr(bs.AnalysisManager, "run", checked)


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
    blocks = bonded(2, 3, material=tuff)
    found = bs.detect_interfaces(blocks, joint_material=dry)
    return bs.Model("small wall", blocks, found.interfaces, detection=found.report)


@pytest.fixture(scope="session")
def small_cases(dead: bs.LoadPattern) -> list[bs.LimitCase]:
    loads = [bs.BodyForce((1, 0, 0)), bs.PointLoad("3.1", ["0.2 m", "0.1 m", "0.6 m"], ["10 N", "0 N", "0 N"])]
    push = bs.LoadPattern("push", loads)
    return [bs.LimitCase(f"push {flow}", dead, push, flow) for flow in bs.Flow]


@pytest.fixture(scope="session")
def small_analysis(small_model: bs.Model, small_cases: list[bs.LimitCase]) -> bs.Analysis:
    return bs.AnalysisManager(small_model).run(small_cases)


@pytest.fixture(scope="session")
def every_schedule(small_model: bs.Model, dead: bs.LoadPattern) -> bs.Analysis:
    """The small wall by every schedule, which takes seconds."""
    case = bs.LimitCase("push", dead, bs.LoadPattern("push", [bs.BodyForce((1, 0, 0))]))
    return bs.AnalysisManager(small_model).run([case], spread=["path", "paper"])


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


@pytest.fixture
def done(call):
    """Call the command, which ends without an error; gives standard output."""

    def run(*words):
        code, out, err = call(*words)
        assert code == 0, err
        return out

    return run


@pytest.fixture
def fails(call):
    """Call the command, which ends with exit code 2 and a message with some words; gives standard error."""

    def run(words, *command):
        code, _, err = call(*command)
        assert code == 2, err
        assert words in " ".join(err.split()), err
        return err

    return run


@pytest.fixture
def blank_pictures(monkeypatch):
    """Pictures of a report are drawn, and take their place on its pages, but are not turned into pixels."""
    plain = Drawing.picture

    def blank(drawing, *of_a_file):
        if of_a_file:
            return plain(drawing, *of_a_file)
        drawing.draw(Figure(figsize=drawing.size).add_subplot(projection=drawing.projection))
        return white(drawing.size)

    monkeypatch.setattr(Drawing, "picture", blank)


@pytest.fixture
def no_pictures(monkeypatch):
    """Pictures of a report are blank, and not even drawn: for tests of its texts."""
    monkeypatch.setattr(Drawing, "picture", lambda drawing: white(drawing.size))


@lru_cache
def white(size):
    stream = BytesIO()
    Figure(figsize=size).savefig(stream, format="png", dpi=200)
    return stream.getvalue()


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
