"""Solve problems of COMPAS DEM. Needs ``pip install "blockstruct[compas]"``.

:func:`posed` makes a model and a limit case of a :class:`compas_dem.problem.Problem`, and :func:`results` makes
:class:`compas_dem.problem.Results` of the collapse state. :func:`solve` does both.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import blockstruct as bs
from blockstruct import Q_
from blockstruct.arrays import Array
from blockstruct.geometry.polygon import polygon_area
from blockstruct.geometry.screws import screw_motions
from blockstruct.imports.solid import Content, Solid, make_blocks
from blockstruct.units import QuantityLike, si


@dataclass(frozen=True, slots=True)
class Posed:
    """A problem of COMPAS DEM as a model and a case.

    Attributes
    ----------
    model : Model
        Blocks are named by their nodes, interfaces by their two nodes.
    case : LimitCase
    report : ImportReport
        Repairs of the meshes.
    """

    model: bs.Model
    case: bs.LimitCase
    report: bs.imports.ImportReport


def posed(
    problem: Any,
    *,
    variable: str | Iterable[str] | None = None,
    joint_material: bs.JointMaterial | None = None,
    flow: bs.Flow | str = bs.Flow.NONASSOCIATIVE,
) -> Posed:
    """Return the model and the limit case of a problem.

    COMPAS DEM has the units m, N, kg/m³ and Pa. Blocks weigh their density times the ``g`` of the boundary
    conditions. Contacts come from the model. If it has none, they are detected.

    Parameters
    ----------
    problem : compas_dem.problem.Problem
        Blocks with supports and densities, boundary conditions, and a Mohr-Coulomb contact model.
    variable
        Names of the boundary conditions that the load factor multiplies, by default all. The others and the weight are
        dead load.
    joint_material
        Strength of the joints, instead of the contact model: with compressive strength, for instance.
    flow
        Flow rule.

    Raises
    ------
    ModelError
        If there is no load to multiply, a block has no density, or a displacement is prescribed.
    UnknownNameError
        If no boundary condition has a name in ``variable``.
    GeometryFileError
        If a mesh is not a block.
    """
    source, groups = problem.model, list(problem.boundary_conditions)
    if not groups:
        msg = "problem: no boundary condition; add one with loads for the load factor to multiply"
        raise bs.errors.ModelError(msg)
    names = [group.name for group in groups]
    chosen = names if variable is None else [variable] if isinstance(variable, str) else list(variable)
    for name in chosen:
        if name not in names:
            msg = f"problem: no boundary condition {name!r}; it has {', '.join(map(repr, names)) or 'none'}"
            raise bs.errors.UnknownNameError(msg)
    gravity = {float(group.g) for group in groups}
    if len(gravity) > 1:
        msg = (
            f"problem: boundary conditions have different g ({', '.join(map(str, sorted(gravity)))}); give one of them"
        )
        raise bs.errors.ModelError(msg)
    if any(group.displacements for group in groups):
        msg = "problem: a displacement is prescribed, which a load factor does not multiply; use a SettlementCase"
        raise bs.errors.ModelError(msg)
    (g,) = gravity
    joint = joint_material or _joint(problem)
    blocks, report = _blocks(source, g)
    interfaces = _interfaces(source, joint) or bs.detect_interfaces(blocks, joint_material=joint)
    dead = [load for group in groups if group.name not in chosen for load in _loads(group, source, g)]
    pushed = [load for group in groups if group.name in chosen for load in _loads(group, source, g)]
    if not pushed:
        msg = "problem: no load to multiply; add one to a boundary condition, and give its name as variable"
        raise bs.errors.ModelError(msg)
    case = bs.LimitCase(
        problem.name or "problem",
        bs.LoadPattern("dead", [bs.SelfWeight(), *dead]),
        bs.LoadPattern(" + ".join(chosen), pushed),
        flow,
    )
    return Posed(bs.Model(source.name or "blocks", blocks, interfaces), case, report)


def solve(problem: Any, *, amplitude: QuantityLike = "0 m", **options: Any) -> Any:
    """Return the results of a problem at collapse, a :class:`compas_dem.problem.Results`.

    Parameters
    ----------
    problem, amplitude
        As for :func:`results`.
    options
        As for :func:`posed`.
    """
    given = posed(problem, **options)
    (result,) = bs.run(given.model, [given.case]).values()
    return results(result, problem, amplitude=amplitude)


def results(result: bs.CaseResult, problem: Any, *, amplitude: QuantityLike = "0 m") -> Any:
    """Return a collapse state as :class:`compas_dem.problem.Results`.

    Forces act on the second block of an edge; the z axis of ``contact_frame`` points to it. If two blocks have several
    contacts, the resultants are their sums, and the polygon belongs to the largest. ``metadata`` has the load factor,
    the status, and whether the certificate holds.

    Parameters
    ----------
    result
        Result of the case from :func:`posed`.
    problem : compas_dem.problem.Problem
        The problem.
    amplitude : quantity, length
        Largest translation of a centroid in ``transformation``: each block moves along the screw of the mechanism. By
        default the blocks are at rest, where the forces belong.

    Raises
    ------
    ModelError
        If the result has no collapse state.
    MissingExtraError
        If compas_dem is not installed.
    """
    compas, dem = _package("compas.geometry"), _package("compas_dem.problem")
    if not result.n_iterations:
        msg = f"case {result.name!r}: no collapse state, {result.headline}"
        raise bs.errors.ModelError(msg)
    found = dem.Results(model_id=str(problem.model.guid), problem_id=str(problem.guid))
    found.metadata = {
        "solver": f"blockstruct {bs.__version__}",
        "load_factor": result.load_factor,
        "status": result.status.value,
        "certified": bool(result.certificate and result.certificate.holds),
        "text": str(result.headline),
    }
    size = si(amplitude, "length", "results: amplitude")
    twist = np.hsplit(size * bs.results.twists(result.mechanism), 2)
    for block, R, t in zip(result.model.blocks, *screw_motions(*twist), strict=True):
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = R, block.centroid + t - R @ block.centroid
        found.set_node(int(block.name), "transformation", compas.Transformation(matrix.tolist()))
    history = result.history.isel(iteration=[-1])
    local = history["contact_force"].isel(iteration=0).transpose("contact_point", "component").to_numpy()
    position, of = history["contact_point_position"].to_numpy(), history["interface_of_contact_point"].to_numpy()
    frames = history["interface_frame"].to_numpy()
    edges: dict[tuple[int, int], list[int]] = {}
    for j, interface in enumerate(result.model.interfaces):
        edges.setdefault((int(interface.minus), int(interface.plus)), []).append(j)
    for edge, parts in edges.items():
        main = max(parts, key=lambda j: result.model.interfaces[j].area)
        at, force = position[of == main], local[of == main]
        total = sum(local[of == j].sum(axis=0) @ frames[j] for j in parts)
        frame = compas.Frame(at.mean(axis=0).tolist(), frames[main, 1].tolist(), frames[main, 2].tolist())
        contact = _package("compas_dem.interactions").FrictionContact(points=at.tolist(), frame=frame)
        contact.forces = [
            {"c_np": float(max(n, 0)), "c_nn": float(max(-n, 0)), "c_u": float(s), "c_v": float(t)} for n, s, t in force
        ]
        values = {
            "face_contact": True,
            "contact_data": contact,
            "contact_polygon": compas.Polygon(result.model.interfaces[main].polygon.tolist()),
            "contact_points": at.tolist(),
            "contact_frame": frame,
            "resultant_global": total.tolist(),
            "resultant_local": [float(total @ frames[main, k]) for k in (1, 2, 0)],
            "force_magnitude": float(np.linalg.norm(total)),
            "force_normal": force[:, 0].tolist(),
            "force_tangent1": force[:, 1].tolist(),
            "force_tangent2": force[:, 2].tolist(),
        }
        for name, value in values.items():
            found.set_edge(edge, name, value)
    return found


def _package(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        raise bs.errors.MissingExtraError.of(error, "compas", "results for COMPAS DEM") from error


def _joint(problem: Any) -> bs.JointMaterial:
    model = problem.contact_properties.contact_model
    if model is None:
        msg = "problem: no contact model; call problem.set_contact_model('MohrCoulomb', mu=0.6), or give joint_material"
        raise bs.errors.ModelError(msg)
    return bs.JointMaterial(
        model.name or "contact model",
        model.mu,
        cohesion=Q_(model.c or 0.0, "Pa"),
        tensile_strength=Q_(model.t_c or 0.0, "Pa"),
    )


def _blocks(source: Any, g: float) -> tuple[tuple[bs.Block, ...], bs.imports.ImportReport]:
    """Return the blocks of a model, repaired as imported meshes are."""
    solids, stones = list[Solid](), dict[str, bs.Material]()
    for element in source.elements():
        name, stone = str(element.graphnode), element.material
        if stone is None or stone.density is None:
            msg = f"block {name}: no density; call model.assign_material with a material that has one"
            raise bs.errors.ModelError(msg)
        label = f"{stone.name} {stone.density:g} kg/m³"
        stones.setdefault(label, bs.Material(label, Q_(stone.density * g, "N/m^3")))
        vertices, faces = element.modelgeometry.to_vertices_and_faces()
        points = np.array([list(v) for v in vertices], dtype=float)
        solids.append(Solid(name, points, [tuple(f) for f in faces], stones[label], bool(element.is_support)))
    where = Path(source.name or "blocks")
    found = make_blocks([Content(solids)], [where], unit="m", fixed=(), exclude=(), up="z", tolerance=None)
    if {b.name for b in found.blocks} != {solid.name for solid in solids}:
        msg = f"{where}: a mesh is several bodies, or a copy of another; divide or remove it\n{found.report}"
        raise bs.errors.ModelError(msg)
    return found.blocks, found.report


def _interfaces(source: Any, joint: bs.JointMaterial) -> list[bs.Interface]:
    """Return the contacts of a model as interfaces; none if they are not computed."""
    found = []
    for u, v in source.graph.edges():
        contacts = source.graph.edge_attribute((u, v), "contacts") or []
        for k, contact in enumerate(contacts, start=1):
            polygon = np.array([list(point) for point in contact.polygon.points], dtype=float)
            _, centre, normal = polygon_area(polygon)
            if normal @ _outward(source.graph.node_element(u).modelgeometry, centre, normal) < 0:
                polygon = polygon[::-1]
            name = f"{u}|{v}" + (f" {k}" if len(contacts) > 1 else "")
            found.append(bs.Interface(name, str(u), str(v), Q_(polygon, "m"), joint))
    return found


def _outward(mesh: Any, centre: Array, normal: Array) -> Array:
    """Return the outward normal of the face of a closed mesh that lies in a plane through a point."""
    faces = [np.array([list(mesh.vertex_coordinates(i)) for i in mesh.face_vertices(f)]) for f in mesh.faces()]
    planes = [polygon_area(corners)[1:] for corners in faces]
    distance = [abs((centre - middle) @ n) + (1 - abs(n @ normal)) for middle, n in planes]
    return planes[int(np.argmin(distance))][1]


def _loads(group: Any, source: Any, g: float) -> list[Any]:
    """Return the loads of a boundary condition."""
    loads: list[Any] = []
    for body in group.body_forces:
        a = np.array(body.acceleration, dtype=float)
        size = float(np.linalg.norm(a))
        if size:
            loads.append(bs.BodyForce(tuple(a / size), share=size / g))
    for point in group.point_loads:
        block = source.graph.node_element(point.block_index)
        place = block.point if point.point is None else point.point
        if any(point.force):
            loads.append(bs.PointLoad(str(point.block_index), Q_(list(place), "m"), Q_(list(point.force), "N")))
        if point.moment is not None and any(point.moment):
            loads.append(bs.Moment(str(point.block_index), Q_(list(point.moment), "N*m")))
    for surface in group.surface_loads:
        mesh = source.graph.node_element(surface.block_index).modelgeometry
        force = np.array(surface.load, dtype=float) * mesh.face_area(surface.face_index)
        centre = Q_(list(mesh.face_center(surface.face_index)), "m")
        loads.append(bs.PointLoad(str(surface.block_index), centre, Q_(force, "N")))
    return loads
