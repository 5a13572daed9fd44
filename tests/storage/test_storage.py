"""Files: round trips, other readers, and what is refused."""

import shutil
from pathlib import Path

import attrs
import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import IterationDone
from blockstruct.model import LOAD_KINDS
from blockstruct.statics.contacts import Division
from blockstruct.statics.statics import Statics
from blockstruct.storage import file as storage_file
from blockstruct.storage import run_folder
from blockstruct.storage.layout import MIGRATIONS
from properties import few
from structures import box, divided, edited, every_load, model_of, push, single_block, stopping


@pytest.fixture(scope="module")
def path(small_analysis, tmp_path_factory):
    return bs.save_analysis(small_analysis, tmp_path_factory.mktemp("store") / "small.h5")


def same(one: bs.Analysis, other: bs.Analysis) -> None:
    assert (one.model.hash, one.model.detection) == (other.model.hash, other.model.detection)
    for name in ("cases", "versions", "created_at", "solver_options", "document_hash", "tags"):
        assert getattr(one, name) == getattr(other, name), name
    for name, result in one.items():
        twin = other[name]
        assert result.history.identical(twin.history)
        assert (str(result.outcome), result.settings) == (str(twin.outcome), twin.settings)
        # As text, every digit of it: where a solver failed, measures are NaN.
        assert repr(result.certificate) == repr(twin.certificate)
        np.testing.assert_equal(result.load_factor, twin.load_factor)


def test_round_trip(small_analysis, path, tmp_path):
    same(small_analysis, bs.open_analysis(path))
    # No tolerance is kept but that of the settings, and files get the rights that new files get.
    assert small_analysis.solver_options["clarabel"]["direct_solve_method"] == "qdldl"
    assert not {"tol_gap_abs", "tol_gap_rel", "tol_feas"} & set(small_analysis.solver_options["clarabel"])
    (tmp_path / "plain").write_text("x")
    assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_every_kind_of_load_is_stored(small_model, tmp_path):
    loads = every_load(small_model.block("3.1"))
    assert {type(load) for load in loads} == set(LOAD_KINDS.values())
    dead = bs.LoadPattern("dead", loads)
    analysis = bs.AnalysisManager(small_model).run([bs.LimitCase("c", dead, push(1, 0, 0), "associative")])
    again = bs.open_analysis(bs.save_analysis(analysis, tmp_path / "loads.h5"))
    same(analysis, again)
    assert again["c"].case.dead.loads == tuple(loads)


def test_every_kind_of_finding_of_a_detection_is_stored(dry, tmp_path):
    # The top of the twisted stone, on which nothing stands, is not plane.
    twisted = box("twisted", [4, 0, 0]).shape
    corners = twisted.vertices + np.where((twisted.vertices == [5, 1, 1]).all(axis=1), 0.006, 0.0)[:, None] * [0, 0, 1]
    blocks = [box("ground", [-1, 0, -1], [11, 1, 1], fixed=True), box("rock", [-2, 0, -1], fixed=True)]
    blocks += [box("far rock", [40, 0, 0], fixed=True), box("left", [0, 0, 0]), box("a gap", [1.0015, 0, 0])]
    blocks += [box("close", [5.05, 0, 0]), bs.Block.from_faces("twisted", Q_(corners, "m"), twisted.faces, STONE)]
    found = bs.detect_interfaces(blocks, dry, tolerance="1 mm")
    report = attrs.evolve(found.report, overlaps=(("left", "a gap", 2e-3),))
    assert {c.reason for c in report.contacts} >= {"", "gap", "supports"}
    assert report.near_misses
    assert report.nonplanar_faces
    assert report.close
    assert report.untouched == ("rock", "far rock")
    model = bs.Model("findings", blocks, found.interfaces, detection=report)
    case = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push(1, 0, 0), "associative")
    analysis = bs.AnalysisManager(model, store=tmp_path / "findings.h5").run([case])
    same(analysis, bs.open_analysis(tmp_path / "findings.h5"))


def test_a_detection_of_other_blocks_is_refused(small_model, dry):
    of_other = bs.detect_interfaces([box("other", [0, 0, 0])], dry).report
    found = bs.detect_interfaces(small_model.blocks, dry)
    fewer = [i for i in small_model.interfaces if i.name != "3.1|3.2"]
    for interfaces, detection, error, words in (
        (small_model.interfaces, of_other, bs.errors.UnknownNameError, "blocks other, which are not in the model"),
        (fewer, small_model.detection, bs.errors.UnknownNameError, r"interfaces 3\.1\|3\.2, which"),
        (small_model.interfaces, found, bs.errors.ModelError, r"detection is a Detection; give found\.report"),
    ):
        with pytest.raises(error, match=words):
            bs.Model("wall", small_model.blocks, interfaces, detection=detection)


STONE = bs.Material("Tuff – größer", "12 kN/m^3")


#: Friction, shares of it in dilatancy and in tension, and cohesion in kPa.
OF_JOINT = st.tuples(st.floats(0.2, 1), st.floats(0, 1), st.floats(0, 10, allow_subnormal=False), st.floats(0, 0.9))
NAMES = st.text(st.characters(categories=["L", "N", "P", "S"]), min_size=1, max_size=12).filter(str.strip)


@few(12)
@pytest.mark.filterwarnings("ignore::blockstruct.errors.UnusualValueWarning")
@given(name=NAMES, case_name=NAMES, of_joint=OF_JOINT)
def test_round_trip_of_any_names_and_joints(tmp_path_factory, name, case_name, of_joint):
    mu, share, c, ft = of_joint
    strengths = {"cohesion": Q_(c, "kPa"), "tensile_strength": Q_(ft * c / mu, "kPa")}
    joint = bs.JointMaterial("γ", mu, dilatancy_angle=Q_(share * np.arctan(mu), "rad"), **strengths)
    ground = bs.Block.box("ground", Q_([0, 0, -1], "m"), Q_([1, 1, 1], "m"), STONE, fixed=True)
    block = bs.Block.box("β/1", Q_([0, 0, 0], "ft"), Q_([2, 2, 1], "ft"), STONE)
    moment = bs.Moment("β/1", Q_([0, 0, c], "kN*m"))
    case = bs.LimitCase(case_name, bs.LoadPattern("dead", [moment]), push(1, 0, 0), flow="associative")
    analysis = bs.run(model_of([ground, block], joint, name), case)
    same(analysis, bs.open_analysis(bs.save_analysis(analysis, tmp_path_factory.mktemp("any") / "x.h5")))


@pytest.mark.parametrize("tied", [False, True])
def test_a_case_whose_solver_failed_is_kept(tied, tmp_path):
    """A dead load of next to nothing on sticky joints: no forces, no velocities, and no warning of numpy."""
    blocks = [box("ground", [0, 0, -1], fixed=True), box("block", [0, 0, 0])]
    sticky = bs.JointMaterial("sticky", 0.5, cohesion="1 kPa")
    dead = bs.LoadPattern("dead", [bs.Moment("block", Q_([0, 0, 1e-30], "kN*m"))])
    case = bs.LimitCase("push", dead, push(1, 0, 0), flow="associative")
    ends = ("ground", "[0, 0, -1] m"), ("block", "[1, 1, 1] m")
    ties = [bs.Tie("bar", *ends, yield_force="1e-30 kN")] if tied else []
    analysis = bs.AnalysisManager(model_of(blocks, sticky).with_ties(ties)).run([case])
    assert analysis["push"].status == "not_converged"
    assert np.isnan(analysis["push"].history["relative_velocity"]).all()
    bs.save_analysis(analysis, tmp_path / "x.h5")
    same(analysis, bs.open_analysis(tmp_path / "x.h5"))


def test_other_files_are_never_replaced(small_analysis, tmp_path):
    for name, content in (("notes.h5", b"notes"), ("x.h5", b"")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(bs.errors.StorageError, match="not replaced"):
            bs.save_analysis(small_analysis, tmp_path / name)
        assert (tmp_path / name).read_bytes() == content


def test_a_failed_write_leaves_nothing_behind(small_analysis, path, tmp_path, monkeypatch):
    target = tmp_path / "x.h5"
    shutil.copy(path, target)

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(run_folder.os, "fsync", full)
    with pytest.raises(bs.errors.StorageError, match=r"No space left.*free some space"):
        bs.save_analysis(small_analysis, target)
    assert target.read_bytes() == path.read_bytes()
    assert [p.name for p in tmp_path.iterdir()] == ["x.h5"]


def damage(group, name, value):
    return lambda file: file[group].attrs.__setitem__(name, value)


def delete(name):
    return lambda file: file.__delitem__(name)


def overwrite(name, value, at=...):
    return lambda file: file[name].__setitem__(at, value)


def relabel(name, texts):
    return overwrite(name, texts, slice(len(texts)))


def absurd(name):
    return lambda file: file.create_dataset(name, shape=(10**12,), dtype="f8", chunks=(1000,))


def left_out(name):
    """Keep the first iteration alone, in chunks, as a file that leaves iterations out has it."""

    def change(file):
        values, attrs, scales = file[name][()], dict(file[name].attrs), [file[name].dims[k][0] for k in range(3)]
        del file[name]
        item = file.create_dataset(name, values.shape, values.dtype, chunks=(1, *values.shape[1:]), fillvalue=np.nan)
        item[0] = values[0]
        item.attrs["units"] = attrs["units"]
        for k, scale in enumerate(scales):
            item.dims[k].attach_scale(scale)

    return change


def link(name, target):
    """Put a link or other values in a place."""

    def change(file):
        if name in file:
            del file[name]
        file[name] = target

    return change


def virtual(file):
    layout = h5py.VirtualLayout(shape=file[f"{HISTORY}/load_factor"].shape, dtype="f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "x", shape=layout.shape)
    file.create_virtual_dataset("/model/extra", layout)


def absurd_together(file):
    size = 20 * file.id.get_filesize()
    for k in range(6):
        file.create_dataset(f"/model/extra{k}", shape=(size,), dtype="i1", chunks=(1000,))


def one_text_many_times(file):
    """Every element points to the same long text in the heap of the file, as h5py would never write it."""
    text = "x" * (file.id.get_filesize() // 4)
    ds = file.create_dataset("/model/extra", (1000,), h5py.string_dtype())
    ds[0] = text
    # The reference of the first element, copied to all: length, address and index in the heap, 16 bytes.
    place = ds.id.get_offset()
    file.flush()
    name = file.filename
    file.close()
    content = bytearray(Path(name).read_bytes())
    content[place : place + 16_000] = content[place : place + 16] * 1000
    Path(name).write_bytes(content)


HISTORY = "/cases/push associative/history"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (damage("/", "format", "other"), ["/", "'other'", "not a blockstruct analysis"]),
        (damage("/", "format_version", "3.0"), ["format version 3.0", "update blockstruct"]),
        (damage("/", "format_version", "new"), ["'new'", "is not a version"]),
        (damage("/", "cases", "[]"), ["/cases"]),
        (damage("/", "model_hash", "0" * 64), ["/model", "model_hash"]),
        (damage("/cases/push associative", "status", "fine"), ["push associative", "'fine'"]),
        (damage("/cases/push associative", "dead", "nobody"), ["/cases/push associative", "nobody"]),
        (damage(f"{HISTORY}/contact_force", "units", "meter"), ["contact_force", "'meter'", "newton"]),
        (damage("/model/vertex_position", "units", "millimeter"), ["vertex_position", "millimeter"]),
        (damage("/", "versions", "[1]"), ["versions"]),
        (damage("/cases/push associative", "settings", "[1]"), ["/cases/push associative", "settings"]),
        (damage("/cases/push associative", "name", "other"), ["/cases/push associative", "name"]),
        (delete("/cases/push associative/flow_rule_gap"), ["/cases/push associative"]),
        (overwrite("/cases/push associative/flow_rule_gap", 1.0), ["/cases/push associative", "holds"]),
        (overwrite("/cases/push associative/load_factor", 99.0), ["/cases/push associative", "converged"]),
        (overwrite("/cases/push associative/holds", 0), ["/cases/push associative", "converged"]),
        (overwrite("/model/unit_weight", np.nan), ["/model", "not finite"]),
        (absurd("/model/extra"), ["/model", "extra", "absurd"]),
        (left_out("/cases/push nonassociative/history/contact_force"), ["contact_force", "not stored whole"]),
        (delete(HISTORY), ["push associative", "'history' is a required property"]),
        (overwrite("/model/minus_block", 99), ["/model/minus_block", "outside 0..7"]),
        (overwrite("/model/block_of_vertex", 0), ["/model"]),
        (overwrite("/model/vertex_position", 0.0), ["/model", "block"]),
        (overwrite(f"{HISTORY}/interface_of_contact_point", 1000), ["interface_of_contact_point", "outside"]),
        (overwrite("/cases/push associative/n_iterations", 7), ["n_iterations"]),
        (relabel(f"{HISTORY}/component", ["t", "s", "n"]), [f"{HISTORY}/component", "n, s, t"]),
        (relabel(f"{HISTORY}/stage", ["final"]), [f"{HISTORY}/stage", "'final' is none of"]),
        (relabel(f"{HISTORY}/solver_status", ["fine"]), [f"{HISTORY}/solver_status", "'fine' is none of"]),
        (relabel(f"{HISTORY}/contact_point", ["elsewhere"]), [f"{HISTORY}/contact_point", "their interfaces"]),
        (link(f"{HISTORY}/load_factor", np.array([1])), [f"{HISTORY}", "load_factor"]),
        (link(f"{HISTORY}/load_factor", h5py.ExternalLink("/etc/passwd", "/x")), ["load_factor", "link"]),
        (link("/model/extra", h5py.SoftLink("/model")), ["/model", "extra", "link"]),
        (absurd_together, ["/model/extra", "absurd"]),
        (one_text_many_times, ["/model/extra", "absurd"]),
        (lambda file: file.__setitem__("/model/extra", file["/model"]), ["/model", "extra"]),
        (virtual, ["/model/extra", "stored in another file"]),
        (
            lambda file: file["/model"].create_dataset("extra", (10,), "f8", external=[("/etc/passwd", 0, 80)]),
            ["/model/extra", "stored in another file"],
        ),
        (link("/model/unit_weight", np.array([b"heavy"])), ["/model/unit_weight"]),
    ],
)
def test_damaged_files_are_refused_with_the_place(path, tmp_path, change, words):
    copy = tmp_path / "copy.h5"
    with edited(path, copy) as file:
        change(file)
    for read in (bs.check_file, look_at_all_of):
        with pytest.raises(bs.errors.FormatError) as caught:
            read(copy)
        assert [word for word in [copy.name, *words] if word not in str(caught.value)] == []


def test_validation_lists_each_violation_with_its_path(path, tmp_path):
    with edited(path, copy := tmp_path / "copy.h5") as file:
        file["/model/unit_weight"].attrs["units"] = "kg"
        del file[f"{HISTORY}/load_factor"], file["/cases/push associative"].attrs["flow"]
        file.attrs["status"] = "fine"
    places = r"\s+/: attribute status.*\s+/cases/push associative.*\s+{HISTORY}.*\s+/model/unit_weight.*"
    with pytest.raises(bs.errors.FormatError, match=".*" + places.format(HISTORY=HISTORY) + "$"):
        bs.check_file(copy)


def look_at_all_of(path):
    for result in bs.open_analysis(path).values():
        assert result.history


DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_files_of_every_version_are_read_for_ever(version, tmp_path):
    found = bs.open_analysis(DATA / f"analysis-{version}.h5")
    assert found["rocking"].load_factor == pytest.approx(0.5, rel=1e-6)
    assert found["rocking"].certificate.holds
    assert found.tags == ("kept",)
    assert found.document_hash == "0" * 64
    assert found["sliding"].status == "converged"
    assert bs.reproduce(found).agrees(1e-3)
    same(found, bs.open_analysis(bs.save_analysis(found, tmp_path / "again.h5")))


def test_older_versions_migrate_step_by_step(path, monkeypatch):
    """As if this file were of an older version that had no tags."""

    def rename(groups):
        return {**groups, "/": groups["/"].assign_attrs(tags='["migrated"]')}

    monkeypatch.setattr(storage_file, "FORMAT_VERSION", "4.0")
    with pytest.raises(bs.errors.FormatError, match="format version 2: no migration to 3"):
        bs.open_analysis(path)
    monkeypatch.setitem(MIGRATIONS, (2, 3), lambda groups: groups)
    monkeypatch.setitem(MIGRATIONS, (3, 4), rename)
    assert bs.open_analysis(path).tags == ("migrated",)


def test_files_that_are_something_else(tmp_path):
    with pytest.raises(bs.errors.StorageError, match="no such file"):
        bs.open_analysis(tmp_path / "missing.h5")
    (tmp_path / "text.h5").write_text("not HDF5")
    with pytest.raises(bs.errors.FormatError, match="not a readable HDF5 file"):
        bs.open_analysis(tmp_path / "text.h5")
    xr.Dataset({"t": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(bs.errors.FormatError, match="not a blockstruct analysis"):
        bs.open_analysis(tmp_path / "other.nc")


MORTAR = bs.JointMaterial("m", 0.6, cohesion="1 kPa", tensile_strength="1 kPa", compressive_strength="1 MPa")
PUSH = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push(1, 0, 0))
IN_50_CELLS = bs.ProcedureSettings(crushing_cells=50)


@pytest.mark.parametrize(("stopped_after", "rectangular"), [(None, True), (0, True), (3, False)])
def test_cells_of_an_earlier_version_stay_as_they_are(tmp_path, stopped_after, rectangular):
    """Files with equal cells, also of rectangles with a tensile strength, are valid, continued and reproduced."""
    path, model = tmp_path / "x.h5", model_of(single_block(0.5, 1.0)[0], MORTAR)
    model = model if rectangular else divided(model)
    stop = [] if stopped_after is None else [stopping(IterationDone, at=stopped_after)]
    manager = bs.AnalysisManager(model, path, settings=IN_50_CELLS, listeners=stop)
    manager.statics = Statics.of(model, Division(50, (0,), regular=True))
    manager.run([PUSH])
    analysis = bs.AnalysisManager.resume(path)
    found = analysis["push"]
    assert found.status == "converged"
    assert found.history.sizes["contact_point"] == 50
    assert bs.results.contradictions(bs.open_analysis(path)) == []
    assert bs.results.recomputed_certificate(bs.open_analysis(path), "push").holds
    again = bs.AnalysisManager.again(analysis)["push"]
    assert again.load_factor == pytest.approx(found.load_factor, rel=1e-6)
    now = bs.AnalysisManager(model, settings=IN_50_CELLS).run([PUSH])["push"]
    assert now.history.sizes["contact_point"] == (4 if rectangular else 49)
    assert found.load_factor < now.load_factor
