"""The README does what it says."""

import re
import runpy
from pathlib import Path

import pytest
import yaml

import blockstruct as bs

README = Path(__file__).parents[1] / "README.md"


def test_python_snippets_run_as_written(tmp_path, monkeypatch):
    # The first snippet stands alone; the second goes on from it.
    snippet = "".join(re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL))
    script = tmp_path / "snippet.py"
    script.write_text(snippet, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(script))
    assert names["result"].status == "converged"
    assert (tmp_path / "runs" / "wall.h5").is_file()


def test_every_name_the_readme_uses_exists():
    text = README.read_text(encoding="utf-8")
    for name in re.findall(r"\bbs\.(\w+)", text):
        assert hasattr(bs, name), name
    for status in bs.Status:
        assert f"`{status}`" in text


def test_every_console_line_of_the_readme_is_a_command():
    text = README.read_text(encoding="utf-8")
    lines = re.findall(r"^blockstruct .*$", text, re.MULTILINE)
    assert {line.split()[1] for line in lines} == {
        "run",
        "show",
        "history",
        "validate",
        "archive",
        "diff",
        "recover",
        "resume",
        "import",
        "check",
        "view",
        "figures",
        "report",
    }


def test_the_yaml_of_the_readme_is_a_block():
    content = yaml.safe_load(re.search(r"```yaml\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)[1])
    shape = content["blocks"][0]["polyhedron"]
    tuff = bs.Material("tuff", "12 kN/m^3")
    wedge = bs.Block.from_faces("wedge", bs.Q_(shape["vertices"], shape["unit"]), shape["faces"], tuff)
    assert wedge.volume == pytest.approx(0.4 * 0.2 / 2 * 0.3)
