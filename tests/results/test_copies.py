"""Results and their parts, sent to another process and copied."""

import copy
import pickle

import pytest

import blockstruct as bs


def ways():
    return pytest.mark.parametrize(
        "again", [lambda thing: pickle.loads(pickle.dumps(thing)), copy.deepcopy], ids=["pickled", "copied"]
    )


@ways()
def test_an_analysis_is_the_same_in_another_process(small_analysis, again):
    same = again(small_analysis)
    assert str(same) == str(small_analysis)
    assert same.model.hash == small_analysis.model.hash
    assert same.versions == small_analysis.versions
    for name, result in small_analysis.items():
        assert same[name].history.identical(result.history)
    with pytest.raises(TypeError):
        same.results["another"] = None


@ways()
def test_an_opened_analysis_is_the_same(small_analysis, tmp_path, again):
    bs.save_analysis(small_analysis, tmp_path / "small.h5")
    same = again(bs.open_analysis(tmp_path / "small.h5"))
    for name, result in small_analysis.items():
        assert same[name].history.identical(result.history)


@ways()
def test_a_spread_is_the_same(small_analysis, again):
    spread = bs.results.Spread({"as given": next(iter(small_analysis.values()))}, None)
    assert str(again(spread)) == str(spread)
    with pytest.raises(TypeError):
        again(spread).runs["another"] = None


@ways()
def test_an_entry_of_the_library_is_the_same(again):
    brick = bs.library.masonry("solid brick and lime mortar")
    assert again(brick) == brick
    assert str(again(brick)) == str(brick)
