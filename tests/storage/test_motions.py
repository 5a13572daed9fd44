"""Pushovers and responses to records on disk: written, read, checked, and gone on with after a kill at any state."""

import io
import re
import shutil
from html import unescape

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import CaseStarted, StateDone, StepDone
from blockstruct.storage.file import folder_of
from blockstruct.views.console import archive_table, study_table
from properties import slow_after
from structures import (
    SELF_WEIGHT,
    block_on_a_bar,
    box,
    edited,
    model_of,
    push,
    single_block,
    slid_from_under,
    slipping_units,
    stopping,
)

CASE = bs.Pushover(
    "push",
    dead=SELF_WEIGHT,
    variable=push(1, 0, 0),
    control=("block", (1, 0, 0)),
    control_point=Q_([0.3, 0, 1.5], "m"),
    steps=12,
    corner_rounding="20 mm",
)


@pytest.fixture(scope="module")
def model():
    return model_of(*single_block(0.3, 1.5, mu=2.0))


@pytest.fixture(scope="module")
def whole(model):
    return bs.run(model, CASE)["push"]


def test_written_and_read(model, whole, tmp_path):
    path = tmp_path / "run.h5"
    result = bs.run(model, CASE, path)["push"]
    read = bs.open_analysis(path)["push"]
    assert read.capacity.identical(result.capacity)
    assert read.case == CASE
    assert str(read.outcome) == str(whole.outcome)
    assert read.curve_ended == whole.curve_ended
    again, first = (curve.drop_vars("solver_time") for curve in (read.capacity, whole.capacity))
    xr.testing.assert_allclose(again, first, rtol=1e-6, atol=1e-7)
    bs.check_file(path)
    assert read.capacity["position"].attrs["units"] == "meter"


def test_a_curve_of_another_model_is_told(model, tmp_path):
    path = tmp_path / "run.h5"
    bs.run(model, CASE, path)
    with edited(path) as file:
        file["cases/push/capacity/block"][0] = "another"
    with pytest.raises(bs.errors.FormatError, match="/capacity: the names along block are not those of /model"):
        bs.open_analysis(path)


def test_how_a_curve_ended_is_kept_when_a_later_case_is_killed(tmp_path):
    """With a bar that has broken by then."""
    model, path = block_on_a_bar(), tmp_path / "run.h5"
    pushover = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=8)
    after = bs.LimitCase("after", SELF_WEIGHT, push(1, 0, 0), "associative")
    seen, stop = [], stopping(CaseStarted, case="after", error=RuntimeError)
    with pytest.raises(RuntimeError):
        bs.AnalysisManager(model, path, listeners=[seen.append, stop]).run([pushover, after])
    bs.AnalysisManager.resume(path)
    whole, read = seen[-2].result, bs.open_analysis(path)["push"]
    assert not whole.broken_ties.empty
    assert read.broken_ties.equals(whole.broken_ties)
    assert read.capacity.identical(whole.capacity)
    assert str(read.outcome) == str(whole.outcome)
    assert read.curve_outcome.text == whole.curve_outcome.text


def shaken():
    pulse = np.repeat([-0.8, 0.0], [4, 8])
    return [
        bs.RecordCase("along", SELF_WEIGHT, Q_(pulse, "g_0"), "0.05 s", "+x", interval="25 ms"),
        bs.RecordCase(
            "axes", SELF_WEIGHT, Q_(np.outer(0.5 * pulse, [0.6, 0.8, 0.2]), "g_0"), Q_(np.arange(12) / 20, "s")
        ),
    ]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    path = tmp_path_factory.mktemp("response") / "run.h5"
    return bs.run(block_on_a_bar("10 mm"), shaken(), path, progress=False), path


def test_a_response_is_opened_as_it_was(stored):
    analysis, path = stored
    bs.check_file(path)
    for name, result in bs.open_analysis(path).items():
        assert result.response.identical(analysis[name].response)
        assert result.broken_ties.index.tolist() == ["bar"] * (name == "along")
        assert result.case == analysis[name].case
        assert result.status is analysis[name].status
        assert all("units" in v.attrs for n, v in result.response.data_vars.items() if not n.endswith("us_of_contact"))


@pytest.mark.parametrize(("ties", "strength"), [(1, None), (0, None), (1, "0.5 MPa")])
def test_an_interrupted_response_is_continued(ties, strength, tmp_path):
    tied, path = block_on_a_bar("10 mm"), tmp_path / "interrupted.h5"
    joint = bs.JointMaterial("joint", 2.0, compressive_strength=strength)
    model = model_of(tied.blocks, joint).with_ties(tied.ties[:ties])
    part = bs.run(model, shaken()[:1], path, listeners=[stopping(StateDone, at=8)])["along"]
    assert part.status is bs.Status.INTERRUPTED
    assert part.response.sizes["time"] == 9
    done = bs.AnalysisManager.resume(path)["along"]
    assert done.response.identical(bs.run(model, shaken()[:1], progress=False)["along"].response)


def test_a_response_is_drawn_and_exported(stored, tmp_path):
    pytest.importorskip("pyvista")
    import matplotlib as mpl

    mpl.use("Agg")
    from blockstruct.views import export
    from blockstruct.views.figures import response
    from blockstruct.views.paraview import write_paraview
    from blockstruct.views.report import write_report

    analysis, _ = stored
    result = analysis["along"]
    line = response(result).lines[-1]
    assert np.abs(line.get_ydata()).max() == pytest.approx(1e3 * np.abs(result.response.displacement).max())
    target = write_paraview(result, tmp_path / "along.pvd")
    # Blocks and ties of each state.
    assert target.read_text().count("<DataSet") == 2 * result.response.sizes["time"]
    said = unescape(write_report(analysis, tmp_path / "report.html").read_text())
    for sentence in bs.results.response_words(result.model, result.response):
        assert sentence in said
    largest = max(one.peak_displacement for one in analysis.values())
    assert f"{1e3 * largest:.4g}" in re.search(r"<b>(.*?)</b>", said)[1]
    table = export.tables(analysis)["response"].loc["along"]
    assert table["kinetic_energy [joule]"].to_numpy() == pytest.approx(result.response.kinetic_energy.to_numpy())
    largest = table["largest_displacement [meter]"].max()
    assert largest == pytest.approx(float(np.linalg.norm(result.response.displacement, axis=2).max()))
    export.write_glb(result, tmp_path / "along.glb")
    bar, still = result.model.blocks[-1], result.response.displacement.isel(time=-1, block=-1).to_numpy()
    path = export.write_moved(result, tmp_path / "along.obj", step=-1)
    moved = bs.imports.read_mesh(path, unit="m", material=bar.material).blocks[-1]
    np.testing.assert_allclose(moved.centroid, bar.centroid + still, atol=1e-9)
    with pytest.raises(bs.errors.ModelError, match="no mechanism, stands; give a step"):
        export.write_moved(result, tmp_path / "along.stl")


def test_responses_are_compared(stored, tmp_path):
    analysis, path = stored
    case = analysis["along"].case
    weaker = bs.run(analysis.model, case.scaled(0.95, "along"), tmp_path / "run.h5", progress=False)
    rows = bs.results.compare(analysis, weaker).cases
    assert rows.status["along"] == rows.status_other["along"]
    assert rows.response_difference["along"] > 0.02
    assert rows.response_difference["axes"] == np.inf
    same = bs.results.compare(analysis, bs.open_analysis(path))
    assert same.agrees()
    assert (same.cases.response_difference == 0).all()
    assert f"{1e3 * analysis['along'].peak_displacement:.4g} mm, relative difference" in str(same)
    differs = bs.Archive(path.parent).difference(bs.Archive(tmp_path)).loc["run.h5", "along"]
    assert differs.end_difference < -0.01
    assert not differs.agree


def test_a_record_is_plotted_and_has_no_mechanism(stored):
    result = stored[0]["along"]
    assert result.plot().get_xlabel() == "time [s]"
    name, text = result.number()
    assert f"<td>{name}</td><td>{text}" in result._repr_html_()
    for part in ("mechanism", "macro_blocks"):
        with pytest.raises(bs.errors.ModelError, match="no mechanism, stands"):
            getattr(result, part)


def test_an_archive_has_the_numbers_of_records(stored):
    analysis, path = stored
    table = bs.Archive(path.parent).table().set_index("case")
    for name, result in analysis.items():
        assert table.peak_displacement[name] == result.peak_displacement
        assert np.isnan(table.collapse_time[name])
    # A study in which nothing falls has no column for the time of collapse.
    data = bs.study(lambda factor: (analysis.model, shaken()[0].scaled(factor)), {"factor": [0.5]}, workers=1)
    weaker = data.peak_displacement.item()
    tables = {weaker: study_table(data), analysis["along"].peak_displacement: archive_table(table.reset_index())}
    for largest, shown in tables.items():
        console = Console(width=200, record=True, file=io.StringIO())
        console.print(shown)
        assert f"{1e3 * largest:.4g} mm" in console.export_text()


def standing(friction, *boxes):
    """Model of boxes on the ground, each a name, its x and z from the origin, its size, and whether it is fixed."""
    ground = box("ground", [-1, 0, -0.5], [6, 1, 0.5], fixed=True)
    blocks = [box(name, [x, 0, 0], [width, 1, height], fixed=name == "stop") for name, x, width, height in boxes]
    return model_of([ground, *blocks], bs.JointMaterial("joint", friction))


#: Structures, their control blocks and steps.
MOTIONS = {
    "a block on a bar that yields and breaks": (block_on_a_bar, "block", 6),
    "a block slides until it meets a low stop, and turns over": (
        lambda: standing(0.2, ("block", 0, 0.4, 0.5), ("stop", 0.5, 0.1, 0.05)), "block", 4,
    ),
    "a tall block falls against one that turns and meets a third": (
        lambda: standing(2.0, ("tall", 0, 0.3, 1.2), ("other", 0.4, 0.5, 1), ("third", 1, 0.5, 0.4)), "tall", 3,
    ),
    "units that slip and rock": (slipping_units, "4.3", 6),
    "a block that drops onto a ledge": (slid_from_under, "a", 10),
}  # fmt: skip


@pytest.mark.parametrize("states", slow_after(4, 10))
@pytest.mark.parametrize("motion", slow_after(*MOTIONS))
def test_killed_at_any_state_it_is_the_same_curve(tmp_path, motion, states):
    structure, control, steps = MOTIONS[motion]
    model = structure()
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=(control, (1, 0, 0)), steps=steps)
    path, kept = tmp_path / "run.h5", []

    def keep(event):
        """The working data as a kill would leave them."""
        if isinstance(event, StepDone):
            kept.append(tmp_path / f"{event.index}" / "run.h5")
            shutil.copytree(folder_of(path), folder_of(kept[-1]))

    whole = bs.AnalysisManager(model, path, listeners=[keep]).run([case])["push"]
    assert len(kept) == whole.capacity.sizes["step"] > steps
    # What follows a state depends on what is kept alone: where three more are the same, all are, as those that are
    # continued to the end show.
    chosen = range(0, len(kept), -(-len(kept) // states))
    to_the_end = {chosen[1], chosen[len(chosen) // 2], *range(len(kept) - 4, len(kept))}
    for at in chosen:
        last = None if at in to_the_end else at + 3
        listeners = [] if last is None else [stopping(StepDone, at=last)]
        done = bs.AnalysisManager.resume(kept[at], listeners=listeners)["push"]
        expected = whole.capacity.drop_vars("solver_time")
        if last is not None:
            expected = expected.isel(step=slice(last + 1), contact=(expected["step_of_contact"] <= last).to_numpy())
            expected = expected.drop_vars(["d0", "tie_break_displacement"], errors="ignore")
        else:
            assert done.curve_ended == whole.curve_ended, at
            assert done.load_factor == pytest.approx(whole.load_factor, rel=1e-8), at
        for name, values in expected.variables.items():
            np.testing.assert_array_equal(done.capacity[name], values, f"{name}, gone on with at {at}")
