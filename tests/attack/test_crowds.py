"""Many at once: a reader next to writers."""

import pytest

import blockstruct as bs
from killed_runs import cases, wall
from processes import FRESH
from trials import outcome

#: Seconds that one look at a file may take, however busy the machine is.
LONGEST = 60


def rewrite(path, times, start):
    start.wait()
    for _ in range(times):
        try:
            bs.save_analysis(bs.open_analysis(path), path)
        except bs.errors.BusyError:
            continue


@pytest.mark.parametrize("times", [2, pytest.param(40, marks=pytest.mark.slow)])
def test_readers_beside_writers(tmp_path, tell, times):
    """Three processes replace a file again and again; a reader always sees a whole one, and no rubbish is left."""
    whole = bs.AnalysisManager(wall(), tmp_path / "wall.h5").run(cases())
    start = FRESH.Event()
    writers = [FRESH.Process(target=rewrite, args=(tmp_path / "wall.h5", times, start)) for _ in range(3)]
    for writer in writers:
        writer.start()
    start.set()
    outcomes = []

    def read():
        assert bs.open_analysis(tmp_path / "wall.h5")["sideways"].history.identical(whole["sideways"].history)
        table = bs.Archive(tmp_path).table().set_index("case")
        assert table.loc["sideways", "load_factor"] == whole["sideways"].load_factor

    while any(writer.is_alive() for writer in writers):
        how, said = outcome(read, LONGEST)
        if how != "answered":
            print(said)
        outcomes.append({"answered": "identical", "refused": "wrong"}.get(how, how))
    tell("reads next to writers", outcomes)
    assert outcomes
    assert [w.exitcode for w in writers] == [0, 0, 0]
    assert [p.name for p in tmp_path.iterdir()] == ["wall.h5"]
