"""The page in a notebook: in a saved one without a kernel, and what is picked in a live one."""

import json

import pytest

from blockstruct.views.page import NotebookPage
from blockstruct.views.page.html import _WIDGET

CELL = """<!doctype html><body><div id="cell"></div><script type="module">
const values = %s, source = new Blob([%s], {type: "text/javascript"});
const model = {
  get: name => values[name],
  set: (name, value) => { values[name] = value; },
  save_changes: () => { window.saved = values.picked; },
};
const widget = (await import(URL.createObjectURL(source))).default;
widget.render({ model, el: document.getElementById("cell") });
</script></body>"""


@pytest.fixture(scope="module")
def shown(small_analysis):
    return NotebookPage(small_analysis)


def drawn(browser, path):
    """Open a file, and return it with the frame of the page in it."""
    requests = []
    page = browser.new_page(viewport={"width": 1200, "height": 800})
    page.on("request", lambda request: requests.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_selector("iframe")
    frame = page.query_selector("iframe").content_frame()
    frame.wait_for_selector("body[data-ready=yes]", timeout=60_000)
    assert [url for url in requests if url.startswith(("http:", "https:"))] == []
    return page, frame


def pick(page, frame, name):
    """Pick an interface in the page, and return the name that the notebook learns."""
    frame.fill("#find", name)
    frame.dispatch_event("#find", "change")
    page.wait_for_function("window.saved !== undefined")
    return page.evaluate("window.saved")


def test_a_saved_notebook_shows_the_page_without_a_network(browser, shown, small_analysis, tmp_path):
    """A saved cell, and a listener that keeps the name of what is picked."""
    listener = 'addEventListener("message", event => { window.saved = event.data.blockstruct.name; });'
    saved = f"<!doctype html><body>{shown._repr_html_()}<script>{listener}</script></body>"
    (tmp_path / "saved.html").write_text(saved, encoding="utf-8")
    page, frame = drawn(browser, tmp_path / "saved.html")
    assert frame.inner_text("#name") == small_analysis.model.name
    name = small_analysis.model.interfaces[2].name
    assert pick(page, frame, name) == name
    page.close()


@pytest.mark.slow
def test_the_widget_takes_over_what_is_picked(browser, shown, small_analysis, tmp_path):
    values = {"page": shown._page, "height": 600, "picked": ""}
    quoted = [json.dumps(value).replace("<", "\\u003c") for value in (values, _WIDGET)]
    (tmp_path / "live.html").write_text(CELL % tuple(quoted), encoding="utf-8")
    page, frame = drawn(browser, tmp_path / "live.html")
    name = small_analysis.model.interfaces[2].name
    assert pick(page, frame, name) == name
    page.close()


def test_an_analysis_shows_itself_in_the_cell(small_analysis, shown, monkeypatch):
    monkeypatch.setattr("blockstruct.results.analysis.in_notebook", lambda: True)
    assert small_analysis.view()._repr_html_().startswith("<iframe srcdoc=")
    pytest.importorskip("anywidget")
    assert shown.picked is None
    shown.widget.picked = "1.1|2.1"
    assert shown.picked == "1.1|2.1"
