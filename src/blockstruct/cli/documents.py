"""Commands on model documents, and the check of any file."""

import warnings
from pathlib import Path
from typing import Annotated, Any

import typer

import blockstruct as bs
from blockstruct.cli.app import VIOLATIONS, app, say
from blockstruct.views import model_text


@app.command("import")
def import_(
    files: Annotated[
        list[Path],
        typer.Argument(help="OBJ, STL or PLY meshes, a DXF drawing or a COMPAS JSON file.", show_default=False),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Model document to write.", show_default=False)],
    unit: Annotated[str, typer.Option(help="Unit of the coordinates: mm, or '0.025 m'.", show_default=False)],
    unit_weight: Annotated[
        list[str],
        typer.Option(help="Of all blocks, '20 kN/m^3', or of a DXF layer, 'WALL=20 kN/m^3'.", show_default=False),
    ],
    friction: Annotated[float, typer.Option(help="Friction coefficient of all joints.", show_default=False)],
    fix: Annotated[
        list[str] | None, typer.Option(help="A support: the name of a block, or lowest.", show_default=False)
    ] = None,
    fix_layer: Annotated[list[str] | None, typer.Option(help="A DXF layer of supports.", show_default=False)] = None,
    thickness: Annotated[
        str | None, typer.Option(help="Of a wall drawn in DXF, as in '30 cm'.", show_default=False)
    ] = None,
    segments: Annotated[int | None, typer.Option(help="Straight pieces of a DXF arc.", show_default=False)] = None,
    gap: Annotated[
        str | None, typer.Option(help="Largest gap in a joint, as in '1 mm'.", show_default="what rounding needs")
    ] = None,
) -> None:
    """Write a model document from blocks drawn elsewhere, then check it."""
    fixed = "lowest" if fix == ["lowest"] else fix or ()
    drawn = files[0].suffix.lower() == ".dxf"
    if len(files) > 1 and any(f.suffix.lower() in (".dxf", ".json") for f in files):
        msg = f"{len(files)} files; several can only be read if all are meshes, import the others one by one"
        raise bs.ModelError(msg)
    if not drawn and (fix_layer or thickness or segments or any("=" in w for w in unit_weight)):
        msg = f"{files[0]}: layers, --thickness and --segments belong to DXF drawings; leave them out"
        raise bs.ModelError(msg)
    material = _materials(unit_weight)
    with warnings.catch_warnings():
        # The report that is printed says the same.
        warnings.simplefilter("ignore", bs.GeometryWarning)
        if drawn:
            found = bs.read_drawing(
                files[0],
                unit=unit,
                material=material,
                thickness=thickness,
                segments=segments,
                supports=fix_layer or (),
                fixed=fixed,
            )
        elif files[0].suffix.lower() == ".json":
            found = bs.read_assembly(files[0], unit=unit, material=material, fixed=fixed)
        else:
            found = bs.read_mesh(files, unit=unit, material=material, fixed=fixed)
    say(str(found.report))
    if gap is None and found.report.joint_gap:
        gap = f"{found.report.joint_gap:.2g} m"
    dead = bs.LoadPattern("self-weight", [bs.SelfWeight()])
    push = bs.LoadPattern("weight sideways, +x", [bs.BodyForce((1, 0, 0))])
    case = bs.LimitCase("push +x", dead, push)
    joint = bs.JointMaterial("joint", friction)
    bs.write_draft(output, output.stem, found.blocks, joint, [case], tolerance=gap)
    say(f"written: {output}, with the case 'push +x': edit its loads and cases")
    check(output)


def _materials(unit_weights: list[str]) -> Any:
    """One material, or one for each layer named."""
    layers = {name: weight for name, _, weight in (w.rpartition("=") for w in unit_weights)}
    if len(layers) < len(unit_weights) or ("" in layers and len(layers) > 1):
        msg = "--unit-weight: give it once for all blocks, or once for each layer as in 'WALL=20 kN/m^3'"
        raise bs.ModelError(msg)
    if "" in layers:
        return bs.Material("stone", layers[""])
    return {name: bs.Material(name, weight) for name, weight in layers.items()}


@app.command()
def check(
    model: Annotated[Path, typer.Argument(help="A model document, YAML or JSON.", show_default=False)],
) -> None:
    """Print the blocks and the interfaces of a model document, with what was left out."""
    document = bs.read_document(model)
    bs.AnalysisManager(document.model, settings=bs.ProcedureSettings.of(document.settings)).check(document.cases)
    say(model_text(document.model))
    say(str(document.report))
    say(f"ready to run: {', '.join(case.name for case in document.cases)}")


@app.command()
def validate(
    file: Annotated[Path, typer.Argument(help="An analysis file, or a model document.", show_default=False)],
) -> None:
    """Check an analysis file or a model document against its schema."""
    try:
        if file.suffix.lower() in (".yaml", ".yml", ".json"):
            document = bs.read_document(file)
            settings = bs.ProcedureSettings.of(document.settings)
            bs.AnalysisManager(document.model, settings=settings).check(document.cases)
            say(f"{file}: a valid model document")
            say(f"{len(document.model.blocks)} blocks, {document.report}")
        else:
            bs.check_file(file)
            say(f"{file}: a valid analysis of {len(bs.open_analysis(file))} cases")
    except (bs.FormatError, bs.ModelError) as error:
        say("\n".join([str(error), *getattr(error, "__notes__", ())]))
        raise typer.Exit(VIOLATIONS) from None
