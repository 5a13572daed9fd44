"""Export for ParaView: one ``.pvd`` file per case, with iterations as times (extra ``viz``).

In ParaView open the ``.pvd`` file. *Warp By Vector* with ``mechanism`` moves the blocks, *Glyph* with ``resultant``
draws the forces.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.arrays import Array
from blockstruct.files import writing
from blockstruct.views.export.motion import Motion, motion_of_states
from blockstruct.views.output import target_with, write_text
from blockstruct.views.selection import application_points, given_result
from blockstruct.views.solids import Patches, Solids, TieLines, triangles

try:
    import pyvista as pv
    from vtkmodules.vtkCommonCore import vtkStringArray
except ModuleNotFoundError as error:
    raise bs.errors.MissingExtraError.of(error, "viz", "export to ParaView") from error


_PIECE = re.compile(
    r"(blocks|interfaces|forces|resultants|ties|pushover|pushed-ties|response|response-ties)-\d{4,}\.vtp"
)

#: Names of displaced pieces in ParaView.
_ARRAYS = {"pushover": "blocks", "pushed-ties": "ties", "response": "blocks", "response-ties": "ties"}
#: Figures of a displaced state in its field data.
_GROUND = "ground acceleration [meter / second ** 2]"
_OF_CURVE = {
    "load factor [dimensionless]": "load_factor",
    "displacement of the control point [meter]": "displacement",
    "reaction [newton]": "reaction",
}


def write_paraview(result: bs.CaseResult, path: str | Path) -> Path:
    """Write the blocks, interfaces and forces of all iterations of a case.

    A pushover has a second file, ``NAME-pushover.pvd``, of its displaced blocks and ties. Its time is the step, and the
    displacement of the control point is in the field data. Displaced blocks and ties of a record have its times.

    Parameters
    ----------
    result
        The result of a case.
    path
        The ``.pvd`` file. Its ``.vtp`` pieces go into a folder of the same name without suffix, and replace pieces of
        an earlier case. Names of arrays contain the unit: ``resultant [newton]``, ``area [meter ** 2]``. ``mechanism``
        is the displacement of the vertices for a largest translation of 1 m. Each state has an array, 1 for interfaces
        in that state. Field data hold the names of blocks and interfaces in UTF-8. Without compressed interfaces, the
        piece of resultants is empty.

    Raises
    ------
    ModelError
        If the argument is not a result, or the case has no iterations.
    StorageError
        If the path does not end in ``.pvd`` or cannot be written.
    """
    target, model = target_with(path, ".pvd"), given_result(result, "write_paraview").model
    if not result.n_iterations and result.response is None:
        ended = str(result.headline)
        msg = f"case {result.name!r}: no iteration to export, {ended}; run the case again"
        raise bs.errors.ModelError(msg)
    folder = target.with_suffix("")
    plain, pushed = _collection(), _collection()
    still, written = _Still(model), set[Path]()
    with writing(target):
        folder.mkdir(parents=True, exist_ok=True)
        for is_pushed, k, time, pieces in still.states(result):
            for part, (kind, piece) in enumerate(pieces.items()):
                name = f"{kind}-{k:04}.vtp"
                piece.save(folder / name)
                written.add(folder / name)
                entry = {"timestep": time, "part": str(part), "name": _ARRAYS.get(kind, kind)}
                entry |= {"file": f"{folder.name}/{name}"}
                ElementTree.SubElement((pushed if is_pushed else plain)[0], "DataSet", entry)
        for old in set(folder.iterdir()) - written:
            if _PIECE.fullmatch(old.name):
                old.unlink()
    of_pushover = target.with_name(f"{target.stem}-pushover.pvd")
    if len(pushed[0]):
        _write_collection(pushed, of_pushover)
    else:
        of_pushover.unlink(missing_ok=True)
    return _write_collection(plain, target)


def _collection() -> ElementTree.Element:
    """Return a file of pieces; its only element lists them."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    ElementTree.SubElement(root, "Collection")
    return root


def _write_collection(root: ElementTree.Element, target: Path) -> Path:
    ElementTree.indent(root)
    return write_text(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True).decode(), target)


class _Still:
    """Geometry that all iterations share."""

    def __init__(self, model: bs.Model) -> None:
        self.solids = Solids.of(model)
        corners, of_face = triangles(self.solids.vertices, self.solids.loops)
        self.blocks = pv.PolyData.from_regular_faces(self.solids.vertices, corners)
        self.blocks.cell_data["block"] = self.solids.block_of_face[of_face]
        self.blocks.cell_data["fixed"] = np.array([b.fixed for b in model.blocks], dtype=np.uint8)[
            self.blocks.cell_data["block"]
        ]
        _name(self.blocks, "block names", [b.name for b in model.blocks])

        patches = Patches.of(model)
        self.of_triangle = patches.of_triangle
        self.interfaces = pv.PolyData.from_regular_faces(patches.vertices, patches.corners)
        self.interfaces.cell_data["interface"] = self.of_triangle
        areas = np.array([i.area for i in model.interfaces])
        self.interfaces.cell_data["area [meter ** 2]"] = areas[self.of_triangle]
        _name(self.interfaces, "interface names", [i.name for i in model.interfaces])
        self.ties = TieLines.of(model)

    def states(self, result: bs.CaseResult) -> Iterator[tuple[bool, int, str, dict[str, "pv.PolyData"]]]:
        """Return the pieces of each state with its number and time, and whether it is of the pushover."""
        response, curve = result.response, result.capacity
        if response is None:
            yield from ((False, i, str(i), self.pieces(result, i)) for i in range(result.n_iterations))
        else:
            motion = motion_of_states(result)
            figures = {"time [second]": response["time"], _GROUND: response["ground_acceleration"]}
            for k, pieces in enumerate(self.moved(result, response, motion, ("response", "response-ties"), figures)):
                yield False, k, f"{motion.time[k]:.9g}", pieces
        if curve is not None:
            figures = {label: curve[name] for label, name in _OF_CURVE.items() if name in curve}
            kinds = ("pushover", "pushed-ties")
            for k, pieces in enumerate(self.moved(result, curve, motion_of_states(result), kinds, figures)):
                yield True, k, str(k), pieces

    def pieces(self, result: bs.CaseResult, iteration: int) -> dict[str, "pv.PolyData"]:
        """Return blocks, interfaces, contact forces and resultants of an iteration."""
        history = result.history.isel(iteration=[iteration])
        blocks, interfaces = self.blocks.copy(), self.interfaces.copy()
        blocks.point_data["mechanism"] = self.solids.displacement(result, iteration)
        states = bs.results.contact_state(history).to_numpy()[0]
        for name in bs.vocabulary.ContactState:
            flag = np.array([name.value in state.split(" + ") for state in states], dtype=np.uint8)
            interfaces.cell_data[name.value] = flag[self.of_triangle]
        used = bs.results.utilisation(history).isel(iteration=0)
        for kind in ("sliding", "crushing"):
            interfaces.cell_data[f"utilisation of {kind} [dimensionless]"] = used[kind].to_numpy()[self.of_triangle]
        point, force = application_points(result, iteration)
        interfaces.cell_data["resultant [newton]"] = force[self.of_triangle]
        pressed = np.isfinite(point).all(axis=1)

        at_points = pv.PolyData(np.asarray(history["contact_point_position"].to_numpy(), dtype=float))
        last = history.isel(iteration=0)
        at_points.point_data["contact force [newton]"] = bs.results.contact_forces(last)
        at_points.point_data["normal force [newton]"] = last["contact_force"].sel(component="n").to_numpy()
        at_points.point_data["interface"] = history["interface_of_contact_point"].to_numpy()
        resultants = pv.PolyData()
        # VTK allows no empty array.
        if pressed.any():
            resultants = pv.PolyData(point[pressed])
            resultants.point_data["resultant [newton]"] = force[pressed]
            resultants.point_data["interface"] = np.flatnonzero(pressed)
        pieces = {"blocks": blocks, "interfaces": interfaces, "forces": at_points, "resultants": resultants}
        if result.model.ties:
            pieces["ties"] = self._ties(result, iteration)
        number = history["reaction" if "reaction" in history else "load_factor"]
        label = f"{str(number.name).replace('_', ' ')} [{number.attrs['units']}]"
        for piece in pieces.values():
            piece.field_data[label] = [float(number.to_numpy()[0])]
        return pieces

    def moved(
        self,
        result: bs.CaseResult,
        states: xr.Dataset,
        motion: Motion,
        kinds: tuple[str, str],
        figures: Mapping[str, xr.DataArray],
    ) -> Iterator[dict[str, "pv.PolyData"]]:
        """Return the displaced blocks and ties of each state of a curve or a response, with some of its figures."""
        has_ties = "tie_force" in states
        of_ties = bs.results.pushed_tie_state(result.model, states).to_numpy() if has_ties else np.empty(0)
        along = "step" if "step" in states.dims else "time"
        for k in range(len(motion.time)):
            blocks = self.blocks.copy()
            blocks.points = moved = motion.points(self.solids, k)
            blocks.point_data["displacement [meter]"] = moved - self.solids.vertices
            pieces = {kinds[0]: blocks}
            if has_ties:
                ends = motion.moved(self.ties.ends, self.ties.blocks, self.solids.centroids, k)
                pieces[kinds[1]] = self._moved_ties(ends, states.isel({along: k}), of_ties[k])
            for piece in pieces.values():
                for label, values in figures.items():
                    piece.field_data[label] = np.atleast_1d(values[k])
            yield pieces

    def _moved_ties(self, ends: Array, at: xr.Dataset, states: NDArray[np.object_]) -> "pv.PolyData":
        """Return ties between moved ends (M, 2, 3), with their forces and elongations in a state."""
        piece = self._tie_lines(ends, at["tie_force"].to_numpy(), states)
        piece.cell_data["elongation [meter]"] = at["tie_elongation"].to_numpy()
        return piece

    def _ties(self, result: bs.CaseResult, iteration: int) -> "pv.PolyData":
        history = result.history.isel(iteration=[iteration])
        force, states = history["tie_force"].to_numpy()[0], bs.ties.tie_state(history).to_numpy()[0]
        piece = self._tie_lines(self.ties.ends, force, states)
        piece.point_data["mechanism"] = self.ties.displacement(result, iteration).reshape(-1, 3)
        return piece

    def _tie_lines(self, ends: Array, force: Array, states: NDArray[np.object_]) -> "pv.PolyData":
        """Return ties as lines between their ends (M, 2, 3), with forces, N, and states."""
        count = len(self.ties.names)
        pairs = np.column_stack([np.full(count, 2), np.arange(2 * count).reshape(-1, 2)])
        piece = pv.PolyData(ends.reshape(-1, 3), lines=pairs.ravel())
        piece.cell_data["tie"] = np.arange(count)
        piece.cell_data["tension [newton]"] = force
        for name in bs.ties.TieState:
            piece.cell_data[name.value] = np.array(states == name.value, dtype=np.uint8)
        _name(piece, "tie names", self.ties.names)
        return piece


def _name(piece: "pv.PolyData", kind: str, names: Iterable[str]) -> None:
    """Add names to the field data as an array of VTK, since an array of pyvista takes ASCII only."""
    array = vtkStringArray()
    array.SetName(kind)
    for name in names:
        array.InsertNextValue(name)
    piece.GetFieldData().AddArray(array)
