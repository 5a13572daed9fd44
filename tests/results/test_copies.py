"""Results and their parts, sent to another process and copied."""

import copy
import pickle

import pytest

import blockstruct as bs


@pytest.mark.parametrize("again", [lambda thing: pickle.loads(pickle.dumps(thing)), copy.deepcopy])
def test_results_are_the_same_in_another_process(small_analysis, tmp_path, again):
    bs.save_analysis(small_analysis, tmp_path / "small.h5")
    for analysis in (small_analysis, bs.open_analysis(tmp_path / "small.h5")):
        same = again(analysis)
        assert str(same) == str(small_analysis)
        assert (same.model.hash, same.versions) == (small_analysis.model.hash, small_analysis.versions)
        assert all(same[name].history.identical(result.history) for name, result in small_analysis.items())
    spread = bs.results.Spread({"as given": next(iter(small_analysis.values()))}, None)
    assert str(again(spread)) == str(spread)
    brick = bs.library.masonry("solid brick and lime mortar")
    assert (again(brick), str(again(brick))) == (brick, str(brick))
    for frozen in (same.results, again(spread).runs):
        with pytest.raises(TypeError):
            frozen["another"] = None
