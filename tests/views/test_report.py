"""The report: every status, any name, a template of one's own."""

import re
from html import escape, unescape

import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.views.console import analysis_summary, result_text
from blockstruct.views.page.html import payload
from blockstruct.views.paraview import write_paraview
from blockstruct.views.report import report_html, write_report
from blockstruct.views.report.contents import detection_rows
from blockstruct.views.words import spread_words
from structures import SELF_WEIGHT, box, every_load, model_of, push, settings_of, single_block, stopping

DRY = bs.JointMaterial("dry", 0.65)

pytestmark = pytest.mark.usefixtures("blank_pictures")


def run(cases, *, tilted=False, listeners=(), **settings):
    blocks, joint = single_block(0.4, 0.8)
    if tilted:
        # Half the block hangs over its support.
        blocks[0] = box("ground", [-1, 0, -0.5], [1.1, 1, 0.5], fixed=True)
    return bs.AnalysisManager(model_of(blocks, joint), settings=settings_of(**settings), listeners=listeners).run(cases)


def case(name="case", direction=(1, 0, 0), flow="nonassociative"):
    return bs.LimitCase(name, SELF_WEIGHT, push(*direction), flow)


@pytest.fixture(scope="module")
def small():
    return run([case(flow="associative")])


@pytest.mark.parametrize(
    ("status", "analysis"),
    [
        ("converged", lambda: run([case()])),
        ("unbounded", lambda: run([case(direction=(0, 0, -1))])),  # Blocks that do not dilate may move all the same.
        ("unbounded", lambda: run([case(direction=(0, 0, -1), flow="associative")])),
        ("unstable under dead load", lambda: run([case()], tilted=True)),
        ("not converged", lambda: run([case()], procedure="fictitious", max_programs=1)),
        ("interrupted", lambda: run([case()], listeners=[stopping()])),
    ],
)
def test_every_view_has_the_one_sentence_of_the_case(status, analysis):
    found = analysis()
    result, said = found["case"], found["case"].headline.text()
    if status == "unbounded":
        proven = result.case.flow is bs.Flow.ASSOCIATIVE
        assert result.outcome.reason == ("never_collapses" if proven else "carries_any_load")
    html = unescape(report_html(found))
    assert f"<td>{status}</td>" in html
    assert html.count(f"{said[:1].upper()}{said[1:]}.") == 1
    assert result_text(result).plain.count(said) == 1
    assert analysis_summary(found)["cases"][0]["text"] == said
    if result.n_iterations:
        assert said[1:] in payload(found)["cases"][0]["status"]
    else:
        with pytest.raises(bs.errors.ModelError, match=re.escape(said)):
            write_paraview(result, "case.pvd")


def test_the_report_has_model_and_results():
    analysis = run([case("push")])
    html = report_html(analysis)
    assert '<td class="number"><strong>0.5</strong></td><td class="number">0.5</td>' in html
    for text in ("20 kN/m³", "0.65 (33°)", "1 free, 1 fixed", "0.4 m², 0.4 m² in all", "The certificate holds."):
        assert text in html, text
    for text in ("crushing is not checked", "the load factor is not unique", analysis.model.hash, bs.__version__):
        assert text in html, text
    assert not re.search(r'(src|href)="(?!data:)', html)
    html = report_html(run([case(flow, flow=flow) for flow in bs.Flow]))
    assert "<td>0.65 (33°)</td><td>33° associative, 0° nonassociative</td>" in html
    soft = model_of(single_block(0.4, 0.8)[0], DRY.varied(compressive_strength=Q_(40, "kPa")))
    html = report_html(bs.run(soft, case(flow="associative")))
    assert "Interface ground|block, the nearest to crushing" in html


def test_the_detection_is_summed_up():
    blocks = [box(name, [x, 0, -1], fixed=True) for name, x in (("left rock", -1), ("rock", 0))]
    blocks += [box("one", [-0.5, 0, 0]), box("two", [0.5015, 0, 0])]
    found = bs.detect_interfaces(blocks, DRY, tolerance="1 mm")
    again = bs.detect_interfaces(blocks, DRY, tolerance="1 mm", explicit=found.interfaces[:1])
    rows = dict(detection_rows(bs.Model("five", blocks, again.interfaces, detection=again.report)))
    assert rows["given, not measured"] == [found.interfaces[0].name]
    html = report_html(bs.run(bs.Model("four", blocks, found), case(flow="associative")))
    for text in ("gap and penetration 1 mm, angle 1°", "3 interfaces, 1.49", "1 by gap", "one | two: gap, gap 1.5 mm"):
        assert text in html, text


def test_a_spread_has_its_table_and_the_run_as_given(small_model):
    analysis = bs.AnalysisManager(small_model).run([case("push")], spread=["steep", "shifted"])
    spread = analysis.spread("push")
    html = report_html(analysis)
    assert spread_words(spread) in html
    assert "<td>steep</td><td>procedure fictitious, schedule slope 0.6</td><td>converged</td><td>holds</td>" in html
    # The number of the run as given stands first, and alone.
    head = html[: html.index("<h2>Model</h2>")]
    assert re.findall(r"<strong>([\d.]+)</strong>", head) == [f"{spread.load_factor:.4g}"]
    assert f">{spread.upper_bound.load_factor:.4g}</td>" in head


def test_names_are_text_in_any_script():
    names = ["<script>alert(1)</script>", "pression é 墙 η", "a & b"]
    html = report_html(run([case(name, flow="associative") for name in names]))
    assert "<script" not in html
    assert all(html.count(escape(name)) >= 2 for name in names)


def test_every_kind_of_load_is_described():
    block = single_block(0.4, 0.8)[0][1]
    weight, _, *others = every_load(block)
    dead, variable = bs.LoadPattern("dead", [weight, *others[3:]]), bs.LoadPattern("many", others[:3] * 5)
    html = report_html(run([bs.LimitCase("case", dead, variable, "associative")]))
    for words in (
        "a force (0, 0, -142.9) N on block block at (0.4, 1, 0.8) m",
        "a couple (0, 0.01, 0) N·m on block block",
        "a traction (0, 0, -300) Pa and a pressure that grows by 9.81 kN/m³ below z = 0.7 m on face 5",
        "a pressure of -800 Pa on face 2",
        "a weight of 142.9 N on block block at (0.4, 1, 0.8) m",
        "a weight of 142.9 N/m along a line on block block",
        "bear all of it: 0.7143 N in all",
        "on its open upper faces: 400 N in all",
        "fill of 18 kN/m³ up to z = 1.2 m",
        "and 5 more loads",
    ):
        assert words in html


def test_a_firm_changes_the_blocks_it_wants(tmp_path, small):
    own = tmp_path / "firm.html.j2"
    block = "{% block project %}<p>Firm {{ name }}</p>{% endblock %}"
    own.write_text('{% extends "report.html.j2" %}' + block, encoding="utf-8")
    html = report_html(small, template=own)
    assert "<p>Firm model</p>" in html


ENDLESS = [
    "{% for i in range(9999) %}{% for j in range(9999) %}{% endfor %}{% endfor %}",
    "{% for i in [1, 2] recursive %}{{ loop([1, 2]) if loop.depth < 40 }}{% endfor %}",
    "{% macro f(n) %}{% if n %}{{ f(n - 1) }}{{ f(n - 1) }}{% endif %}{% endmacro %}{{ f(60) }}",
]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("own.j2", "\n{{ nothing }}", r"'nothing' is undefined, line 2"),
        ("own.j2", "\n\n{{ 1 + name }}", r"own\.j2: not a usable template \(unsupported operand.*, line 3\)"),
        ("own.j2", "{{ cycler.__init__.__globals__.os.system('true') }}", "access to attribute '__init__'.*unsafe"),
        ("own.j2", "{{ project.update(client='x') }}", "attribute 'update' of 'dict' object is unsafe"),
        ("own.j2", b"\nclient: \xe9", r"own\.j2: not a usable template \('utf-8' codec.*, line 2\)"),
        ("own.j2", "{% if %}", "line 1"),
        ("missing.j2", None, "not a usable template"),
        ("report.html.j2", "", "rename the file"),
        *(("own.j2", text, "more than 1000000 rounds") for text in ENDLESS),
    ],
)
def test_a_template_that_cannot_be_used_is_refused(tmp_path, name, text, words, small):
    if text is not None:
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(bs.errors.StorageError, match=words):
        write_report(small, tmp_path / "r.html", template=tmp_path / name)
    assert not (tmp_path / "r.html").exists()


@pytest.mark.parametrize("other", ["secret.txt", "link", "contents.py", "room.py", "../secret.txt"])
@pytest.mark.parametrize("tag", ["{% include NAME %}", "{% import NAME as x %}", "{% extends NAME %}"])
def test_a_template_reads_no_other_file(tmp_path, tag, other, small):
    (tmp_path / "secret.txt").write_text("SECRET", encoding="utf-8")
    (tmp_path / "link").symlink_to(tmp_path / "secret.txt")
    own = tmp_path / "own.j2"
    own.write_text(tag.replace("NAME", repr(other)), encoding="utf-8")
    with pytest.raises(bs.errors.StorageError, match="not a usable template"):
        report_html(small, template=own)
