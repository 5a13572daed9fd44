"""Tables of an analysis for Excel and as CSV."""

import io
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

import blockstruct as bs
from blockstruct.files import without_formulas
from blockstruct.views.output import made_folder, write_bytes, write_csv
from blockstruct.views.selection import shown_results


def tables(analysis: bs.Analysis) -> dict[str, pd.DataFrame]:
    """Return the tables of an analysis: cases, blocks, interfaces, iterations, and states of motions and ties.

    Forces, states and mechanism belong to the last iteration. Units are in the column names. Tables without rows are
    left out.
    """
    every = list(shown_results(analysis))
    results = [result for result in every if result.n_iterations]
    tables = {
        "cases": pd.DataFrame([_case(result) for result in every]).set_index("case"),
        "blocks": _together(results, _blocks),
        "interfaces": _together(results, _interfaces),
        "iterations": _together(results, lambda result: result.history.blockstruct.convergence()),
        "pushover": _together(results, lambda result: _states(result.capacity)),
        "response": _together(every, lambda result: _states(result.response)),
        "ties": _together(results, lambda result: result.ties),
    }
    return {name: table for name, table in tables.items() if len(table)}


def write_tables(analysis: bs.Analysis, path: str | Path) -> Path:
    """Write the tables of an analysis as sheets of an Excel file, or as CSV files into a folder.

    Parameters
    ----------
    analysis
        An analysis.
    path
        A ``.xlsx`` file, which needs ``pip install "blockstruct[excel]"``, or a folder. Existing files are replaced.

    Raises
    ------
    MissingExtraError
        If openpyxl is not installed.
    StorageError
        If the path has another suffix or cannot be written.
    """
    target, found = Path(path), tables(analysis)
    if target.suffix.lower() == ".xlsx":
        try:
            import_module("openpyxl")  # pandas writes with it
        except ModuleNotFoundError as error:
            raise bs.errors.MissingExtraError.of(error, "excel", "export to Excel") from error
        content = io.BytesIO()
        with pd.ExcelWriter(content, engine="openpyxl") as book:
            for name, table in found.items():
                levels, plain = table.index.nlevels, without_formulas(table).reset_index()
                plain.to_excel(book, sheet_name=name, index=False, freeze_panes=(1, levels))
        return write_bytes(content.getvalue(), target)
    if target.suffix:
        msg = f"{target}: give a name that ends in .xlsx, or a folder for CSV files"
        raise bs.errors.StorageError(msg)
    made_folder(target)
    for name, table in found.items():
        write_csv(table, target / f"{name}.csv")
    return target


def _together(results: list[bs.CaseResult], table: Callable[[bs.CaseResult], pd.DataFrame]) -> pd.DataFrame:
    """Return the tables of all results as one, with the case in the index."""
    parts = {result.name: table(result) for result in results}
    parts = {name: part for name, part in parts.items() if len(part)}
    return pd.concat(parts, names=["case"]) if parts else pd.DataFrame()


def _case(result: bs.CaseResult) -> dict[str, object]:
    certificate = result.certificate
    return {
        "case": result.name,
        "flow": result.case.flow.value,
        "status": result.status.value,
        "load factor": result.load_factor,
        **({f"reaction [{result.answer.unit}]": result.reaction.magnitude} if result.answer.is_reaction else {}),
        "result": str(result.headline),
        "iterations": result.n_iterations,
        "duration [second]": result.duration,
        **({} if certificate is None else certificate.measures),
    }


def _states(motion: xr.Dataset | None) -> pd.DataFrame:
    return pd.DataFrame() if motion is None else bs.results.capacity_frame(motion)


def _blocks(result: bs.CaseResult) -> pd.DataFrame:
    motion, blocks = result.mechanism, result.model.blocks
    centroid = np.array([b.centroid for b in blocks])
    columns = {
        "material": [b.material.name for b in blocks],
        "fixed": [b.fixed for b in blocks],
        "held": [", ".join(b.held) for b in blocks],
        "volume [meter ** 3]": [b.volume for b in blocks],
        "weight [newton]": [b.weight for b in blocks],
    }
    for k, axis in enumerate("xyz"):
        columns[f"{axis} [meter]"] = centroid[:, k].tolist()
    for name, label in (("translation", "translation {}"), ("rotation", "rotation {} [radian / meter]")):
        for axis in "xyz":
            columns[label.format(axis)] = motion[name].sel(axis=axis).to_numpy().tolist()
    return pd.DataFrame(columns, index=pd.Index([b.name for b in blocks], name="block"))


def _interfaces(result: bs.CaseResult) -> pd.DataFrame:
    interfaces, last = result.model.interfaces, result.history.isel(iteration=[-1])
    resultants, used = bs.results.interface_resultants(last).isel(iteration=0), bs.results.utilisation(last)
    columns = {
        "minus": [i.minus for i in interfaces],
        "plus": [i.plus for i in interfaces],
        "joint": [i.joint_material.name for i in interfaces],
        "area [meter ** 2]": [i.area for i in interfaces],
        "state": bs.results.contact_state(last).to_numpy()[0].tolist(),
    }
    for name, labels, unit in (
        ("force", ("N", "V_s", "V_t"), "newton"),
        ("moment", ("M_n", "M_s", "M_t"), "newton * meter"),
        ("eccentricity", ("e_s", "e_t"), "meter"),
    ):
        values = resultants[name].transpose("interface", ...).to_numpy()
        columns |= {f"{label} [{unit}]": values[:, k].tolist() for k, label in enumerate(labels)}
    for kind in ("sliding", "crushing"):
        columns[f"utilisation of {kind}"] = used[kind].isel(iteration=0).to_numpy().tolist()
    return pd.DataFrame(columns, index=pd.Index([i.name for i in interfaces], name="interface"))
