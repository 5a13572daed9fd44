"""Equilibrium of a wall of 199 bricks on a base under its weight, by blockstruct and by other solvers.

``python benchmarks/other_tools.py blockstruct`` needs nothing else; ``RBE`` and ``CRA`` need
``pip install compas_dem compas_cra pyomo``. Prints processor times and the sum of the normal forces on the base. With
``--push 0.5`` other solvers get half the weight as a push to +x as well.
"""

import argparse
import contextlib
import io
import time

import blockstruct as bs


def brick_wall() -> list[bs.Block]:
    """A wall 2.5 m long and 1.235 m high in running bond."""
    brick = bs.Material("brick", bs.Q_(1800 * 9.81, "N/m^3"))
    size = {"length": "2.5 m", "unit_length": "25 cm", "unit_height": "6.5 cm", "thickness": "12 cm"}
    return bs.wall(courses=19, material=brick, **size)


def by_blockstruct(blocks: list[bs.Block]) -> str:
    """Follow a push, and take the state before it."""
    start = time.process_time()
    found = bs.detect_interfaces(blocks, joint_material=bs.JointMaterial("joint", 0.7))
    model, detection = bs.Model("wall", blocks, found), time.process_time() - start
    dead, push = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce("+x")])
    result = bs.run(model, [bs.LimitCase("push", dead, push)], progress=False)["push"]
    whole = time.process_time() - start
    history = result.history
    rest = int((history["load_factor"].to_numpy() == 0).argmax())
    N = bs.results.interface_resultants(history.isel(iteration=[rest]))["force"].sel(component="n").to_numpy()[0]
    on_base = sum(N[j] for j, i in enumerate(model.interfaces) if "base" in (i.minus, i.plus))
    return (
        f"contacts {len(model.interfaces)} in {detection:.2f} s, weight {float(history['solver_time'][rest]):.2f} s, "
        f"on the base {on_base:.1f} N; with its collapse at {result.load_factor:.4f} {whole:.2f} s"
    )


def by_other(solver: str, blocks: list[bs.Block], push: float) -> str:
    """Pose the same wall to COMPAS DEM."""
    from compas.datastructures import Mesh
    from compas_dem.material import Stone
    from compas_dem.models import BlockModel
    from compas_dem.problem import Problem, Solver

    model = BlockModel()
    for block in blocks:
        mesh = Mesh.from_vertices_and_faces(block.shape.vertices.tolist(), [list(face) for face in block.shape.faces])
        (model.add_support_from_mesh if block.fixed else model.add_block_from_mesh)(mesh)
    model.add_material(stone := Stone(fck=20, density=1800))
    model.assign_material(stone, elements=list(model.elements()))
    start = time.process_time()
    # The default leaves out contacts below 0.01 m²: all head joints.
    model.compute_contacts(minimum_area=1e-4)
    detection = time.process_time() - start
    contacts = sum(len(model.graph.edge_attribute(edge, "contacts") or ()) for edge in model.graph.edges())
    problem = Problem(model, name="wall")
    problem.set_contact_model("MohrCoulomb", mu=0.7)
    if push:
        problem.add_boundary_condition("push").add_global_body_force(push * 9.81, 0, 0)
    problem.set_solver(getattr(Solver, solver)())
    start = time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        results = problem.solve()
    solved = time.process_time() - start
    x, _, z = (sum(results.resultant_global(edge)[k] for edge in results.edges() if 0 in edge) for k in range(3))
    return f"contacts {contacts} in {detection:.2f} s, {solved:.2f} s, on the base {z:.1f} N down, {x:.1f} N along"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("solver", choices=["blockstruct", "RBE", "CRA"])
    parser.add_argument("--push", type=float, default=0.0)
    given = parser.parse_args()
    wall = brick_wall()
    found = by_blockstruct(wall) if given.solver == "blockstruct" else by_other(given.solver, wall, given.push)
    print(f"{given.solver}: {len(wall)} blocks, {found}")
