"""Builders of structures that tests vary: plain numbers in, model or load factor out."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path

import h5py
import numpy as np

import blockstruct as bs
from blockstruct import Q_
from blockstruct.geometry.polyhedron import lofted
from blockstruct.storage.file import seal_of

STONE = bs.Material("stone", "20 kN/m^3")
#: A model document: a pier of 0.5 m by 1 m by 1 m, pushed along x.
PIER = """
blockstruct: model-1
materials: {tuff: {unit_weight: 12 kN/m^3}}
joint_materials: {lime: {friction_coefficient: 0.65}}
blocks:
  - {name: base, material: tuff, fixed: true, box: {origin: [-1 m, -1 m, -1 m], size: [3 m, 3 m, 1 m]}}
  - {name: pier, material: tuff, box: {origin: [0 m, 0 m, 0 m], size: [0.5 m, 1 m, 1 m]}}
interfaces: {joint_material: lime}
load_patterns: {dead: [{kind: self_weight}], push: [{kind: body_force, direction: +x}]}
cases: [{name: push, dead: dead, variable: push, flow: associative}]
"""
SELF_WEIGHT = bs.LoadPattern("dead", [bs.SelfWeight()])


def push(*direction: float) -> bs.LoadPattern:
    """Mass-proportional variable load, in multiples of the weight."""
    length = np.linalg.norm(direction)
    return bs.LoadPattern("push", [bs.BodyForce(np.asarray(direction) / length, share=length)])


def rotation(axis: Sequence[float], angle: float) -> np.ndarray:
    """Rotation matrix about an axis (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def moved(blocks: Sequence[bs.Block], R: np.ndarray, shift: Sequence[float] = (0, 0, 0)) -> list[bs.Block]:
    """Blocks after a rigid motion."""
    return [
        bs.Block.from_faces(
            b.name, Q_(b.shape.vertices @ R.T + np.asarray(shift), "m"), b.shape.faces, b.material, fixed=b.held
        )
        for b in blocks
    ]


def box(name: str, origin: Sequence[float], size: Sequence[float] = (1, 1, 1), *, fixed: bool = False) -> bs.Block:
    """A box of 20 kN/m³, its origin and size in m."""
    return bs.Block.box(name, Q_(origin, "m"), Q_(size, "m"), STONE, fixed=fixed)


def extruded(
    name: str, outline: Sequence[Sequence[float]], low: float, high: float, *, fixed: bool = False
) -> bs.Block:
    """A vertical prism of 20 kN/m³ over a counter-clockwise outline in plan, m."""
    vertices, faces = lofted(*(np.array([(*p, z) for p in outline], dtype=float) for z in (low, high)))
    return bs.Block.from_faces(name, Q_(vertices, "m"), faces, STONE, fixed=fixed)


def beam_on_ledges(*others: bs.Block) -> bs.Model:
    """A beam of 4 m and 48 kN on two supports, ``left`` and ``right``, of which one may settle, and other blocks."""
    ledges = [box(name, [x, 0, -0.3], [0.5, 1, 0.3], fixed=True) for name, x in (("left", 0), ("right", 3.5))]
    return model_of([*ledges, *others, box("beam", [0, 0, 0], [4, 1, 0.6])], bs.JointMaterial("joint", 0.6), "beam")


def single_block(b: float, h: float, t: float = 1.0, mu: float = 0.65) -> tuple[list[bs.Block], bs.JointMaterial]:
    """A block b × t × h on a larger support."""
    ground = box("ground", [-1, -1, -0.5], [b + 2, t + 2, 0.5], fixed=True)
    return [ground, box("block", [0, 0, 0], [b, t, h])], bs.JointMaterial("joint", mu)


def model_of(blocks: Sequence[bs.Block], joint: bs.JointMaterial, name: str = "model") -> bs.Model:
    """Model with all interfaces of the blocks."""
    return bs.Model(name, blocks, bs.detect_interfaces(blocks, joint_material=joint).interfaces)


def bonded(units: int, courses: int, depth: str = "0.2 m", material: bs.Material = STONE) -> list[bs.Block]:
    """A wall of whole units of 0.4 m by 0.2 m in running bond, on its base."""
    rows = [[1] * units if j % 2 == 0 else [0.5, *[1] * (units - 1), 0.5] for j in range(courses)]
    return bs.courses(rows, unit_length="0.4 m", unit_height="0.2 m", thickness=depth, material=material)


def every_load(block: bs.Block) -> list[object]:
    """A load of every kind on a block, near the highest of its corners, with numbers that no decimal holds."""
    corner = block.shape.vertices.max(axis=0)
    level = Q_(corner[2] - 0.1, "m")
    ends = {"start": Q_(corner - [0.1, 0.05, 0], "m"), "end": Q_(corner, "m")}
    return [
        bs.SelfWeight(),
        bs.BodyForce((0.6, 0, 0.8), share=1 / 3),
        bs.PointLoad(block.name, ends["end"], Q_([0, 0, -1 / 7], "kN")),
        bs.Moment(block.name, Q_([0, 1e-5, 0], "kN*m")),
        bs.FaceLoad(block.name, 5, Q_([0, 0, -0.3], "kPa"), unit_weight="9.81 kN/m^3", level=level),
        bs.FaceLoad(block.name, 2, pressure="-0.8 kPa"),
        bs.Weight(block.name, ends["end"], Q_(1 / 7, "kN"), mass_share=1 / 3),
        bs.LineLoad(Q_(1 / 7, "kN/m"), **ends, block=block.name, mass_share=0.25),
        bs.AreaLoad("1 kPa", block=block.name, mass_share=0),
        bs.AreaLoad(Q_(1 / 7, "kPa"), **ends, spanning=True),
        bs.FillLoad("18 kN/m^3", ends["start"], Q_(corner - [0, 0, -0.4], "m"), lateral_coefficient=0.3),
    ]


def semicircle(thickness: float, joint: bs.JointMaterial, voussoirs: int = 27, radius: float = 1.0) -> bs.Model:
    """A semicircular arch, 1 m deep, of a centreline radius and a thickness relative to it."""
    size = {"span": Q_((2 - thickness) * radius, "m"), "thickness": Q_(thickness * radius, "m"), "depth": "1 m"}
    return model_of(bs.arch(**size, voussoirs=voussoirs, material=STONE), joint)


def divided(model: bs.Model) -> bs.Model:
    """The same joints, divided into cells where they crush: one more corner on an edge, and none is a rectangle."""
    joints = []
    for i in model.interfaces:
        middle = (i.polygon[0] + i.polygon[1]) / 2
        polygon = Q_(np.insert(i.polygon, 1, middle, axis=0), "m")
        joints.append(bs.Interface(i.name, i.minus, i.plus, polygon, i.joint_material))
    return bs.Model(model.name, model.blocks, joints)


def random_frame(seed: int, torsion: str, **joint: object) -> tuple[bs.Model, bs.LoadPattern]:
    """A beam on a stack of two or three blocks and on a column, pushed and twisted at random."""
    random = np.random.default_rng(seed)
    blocks, height, shift = [box("ground", [-1, -1, -0.5], [5, 3, 0.5], fixed=True)], 0.0, np.zeros(2)
    for k in range(int(random.integers(2, 4))):
        size = [*random.uniform(0.6, 1, 2), random.uniform(0.4, 0.8)]
        blocks.append(box(f"block {k}", [*shift, height], size))
        height, shift = height + size[2], random.uniform(-0.1, 0.1, 2)
    blocks += [box("column", [1.8, 0, 0], [0.6, 0.9, height]), box("beam", [0, 0.1, height], [2.4, 0.5, 0.4])]
    friction = float(random.uniform(0.3, 0.9))
    model = model_of(blocks, bs.JointMaterial("joint", friction, torsion=torsion, **joint))
    direction = random.normal(size=3) * (1, 1, 0.2)
    moment = bs.Moment("block 0", Q_(random.normal(size=3) * 2, "kN m"))
    return model, bs.LoadPattern("push", [bs.BodyForce(direction / np.linalg.norm(direction)), moment])


def settings_of(**values: object) -> bs.ProcedureSettings:
    """Settings by the names of their fields, those of the schedule and the numerics sorted into their parts."""
    parts = {
        part: {f.name: values.pop(f.name) for f in fields(kind) if f.name in values}
        for part, kind in (("schedule", bs.FictitiousSchedule), ("numerics", bs.Numerics))
    }
    return bs.ProcedureSettings.of({**values, **parts})


def solve(
    model: bs.Model,
    variable: bs.LoadPattern,
    flow: str = "associative",
    dead: bs.LoadPattern = SELF_WEIGHT,
    *,
    effects: bool = False,
    **settings: object,
) -> bs.CaseResult:
    """Result of one case; its remedies of torsion and crushing are not run unless a test is about them."""
    case = bs.LimitCase("case", dead, variable, flow)
    return bs.AnalysisManager(model, settings=settings_of(**settings), effects=effects).run([case])["case"]


def kept(model: bs.Model, case: bs.model.Case, folder: Path) -> bs.Analysis:
    """The analysis of a case from a file, after checks that files and documents keep the model and the result."""
    ran, stored = bs.run(model, case, folder / "kept.h5", progress=False), bs.open_analysis(folder / "kept.h5")
    assert stored[case.name].history.identical(ran[case.name].history)
    assert bs.results.contradictions(stored) == []
    order = [i.name for i in model.interfaces]
    for name in ("kept.yaml", "kept.json"):
        read = bs.read_document(bs.write_document(folder / name, model, [case])).model
        # Documents list interfaces by their joint material.
        interfaces = sorted(read.interfaces, key=lambda i: order.index(i.name))
        assert bs.Model(read.name, read.blocks, interfaces).hash == stored.model.hash == model.hash
    return stored


def seal_again(path: Path) -> None:
    """Seal a file after a change, as who damages it on purpose would."""
    content = path.read_bytes()
    path.write_bytes(content + seal_of(content))


@contextmanager
def edited(path: Path, copy: Path | None = None) -> Iterator[h5py.File]:
    """A file, or a copy of it, opened to be changed, and sealed again."""
    path = path if copy is None else shutil.copy(path, copy)
    with h5py.File(path, "r+") as file:
        yield file
    seal_again(path)


def stopping(
    *kinds: type, at: int | None = None, case: str = "", nth: int = 1, error: type[BaseException] = KeyboardInterrupt
) -> Callable[[object], None]:
    """Listener that stops a run at the nth event: of some kinds, of an index, of a case."""
    seen = []

    def listen(event: object) -> None:
        wanted = not kinds or isinstance(event, kinds)
        if wanted and at in (None, getattr(event, "index", None)) and (not case or event.case.name == case):
            seen.append(event)
            if len(seen) == nth:
                raise error

    return listen


def slid_from_under() -> bs.Model:
    """A block ``a`` of 1 m, 4 kN, and on its end a block ``b``, 0.96 kN, which a tie holds back.

    Once a has moved by 0.1 m the centroid of b is beyond its edge, and b turns until it meets a ledge, 10 mm below.
    """
    blocks = [
        box("ground", [-1, 0, -0.2], [3, 0.4, 0.2], fixed=True),
        box("ledge", [-0.6, 0, 0.2], [0.598, 0.4, 0.29], fixed=True),
        box("post", [-0.8, 0, 0], [0.2, 0.4, 0.8], fixed=True),
        box("a", [0, 0, 0], [1, 0.4, 0.5]),
        box("b", [-0.1, 0, 0.5], [0.4, 0.4, 0.3]),
    ]
    ends = ("post", Q_([-0.6, 0.2, 0.5], "m")), ("b", Q_([-0.1, 0.2, 0.5], "m"))
    tie = bs.Tie("tie", *ends, yield_force="100 kN")
    return model_of(blocks, bs.JointMaterial("smooth", 0.3)).with_ties([tie])


def block_on_a_bar(breaks_at: str | None = "0.1 m", yields_at: str = "4 kN") -> bs.Model:
    """A ``block`` of 0.5 m by 2 m, held at 1.5 m by a bar to a ``post``. The block weighs 20 kN."""
    blocks = [
        box("ground", [-3, 0, -0.5], [6, 1, 0.5], fixed=True),
        box("post", [-2.5, 0, 0], [0.5, 1, 2], fixed=True),
        box("block", [0, 0, 0], [0.5, 1, 2]),
    ]
    ends = ("post", Q_([-2, 0.5, 1.5], "m")), ("block", Q_([0, 0.5, 1.5], "m"))
    bar = bs.Tie("bar", *ends, yield_force=yields_at, elongation_limit=breaks_at)
    return model_of(blocks, bs.JointMaterial("rough", 2.0)).with_ties([bar])


def slipping_units() -> bs.Model:
    """A wall of ten units, which slip and rock."""
    return model_of(bonded(2, 4), bs.JointMaterial("dry", 0.5))
