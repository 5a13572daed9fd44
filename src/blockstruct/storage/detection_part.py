"""How the interfaces were found, as variables of the model's Dataset, and back."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.model import DetectionReport, DetectionTolerances, FoundContact
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import JointOrientation

#: Variable and dimension of each tolerance.
_TOLERANCES = {
    "gap": ("gap_tolerance", "length"),
    "angle": ("angle_tolerance", "angle"),
    "area": ("area_tolerance", "area"),
    "close": ("close_distance", "length"),
}
_MEASURES = {"gap": "length", "angle": "angle", "area": "area"}
#: Pairs of blocks: field of the report, its dimension in the file, what is measured.
_PAIRS = (("overlaps", "overlap", "depth"), ("close", "close_pair", "distance"))


def detection_variables(report: DetectionReport, blocks: Sequence[str], interfaces: Sequence[str]) -> dict[str, Any]:
    """Variables of a report, for a model with these blocks and interfaces."""
    block = {name: i for i, name in enumerate(blocks)}
    interface = {name: i for i, name in enumerate(interfaces)} | {"": -1}
    contacts, flag = report.contacts, {"units": SI_UNITS["dimensionless"]}
    variables: dict[str, Any] = {
        name: ((), getattr(report.tolerances, field), {"units": SI_UNITS[dimension]})
        for field, (name, dimension) in _TOLERANCES.items()
    }
    variables |= {
        "minus_of_contact": ("contact", _integers(block[c.minus] for c in contacts)),
        "plus_of_contact": ("contact", _integers(block[c.plus] for c in contacts)),
        "interface_of_contact": ("contact", _integers(interface[c.interface] for c in contacts)),
        "reason_of_contact": ("contact", np.array([c.reason for c in contacts], dtype=object)),
        "orientation_of_contact": ("contact", np.array([c.orientation.value for c in contacts], dtype=object)),
        "near_miss_of_contact": ("contact", _integers(c.near_miss for c in contacts), flag),
    }
    for name, dimension in _MEASURES.items():
        variables[f"{name}_of_contact"] = _floats("contact", [getattr(c, name) for c in contacts], dimension)
    for field, dim, measure in _PAIRS:
        found = getattr(report, field)
        variables[f"first_of_{dim}"] = (dim, _integers(block[first] for first, _, _ in found))
        variables[f"second_of_{dim}"] = (dim, _integers(block[second] for _, second, _ in found))
        variables[f"{measure}_of_{dim}"] = _floats(dim, [value for _, _, value in found], "length")
    faces = report.nonplanar_faces
    variables["block_of_nonplanar_face"] = ("nonplanar_face", _integers(block[name] for name, _, _ in faces))
    variables["face_of_nonplanar_face"] = ("nonplanar_face", _integers(face for _, face, _ in faces))
    variables["deviation_of_nonplanar_face"] = _floats("nonplanar_face", [off for _, _, off in faces], "length")
    for name in ("floating", "untouched"):
        variables[name] = ("block", np.isin(blocks, getattr(report, name)).astype(np.int8), flag)
    return variables


def read_detection(ds: xr.Dataset) -> DetectionReport | None:
    """Report that a model's Dataset holds; None without one."""
    if "gap_tolerance" not in ds:
        return None
    block = [str(name) for name in ds["block"].to_numpy()]
    # The last entry, of index −1, is that of a contact left out.
    interface = [*(str(name) for name in ds["interface"].to_numpy()), ""]

    def values(*names: str) -> Any:
        return zip(*(ds[name].to_numpy().tolist() for name in names), strict=True)

    pairs = {
        field: tuple(
            (block[i], block[j], value)
            for i, j, value in values(f"first_of_{dim}", f"second_of_{dim}", f"{measure}_of_{dim}")
        )
        for field, dim, measure in _PAIRS
    }
    columns = [
        f"{name}_of_contact"
        for name in ("minus", "plus", "interface", "reason", *_MEASURES, "orientation", "near_miss")
    ]
    faces = [f"{name}_of_nonplanar_face" for name in ("block", "face", "deviation")]
    return DetectionReport(
        DetectionTolerances(**{field: float(ds[name]) for field, (name, _) in _TOLERANCES.items()}),
        tuple(
            FoundContact(block[i], block[j], interface[k], reason, gap, angle, area, JointOrientation(lie), bool(near))
            for i, j, k, reason, gap, angle, area, lie, near in values(*columns)
        ),
        nonplanar_faces=tuple((block[i], face, off) for i, face, off in values(*faces)),
        floating=tuple(name for name, flag in zip(block, ds["floating"].to_numpy(), strict=True) if flag),
        untouched=tuple(name for name, flag in zip(block, ds["untouched"].to_numpy(), strict=True) if flag),
        **pairs,
    )


def _integers(values: Any) -> np.ndarray:
    return np.array(list(values), dtype=np.int64)


def _floats(dim: str, values: list[float], dimension: str) -> tuple[str, np.ndarray, dict[str, str]]:
    return dim, np.array(values, dtype=float), {"units": SI_UNITS[dimension]}
