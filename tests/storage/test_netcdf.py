"""A stored analysis is netCDF-4: every reader finds the same variables, values, dimensions and units."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr

import blockstruct as bs
import studied
from blockstruct.storage.file import folder_of
from structures import SELF_WEIGHT, block_on_a_bar, push

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "file-format.md").read_text(encoding="utf-8")
SCHEMA = json.loads((ROOT / "schemas" / "analysis-2.json").read_text(encoding="utf-8"))
KINDS = {"float": {"const": "f"}, "integer": {"enum": ["i", "u"]}, "text": {"const": "text"}}


@pytest.mark.parametrize(
    ("title", "group"),
    [("`/model`", "model"), ("a case", "case"), ("a history", "history"), ("a capacity curve", "capacity")],
    ids=lambda t: t,
)
def test_every_variable_is_stated_as_the_schema_has_it(title, group):
    section = PAGE.split(f"### Variables of {title}\n")[1].split("\n#")[0]
    rows = [[c.strip() for c in line.split("|")[1:-1]] for line in section.splitlines() if line.startswith("| `")]
    variables = SCHEMA["$defs"][group]["properties"]["variables"]
    assert [row[0].strip("`") for row in rows] == list(variables["properties"])
    for name, dims, kind, units, must, _ in rows:
        stated = variables["properties"][name.strip("`")]["properties"]
        assert stated["dims"]["const"] == ([] if dims == "scalar" else dims.split(", "))
        assert stated["kind"] == KINDS[kind]
        either = stated.get("units", {})
        assert " or ".join(either.get("enum", [either.get("const", "")])) == units
        assert (name.strip("`") in variables["required"]) == (must == "MUST")


def test_every_attribute_is_stated():
    for group, of_schema in (
        ("/", SCHEMA["properties"]),
        ("/model", SCHEMA["$defs"]["model"]["properties"]),
        ("/cases/<name>", SCHEMA["$defs"]["case"]["properties"]),
    ):
        lines = re.findall(rf"^\| `{re.escape(group)}` \| (.*?) \| MUST", PAGE, re.MULTILINE)
        assert set(re.findall(r"`(\w+)`", " ".join(lines))) == set(of_schema["attrs"]["required"])


@pytest.mark.parametrize("name", ["limit", "moves"])
def test_every_variable_tells_what_it_is(files, name):
    """As readers without blockstruct show it; flags count nothing, but have units as every number that is no index."""
    path, bare = files / f"{name}.h5", []

    def look(name, item):
        if isinstance(item, h5py.Dataset) and b"not a netCDF variable" not in bytes(item.attrs.get("NAME", b"")):
            bare.extend([] if item.attrs.get("long_name") else [name])
            assert item.dtype.kind != "f" or "units" in item.attrs, name

    with h5py.File(path) as file:
        file.visititems(look)
        of_detection = ("floating", "untouched", "near_miss_of_contact") if name == "limit" else ()
        for flag in ("fixed", *of_detection):
            assert file[f"model/{flag}"].attrs["units"] == "dimensionless"
        assert file["model/material_of_block"].attrs["long_name"] == "index of its material"
    assert bare == ["schema"]
    bs.check_file(path)


OLD = Path(__file__).parents[1] / "data" / "analysis-1.0.h5"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Files with every kind of case, and the working file that a run keeps while it goes on."""
    folder = tmp_path_factory.mktemp("netcdf")
    bar, weak = block_on_a_bar(), bs.JointMaterial("weak", 2.0, compressive_strength="1 MPa")
    crushes = bs.Model("weak", bar.blocks, bs.detect_interfaces(bar.blocks, weak), ties=bar.ties)
    loads = {"dead": SELF_WEIGHT, "variable": push(1, 0, 0)}
    limit = [bs.LimitCase(flow, flow=flow, **loads) for flow in bs.Flow]
    moves = [
        bs.SettlementCase("settlement", SELF_WEIGHT, ["post"], "-x", flow="associative"),
        bs.Pushover("pushover", **loads, control=("block", (1, 0, 0)), steps=3),
    ]

    def keep_plan(_):
        if not (folder / "plan.h5").exists():
            shutil.copy(folder_of(folder / "limit.h5") / "plan", folder / "plan.h5")

    settings = bs.ProcedureSettings(crushing_cells=16)
    manager = bs.AnalysisManager(crushes, folder / "limit.h5", settings=settings, listeners=[keep_plan])
    manager.run(limit, spread=["steep"])
    bs.run(bar, moves, folder / "moves.h5")
    bs.study(studied.pulled, {"friction_coefficient": [0.3]}, folder / "study", workers=1, listeners=[])
    shutil.move(next((folder / "study").glob("*.h5")), folder / "study.h5")
    return folder


@pytest.fixture(params=["limit", "plan", "moves", "study"])
def path(request, files):
    return files / f"{request.param}.h5"


def stored(path):
    """Dimensions, values and attributes of every variable, by its HDF5 path."""
    found, dimensions = {}, {}

    def look(name, item):
        if not isinstance(item, h5py.Dataset):
            return
        group = item.parent.name
        if item.is_scale:
            dimensions.setdefault(group, {})[Path(name).name] = len(item)
        if b"not a netCDF variable" in bytes(item.attrs.get("NAME", b"")):
            return
        dims = [Path(name).name] if item.is_scale else [Path(item.dims[k][0].name).name for k in range(item.ndim)]
        values = item.asstr()[()] if h5py.check_string_dtype(item.dtype) else item[()]
        attrs = {key: item.attrs[key] for key in ("units", "long_name") if key in item.attrs}
        found[f"/{name}"] = (tuple(dims), np.asarray(values), attrs)

    with h5py.File(path) as file:
        file.visititems(look)
    return found, dimensions


def check_same(seen, kept):
    assert seen.keys() == kept.keys()
    for name, (dims, values, attrs) in seen.items():
        assert tuple(dims) == kept[name][0]
        assert np.shape(values) == kept[name][1].shape
        np.testing.assert_array_equal(np.asarray(values), kept[name][1])
        assert {key: attrs[key] for key in kept[name][2]} == kept[name][2]


def groups_of(dataset):
    yield dataset
    for group in dataset.groups.values():
        yield from groups_of(group)


def check_netcdf(path, kept, dimensions):
    """Check all that the library of netCDF reads of a file."""
    seen = {}
    with netCDF4.Dataset(path) as root:
        for group in groups_of(root):
            assert {name: len(dim) for name, dim in group.dimensions.items()} == dimensions.get(group.path, {})
            for name, variable in group.variables.items():
                variable.set_auto_mask(False)
                attrs = {key: variable.getncattr(key) for key in variable.ncattrs()}
                seen[f"{group.path.rstrip('/')}/{name}"] = variable.dimensions, variable[...], attrs
    check_same(seen, kept)


def test_netcdf_reads_what_is_stored(path):
    check_netcdf(path, *stored(path))


@pytest.mark.parametrize(
    ("name", "engine"), [("moves", "h5netcdf"), *((name, "netcdf4") for name in ("limit", "plan", "moves", "study"))]
)
def test_xarray_reads_what_is_stored(files, name, engine):
    path = files / f"{name}.h5"
    kept, _ = stored(path)
    seen = {}
    with xr.open_datatree(path, engine=engine, decode_cf=False) as tree:
        for node in tree.subtree:
            with xr.open_dataset(path, group=node.path, engine=engine, decode_cf=False) as ds:
                assert ds.identical(node.to_dataset(inherit=False))
                for name, v in ds.variables.items():
                    seen[f"{node.path.rstrip('/')}/{name}"] = v.dims, v.values, v.attrs
    check_same(seen, kept)


@pytest.mark.skipif(shutil.which("ncdump") is None, reason="no ncdump: apt install netcdf-bin")
def test_ncdump_prints_what_is_stored(path, tmp_path):
    """Its text is made a file again, and that file holds the same."""
    text = subprocess.run(["ncdump", "-p", "9,17", path], check=True, capture_output=True, timeout=60).stdout
    (tmp_path / "again.cdl").write_bytes(text)
    subprocess.run(["ncgen", "-4", "-o", tmp_path / "again.nc", tmp_path / "again.cdl"], check=True, timeout=60)
    check_netcdf(tmp_path / "again.nc", *stored(path))


@pytest.mark.parametrize("how", ["save", "migrate"])
def test_a_file_that_netcdf_reads_short_is_written_anew(how, call, tmp_path):
    """Numbers of dimensions began at 0 in each group: netCDF takes one of another group, and its length."""
    path = tmp_path / "old.h5"
    shutil.copy(OLD, path)
    kept, dimensions = stored(path)
    with pytest.raises((AssertionError, RuntimeError, IndexError)):
        check_netcdf(path, kept, dimensions)
    analysis = bs.open_analysis(path)
    if how == "save":
        bs.save_analysis(analysis, path)
    else:
        assert call("migrate", path) == (0, f"written: {path}\n", "")
    assert all(analysis[name].history.identical(r.history) for name, r in bs.open_analysis(path).items())
    check_netcdf(path, *stored(path))


def test_models_that_differ_in_numbers_share_no_number(tmp_path):
    """Files of models with the same names and shapes, made one after the other."""
    bar, path = block_on_a_bar(), tmp_path / "bar.h5"
    cases = [bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), flow="associative")]
    joints = [
        bs.JointMaterial("lime", mu, torsion=torsion) for torsion in bs.vocabulary.Torsion for mu in (0.2, 0.5, 0.2)
    ]
    for joint in joints:
        model = bs.Model("bar", bar.blocks, bs.detect_interfaces(bar.blocks, joint), ties=bar.ties)
        bs.run(model, cases, path)
        assert bs.check_file(path)
        assert bs.open_analysis(path).model.joint_materials["lime"] == joint
        with netCDF4.Dataset(path) as file:
            assert file["model/friction_coefficient"][:].tolist() == [joint.friction_coefficient]
