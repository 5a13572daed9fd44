"""Commands on model documents, and the check of any file."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Annotated, Any

import typer

import blockstruct as bs
from blockstruct.cli.app import Exit, app, argument, option, say
from blockstruct.vocabulary import counted


@app.command("import")
def import_(
    files: Annotated[list[Path], argument("OBJ, STL, PLY, DXF, Rhino 3DM, IFC or COMPAS JSON files.")],
    output: Annotated[Path, option("Model document to write.", "--output", "-o")],
    unit_weight: Annotated[
        list[str], option("Unit weight, '20 kN/m^3', or of one layer or IFC material, 'WALL=20 kN/m^3'.")
    ],
    friction: Annotated[float, option("Friction coefficient of all joints.")],
    unit: Annotated[
        str | None, option("Unit of the coordinates: mm, or '0.025 m'; 3DM and IFC files state it.")
    ] = None,
    fix: Annotated[
        list[str] | None,
        option("A support: the name of a block, * is any text, lowest, or 'lowest 3 cm'; NAME:x,z holds only these."),
    ] = None,
    ground: Annotated[str | None, option("Add a fixed block with its top at this height: lowest, or '0 m'.")] = None,
    exclude: Annotated[list[str] | None, option("A block to leave out; * is any text.")] = None,
    up: Annotated[str, option("Axis of a mesh that points up: x, y or z.", default=True)] = "z",
    override_unit: Annotated[
        bool, option("Take --unit although the file states another one.", "--override-unit")
    ] = False,
    fix_layer: Annotated[list[str] | None, option("A layer, or an IFC class, of supports.")] = None,
    unit_size: Annotated[
        tuple[str, str] | None, option("Length and height of the units that IFC walls are cut into.")
    ] = None,
    plane: Annotated[str | None, option("View of a DXF drawing: elevation or plan.", default="elevation")] = None,
    thickness: Annotated[str | None, option("Thickness of a wall drawn in DXF, such as '30 cm'.")] = None,
    segments: Annotated[int | None, option("Straight pieces of a DXF arc.")] = None,
    closing: Annotated[str | None, option("Largest gap in a DXF outline, as in '1 mm'.", default="rounding")] = None,
    gap: Annotated[
        str | None, option("Largest gap in a joint, as in '1 mm'.", default="rounding, and the repairs of its faces")
    ] = None,
    angle: Annotated[str | None, option("Largest angle between the faces of a joint.", default="1 deg")] = None,
    area_tolerance: Annotated[
        str | None, option("Area up to which a contact is left out, as in '1 cm^2'.", default="rounding")
    ] = None,
    direction: Annotated[
        list[str] | None,
        option("Direction of the push: +x, -y or a vector, as 1,1,0; several give a case each.", default="+x"),
    ] = None,
    flow: Annotated[bs.Flow, option("Flow rule of the cases.", default=True)] = bs.Flow.NONASSOCIATIVE,
    tilt: Annotated[
        bool, option("Name the cases 'tilt': with friction alone, results show the angle of a tilting table.", "--tilt")
    ] = False,
) -> None:
    """Write a model document from drawn blocks, then check it."""
    bs.documents.check_new_document(output)
    cases = [_case(text, flow, tilt=tilt) for text in direction or ["+x"]]
    options: dict[str, Any] = {
        "override_unit": override_unit or None,
        "supports": fix_layer,
        "plane": plane,
        "thickness": thickness,
        "segments": segments,
        "closing": closing,
        "unit_length": unit_size and unit_size[0],
        "unit_height": unit_size and unit_size[1],
    }
    with warnings.catch_warnings():
        # The printed report contains the same.
        warnings.simplefilter("ignore", bs.errors.GeometryWarning)
        imported = bs.imports.read_files(
            files,
            unit=unit,
            material=_materials(unit_weight),
            fixed=[*(fix or ()), *([] if ground is None else [f"ground {ground}"])],
            exclude=exclude or (),
            up=up,
            **{name: value for name, value in options.items() if value is not None},
        )
    say(str(imported.report))
    joint = bs.JointMaterial("joint", friction)
    limits: dict[str, Any] = {"angle_tolerance": angle, "area_tolerance": area_tolerance}
    explicit: tuple[bs.Interface, ...] = ()
    tolerance = gap
    if gap is None and imported.moves:
        corrected = bs.contacts.corrected_joints(imported.blocks, joint, imported.moves, **limits)
        tolerance, explicit = corrected.tolerance, corrected.explicit
        say(str(corrected))
    bs.documents.write_draft(
        output, output.stem, imported.blocks, joint, cases, explicit=explicit, tolerance=tolerance, **limits
    )
    try:
        document = _checked(output)
    except bs.errors.BlockstructError:
        # A document that cannot run would be in the way of the next attempt.
        output.unlink()
        raise
    names = ", ".join(repr(case.name) for case in cases)
    say(f"written: {output}, with the case{'s' if len(cases) > 1 else ''} {names}: edit its loads and cases")
    _say_checked(document)


def _case(text: str, flow: bs.Flow, *, tilt: bool) -> bs.LimitCase:
    """Return the load of self-weight, and of weight turned to a direction."""
    name = f"+{text}" if text in ("x", "y", "z") else f"({text})" if "," in text else text
    try:
        vector = [float(part) for part in text.split(",")] if "," in text else []
        force = bs.BodyForce([v / math.hypot(*vector) for v in vector] or name)
    except (ValueError, ZeroDivisionError, bs.errors.BlockstructError) as error:
        msg = f"--direction {text!r}: give +x, -x, +y, -y, +z, -z or a vector such as 1,1,0"
        raise bs.errors.ModelError(msg) from error
    if tilt and force.direction[2]:
        msg = f"--direction {text!r}: a table tilts to a level direction, such as +x"
        raise bs.errors.ModelError(msg)
    push = bs.LoadPattern(f"weight sideways, {name}", [force])
    return bs.LimitCase(
        f"{'tilt' if tilt else 'push'} {name}", bs.LoadPattern("self-weight", [bs.SelfWeight()]), push, flow
    )


def _materials(unit_weights: list[str]) -> Any:
    """Return one material, or one for each named layer."""
    layers = {name: weight for name, _, weight in (w.rpartition("=") for w in unit_weights)}
    if len(layers) < len(unit_weights) or ("" in layers and len(layers) > 1):
        msg = "--unit-weight: give it once for all blocks, or once for each layer as in 'WALL=20 kN/m^3'"
        raise bs.errors.ModelError(msg)
    if "" in layers:
        return bs.Material("stone", layers[""])
    return {name: bs.Material(name, weight) for name, weight in layers.items()}


@app.command()
def check(model: Annotated[Path, argument("A model document, YAML or JSON.")]) -> None:
    """Print the blocks and the interfaces of a model document, with rejected contacts."""
    _say_checked(_checked(model))


def _checked(path: Path) -> bs.documents.Document:
    """Return a model document that can run."""
    document = bs.read_document(path)
    bs.AnalysisManager(document.model, settings=bs.ProcedureSettings.of(document.settings)).check(document.cases)
    return document


def _say_checked(document: bs.documents.Document) -> None:
    say(document.model.summary())
    say(str(document.report))
    say(f"ready to run: {', '.join(case.name for case in document.cases)}")


@app.command()
def validate(file: Annotated[Path, argument("An analysis file, or a model document.")]) -> None:
    """Check an analysis file against its schema and its own numbers, or a model document."""
    try:
        if file.suffix.lower() in (".yaml", ".yml", ".json"):
            document = _checked(file)
            say(f"{file}: a valid model document")
            say(f"{counted(len(document.model.blocks), 'block')}, {document.report}")
        else:
            bs.check_file(file)
            analysis = bs.open_analysis(file)
            contradictory = bs.results.contradictions(analysis)
            if contradictory:
                say("\n".join(f"{file}: case {name!r}: {what}" for name, what in contradictory))
                say("these numbers are no proof: take the original file, or run the cases again")
                raise typer.Exit(Exit.VIOLATIONS)
            say(f"{file}: a valid analysis of {counted(len(analysis), 'case')}")
    except (bs.errors.FormatError, bs.errors.ModelError) as error:
        say("\n".join([str(error), *getattr(error, "__notes__", ())]))
        raise typer.Exit(Exit.VIOLATIONS) from None
