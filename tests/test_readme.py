"""The README does what it says."""

import re
import runpy
from pathlib import Path

import blockstruct as bs

README = Path(__file__).parents[1] / "README.md"


def test_first_python_snippet_runs_as_written(tmp_path, monkeypatch):
    snippet = re.search(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)[1]
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
