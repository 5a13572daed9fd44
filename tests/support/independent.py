"""Limit analysis a second time, by other means: what the library must agree with.

Nothing here is taken from the library but the geometry of blocks, interfaces and ties. Equilibrium is assembled block
by block in global axes about the origin, friction is a pyramid inside or around the cone, and the program is linear.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import linprog

import blockstruct as bs

FACETS = 32


@dataclass
class Structure:
    """Bodies and contact points of a model, in SI units and global axes."""

    centroid: dict[str, np.ndarray]
    weight: dict[str, float]
    free: list[str]
    contacts: list[tuple[str, str, np.ndarray, np.ndarray, float]]  # minus, plus, point, normal, friction
    ties: list[bs.ties.TieSegment]

    @classmethod
    def of(cls, model: bs.Model) -> "Structure":
        centroid, weight, contacts = {}, {}, []
        for block in model.blocks:
            volume, centroid[block.name] = solid(block.shape.vertices, block.shape.faces)
            weight[block.name] = volume * block.material.unit_weight
        for interface in model.interfaces:
            corners = interface.polygon
            normal = sum(np.cross(a - corners[0], b - corners[0]) for a, b in pairwise(corners))
            normal /= np.linalg.norm(normal)
            mu = interface.joint_material.friction_coefficient
            contacts += [(interface.minus, interface.plus, corner, normal, mu) for corner in corners]
        ties = bs.ties.tie_segments(model.ties, model.blocks)
        return cls(centroid, weight, [b.name for b in model.blocks if not b.fixed], contacts, ties)

    def wrench(self, loads: dict[str, list[tuple[np.ndarray, np.ndarray]]]) -> np.ndarray:
        """Force and moment about the origin on every free block of forces at points."""
        w = np.zeros((len(self.free), 6))
        for row, name in zip(w, self.free, strict=True):
            for point, force in loads.get(name, []):
                row[:3] += force
                row[3:] += np.cross(point, force)
        return w.ravel()

    def body_force(self, direction: np.ndarray) -> np.ndarray:
        """Wrench of the weight turned to a direction."""
        return self.wrench({b: [(self.centroid[b], self.weight[b] * np.asarray(direction))] for b in self.free})

    def pulls(self) -> np.ndarray:
        """Wrenches of a unit force in every stretch of a tie: each of its blocks is drawn to the other."""
        pulls = np.zeros((len(self.ties), 6 * len(self.free)))
        for pull, s in zip(pulls, self.ties, strict=True):
            d, (one, other) = np.array(s.direction), s.blocks
            pull += self.wrench({one: [(np.array(s.start), d)], other: [(np.array(s.end), -d)]})
        return pulls

    def changes(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the changes of force along bonded bars, both ways, and the bond that limits them."""
        rows, most = [], []
        for k, s in enumerate(self.ties):
            if math.isfinite(s.bond[1]):
                row = np.zeros(len(self.ties))
                row[k : k + 2] = -1.0, 1.0
                rows += [row, -row]
                most += [s.bond[1]] * 2
        return np.array(rows).reshape(len(rows), len(self.ties)), np.array(most)

    def columns(self, radius: float) -> np.ndarray:
        """Wrenches of the edges of all friction pyramids, whose base is a polygon of a radius in multiples of μ."""
        row = {name: 6 * i for i, name in enumerate(self.free)}
        columns = []
        for minus, plus, point, normal, mu in self.contacts:
            first = np.cross(normal, [1.0, 0, 0] if abs(normal[0]) < 0.9 else [0, 1.0, 0])
            first /= np.linalg.norm(first)
            second = np.cross(normal, first)
            for k in range(FACETS):
                angle = 2 * math.pi * k / FACETS
                force = normal + radius * mu * (math.cos(angle) * first + math.sin(angle) * second)
                column = np.zeros(6 * len(self.free))
                for name, sign in ((plus, 1.0), (minus, -1.0)):
                    if name in row:
                        i = row[name]
                        column[i : i + 3] += sign * force
                        column[i + 3 : i + 6] += sign * np.cross(point, force)
                columns.append(column)
        return np.array(columns).T


def solid(vertices: np.ndarray, faces: tuple[tuple[int, ...], ...]) -> tuple[float, np.ndarray]:
    """Volume and centroid of a solid, by the tetrahedra of its faces from one of its points."""
    apex = vertices.mean(axis=0)
    triangles = [(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)]
    tetrahedra = vertices[np.array(triangles)] - apex
    volumes = np.linalg.det(tetrahedra) / 6
    return volumes.sum(), apex + (volumes[:, None] * tetrahedra.sum(axis=1) / 4).sum(axis=0) / volumes.sum()


def load_factor(structure: Structure, dead: np.ndarray, variable: np.ndarray, radius: float) -> float:
    """Largest α with ``forces + dead + α variable = 0``: NaN if the dead load alone finds none, ∞ if unbounded."""
    none = np.zeros_like(dead)
    # A prestress is a load that comes with the dead load.
    stressed = dead + np.array([s.prestress for s in structure.ties]) @ structure.pulls()
    share = largest(structure, radius, none, stressed, 1.0)
    return math.nan if share < 1 - 1e-7 else largest(structure, radius, stressed, variable, None)


def largest(structure: Structure, radius: float, fixed: np.ndarray, growing: np.ndarray, limit: float | None) -> float:
    """Largest factor ≥ 0 of a load that forces at contacts and in ties balance beside a fixed one."""
    A, pulls = structure.columns(radius), structure.pulls()
    unit = np.abs(fixed).max() or np.abs(growing).max()
    cost = np.append(np.zeros(A.shape[1] + len(pulls)), -1.0)
    balance = np.hstack([A, pulls.T, growing[:, None] / unit])
    rows, most = structure.changes()
    changes = np.hstack([np.zeros((len(rows), A.shape[1])), rows, np.zeros((len(rows), 1))])
    limits = [(0, None)] * A.shape[1] + [(0, (s.capacity - s.prestress) / unit) for s in structure.ties] + [(0, limit)]
    for method in ("highs-ds", "highs-ipm"):
        found = linprog(cost, changes, most / unit, A_eq=balance, b_eq=-fixed / unit, bounds=limits, method=method)
        if found.status == 0:
            return -found.fun
        if found.status == 3:
            return math.inf
    msg = f"no answer: {found.message}"
    raise AssertionError(msg)


def bounds(structure: Structure, dead: np.ndarray, variable: np.ndarray) -> tuple[float, float]:
    """Load factors of the pyramids inside and around the cones."""
    inner = load_factor(structure, dead, variable, 1.0)
    return inner, load_factor(structure, dead, variable, 1 / math.cos(math.pi / FACETS))


@dataclass
class Measures:
    """A certificate by hand: shares of the weight, of the fastest motion, and of the work of the variable load."""

    residual: float
    excess: float
    penetration: float
    gap: float
    work: float


def measures(structure: Structure, dead: np.ndarray, variable: np.ndarray, result: bs.CaseResult) -> Measures:
    """Certificate of the last iteration of a non-dilatant case, contact by contact, in SI units."""
    last = result.history.isel(iteration=-1)
    motion = np.hstack([last.block_velocity, last.block_angular_velocity])
    of_block = dict(zip(last.block.to_numpy(), motion, strict=True))
    frames = last.interface_frame.to_numpy()[last.interface_of_contact_point.to_numpy()]
    forces = np.einsum("kc,kca->ka", last.contact_force.to_numpy(), frames)
    row = {name: 6 * i for i, name in enumerate(structure.free)}
    balance = dead + result.load_factor * variable
    excess = penetration = gap = fastest = 0.0
    for (minus, plus, point, normal, mu), force in zip(structure.contacts, forces, strict=True):
        v = np.zeros(3)
        for name, sign in ((plus, 1.0), (minus, -1.0)):
            velocity = of_block[name]
            v += sign * (velocity[:3] + np.cross(velocity[3:], point - structure.centroid[name]))
            if name in row:
                balance[row[name] : row[name] + 3] += sign * force
                balance[row[name] + 3 : row[name] + 6] += sign * np.cross(point, force)
        n, v_n = force @ normal, v @ normal
        t, v_t = force - n * normal, v - v_n * normal
        excess = max(excess, np.linalg.norm(t) - mu * n, -n)
        penetration, fastest = max(penetration, -v_n), max(fastest, np.linalg.norm(v))
        gap += abs(n * v_n) + abs(mu * n * np.linalg.norm(v_t) + t @ v_t)
    if structure.ties:
        tension = last.tie_force.to_numpy()
        balance += tension @ structure.pulls()
        rates = np.zeros(len(tension))
        for k, s in enumerate(structure.ties):
            for name, point, sign in ((s.blocks[1], s.end, 1.0), (s.blocks[0], s.start, -1.0)):
                velocity = of_block[name]
                at = velocity[:3] + np.cross(velocity[3:], np.array(point) - structure.centroid[name])
                rates[k] += sign * at @ s.direction
            excess = max(excess, tension[k] - s.capacity, s.prestress - tension[k])
        rows, most = structure.changes()
        excess = max(excess, (rows @ tension - most).max(initial=-np.inf))
        limits = [(s.prestress, s.capacity) for s in structure.ties]
        unit, speed = max(s.capacity for s in structure.ties), max(np.abs(rates).max(), 1e-300)
        best = linprog(-rates / speed, rows, most / unit, bounds=np.array(limits) / unit)
        gap += -best.fun * speed * unit - tension @ rates
    work = 0.0
    for name in structure.free:
        i, velocity = row[name], of_block[name]
        force, moment = variable[i : i + 3], variable[i + 3 : i + 6]
        work += force @ velocity[:3] + (moment - np.cross(structure.centroid[name], force)) @ velocity[3:]
    weight = max(structure.weight[name] for name in structure.free)
    return Measures(np.abs(balance).max() / weight, excess / weight, penetration / fastest, gap, work)
