"""Responses to records: stored, opened again, resumed after a kill, exported."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import StateDone
from structures import SELF_WEIGHT, model_of, single_block, stopping


def model():
    return model_of(*single_block(0.4, 1.2, mu=0.7))


def cases():
    pulse = np.repeat([0.45, 0.0], [4, 8])
    return [
        bs.RecordCase("along", SELF_WEIGHT, Q_(pulse, "g_0"), "0.05 s", "+x", interval="25 ms"),
        bs.RecordCase(
            "axes", SELF_WEIGHT, Q_(np.outer(0.5 * pulse, [0.6, 0.8, 0.2]), "g_0"), Q_(np.arange(12) / 20, "s")
        ),
    ]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    path = tmp_path_factory.mktemp("response") / "run.h5"
    return bs.run(model(), cases(), path, progress=False), path


def test_a_response_is_opened_as_it_was(stored):
    analysis, path = stored
    bs.check_file(path)
    for name, result in bs.open_analysis(path).items():
        assert result.response.identical(analysis[name].response)
        assert result.case == analysis[name].case
        assert result.status is analysis[name].status
        assert all("units" in v.attrs for n, v in result.response.data_vars.items() if not n.endswith("us_of_contact"))


def test_an_interrupted_response_is_continued(stored, tmp_path):
    analysis, _ = stored
    path = tmp_path / "interrupted.h5"
    part = bs.run(model(), cases()[:1], path, listeners=[stopping(StateDone, at=5)])["along"]
    assert part.status is bs.Status.INTERRUPTED
    assert part.response.sizes["time"] == 6
    done = bs.AnalysisManager.resume(path)["along"]
    assert done.response.identical(analysis["along"].response)


def test_a_response_is_drawn_and_exported(stored, tmp_path):
    pytest.importorskip("pyvista")
    import matplotlib as mpl

    mpl.use("Agg")
    from blockstruct.views.figures import response
    from blockstruct.views.paraview import write_paraview
    from blockstruct.views.report import write_report

    analysis, _ = stored
    result = analysis["along"]
    line = response(result).lines[-1]
    assert np.abs(line.get_ydata()).max() == pytest.approx(1e3 * np.abs(result.response.displacement).max())
    target = write_paraview(result, tmp_path / "along.pvd")
    assert target.read_text().count("<DataSet") == result.response.sizes["time"]
    assert write_report(analysis, tmp_path / "report.html").exists()
