"""Random structures of twenty kinds, for campaigns: seeds of their own, and the load factors that are known by hand.

``names()`` lists all of them, and ``structure(name)`` builds one. Lengths are in m, forces in kN.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, model_of

STONE = bs.Material("stone", "16 kN/m^3")
GROUND = bs.Block.box("ground", Q_([-3, -3, -0.5], "m"), Q_([12, 8, 0.5], "m"), STONE, fixed=True)
DIRECTIONS = {"in plane": (1, 0, 0), "outwards": (0, -1, 0), "askew": (1, -1, 0), "inwards": (0.4, 1, 0)}

Random = np.random.Generator
Tied = tuple[str, str, Sequence[float], str, Sequence[float], float]


@dataclass(frozen=True)
class Structure:
    """Blocks, joints and loads of one case, and what is known of its load factor."""

    name: str
    kind: str
    blocks: list[bs.Block]
    joint: bs.JointMaterial
    variable: bs.LoadPattern
    dead: bs.LoadPattern = SELF_WEIGHT
    ties: list[Tied] = field(default_factory=list)
    #: Load factor by hand.
    exact: float | None = None

    @property
    def model(self) -> bs.Model:
        model = model_of(self.blocks, self.joint, self.name)
        ties = [
            bs.Tie(name, start=(a, Q_(p, "m")), end=(b, Q_(q, "m")), yield_force=Q_(force, "kN"))
            for name, a, p, b, q, force in self.ties
        ]
        return model.with_ties(ties) if ties else model

    def turned(self, R: np.ndarray) -> "Structure":
        """The structure after a rotation or a reflection about the origin that keeps the vertical."""
        mirrored = np.linalg.det(R) < 0
        blocks = []
        for b in self.blocks:
            faces = [face[::-1] for face in b.shape.faces] if mirrored else b.shape.faces
            vertices = Q_(b.shape.vertices @ R.T, "m")
            blocks.append(bs.Block.from_faces(b.name, vertices, faces, b.material, fixed=b.fixed))
        ties = [(name, a, R @ p, b, R @ q, force) for name, a, p, b, q, force in self.ties]
        dead, variable = (
            bs.LoadPattern(p.name, [turned_load(load, R) for load in p.loads]) for p in (self.dead, self.variable)
        )
        return replace(self, blocks=blocks, ties=ties, dead=dead, variable=variable)

    def renumbered(self, seed: int) -> "Structure":
        """The structure with its blocks in another order."""
        order = np.random.default_rng(seed).permutation(len(self.blocks))
        return replace(self, blocks=[self.blocks[k] for k in order])


def turned_load(load: object, R: np.ndarray) -> object:
    """A load after a rotation or a reflection about the origin."""
    match load:
        case bs.BodyForce():
            direction = np.array(load.direction) / np.linalg.norm(load.direction)
            return bs.BodyForce(R @ direction, share=load.share)
        case bs.PointLoad():
            return bs.PointLoad(load.block, Q_(R @ load.point, "m"), Q_(R @ load.force, "N"))
        case bs.Moment():
            return bs.Moment(load.block, Q_(np.linalg.det(R) * (R @ load.moment), "N m"))
        case bs.FaceLoad():
            return bs.FaceLoad(load.block, load.face, Q_(R @ load.traction, "Pa"))
    return load


def push(*direction: float) -> bs.LoadPattern:
    return bs.LoadPattern("push", [bs.BodyForce(np.array(direction) / np.linalg.norm(direction))])


def loads(*of: object) -> bs.LoadPattern:
    return bs.LoadPattern("loads", list(of))


def point(block: bs.Block, at: np.ndarray, force: Sequence[float]) -> bs.PointLoad:
    return bs.PointLoad(block.name, Q_(np.array(at, dtype=float), "m"), Q_(np.array(force, dtype=float), "kN"))


def joint(friction: float, **strengths: object) -> bs.JointMaterial:
    return bs.JointMaterial("joint", float(friction), **strengths)


def metres(value: float) -> object:
    return Q_(round(float(value), 4), "m")


def box(name: str, origin: Sequence[float], size: Sequence[float], *, fixed: bool = False) -> bs.Block:
    origin, size = (Q_(np.array(v, dtype=float), "m") for v in (origin, size))
    return bs.Block.box(name, origin, size, STONE, fixed=fixed)


def masonry(length: float, courses: int, depth: float, **more: object) -> list[bs.Block]:
    """A wall of units 0.5 m × 0.25 m."""
    size = {"unit_length": "0.5 m", "unit_height": "0.25 m", "thickness": metres(depth)}
    return bs.wall(length=metres(length), courses=courses, material=STONE, **size, **more)


def free(blocks: list[bs.Block]) -> list[bs.Block]:
    return [b for b in blocks if not b.fixed]


def top(blocks: list[bs.Block]) -> list[bs.Block]:
    """The free blocks that reach highest, from left to right."""
    heights = {b.name: b.shape.vertices[:, 2].max() for b in free(blocks)}
    highest = max(heights.values())
    return sorted((b for b in free(blocks) if heights[b.name] > highest - 1e-6), key=lambda b: tuple(b.centroid))


def middle_of_top(block: bs.Block) -> np.ndarray:
    z = block.shape.vertices[:, 2]
    return block.shape.vertices[z > z.max() - 1e-6].mean(axis=0)


def rubble(r: Random, i: int) -> dict:
    bond = bs.structures.Rubble(seed=1 + i, shortest="0.2 m", longest=metres(r.uniform(0.45, 0.9)), overlap="0.05 m")
    size = {"length": metres(r.uniform(1.4, 3.2)), "courses": int(r.integers(4, 9)), "unit_height": "0.25 m"}
    blocks = bs.wall(**size, thickness=metres(r.uniform(0.2, 0.5)), material=STONE, rubble=bond)
    return {"blocks": blocks, "joint": joint(r.uniform(0.4, 0.8)), "variable": push(*direction(i))}


def direction(i: int) -> tuple[float, float, float]:
    return list(DIRECTIONS.values())[i % len(DIRECTIONS)]


def openings(r: Random, i: int) -> dict:
    length, courses = 0.5 * int(r.integers(6, 9)), int(r.integers(7, 11))
    width, height = 0.5 * int(r.integers(1, 3)), 0.25 * int(r.integers(2, 5))
    start = 0.5 * int(r.integers(1, round((length - width) / 0.5)))
    sill = 0.25 * int(r.choice([0, 2]))
    hole = bs.structures.Opening(start=metres(start), sill=metres(sill), width=metres(width), height=metres(height))
    blocks = masonry(length, courses, r.choice([0.2, 0.3]), openings=[hole])
    return {"blocks": blocks, "joint": joint(r.uniform(0.45, 0.75)), "variable": push(*direction(i))}


def front(r: Random, i: int) -> dict:
    """A façade with one or two returns."""
    length, courses, depth = 0.5 * int(r.integers(3, 7)), int(r.integers(4, 9)), 0.25
    at = [("left", 0.0), ("right", length - depth)][: 1 + i % 2]
    bonded = i % 3 != 0
    sides = [bs.structures.Sidewall(n, metres(x), metres(0.5 * int(r.integers(2, 4))), bonded=bonded) for n, x in at]
    blocks = masonry(length, courses, depth, sidewalls=sides)
    way = [(0, -1, 0), (1, -1, 0), (0.3, -1, 0), (0, 1, 0), (1, 0, 0)][i % 5]
    return {"blocks": blocks, "joint": joint(r.uniform(0.45, 0.75)), "variable": push(*way)}


def arch(r: Random, i: int) -> dict:
    span, count = r.uniform(2, 6), int(r.integers(8, 24))
    rise = {} if i % 2 else {"rise": metres(r.uniform(0.22, 0.42) * span)}
    size = {"span": metres(span), "thickness": metres(span * r.uniform(0.09, 0.16)), "depth": "0.7 m"}
    blocks = bs.arch(**size, voussoirs=count, material=STONE, **rise)
    quarter = free(blocks)[len(free(blocks)) // 4]
    down = loads(point(quarter, middle_of_top(quarter), (0, 0, -1)))
    variable = [push(1, 0, 0), down, push(0.6, 0.5, 0)][i % 3]
    return {"blocks": blocks, "joint": joint(r.uniform(0.45, 0.8)), "variable": variable}


def arch_on_piers(r: Random, i: int) -> dict:
    size = {"span": metres(r.uniform(2, 3.6)), "thickness": metres(r.uniform(0.35, 0.6)), "depth": "0.7 m"}
    piers = {"pier_width": metres(r.uniform(0.7, 1.1)), "pier_height": metres(r.uniform(0.8, 1.8))}
    parts = {"pier_courses": int(r.integers(2, 6)), "voussoirs": int(r.integers(7, 15)), "material": STONE}
    blocks = bs.structures.arch_on_piers(**size, **piers, **parts)
    way = [(1, 0, 0), (0, 1, 0), (1, 0.7, 0)][i % 3]
    return {"blocks": blocks, "joint": joint(r.uniform(0.5, 0.8)), "variable": push(*way)}


def vault(r: Random, i: int) -> dict:
    """A barrel vault, or every third time a cross vault."""
    if i % 3 == 2:
        size = {"span": metres(r.uniform(3, 5)), "thickness": metres(r.uniform(0.35, 0.5))}
        blocks = bs.structures.cross_vault(**size, courses=int(r.integers(4, 6)), units=2, material=STONE)
    else:
        size = {"span": metres(r.uniform(2.4, 3.8)), "thickness": metres(r.uniform(0.3, 0.5))}
        parts = {"length": metres(r.uniform(1.4, 2.6)), "voussoirs": int(r.integers(7, 11)), "units": 2 + i % 2}
        blocks = bs.structures.barrel_vault(**size, **parts, material=STONE, staggered=i % 2 == 0)
    third = free(blocks)[len(free(blocks)) // 3]
    down = loads(point(third, middle_of_top(third), (0, 0, -1)))
    variable = [push(1, 0, 0), push(1, 1, 0), push(1, 0.3, 0), down][i % 4]
    return {"blocks": blocks, "joint": joint(r.uniform(0.5, 0.8)), "variable": variable}


def dome(r: Random, i: int) -> dict:
    span = r.uniform(4, 8)
    size = {"span": metres(span), "thickness": metres(span * r.uniform(0.06, 0.1)), "oculus": metres(0.22 * span)}
    parts = {"courses": int(r.integers(3, 6)), "units": int(r.integers(8, 13)), "staggered": i % 3 != 0}
    blocks = bs.structures.dome(**size, **parts, material=STONE)
    rim = top(blocks)[0]
    down = loads(point(rim, middle_of_top(rim), (0, 0, -1)))
    variable = [push(1, 0, 0), push(1, 0.4, 0), down][i % 3]
    return {"blocks": blocks, "joint": joint(r.uniform(0.5, 0.9)), "variable": variable}


def portal(r: Random, i: int) -> dict:
    opening = {"pier_width": "1 m", "opening_width": "1 m", "opening_height": "0.75 m", "spandrel_height": "0.5 m"}
    unit = {"unit_length": "0.5 m", "unit_height": "0.25 m", "thickness": metres(r.uniform(0.25, 0.5))}
    blocks = bs.structures.pier_spandrel(bays=1 + i % 2, storeys=1 + (i // 2) % 2, **opening, **unit, material=STONE)
    way = [(1, 0, 0), (0, 1, 0), (1, 0.8, 0)][i % 3]
    return {"blocks": blocks, "joint": joint(r.uniform(0.45, 0.75)), "variable": push(*way)}


def column(r: Random, i: int) -> dict:
    """A column of drums, a stack out of plumb, or a pier of two leaves that leans."""
    if i % 3 == 0:
        size = {"height": metres(r.uniform(2, 5)), "diameter": metres(r.uniform(0.5, 0.9))}
        parts = {"drums": int(r.integers(1, 8)), "sides": int(r.choice([6, 8, 12]))}
        blocks = bs.structures.column(**size, **parts, material=STONE)
    elif i % 3 == 1:
        count = int(r.integers(4, 11))
        shift = Q_(r.uniform(0, 0.2 / count, 2), "m")
        blocks = bs.structures.stack(count, size=Q_([0.5, 0.6, 0.4], "m"), material=STONE, shift=shift)
    else:
        blocks = masonry(1.0, int(r.integers(5, 11)), 0.8, leaves=2, header_every=2)
        blocks = bs.structures.tilted(blocks, Q_(float(r.uniform(1, 4)), "deg"), axis=(0, 1, 0))
    way = [(1, 0, 0), (1, 1, 0), (-1, 0.3, 0), (0.2, 1, 0)][i % 4]
    return {"blocks": blocks, "joint": joint(r.uniform(0.4, 0.75)), "variable": push(*way)}


def point_load(r: Random, i: int) -> dict:
    blocks = masonry(0.5 * int(r.integers(3, 6)), int(r.integers(4, 8)), r.choice([0.25, 0.4]))
    row = top(blocks)
    block = [row[0], free(blocks)[int(r.integers(len(free(blocks))))], row[len(row) // 2]][i % 3]
    ways = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, -1), (0, 0.4, -1), (1, 0, 0.5), (0, -1, 0.5), (-1, -0.3, 0)]
    variable = loads(point(block, block.centroid, ways[i % 8]))
    return {"blocks": blocks, "joint": joint(r.uniform(0.4, 0.75)), "variable": variable}


def cohesion(r: Random, i: int) -> dict:
    friction, strength = r.uniform(0.4, 0.7), r.uniform(2, 25)
    more = {"cohesion": Q_(strength, "kPa")}
    if i % 2:
        more["tensile_strength"] = Q_(r.uniform(0.2, 0.9) * strength / friction, "kPa")
    sides = [bs.structures.Sidewall("left", "0 m", "1 m", bonded=True)] if i % 3 == 0 else []
    blocks = masonry(0.5 * int(r.integers(3, 6)), int(r.integers(4, 8)), 0.25, sidewalls=sides)
    way = [(1, 0, 0), (0, -1, 0), (1, -1, 0)][i % 3]
    return {"blocks": blocks, "joint": joint(friction, **more), "variable": push(*way)}


def tied(r: Random, i: int) -> dict:
    """A façade between two returns, held by a tie along each of them."""
    length, courses, depth = 0.5 * int(r.integers(3, 6)), int(r.integers(4, 8)), 0.25
    at = {"left": 0, "right": length - depth}
    sides = [bs.structures.Sidewall(name, metres(x), "1 m", bonded=i % 2 == 0) for name, x in at.items()]
    blocks = masonry(length, courses, depth, sidewalls=sides)
    ties = []
    for k, x in enumerate((0.1, length - 0.1)):
        ends = [np.array([x, y, 0.25 * courses - 0.1]) for y in (0.02, depth + 0.98)]
        one, other = (next(b for b in free(blocks) if contains(b, end)) for end in ends)
        ties.append((f"tie {k}", one.name, ends[0], other.name, ends[1], float(r.uniform(0.3, 5))))
    way = [(0, -1, 0), (1, -1, 0)][i % 2]
    return {"blocks": blocks, "joint": joint(r.uniform(0.45, 0.7)), "variable": push(*way), "ties": ties}


def contains(block: bs.Block, at: np.ndarray) -> bool:
    """Whether a point lies in the box around a block."""
    corners = block.shape.vertices
    return bool((corners.min(axis=0) <= at + 1e-9).all() and (at <= corners.max(axis=0) + 1e-9).all())


def crushing(r: Random, i: int) -> dict:
    """A wall, with a return bonded or butted, of a strength in multiples of the stress at its base."""
    length, courses = 0.5 * int(r.integers(3, 6)), int(r.integers(4, 8))
    sides = [[], [bs.structures.Sidewall("left", "0 m", "1 m", bonded=i % 2 == 0)]][i // 2 % 2]
    strength = [20, 60, 200, 600][i % 4] * 16 * 0.25 * courses / 2
    blocks = masonry(length, courses, 0.25, sidewalls=sides)
    way = [(1, 0, 0), (0, -1, 0), (1, -1, 0)][i % 3]
    strong = joint(r.uniform(0.5, 0.7), compressive_strength=Q_(strength, "kPa"))
    return {"blocks": blocks, "joint": strong, "variable": push(*way)}


def precompressed(r: Random, i: int) -> dict:
    blocks, pressure = masonry(0.5 * int(r.integers(3, 6)), int(r.integers(4, 8)), 0.25), r.uniform(1, 20)
    row = top(blocks)
    weights = [point(b, middle_of_top(b), (0, 0, -pressure * np.ptp(b.shape.vertices[:, 0]))) for b in row]
    pushed = loads(*(point(b, middle_of_top(b), (0.5 * pressure, 0.2 * pressure, 0)) for b in row))
    variable = [push(1, 0, 0), push(0, 1, 0), push(1, 1, 0), pushed][i % 4]
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), *weights])
    return {"blocks": blocks, "joint": joint(r.uniform(0.4, 0.7)), "variable": variable, "dead": dead}


def dilatant(r: Random, i: int) -> dict:
    friction = r.uniform(0.4, 0.75)
    angle = [0.1, 0.3, 0.5, 0.7, 0.9, 1.0][i % 6] * (1 - 1e-9) * math.degrees(math.atan(friction))
    length, courses = 0.5 * int(r.integers(4, 6)), int(r.integers(5, 8))
    sides = [bs.structures.Sidewall("left", "0 m", "1 m", bonded=True)] if i >= 6 else []
    holes = [] if sides else [bs.structures.Opening(start="0.5 m", sill="0 m", width="0.5 m", height="0.75 m")]
    blocks = masonry(length, courses, 0.25, sidewalls=sides, openings=holes)
    rough = joint(friction, dilatancy_angle=Q_(float(angle), "deg"))
    return {"blocks": blocks, "joint": rough, "variable": push(*[(1, 0, 0), (0, -1, 0)][i // 6 % 2])}


def by_hand(r: Random, i: int) -> dict:
    """A block, or two, whose load factor statics gives."""
    b, t, h, mu = r.uniform(0.3, 0.7), r.uniform(0.3, 0.8), r.uniform(0.5, 1.6), r.uniform(0.25, 0.8)
    block = box("block", [0, 0, 0], [b, t, h])
    blocks, of_joint, variable, exact = [GROUND, block], joint(mu), push(1, 0, 0), min(mu, b / h)
    weight = 16 * b * t * h
    if i % 6 == 1:
        variable, exact = loads(point(block, block.centroid, (0, 0, 1))), weight
    elif i % 6 == 2:
        # Up or down a slope, a push along the global x.
        tan, ratio = math.tan(0.1), exact
        blocks = bs.structures.tilted(blocks, Q_(0.1, "rad"), axis=(0, 1, 0))
        exact = (ratio - tan) / (1 + ratio * tan)
    elif i % 6 == 3:
        share = r.uniform(0.02, 0.3)
        of_joint = joint(0.9, compressive_strength=Q_(16 * h / share, "kPa"))
        exact = min(0.9, b / h * (1 - share))
    elif i % 6 == 4:
        # A push with a lift: sliding at μ (W - α sin) = α cos, rocking about the toe.
        cos, sin = math.cos(0.3), math.sin(0.3)
        variable = loads(point(block, block.centroid, (cos, 0, sin)))
        exact = min(mu * weight / (cos + mu * sin), weight * b / (h * cos + b * sin))
    elif i % 6 == 5:
        # Two blocks: the upper one rocks or slides, or both rock as one about the toe of the lower one.
        height, narrow, offset = r.uniform(0.6, 1.2), 0.8 * b, 0.05
        blocks.append(box("upper", [offset, 0, h], [narrow, t, height]))
        one, other = b * h, narrow * height
        arm = one * b / 2 + other * (b - offset - narrow / 2)
        both = arm / (one * h / 2 + other * (h + height / 2))
        exact = min(mu, narrow / height, both)
    return {"blocks": blocks, "joint": of_joint, "variable": variable, "exact": exact}


def falls(r: Random, i: int) -> dict:
    """A structure that does not stand under its own weight."""
    blocks = [
        lambda: bs.arch(span="4 m", thickness="0.13 m", depth="0.6 m", voussoirs=17, material=STONE),
        lambda: bs.structures.stack(8, size=Q_([0.5, 0.6, 0.4], "m"), material=STONE, shift=Q_([0.12, 0.0], "m")),
        lambda: bs.structures.tilted(masonry(1.5, 6, 0.25), Q_(40.0, "deg"), axis=(0, 1, 0)),
        lambda: bs.structures.barrel_vault(
            span="3 m", thickness="0.1 m", length="1.2 m", voussoirs=9, units=2, material=STONE, staggered=True
        ),
    ][i % 4]()
    return {"blocks": blocks, "joint": joint(r.uniform(0.5, 0.7)), "variable": push(1, 0, 0)}


def jammed(r: Random, i: int) -> dict:
    """A load that never, or hardly, moves the structure."""
    if i % 4 == 0:
        return {"blocks": masonry(1.5, 5, 0.3), "joint": joint(0.6), "variable": push(0, 0, -1)}
    jambs = [box(n, [x, 0, 0], [0.5, 0.5, 2], fixed=True) for n, x in (("left", -0.5), ("right", 1.5))]
    fill = [box(f"{j}.{k}", [0.5 * k, 0, 0.4 * j], [0.5, 0.5, 0.4]) for j in range(3) for k in range(3)]
    way = [(1, 0, 0), (0, 1, 0), (0, 0, 1)][i % 4 - 1]
    return {"blocks": [GROUND, *jambs, *fill], "joint": joint(r.uniform(0.4, 0.7)), "variable": push(*way)}


def several_loads(r: Random, i: int) -> dict:
    blocks = masonry(2.0, int(r.integers(4, 8)), 0.3)
    row = top(blocks)
    first, last = row[0], row[-1]
    of = [bs.BodyForce((1, 0, 0)), point(first, first.centroid, (1, 0, 0)), point(last, last.centroid, (0, 0.5, 0))]
    if i % 2:
        of.append(bs.Moment(first.name, Q_([0.0, 0.3, 0.2], "kN m")))
        of.append(bs.FaceLoad(last.name, last.face_towards((0, 0, 1)), Q_([0.0, 0.0, -5.0], "kPa")))
    return {"blocks": blocks, "joint": joint(r.uniform(0.4, 0.7)), "variable": loads(*of)}


def unequal(r: Random, i: int) -> dict:
    """Boulders and pebbles, or courses of very different heights."""
    if i % 2 == 0:
        s = [0.02, 0.05, 0.1, 0.03][i // 2 % 4]
        sizes = [
            ("boulder", [0, 0, 0], [1, 1, 1.2]),
            ("pebble", [1, 0.4, 0], [s, s, s]),
            ("cap", [0.2, 0.2, 1.2], [2 * s, s, s]),
            ("other", [1 + s, 0, 0], [0.5, 1, 0.8]),
        ]
        blocks = [GROUND, *(box(*each) for each in sizes)]
        return {"blocks": blocks, "joint": joint(0.5), "variable": push(1, 0.2 * (i % 4), 0)}
    blocks, z = [GROUND], 0.0
    for j in range(5):
        height = float(r.choice([0.05, 0.1, 0.5]))
        edges = [0.0, *np.cumsum(r.uniform(0.3, 0.9, int(r.integers(1, 4))))]
        edges = [*(e * 2 / edges[-1] for e in edges[:-1]), 2.0]
        for k, (a, b) in enumerate(pairwise(edges)):
            blocks.append(box(f"{j}.{k}", [a, 0, z], [b - a, 0.4, height]))
        z = round(z + height, 6)
    return {"blocks": blocks, "joint": joint(0.6), "variable": push(*[(1, 0, 0), (0, 1, 0)][i // 2 % 2])}


def tall(r: Random, i: int) -> dict:
    """A slender wall, alone or with two returns."""
    at = {"left": 0, "right": 1.25} if i % 2 else {}
    sides = [bs.structures.Sidewall(name, metres(x), "1 m", bonded=True) for name, x in at.items()]
    blocks = masonry(1.5, int(r.integers(12, 22)), 0.25, sidewalls=sides)
    return {"blocks": blocks, "joint": joint(0.6), "variable": push(*[(1, 0, 0), (0, -1, 0), (1, -1, 0)][i % 3])}


def large(r: Random, i: int) -> dict:
    """A wall of some hundred units, with or without openings."""
    holes = [
        bs.structures.Opening(start="1.5 m", sill="0 m", width="1 m", height="1.5 m"),
        bs.structures.Opening(start="4 m", sill="1 m", width="1 m", height="1 m"),
    ]
    blocks = masonry(8.0, int(r.integers(14, 20)), 0.3, openings=holes if i % 2 else [])
    return {"blocks": blocks, "joint": joint(0.62), "variable": push(*direction(i))}


#: Every kind, its builder, and how many structures of it there are.
KINDS: dict[str, tuple[Callable[[Random, int], dict], int]] = {
    "rubble": (rubble, 20),
    "openings": (openings, 20),
    "front": (front, 20),
    "arch": (arch, 14),
    "arch on piers": (arch_on_piers, 6),
    "vault": (vault, 12),
    "dome": (dome, 9),
    "portal": (portal, 8),
    "column": (column, 12),
    "point load": (point_load, 16),
    "cohesion": (cohesion, 12),
    "tied": (tied, 8),
    "crushing": (crushing, 16),
    "precompressed": (precompressed, 8),
    "dilatant": (dilatant, 12),
    "by hand": (by_hand, 18),
    "falls": (falls, 4),
    "jammed": (jammed, 4),
    "several loads": (several_loads, 6),
    "unequal": (unequal, 8),
    "tall": (tall, 6),
    "large": (large, 4),
}


def names() -> list[str]:
    """Names of all structures: their kind and a number."""
    return [f"{kind} {i}" for kind, (_, count) in KINDS.items() for i in range(count)]


def structure(name: str) -> Structure:
    """The structure of a name."""
    kind, _, number = name.rpartition(" ")
    builder, _ = KINDS[kind]
    seed = 31 * list(KINDS).index(kind) + 1000 * int(number)
    return Structure(name, kind, **builder(np.random.default_rng(seed), int(number)))
