"""The loading path a second time, by other means: implicit steps of rigid blocks on small elastic joints.

Only blocks, loads, ties and corners of interfaces come from the library. Every contact point is a spring that bears
compression and slides by a return mapping. Newton's method solves each step to equilibrium. The displacement of the
variable load is prescribed, and its load factor is an unknown.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

import blockstruct as bs
from independent import solid

Array = NDArray[np.float64]

#: Shear over normal stiffness of a joint, the default of the library.
SHEAR_RATIO = 0.4
#: Largest unbalanced wrench of a solved step, in mean weights of a block.
BALANCED = 1e-5
#: Iterations of Newton's method in one step.
MAX_ITERATIONS = 20
#: Shares of a Newton correction that are tried.
SHARES = (1.0, 0.5, 0.25, 0.1, 0.03)
#: Least stiffness added to every block, which keeps one without contacts from moving without limit.
LEAST_STIFFNESS = 1e-7
#: Drag on the blocks where a step has no equilibrium nearby: the first, and the largest.
FIRST_DRAG, LARGEST_DRAG = 1e-4, 1e3
#: Stiffness of ties over that of a mean contact point. Ties of the library are rigid until they yield.
TIE_STIFFNESS = 1e3


@dataclass(frozen=True)
class Memory:
    """What contact points and ties remember: displacement, shear force and plastic opening."""

    displacement: Array  # (K, 3)
    shear: Array  # (K, 2)
    plastic: Array  # (K,)
    stretched: Array  # (M,)


@dataclass(frozen=True)
class Response:
    """Forces of contact points (K, 3) and ties (M,), their stiffness, and what they would remember."""

    force: Array
    stiffness: Array  # (K, 3, 3), loss of force per displacement
    tension: Array
    tie_stiffness: Array
    memory: Memory


@dataclass(frozen=True)
class State:
    """Displacements of the blocks, the load factor, and what joints remember."""

    u: Array
    alpha: float
    memory: Memory


@dataclass(frozen=True)
class Path:
    """Load factors over displacements in multiples of the elastic one.

    ``drag`` is the force, in mean weights, that holds the blocks back at the end of each step: zero in equilibrium.
    """

    displacement: Array
    load_factor: Array
    drag: Array
    furthest: float

    @property
    def last(self) -> float:
        return float(self.load_factor[-1])

    @property
    def finished(self) -> bool:
        """Whether the path has come to its end, in equilibrium."""
        return bool(self.displacement[-1] >= self.furthest and self.drag[-1] < 10 * BALANCED)

    @property
    def change(self) -> float:
        """Range of the load factor over the last decade of displacement, relative to its end."""
        tail = self.load_factor[self.displacement > self.displacement[-1] / 10]
        return float(np.ptp(tail) / max(abs(self.last), 1e-12))


@dataclass(frozen=True)
class Joints:
    """Springs at contact points, non-dimensional: forces in mean weights, lengths in a mean block size."""

    B: sp.csr_array  # (6 F, 3 K + M) wrenches of unit forces
    normal: Array
    shear: Array
    friction: Array
    dilatancy: Array
    cohesion: Array
    tension: Array
    strength: Array
    least: Array  # tie force at rest
    most: Array

    def at_rest(self) -> Memory:
        K = len(self.normal)
        return Memory(np.zeros((K, 3)), np.zeros((K, 2)), np.zeros(K), np.zeros(len(self.least)))

    def respond(self, u: Array, memory: Memory) -> Response:
        """Forces of all points and ties at displacements u of the blocks."""
        K = len(self.normal)
        moved = self.B.T @ u
        d, elongation = moved[: 3 * K].reshape(K, 3), -moved[3 * K :]
        kn, kt, psi, mu = self.normal, self.shear, self.dilatancy, self.friction
        n = kn * (memory.plastic - d[:, 0])
        trial = memory.shear - kt[:, None] * (d - memory.displacement)[:, 1:]
        size = np.linalg.norm(trial, axis=1)
        limit = self.cohesion + mu * np.minimum(n, self.strength)
        # Return to the cone: slip γ lowers the shear by kt γ and, with dilatancy, raises the normal force.
        slip = np.maximum(size - limit, 0.0) / (kt + mu * kn * psi)
        n = n + kn * psi * slip
        opens, crushes = n < -self.tension, n > self.strength
        capped = opens | crushes
        plastic = memory.plastic + np.where(opens, 0.0, psi * slip)
        plastic = np.where(crushes, plastic - (n - self.strength) / kn, plastic)
        n = np.clip(n, -self.tension, self.strength)
        limit = np.maximum(self.cohesion + mu * n, 0.0)
        slides = size > limit
        factor = np.where(slides, limit / np.maximum(size, 1e-300), 1.0)
        force = np.column_stack([n, factor[:, None] * trial])

        along = trial / np.maximum(size, 1e-300)[:, None]
        stiffness = np.zeros((K, 3, 3))
        # Derivatives of n by the normal displacement and by the shear trial.
        soft = np.where(slides & ~capped, kt / (kt + mu * kn * psi), 1.0)
        dn = np.where(capped, 0.0, kn * soft)
        dn_dt = np.where(slides & ~capped, kn * psi / (kt + mu * kn * psi), 0.0)
        stiffness[:, 0, 0] = dn
        stiffness[:, 0, 1:] = (dn_dt * kt)[:, None] * along
        across = np.eye(2) - along[:, :, None] * along[:, None, :]
        stiffness[:, 1:, 1:] = (kt * factor)[:, None, None] * np.where(slides[:, None, None], across, np.eye(2))
        sliding = np.where(slides, mu, 0.0)
        stiffness[:, 1:, 0] = (sliding * dn)[:, None] * along
        stiffness[:, 1:, 1:] += (sliding * dn_dt * kt)[:, None, None] * along[:, :, None] * along[:, None, :]

        pull = self.least + TIE_STIFFNESS * (elongation - memory.stretched)
        tension = np.clip(pull, self.least, self.most)
        stretched = memory.stretched + np.maximum(pull - self.most, 0.0) / TIE_STIFFNESS
        holds = (pull >= self.least) & (pull <= self.most)
        kept = Memory(d, force[:, 1:], plastic, stretched)
        return Response(force, stiffness, tension, np.where(holds, TIE_STIFFNESS, 0.0), kept)


@dataclass(frozen=True)
class Structure:
    """Joints, and the wrenches of the dead and the variable load on the free blocks."""

    joints: Joints
    dead: Array
    variable: Array
    load_unit: float  # load factor of the library per load factor here

    @classmethod
    def of(cls, model: bs.Model, dead: bs.LoadPattern, variable: bs.LoadPattern, cells: int = 0) -> "Structure":
        """Springs and loads of a model. With ``cells``, rectangles that crush have that many points squared."""
        free = [b for b in model.blocks if not b.fixed]
        row = {b.name: 6 * i for i, b in enumerate(free)}
        solids = {b.name: solid(b.shape.vertices, b.shape.faces) for b in model.blocks}
        weights = {b.name: solids[b.name][0] * b.material.unit_weight for b in free}
        length = float(np.mean([solids[b.name][0] for b in free])) ** (1 / 3)

        points = [p for i in model.interfaces for p in points_of(i, cells)]
        at = np.array([p.position for p in points])
        frames = np.array([p.frame for p in points])
        names = [(p.interface.minus, p.interface.plus) for p in points]
        pulls = bs.ties.tie_segments(model.ties, model.blocks)
        rows, columns, entries = [], [], []
        for sign, end in ((-1.0, 0), (1.0, 1)):
            own = np.array([row.get(n[end], -1) for n in names])
            arm = (at - np.array([solids[n[end]][1] for n in names])) / length
            acts = own >= 0
            wrench = np.concatenate([frames, np.cross(arm[:, None, :], frames)], axis=2)[acts] * sign
            k = np.flatnonzero(acts)
            rows.append((own[acts][:, None, None] + np.arange(6) + np.zeros((1, 3, 1), int)).ravel())
            columns.append((3 * k[:, None, None] + np.arange(3)[:, None] + np.zeros((1, 1, 6), int)).ravel())
            entries.append(wrench.ravel())
        for m, tie in enumerate(pulls):
            d = np.array(tie.direction)
            for name, point, force in zip(tie.blocks, (tie.start, tie.end), (d, -d), strict=True):
                if name in row:
                    arm = (np.array(point) - solids[name][1]) / length
                    rows.append(row[name] + np.arange(6))
                    columns.append(np.full(6, 3 * len(points) + m))
                    entries.append(np.concatenate([force, np.cross(arm, force)]))
        shape = (6 * len(free), 3 * len(points) + len(pulls))
        coordinates = np.concatenate(rows), np.concatenate(columns)
        B = sp.csr_array(sp.coo_array((np.concatenate(entries), coordinates), shape=shape))

        def wrench(pattern: bs.LoadPattern) -> Array:
            w = np.zeros((len(free), 6))
            for load in pattern.loads:
                for name, point, force, couple in acting(load, free, weights, solids):
                    if name in row:
                        w[row[name] // 6, :3] += force
                        w[row[name] // 6, 3:] += (np.cross(point - solids[name][1], force) + couple) / length
            return w.ravel()

        unit = float(np.mean(list(weights.values())))
        w_D, w_L = wrench(dead) / unit, wrench(variable) / unit
        size = float(np.abs(w_L).sum() / np.abs(w_D).sum())
        area = np.array([p.area for p in points])
        stiffness = area / area.mean()
        material = [p.interface.joint_material for p in points]
        strength = [m.compressive_strength if p.crushes else np.inf for m, p in zip(material, points, strict=True)]
        joints = Joints(
            B=B,
            normal=stiffness,
            shear=SHEAR_RATIO * stiffness,
            friction=np.array([m.friction_coefficient for m in material]),
            dilatancy=np.tan([m.dilatancy_angle for m in material]),
            cohesion=np.array([m.cohesion for m in material]) * area / unit,
            tension=np.array([m.tensile_strength for m in material]) * area / unit,
            strength=np.array(strength) * area / unit,
            least=np.array([t.prestress for t in pulls]) / unit,
            most=np.array([t.capacity for t in pulls]) / unit,
        )
        return cls(joints, w_D, w_L / size, 1 / size)


@dataclass(frozen=True)
class Point:
    """A spring: where it is, the normal and two axes of its plane, and the area it stands for."""

    interface: bs.Interface
    position: Array
    frame: Array
    area: float
    crushes: bool = False


def points_of(interface: bs.Interface, cells: int) -> list[Point]:
    """Springs of an interface: at its corners, or in a rectangle that crushes at the centres of its cells."""
    corners = interface.polygon
    vector = sum(np.cross(corners[i] - corners[0], corners[i + 1] - corners[0]) for i in range(1, len(corners) - 1)) / 2
    area = float(np.linalg.norm(vector))
    normal = vector / area
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    frame = np.array([normal, first, np.cross(normal, first)])
    if cells and np.isfinite(interface.joint_material.compressive_strength):
        origin, along, across = corners[0], corners[1] - corners[0], corners[3] - corners[0]
        # Cells narrow towards the edges, where joints crush.
        edges = np.sin(np.pi / 2 * np.linspace(0, 1, cells + 1)) ** 2
        middles, widths = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
        at = [origin + a * along + b * across for a in middles for b in middles]
        areas = area * np.outer(widths, widths).ravel()
        return [Point(interface, p, frame, float(a), crushes=True) for p, a in zip(at, areas, strict=True)]
    # A corner takes half of the two triangles that it spans with the centroid.
    arms = corners - interface.centroid
    triangles = np.cross(arms, np.roll(arms, -1, axis=0)) @ normal / 2
    shares = (triangles + np.roll(triangles, 1)) / 2
    return [Point(interface, p, frame, float(a)) for p, a in zip(corners, shares, strict=True)]


def acting(load: object, free: list[bs.Block], weights: dict[str, float], solids: dict) -> list[tuple]:
    """Block, point, force and couple of everything that a load does."""
    none = np.zeros(3)
    match load:
        case bs.SelfWeight():
            return [(b.name, solids[b.name][1], np.array([0.0, 0.0, -weights[b.name]]), none) for b in free]
        case bs.BodyForce():
            d = np.asarray(load.direction) * load.share
            return [(b.name, solids[b.name][1], weights[b.name] * d, none) for b in free]
        case bs.PointLoad():
            return [(load.block, np.asarray(load.point), np.asarray(load.force), none)]
        case bs.Moment():
            return [(load.block, none, none, np.asarray(load.moment))]
        case bs.FaceLoad():
            block = next(b for b in free if b.name == load.block)
            face = block.shape.vertices[list(block.shape.faces[load.face])]
            parts = [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]
            areas = [np.linalg.norm(np.cross(b - a, c - a)) / 2 for a, b, c in parts]
            traction = np.asarray(load.traction)
            return [(load.block, np.mean(t, axis=0), a * traction, none) for t, a in zip(parts, areas, strict=True)]
    msg = f"no load of this kind: {load!r}"
    raise TypeError(msg)


def follow(
    structure: Structure, *, first: float = 0.1, growth: float = 1.2, furthest: float = 1e3, most_steps: int = 1000
) -> Path | None:
    """Load factor from the state under dead load to ``furthest`` elastic displacements, None if there is no such state.

    Steps grow from ``first`` by ``growth``. A step that is not solved is halved down to a tenth of the first one; then
    a drag holds the blocks back until they have come to a state of equilibrium further on.
    """
    newton = Newton(structure)
    state = newton.at_rest()
    if state is None:
        return None
    unit, length, drag, speed = newton.elastic_displacement(), first, 0.0, None
    rows = [(0.0, 0.0, 0.0)]
    while rows[-1][0] < furthest and len(rows) < most_steps and drag <= LARGEST_DRAG:
        guesses = [state.u] if speed is None else [state.u + length * speed, state.u]
        steps = (newton.step(state, length * unit, guess, drag) for guess in guesses)
        solved = next((s for s in steps if s is not None), None)
        if solved is None and length > first / 10:
            length /= 2
        elif solved is None:
            drag = max(10 * drag, FIRST_DRAG)
        else:
            moved = solved.u - state.u
            rows.append((rows[-1][0] + length, solved.alpha * structure.load_unit, drag * np.abs(moved).max()))
            state, speed = solved, moved / length
            length *= growth
            drag = drag / 3 if drag > FIRST_DRAG / 10 else 0.0
    return Path(*np.array(rows).T, furthest)


class Newton:
    """Newton's method with backtracking, for blocks whose displacement along the variable load is prescribed."""

    def __init__(self, structure: Structure) -> None:
        self._structure, self._joints = structure, structure.joints
        self._B, self._BT = structure.joints.B, sp.csr_array(structure.joints.B.T)

    def at_rest(self) -> State | None:
        """Equilibrium under dead load."""
        joints, load = self._joints, self._structure.dead
        begin = State(np.zeros_like(load), 0.0, joints.at_rest())
        return self._solve(begin, np.zeros_like(load), 0.0, begin.u, 0.0)

    def step(self, state: State, s: float, guess: Array, drag: float) -> State | None:
        """Equilibrium after a displacement s of the variable load, None if it is not found."""
        return self._solve(state, self._structure.variable, s, guess, drag)

    def elastic_displacement(self) -> float:
        """Displacement of the variable load at a load factor of one, on joints that neither open nor slide."""
        j, w = self._joints, self._structure.variable
        springs = np.column_stack([j.normal, j.shear, j.shear]).ravel()
        springs = sp.diags_array(np.append(springs, np.full(len(j.least), TIE_STIFFNESS)))
        return float(w @ splu(sp.csc_array(self._B @ springs @ self._BT)).solve(w))

    def _solve(self, before: State, w: Array, s: float, guess: Array, drag: float) -> State | None:
        u, alpha, extra = guess, before.alpha, LEAST_STIFFNESS

        def at(u: Array, alpha: float) -> tuple[Response, Array]:
            response = self._joints.respond(u, before.memory)
            forces = np.append(response.force.ravel(), response.tension)
            return response, self._B @ forces + self._structure.dead + alpha * w - drag * (u - before.u)

        response, R = at(u, alpha)
        for _ in range(MAX_ITERATIONS):
            missing = s - w @ (u - before.u)
            if np.abs(R).max() < BALANCED and abs(missing) <= 1e-9 * abs(s):
                return State(u, alpha, response.memory)
            correction = self._correction(response, w, R, missing, drag + extra)
            if correction is None:
                return None
            du, d_alpha = correction
            # A first correction that moves the load unbalances joints that open or slide, whatever its share.
            jumps, best = abs(missing) > 1e-9 * abs(s), None
            for share in SHARES:
                trial = (*at(u + share * du, alpha + share * d_alpha), share)
                size = np.linalg.norm(trial[1])
                if best is None or size < np.linalg.norm(best[1]):
                    best = trial
                if jumps or size < (1 - 0.2 * share) * np.linalg.norm(R):
                    break
            response, R, share = best
            extra = max(extra / 4, LEAST_STIFFNESS) if share == 1.0 else min(10 * extra, 1.0)
            u, alpha = u + share * du, alpha + share * d_alpha
        return None

    def _correction(
        self, response: Response, w: Array, R: Array, missing: float, extra: float
    ) -> tuple[Array, float] | None:
        """Newton's correction of displacements and load factor, None if the matrix is singular."""
        K, ties = len(response.stiffness), sp.diags_array(response.tie_stiffness)
        D = sp.bsr_array((response.stiffness, np.arange(K), np.arange(K + 1)))
        if len(response.tension):
            D = sp.block_diag([D, ties])
        matrix = self._B @ (D @ self._BT) + extra * sp.eye_array(len(R))
        try:
            if not w.any():
                return splu(sp.csc_array(matrix)).solve(R), 0.0
            bordered = sp.block_array([[matrix, -w[:, None]], [w[None], None]], format="csc")
            x = splu(bordered).solve(np.append(R, missing))
        except RuntimeError:
            return None
        return x[:-1], float(x[-1])
