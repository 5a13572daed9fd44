"""Conditions that want more than rows are refused, and nothing of them is run."""

import pytest

import blockstruct as bs
from structures import SELF_WEIGHT, model_of, push, single_block

HOSTILE = [
    "path.__class__.__init__.__globals__['sys'].modules['os'].system('touch {proof}') == 0",
    "load_factor.to_csv('{proof}') == 1", "path.str.replace('w', 'v').map(path.to_csv)", "path.str.len() > 3",
    "__import__('os').system('touch {proof}') == 0", "open('{proof}', 'w') == 1",
    'exec(\'open("{proof}", "w")\') == None', "eval('1') == 1", "@pd.io.common.os.system('touch {proof}')",
    "@builtins == 1", "load_factor.values.tofile('{proof}') == 1", "(lambda: 0)() == load_factor",
    "[open('{proof}', 'w') for x in [1]] == load_factor", "{{x: x for x in path}} == 1", "(x := 1) == load_factor",
    "f'{{load_factor}}' == status", "load_factor[0] < 1", "load_factor + 1 < 2", "-load_factor < 0",
    "load_factor < 2 ** 9 ** 9 ** 9", "load_factor < 9 ** 999999999", "status == 'a' * 9999999999",
    "load_factor if 1 else 2", "status == status.__class__", "globals() == 1", "yield load_factor",
    "await load_factor", "load_factor < 1; import os", "path.__class__ == 1", "load_factor.values < 1",
    "'load_factor' < 1", "'__class__' == 'x'", "load_factor().a < 1", "import os", "load_factor = 1",
    "status == b'converged'", "load_factor < 1j", "load_factor is None", "load_factor < ...", "load_factor & 1",
    "~holds", "index > 0", "`load_factor` < 1", "1 == 1", "'a' in 'abc'",
    # columns that are not there, and values of another kind
    "load_factr < 1", "status == converged", "load_factor < '0.3'", "status < 1", "status in ['converged', 1]",
    "tags == 'north'", "created_at > 'yesterday'", "created_at > 2026", "status in 'converged'", "1 in load_factor",
    "load_factor < reaction", "holds", "load_factor <",
]  # fmt: skip
#: What exhausts a parser: too large to be written out.
LARGE = {
    "10,001 characters": "load_factor < " + "1" * 10_000,
    "4,900 digits": "load_factor < " + "1" * 4_900,
    "3,000 brackets": "(" * 3_000 + "load_factor < 1" + ")" * 3_000,
    "2,000 not": "not " * 2_000 + "load_factor < 1",
    "9,000 signs": "load_factor < " + "-" * 9_000 + "1",
    "a list in a list": "load_factor in " + "[" * 90 + "1" + "]" * 90,
    "NUL": "load_factor < 1\0",
    "surrogate": "status == '\ud800'",
    "backslash": "status == '\\d'",
    "no text": 1,
    "bytes": b"load_factor < 1",
    "empty": "",
}
#: Large or odd, and yet harmless: rows are selected, or none.
HARMLESS = {
    "150 brackets": "not (" * 150 + "load_factor < 1" + ")" * 150,
    "500 comparisons": " or ".join(["load_factor < 1"] * 500),
    "800 texts": f"case in {[str(k) for k in range(800)]}",
    "300 digits": "load_factor < " + "1" * 300,
    "an exponent of 3,000 digits": "load_factor < 1e" + "9" * 3_000,
    "infinity": "load_factor < 1e999",
}


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """A block that rocks, one that cannot, and a file that is none."""
    folder = tmp_path_factory.mktemp("conditions")
    for name, tags in (("slender", ["north", "survey"]), ("squat", ["south"])):
        model = model_of(*single_block(0.5, 1.0 if name == "slender" else 0.1), name=name)
        cases = [bs.LimitCase("push +x", SELF_WEIGHT, push(1, 0, 0), "associative")]
        bs.AnalysisManager(model, folder / f"{name}.h5", tags=tags).run(cases)
    (folder / "text.h5").write_text("notes", encoding="utf-8")
    return bs.Archive(folder)


@pytest.mark.parametrize("name", [*HOSTILE, *LARGE])
def test_nothing_but_comparisons_is_understood(archive, tmp_path, name):
    proof = tmp_path / "proof"
    expression = LARGE[name] if name in LARGE else name.format(proof=proof)
    with pytest.raises(bs.errors.StorageError, match=r"(?s)^where .*; compare columns with numbers or texts"):
        archive.select(expression)
    assert not proof.exists()
    with pytest.raises((bs.errors.StorageError, TypeError)):
        archive.history(expression)
    assert not proof.exists()


@pytest.mark.parametrize(
    ("expression", "files"),
    [
        ("load_factor < 0.6", ["slender"]),
        ("0.4 < load_factor <= 0.6", ["slender"]),
        ("not load_factor < 0.6", ["squat", "text"]),
        ("status == 'converged' and not (model == 'squat' or problem != '')", ["slender"]),
        ("model not in ('squat',) and load_factor > 0", ["slender"]),
        ("'north' in tags", ["slender"]),
        ("'slen' in path", ["slender"]),
        ("'north' not in tags", ["squat", "text"]),
        ("holds == True", ["slender", "squat"]),
        ("d0 != 'a'", ["slender", "squat", "text"]),
        ("created_at > '2026-01-31' or created_at < '2026-01-31'", ["slender", "squat"]),
        ("settings_schedule_max_programs == 120", ["slender", "squat"]),
        *((text, None) for text in HARMLESS.values()),
    ],
)
def test_comparisons_select_rows(archive, expression, files):
    found = archive.select(expression)
    assert found.attrs["units"]
    if files is not None:
        assert found["path"].tolist() == [f"{name}.h5" for name in files]
