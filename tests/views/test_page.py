"""The interactive page: its data, and its behaviour in a real browser."""

import base64
import json
import re
import zlib
from contextlib import contextmanager

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.results import is_pressed
from blockstruct.views.page import NotebookPage, page_html, write_page
from blockstruct.views.page.html import payload
from blockstruct.views.solids import Solids, load_arrows
from blockstruct.views.style import AMPLITUDE
from blockstruct.views.words import spread_words
from refusals import refused
from structures import SELF_WEIGHT, box, model_of, moved, push, single_block, stopping

#: Traces of the scene.
BLOCKS, FORCES, VARIABLE = 1, 5, 10
HOSTILE = "</script><b>wall</b> ’ü 墙 @data@"


@pytest.fixture(scope="module")
def analysis(small_model):
    model = bs.Model(HOSTILE, small_model.blocks, small_model.interfaces)
    cases = [bs.LimitCase(f"<i>{flow}</i>", SELF_WEIGHT, push(1, 0, 0), flow) for flow in bs.Flow]
    return bs.AnalysisManager(model).run(cases)


@pytest.fixture(scope="module")
def html(analysis):
    return page_html(analysis)


@pytest.fixture(scope="module")
def data(html):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', html, re.DOTALL)[1])


def unpacked(text, kind, *shape):
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=kind).reshape(shape).astype(float)


def test_the_page_holds_the_numbers_of_every_iteration(analysis, data):
    model = analysis.model
    assert data["name"] == HOSTILE
    assert data["interfaces"]["name"] == [i.name for i in model.interfaces]
    vertices = unpacked(data["blocks"]["vertices"], "<f4", -1, 3)
    np.testing.assert_allclose(vertices, np.concatenate([b.shape.vertices for b in model.blocks]), rtol=1e-6)
    for case, result in zip(data["cases"], analysis.values(), strict=True):
        n, count = result.n_iterations, len(model.interfaces)
        assert case["answers"] == result.history.load_factor.to_numpy().tolist()
        # Small forces beside large ones, too.
        np.testing.assert_allclose(unpacked(case["force"], "<f4", n, count, 3), result.resultants.force, rtol=1e-6)
        states = np.array(case["states"])[unpacked(case["state"], "<u2", n, count).astype(int)]
        np.testing.assert_array_equal(states, result.states.to_numpy())


def test_the_page_has_the_loads():
    """Dead load besides the weight of the blocks, variable load; each to its own largest force, at its block."""
    model = model_of(*single_block(0.4, 0.8))
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.AreaLoad("4 kPa", block="block")])
    pushed = bs.LimitCase("push", dead, push(1, 0, 0), "associative")
    settles = bs.SettlementCase("sinks", dead, ["ground"], "-z", flow="associative")
    of_push, of_settlement = payload(bs.run(model, [pushed, settles]))["cases"]
    assert "Pushed weight: 6.4 kN masonry + 1.6 kN area loads" in of_push["loads"]
    (down,), (_, sideways) = of_settlement["arrows"], of_push["arrows"]
    assert (down["grows"], sideways["grows"]) == (False, True)
    np.testing.assert_allclose(unpacked(down["vector"], "<f4", -1, 3), [[0, 0, -1]])
    assert unpacked(down["point"], "<f4", -1, 3)[0, 2] == pytest.approx(0.8)
    vectors = unpacked(sideways["vector"], "<f4", -1, 3)
    assert np.linalg.norm(vectors, axis=1).max() == pytest.approx(1)
    assert (vectors[:, 0] > 0).all()
    assert {model.blocks[k].name for k in sideways["block"]} == {"block"}


def test_the_page_asks_nothing_of_the_network(html):
    bare = re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL)
    assert "default-src 'none'" in bare
    assert [word for word in ("http://", "https://", "<b>wall") if word in bare] == []


def test_the_page_is_written_whole_or_not_at_all(analysis, small_model, tmp_path):
    target = write_page(analysis, tmp_path / "page.html")
    assert target.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]
    with refused(bs.errors.StorageError, "page.html written"):
        write_page(analysis, tmp_path / "nowhere" / "page.html")

    case = bs.LimitCase("case", SELF_WEIGHT, push(1, 0, 0))
    cut = bs.AnalysisManager(small_model, listeners=[stopping()]).run([case])
    with refused(bs.errors.ModelError, "iteration interrupted"):
        page_html(cut)


@pytest.fixture(scope="module")
def surveyed():
    """A block in the coordinates of a survey, pushed sideways and pressed down."""
    blocks, joint = single_block(0.4, 0.8)
    model = model_of(moved(blocks, np.eye(3), (4.5e6 + 0.123, -300, 0)), joint)
    sideways, down = push(1, 0, 0), bs.LoadPattern("press", [bs.BodyForce((0, 0, -1))])
    cases = [bs.LimitCase(load.name, SELF_WEIGHT, load, "associative") for load in (sideways, down)]
    return bs.AnalysisManager(model).run(cases)


def test_places_are_kept_far_from_the_origin(surveyed):
    data = payload(surveyed)
    assert data["origin"] == [4.5e6, -300, 0]
    vertices = unpacked(data["blocks"]["vertices"], "<f4", -1, 3) + data["origin"]
    expected = np.concatenate([b.shape.vertices for b in surveyed.model.blocks])
    np.testing.assert_allclose(vertices, expected, rtol=0, atol=1e-6)
    assert payload(surveyed)["blocks"]["size"] == pytest.approx(3)


def test_the_page_has_the_spread_of_a_case(small_model):
    """The number of every run is that of the case as given, which is opened first."""
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    analysis = bs.AnalysisManager(small_model).run([case], spread="half steps")
    spread, data = analysis.spread("push"), payload(analysis)
    assert (data["first"], data["cases"][0]["name"]) == (0, "push")
    assert {case["head"]["number"] for case in data["cases"]} == {spread.headline.number}
    assert all(spread_words(spread) in case["head"]["below"] for case in data["cases"])


@contextmanager
def opened(browser, target):
    """The page, drawn; on leaving, without errors and requests."""
    errors, requests = [], []
    page = browser.new_page(viewport={"width": 1200, "height": 800})
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: requests.append(request.url))
    page.goto(target.as_uri())
    settle(page)
    yield page
    page.close()
    assert errors == []
    assert requests == [target.as_uri()]


@pytest.fixture(scope="module")
def opened_once(browser, analysis, tmp_path_factory):
    with opened(browser, write_page(analysis, tmp_path_factory.mktemp("page") / "page.html")) as page:
        page.evaluate(
            "window.asOpened = Array.from(document.querySelectorAll('input, select'), e => [e, e.value, e.checked])"
        )
        yield page


@pytest.fixture
def page(opened_once):
    """The page as it was when it was opened: to load it takes seconds."""
    yield opened_once
    opened_once.evaluate(
        """() => window.asOpened.forEach(([e, value, checked]) => {
            if (e.value === value && e.checked === checked) return;
            Object.assign(e, { value, checked });
            ['input', 'change'].forEach(kind => e.dispatchEvent(new Event(kind)));
        })"""
    )
    settle(opened_once)


def slide(page, name, value):
    page.evaluate(
        "([name, value]) => { const e = document.getElementById(name); e.value = value; "
        "e.dispatchEvent(new Event('input')); }",
        [name, value],
    )
    settle(page)


def settle(page):
    """Wait until the picture is drawn."""
    page.wait_for_selector("body[data-ready=yes]", timeout=60_000)


def coordinates(page, trace):
    values = page.evaluate(f"['x', 'y', 'z'].map(c => Array.from(document.getElementById('view').data[{trace}][c]))")
    return np.array(values, dtype=float).T


def test_the_sliders_move_the_blocks(page, analysis):
    model, result = analysis.model, next(iter(analysis.values()))
    still = np.concatenate([b.shape.vertices for b in model.blocks])
    size = np.ptp(still, axis=0).max()

    def middles():
        return (coordinates(page, BLOCKS) - still).reshape(len(model.blocks), 8, 3).mean(axis=1)

    # As it is opened: names are text and never markup.
    assert page.inner_text("#name") == HOSTILE
    assert page.inner_text("#case option:first-child") == "<i>associative</i>"
    assert page.inner_text("#load-factor") == f"{result.load_factor:.4g}"
    assert page.evaluate("document.getElementById('view').data[1].opacity") == 1
    unit = size / np.linalg.norm(Solids.of(model).displacement(result, -1), axis=1).max()
    np.testing.assert_allclose(middles(), AMPLITUDE * unit * result.mechanism.translation, atol=2e-3 * size)
    slide(page, "amplitude", "0")
    np.testing.assert_allclose(coordinates(page, BLOCKS), still, atol=1e-6)
    slide(page, "amplitude", "0.1")
    np.testing.assert_allclose(middles(), 0.1 * unit * result.mechanism.translation, atol=2e-3 * size)
    slide(page, "case", "1")
    n = list(analysis.values())[1].n_iterations
    assert page.inner_text("#iteration-value").startswith(f"{n - 1} of {n - 1}, admissible")
    last = coordinates(page, BLOCKS)
    slide(page, "iteration", "0")
    assert page.inner_text("#iteration-value").startswith(f"0 of {n - 1}, associative")
    assert np.abs(coordinates(page, BLOCKS) - last).max() > 1e-4


def test_the_toolbar_has_no_button_that_sends_anything(page):
    titles = page.evaluate("Array.from(document.querySelectorAll('.modebar-btn'), b => b.dataset.title)")
    # Some versions of plotly write png in small letters.
    expected = "download plot as a png, zoom, pan, orbital rotation, turntable rotation, reset camera to default"
    assert ", ".join(titles).lower() == expected


def test_a_click_picks_a_block_and_a_name_picks_an_interface(page, analysis):
    box = page.locator("#view").bounding_box()
    # Within the front of 1.1, off its edges.
    x, y = box["x"] + 0.36 * box["width"], box["y"] + 0.55 * box["height"]
    # The scene looks for what is below the mouse a frame after a move: without a graphics card that takes a while.
    for attempt in range(20):
        page.mouse.move(x + attempt % 3, y, steps=3)
        page.wait_for_timeout(300)
        page.mouse.click(x + attempt % 3, y, delay=200)
        if page.locator("#picked td").count():
            break
    text = page.inner_text("#picked")
    assert text.startswith("block\t1.1\nmaterial\ttuff\n")
    assert f"weight\t{analysis.model.block('1.1').weight:.3g} N" in text
    choose(page, "find", "base|1.1")
    N = float(next(iter(analysis.values())).resultants.force.sel(component="n", interface="base|1.1")[-1])
    assert f"N\t{N:.3g} N" in page.inner_text("#picked")


def test_loads_can_be_shown(page, analysis):
    page.check("#show-loads")
    (arrows,) = load_arrows(next(iter(analysis.values())))
    slide(page, "amplitude", "0")
    np.testing.assert_allclose(coordinates(page, VARIABLE).reshape(-1, 7, 3)[:, 1], arrows.point, atol=1e-5)
    page.uncheck("#show-loads")


def test_resultants_and_colours_can_be_chosen(page, analysis):
    page.check("#show-forces")
    settle(page)
    result = next(iter(analysis.values()))
    assert len(coordinates(page, FORCES)) == 3 * int(is_pressed(result.history, result.resultants)[-1].sum())
    slide(page, "colour", "sliding")
    shades = page.evaluate("Array.from(document.getElementById('view').data[3].intensity)")
    expected = bs.results.utilisation(result.history).sliding.isel(iteration=-1).to_numpy()
    np.testing.assert_allclose(np.array(shades, dtype=float), np.repeat(expected, 2), rtol=1e-3, atol=1e-6)


def test_macro_blocks_are_coloured_and_named(page, analysis):
    page.check("#show-bodies")
    settle(page)
    moving = [body for body in next(iter(analysis.values())).macro_blocks if body.moves]
    assert page.inner_text("#bodies").startswith("body 1, ")
    choose(page, "find", moving[0].blocks[0])
    assert "macro-block\tbody 1" in page.inner_text("#picked")
    page.uncheck("#show-bodies")


def choose(page, name, value):
    page.fill(f"#{name}", value)
    page.keyboard.press("Enter")
    settle(page)


@pytest.mark.slow
def test_long_names_stay_within_the_panel(browser, tmp_path):
    """Names without a blank to break them at, as of patterns, blocks, joints and ties."""

    def long(what):
        return f"{what}_{'senza_spazi_nel_nome_' * 5}"

    ground, wall = long("suolo"), long("muro")
    blocks = [box(ground, [-1, -1, -1], [4, 3, 1], fixed=True), box(wall, [0, 0, 0], [0.4, 1, 2])]
    tie = bs.Tie(long("catena"), (ground, "[2, 0.5, 0] m"), (wall, "[0.4, 0.5, 1.5] m"), yield_force="1 kN")
    model = model_of(blocks, bs.JointMaterial(long("malta"), 0.6), name=long("casa")).with_ties([tie])
    dead = bs.LoadPattern(long("permanenti"), [bs.SelfWeight(), bs.Weight(wall, "[0.2, 0.5, 2] m", "1 kN")])
    case = bs.LimitCase(long("ribaltamento"), dead, bs.LoadPattern(long("spinta"), [bs.BodyForce("-x")]))
    with opened(browser, write_page(bs.run(model, case), tmp_path / "page.html")) as page:
        choose(page, "find", wall)
        page.check("#show-bodies")
        settle(page)
        assert wall in page.inner_text("#picked")
        beyond = page.evaluate(
            "() => { const panel = document.querySelector('aside'), end = panel.getBoundingClientRect().right;"
            " return [...panel.querySelectorAll('*')].filter(e => e.getBoundingClientRect().right > end + 1"
            " && !e.closest('#convergence, #capacity')).map(e => e.outerHTML); }"
        )
        assert beyond == []
        panel = "document.querySelector('aside')"
        assert page.evaluate(f"{panel}.scrollWidth <= {panel}.clientWidth")


def test_analysis_views_itself(analysis, html, tmp_path, monkeypatch):
    assert analysis.view(tmp_path / "page.html").read_text(encoding="utf-8") == html
    shown = []
    monkeypatch.setattr("webbrowser.open", shown.append)
    page = analysis.view()
    assert shown == [page.as_uri()]


def test_a_saved_notebook_shows_the_page_without_a_network(browser, small_analysis, tmp_path):
    shown = NotebookPage(small_analysis)._repr_html_()
    (tmp_path / "saved.html").write_text(f"<!doctype html><body>{shown}</body>", encoding="utf-8")
    page, requests = browser.new_page(viewport={"width": 1200, "height": 800}), []
    page.on("request", lambda request: requests.append(request.url))
    page.goto((tmp_path / "saved.html").as_uri())
    frame = page.wait_for_selector("iframe").content_frame()
    frame.wait_for_selector("body[data-ready=yes]", timeout=60_000)
    assert frame.inner_text("#name") == small_analysis.model.name
    assert [url for url in requests if url.startswith(("http:", "https:"))] == []
    page.close()


def test_an_analysis_shows_itself_in_the_cell(small_analysis, monkeypatch):
    monkeypatch.setattr("blockstruct.results.analysis.in_notebook", lambda: True)
    assert small_analysis.view()._repr_html_().startswith("<iframe srcdoc=")
