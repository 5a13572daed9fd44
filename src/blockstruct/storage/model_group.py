"""The model as a Dataset, ragged data flat, and back."""

from typing import Any

import numpy as np
import xarray as xr

from blockstruct.geometry import polyhedron
from blockstruct.model import (
    JOINT_PROPERTIES,
    LOAD_KINDS,
    Block,
    Interface,
    JointMaterial,
    Load,
    LoadPattern,
    Material,
    Model,
    kind_of,
)
from blockstruct.storage.detection_part import detection_variables, read_detection
from blockstruct.storage.tie_part import tie_variables, ties_of
from blockstruct.units import SI_UNITS, to_quantity
from blockstruct.vocabulary import AXES, Torsion

#: Every vector of a load, and every number, with its dimension.
_VECTORS = {name: dimension for kind in LOAD_KINDS.values() for name, dimension in kind.vectors.items()}
_NUMBERS = {name: "dimensionless" for kind in LOAD_KINDS.values() for name in kind.plain} | {
    name: dimension for kind in LOAD_KINDS.values() for name, dimension in kind.quantities.items()
}
#: Of the first loads there were: always there.
_ALWAYS = ("direction", "point", "force", "traction", "moment", "share")


def model_dataset(model: Model, patterns: list[LoadPattern]) -> xr.Dataset:
    """Everything a model and its load patterns are made of."""
    materials, joints = list(model.materials), list(model.joint_materials)
    blocks, interfaces = model.blocks, model.interfaces
    index = {b.name: i for i, b in enumerate(blocks)}
    n_vertices = [len(b.shape.vertices) for b in blocks]
    first_vertex = np.cumsum([0, *n_vertices[:-1]])
    faces = [(i, face) for i, b in enumerate(blocks) for face in b.shape.faces]
    loads = [(p, load) for p, pattern in enumerate(patterns) for load in pattern.loads]

    def integers(values: Any) -> np.ndarray:
        return np.asarray(values, dtype=np.int64)

    variables: dict[str, Any] = {
        "unit_weight": (
            "material",
            [m.unit_weight for m in model.materials.values()],
            {"units": SI_UNITS["force/volume"]},
        ),
        "material_of_block": ("block", integers([materials.index(b.material.name) for b in blocks])),
        "fixed": ("block", np.array([b.fixed for b in blocks], dtype=np.int8), {"units": SI_UNITS["dimensionless"]}),
        "volume": ("block", [b.volume for b in blocks], {"units": SI_UNITS["volume"]}),
        "centroid": (("block", "axis"), [b.centroid for b in blocks], {"units": SI_UNITS["length"]}),
        "vertex_position": (
            ("vertex", "axis"),
            np.concatenate([b.shape.vertices for b in blocks]),
            {"units": SI_UNITS["length"]},
        ),
        "block_of_vertex": ("vertex", np.repeat(np.arange(len(blocks)), n_vertices)),
        "block_of_face": ("face", integers([i for i, _ in faces])),
        "face_of_face_corner": ("face_corner", np.repeat(np.arange(len(faces)), [len(f) for _, f in faces])),
        "vertex_of_face_corner": ("face_corner", np.concatenate([first_vertex[i] + integers(f) for i, f in faces])),
        "minus_block": ("interface", integers([index[i.minus] for i in interfaces])),
        "plus_block": ("interface", integers([index[i.plus] for i in interfaces])),
        "joint_material_of_interface": (
            "interface",
            integers([joints.index(i.joint_material.name) for i in interfaces]),
        ),
        "area": ("interface", [i.area for i in interfaces], {"units": SI_UNITS["area"]}),
        "interface_corner_position": (
            ("interface_corner", "axis"),
            np.concatenate([i.polygon for i in interfaces]),
            {"units": SI_UNITS["length"]},
        ),
        "interface_of_interface_corner": (
            "interface_corner",
            np.repeat(np.arange(len(interfaces)), [len(i.polygon) for i in interfaces]),
        ),
        "pattern_of_load": ("load", integers([p for p, _ in loads])),
        "kind_of_load": ("load", _texts([kind_of(load) for _, load in loads])),
        "block_of_load": ("load", integers([index.get(getattr(load, "block", None) or "", -1) for _, load in loads])),
        "face_of_load": ("load", integers([getattr(load, "face", -1) for _, load in loads])),
    }
    for name, joint_property in JOINT_PROPERTIES.items():
        values = [getattr(j, name) for j in model.joint_materials.values()]
        variables[name] = ("joint_material", values, {"units": SI_UNITS[joint_property.dimension]})
    variables["torsion"] = ("joint_material", _texts([str(j.torsion) for j in model.joint_materials.values()]))
    for name, dimension in (_VECTORS | _NUMBERS).items():
        found = [getattr(load, name, None) for _, load in loads]
        if name not in _ALWAYS and all(value is None for value in found):
            continue
        absent, dims = ((np.nan,) * 3, ("load", "axis")) if name in _VECTORS else (np.nan, ("load",))
        numbers = np.array([absent if value is None else value for value in found], dtype=float)
        shape = (len(loads), *([3] if name in _VECTORS else []))
        variables[f"{name}_of_load"] = (dims, numbers.reshape(shape), {"units": SI_UNITS[dimension]})
    sources = {
        "material": [m.source for m in model.materials.values()],
        "joint_material": [m.source for m in model.joint_materials.values()],
    }
    variables |= {f"source_of_{dim}": (dim, _texts(texts)) for dim, texts in sources.items() if any(texts)}
    names = [b.name for b in blocks], [i.name for i in interfaces]
    if model.detection is not None:
        variables |= detection_variables(model.detection, *names)
    variables |= tie_variables(model)
    coords = {
        "axis": _texts(AXES),
        "material": _texts(materials),
        "joint_material": _texts(joints),
        "block": _texts(names[0]),
        "interface": _texts(names[1]),
        "load_pattern": _texts([p.name for p in patterns]),
    }
    return xr.Dataset(variables, coords=coords, attrs={"name": model.name})


def read_model(ds: xr.Dataset) -> Model:
    """Model of a Dataset, built through the same constructors and checks as any other."""
    materials = [
        Material(str(name), to_quantity(value, "force/volume"), source=source)
        for name, value, source in zip(
            ds["material"].to_numpy(), ds["unit_weight"].to_numpy(), _sources(ds, "material"), strict=True
        )
    ]
    joints = [_joint(ds, k) for k in range(ds.sizes["joint_material"])]
    vertices = _parts(ds["vertex_position"].to_numpy(), ds["block_of_vertex"].to_numpy(), ds.sizes["block"])
    first = np.searchsorted(ds["block_of_vertex"].to_numpy(), np.arange(ds.sizes["block"]))
    corners = _parts(ds["vertex_of_face_corner"].to_numpy(), ds["face_of_face_corner"].to_numpy(), ds.sizes["face"])
    faces: list[list[list[int]]] = [[] for _ in range(ds.sizes["block"])]
    for block, corner in zip(ds["block_of_face"].to_numpy(), corners, strict=True):
        faces[block].append((corner - first[block]).tolist())
    blocks = [
        Block(str(name), polyhedron(v, f, str(name)), materials[m], bool(fixed))
        for name, v, f, m, fixed in zip(
            ds["block"].to_numpy(),
            vertices,
            faces,
            ds["material_of_block"].to_numpy(),
            ds["fixed"].to_numpy(),
            strict=True,
        )
    ]
    owner = ds["interface_of_interface_corner"].to_numpy()
    polygons = _parts(ds["interface_corner_position"].to_numpy(), owner, ds.sizes["interface"])
    interfaces = [
        Interface(str(name), blocks[minus].name, blocks[plus].name, to_quantity(polygon, "length"), joints[joint])
        for name, minus, plus, polygon, joint in zip(
            ds["interface"].to_numpy(),
            ds["minus_block"].to_numpy(),
            ds["plus_block"].to_numpy(),
            polygons,
            ds["joint_material_of_interface"].to_numpy(),
            strict=True,
        )
    ]
    return Model(ds.attrs["name"], blocks, interfaces, detection=read_detection(ds), ties=ties_of(ds))


def read_patterns(ds: xr.Dataset) -> dict[str, LoadPattern]:
    """Load patterns of a Dataset by name."""
    names = [str(name) for name in ds["load_pattern"].to_numpy()]
    loads: list[list[Load]] = [[] for _ in names]
    for k, pattern in enumerate(ds["pattern_of_load"].to_numpy()):
        loads[pattern].append(_load(ds, k))
    return {name: LoadPattern(name, items) for name, items in zip(names, loads, strict=True)}


def _joint(ds: xr.Dataset, k: int) -> JointMaterial:
    values = {name: float(ds[name].to_numpy()[k]) for name in JOINT_PROPERTIES}
    # Files of the first version know no torsion but that of corners.
    torsion = str(ds["torsion"].to_numpy()[k]) if "torsion" in ds else Torsion.CORNERS
    source = _sources(ds, "joint_material")[k]
    return JointMaterial.from_si(str(ds["joint_material"].to_numpy()[k]), values, torsion, source)


def _sources(ds: xr.Dataset, dim: str) -> list[str]:
    name = f"source_of_{dim}"
    return [str(text) for text in ds[name].to_numpy()] if name in ds else [""] * ds.sizes[dim]


def _load(ds: xr.Dataset, k: int) -> Load:
    kind = LOAD_KINDS[str(ds["kind_of_load"].to_numpy()[k])]
    block = int(ds["block_of_load"].to_numpy()[k])
    given: dict[str, Any] = {
        "block": str(ds["block"].to_numpy()[block]) if block >= 0 else None,
        "face": int(ds["face_of_load"].to_numpy()[k]),
    }
    arguments = {name: given[name] for name in kind.named}
    for name, dimension in {**kind.vectors, **kind.quantities}.items():
        stored = ds[f"{name}_of_load"].to_numpy()[k] if f"{name}_of_load" in ds else np.nan
        arguments[name] = None if name in kind.absent and np.isnan(stored).all() else to_quantity(stored, dimension)
    for name, default in kind.plain.items():
        arguments[name] = type(default)(ds[f"{name}_of_load"].to_numpy()[k])
    return kind.type(**arguments)


def _parts(values: np.ndarray, owner: np.ndarray, n: int) -> list[np.ndarray]:
    """Values of each of n owners; the owners are in ascending order."""
    return np.split(values, np.searchsorted(owner, np.arange(1, n)))


def _texts(values: Any) -> np.ndarray:
    return np.array(list(values), dtype=object)
