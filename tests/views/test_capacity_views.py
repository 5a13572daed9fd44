"""A pushover in the figures, in the page and in ParaView."""

import base64
import zlib
from xml.etree import ElementTree

import attrs
import numpy as np
import pytest
from test_page import opened, settle, slide

import blockstruct as bs
from blockstruct.views import figures, result_text
from blockstruct.views.page import write_page
from blockstruct.views.page.payload import payload
from blockstruct.views.paraview import write_paraview
from refusals import refused
from structures import SELF_WEIGHT, model_of, push, single_block

pv = pytest.importorskip("pyvista")


@pytest.fixture(scope="module")
def analysis():
    blocks, joint = single_block(0.3, 1.5, mu=2.0)
    control = ("block", (1, 0, 0))
    cases = [
        bs.Pushover("push", dead=SELF_WEIGHT, variable=push(1, 0, 0), control=control, steps=8),
        bs.LimitCase("plain", SELF_WEIGHT, push(1, 0, 0)),
    ]
    return bs.AnalysisManager(model_of(blocks, joint)).run(cases)


def test_figure(analysis):
    ax = figures.capacity(analysis["push"], label="block")
    curve = analysis["push"].capacity
    np.testing.assert_allclose(ax.lines[0].get_ydata(), curve["load_factor"])
    np.testing.assert_allclose(ax.lines[0].get_xdata(), curve["displacement"])
    assert ax.texts[0].get_text() == "d0 = 0.15 m"
    assert "capacity" in [d.name for d in figures.drawings(analysis["push"])]
    assert "capacity" not in [d.name for d in figures.drawings(analysis["plain"])]


def test_a_case_without_a_curve_says_why(analysis, tmp_path, call):
    with refused(bs.errors.ModelError, "'plain' Pushover"):
        figures.capacity(analysis["plain"])
    with refused(bs.errors.ModelError, "NoneType result.capacity"):
        bs.results.capacity_frame(analysis["plain"].capacity)
    case = attrs.evolve(analysis["push"].case, control=("block", (0, 1, 0)))
    found = bs.AnalysisManager(analysis.model, tmp_path / "rests.h5").run([case])
    with refused(bs.errors.ModelError, "(0, 1, 0) (0.981, 0, 0.196)"):
        figures.capacity(found["push"])
    code, _, err = call("history", tmp_path / "rests.h5", "push", "--pushover")
    assert (code, "--pushover: case 'push': " in " ".join(err.split())) == (2, True)
    assert found["push"].missing_curve in result_text(found["push"]).plain


def test_the_page_has_the_blocks_where_they_are(analysis):
    data = payload(analysis)
    pushed, plain = data["cases"]
    assert "pushover" not in plain
    curve = analysis["push"].capacity
    assert pushed["pushover"]["load_factor"] == curve["load_factor"].to_numpy().tolist()
    raw = zlib.decompress(base64.b64decode(pushed["pushover"]["motion"]))
    motion = np.frombuffer(raw, "<f4").reshape(curve.sizes["step"], 2, 12)
    # At the end the block has turned about its edge (0.3, y, 0) until its centroid is above it.
    R, c = motion[-1, 1, :9].reshape(3, 3), motion[-1, 1, 9:]
    np.testing.assert_allclose(c, [0.3, 0.5, np.hypot(0.15, 0.75)], atol=1e-4)
    np.testing.assert_allclose(c + R @ [0.15, 0, -0.75], [0.3, 0.5, 0], atol=1e-4)


def test_paraview(analysis, tmp_path):
    target = write_paraview(analysis["push"], tmp_path / "push.pvd")
    curve = analysis["push"].capacity
    listed = ElementTree.parse(tmp_path / "push-pushover.pvd").findall(".//DataSet")
    assert [int(e.get("timestep")) for e in listed] == list(range(curve.sizes["step"]))
    last = pv.read(tmp_path / listed[-1].get("file"))
    control = last.field_data["displacement of the control point [meter]"]
    assert control == pytest.approx(float(curve["displacement"][-1]))
    moved = last.points - last.point_data["displacement [meter]"]
    np.testing.assert_allclose(moved.max(axis=0), [1.3, 2, 1.5], atol=1e-6)
    assert target.exists()
    write_paraview(analysis["plain"], tmp_path / "push.pvd")
    assert not (tmp_path / "push-pushover.pvd").exists()
    assert not list((tmp_path / "push").glob("pushover-*"))


def test_the_page_shows_a_step(browser, analysis, tmp_path):
    with opened(browser, write_page(analysis, tmp_path / "page.html")) as page:
        last = analysis["push"].capacity.sizes["step"] - 1
        assert page.locator("#step-value").text_content() == f"of {last}"
        assert all(part.is_hidden() for part in page.locator(".of-ties").all())
        slide(page, "step", last)
        assert page.locator("#step-value").text_content() == f"{last} of {last}, 150 mm, α = 0"
        # The mechanism is shown again, and no step.
        slide(page, "amplitude", 0.1)
        assert page.locator("#step-value").text_content() == f"of {last}"
        page.select_option("#case", "1")
        settle(page)
        assert page.locator("#pushover").is_hidden()
