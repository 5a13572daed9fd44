"""The README does what it says."""

import re
import shlex
import shutil
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
import xarray

import blockstruct as bs

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
CELL = "{code-cell} ipython3"
PAGES = [
    p
    for p in sorted((ROOT / "docs").rglob("*.md"))
    if re.search(f"```(sh|python|{re.escape(CELL)})\n", p.read_text(encoding="utf-8"))
]


#: What sets up the environment in which tests run.
SETS_UP = ("make", "pip")
LANGUAGES = rf"```(python|sh|{re.escape(CELL)})\n(.*?)```"


def carry_out(page, call, names):
    """Run the snippets of a page as written, in order, in this folder; those of Python share their names."""
    for language, text in re.findall(LANGUAGES, page.read_text(encoding="utf-8"), re.DOTALL):
        if language in ("python", CELL):
            code = re.sub(r"^:.*\n", "", text, flags=re.MULTILINE)
            exec(compile(code, page.name, "exec"), names)
            continue
        for line in text.replace("\\\n", " ").splitlines():
            program, *words = shlex.split(line, comments=True)
            if program not in SETS_UP:
                assert program == "blockstruct", line
                code, _, err = call(*words)
                assert code == 0, f"{line}\n{err}"


@pytest.fixture
def clone(tmp_path, monkeypatch):
    """A folder in which the examples are where the pages say."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_readme_is_carried_out_in_order(clone, call, done):
    names = {}
    carry_out(README, call, names)
    assert names["result"].status == "converged"
    # The demo, the gallery and the guide show the same wall.
    done("demo", "-q", "-o", "runs/demo.h5")
    wall = names["model"].hash
    assert bs.open_analysis("runs/demo.h5").model.hash == wall
    for page in ("gallery/wall.md", "guide/analysis.md"):
        carry_out(ROOT / "docs" / page, call, names)
        assert names["model"].hash == wall
    assert (clone / "runs" / "wall.h5").is_file()


def costed(page):
    """A page as a parameter; one with cells, which are run when the site is built, or with a building is slow."""
    text = page.read_text(encoding="utf-8")
    is_slow = CELL in text or "assess.building(" in text
    return pytest.param(page, marks=[pytest.mark.slow] * is_slow, id=page.name)


@pytest.mark.parametrize("page", [costed(page) for page in PAGES])
def test_the_pages_are_carried_out_in_order(page, clone, call, small_analysis, blank_pictures):
    (clone / "runs").mkdir()
    named = dict(zip(("push", "other"), small_analysis.values(), strict=True))
    named["push +x"] = named["other"]
    results = {name: replace(r, case=r.case.renamed(name)) for name, r in named.items()}
    if page.name == "results.md":
        # Its snippets select a joint of the wall of the first analysis.
        carry_out(page.with_name("analysis.md"), call, {})
    else:
        bs.save_analysis(small_analysis.replaced(results=results), "runs/wall.h5")
    if "write_obj(" not in page.read_text(encoding="utf-8"):
        bs.imports.write_obj("wall.obj", small_analysis.model.blocks, unit="mm")
    carry_out(page, call, {"bs": bs, "xarray": xarray})
    plt.close("all")


def test_what_sets_up_is_a_target_of_make():
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"\bmake ([\w-]+)", README.read_text(encoding="utf-8"))) <= set(targets)


@pytest.mark.parametrize("page", [README, *PAGES], ids=lambda page: page.name)
def test_every_name_that_a_page_uses_exists(page):
    for names in re.findall(r"\bbs\.([\w.]+\w)", page.read_text(encoding="utf-8")):
        found = bs
        for name in names.split(".")[: 2 if names.split(".")[0] in ("errors", "imports", "contacts", "assess") else 1]:
            found = getattr(found, name)


def test_every_name_of_the_reference_exists():
    page = (ROOT / "docs" / "reference" / "index.md").read_text(encoding="utf-8")
    names = re.findall(r"^   ([\w.]+)$", page, re.MULTILINE)
    assert len(names) > 40
    for name in names:
        found = bs
        for part in name.split("."):
            found = getattr(found, part)
        assert found.__doc__, name
