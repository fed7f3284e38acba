"""A second, independent solver of the woven lattice, for hidden truths only: numpy and scipy, nothing of the product.

It differs from the product on purpose: another lattice, laws as tables, forces without an energy, a pseudo-transient
Newton (Levenberg-Marquardt damping that follows the residual), contact by a plain stiff penalty. Units mm, N, MPa, s.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse
from scipy.linalg import solveh_banded
from scipy.sparse.csgraph import reverse_cuthill_mckee


CELL = (0.2849, 0.1603)
AREA = 0.0155
THICKNESS = 0.35
WARP, WEFT, DIAGONAL = 0, 1, 2
# Residual in N below which a node counts as balanced.
FLOOR = 5e-6
# E, sigma_y0, H, n per family: the estimates that the paper's lost table is replaced by
MID = ((3000.0, 0.2, 9960.0, 1.5), (4500.0, 0.2, 4230.0, 1.1), (1500.0, 0.2, 1550.0, 2.2))


class Law:
    """Stress over strain of one family as a table: plastic strain p, yield stress s(p); unloads with E (1 - d)."""

    def __init__(self, E, yield0, H, n, *, change=None, damage=None):
        p = np.concatenate([[0.0], np.geomspace(1e-9, 4.0, 6000)])
        stress = yield0 * p / (p + 1e-3) + H * p**n
        if change is not None:
            stress = change(p, stress)
        self.E, self.p, self.undamaged = E, p, stress
        self.kept = np.ones_like(p) if damage is None else 1.0 - damage(p)
        self.total = p + stress / E
        self.slope = np.gradient(stress, p)

    def coupon(self, strain, turn):
        """Engineering stress on A0 at engineering strains: up to index `turn`, then unloading."""
        eps = np.log1p(strain)
        p = np.interp(eps, self.total, self.p)
        p[turn + 1 :] = p[turn]
        stress = np.where(
            np.arange(len(eps)) <= turn, np.interp(p, self.p, self.undamaged), np.maximum(self.E * (eps - p), 0.0)
        )
        return stress * np.interp(p, self.p, self.kept) * np.exp(-p)


@dataclass
class Lattice:
    """Quarter of the specimen, nx x ny cells: nodes (N, 3), trusses (M, 2), family, rest length, area, cells (Q, 4)."""

    nx: int
    ny: int
    points: np.ndarray
    trusses: np.ndarray
    family: np.ndarray
    rest: np.ndarray
    area: np.ndarray
    cells: np.ndarray
    share: np.ndarray
    half: tuple

    @classmethod
    def quarter(cls, nx, ny, half=(50.0, 50.0)):
        x, y = np.linspace(0, half[0], nx + 1), np.linspace(0, half[1], ny + 1)
        number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
        points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((nx + 1, ny + 1))], axis=-1).reshape(-1, 3)
        hx, hy = x[1], y[1]
        wide_x, wide_y = np.full(nx + 1, hx), np.full(ny + 1, hy)
        wide_x[[0, -1]] /= 2
        wide_y[[0, -1]] /= 2
        slanted = np.hypot(hx, hy)
        diagonal = hx * hy / (CELL[0] * CELL[1]) * np.hypot(*CELL) * AREA / slanted
        parts = [
            (number[:-1], number[1:], WARP, np.broadcast_to(AREA * wide_y / CELL[1], (nx, ny + 1))),
            (number[:, :-1], number[:, 1:], WEFT, np.broadcast_to((AREA * wide_x / CELL[0])[:, None], (nx + 1, ny))),
            (number[:-1, :-1], number[1:, 1:], DIAGONAL, np.full((nx, ny), diagonal)),
            (number[1:, :-1], number[:-1, 1:], DIAGONAL, np.full((nx, ny), diagonal)),
        ]
        trusses = np.concatenate([np.stack([a.ravel(), b.ravel()], 1) for a, b, _, _ in parts])
        family = np.concatenate([np.full(a.size, k) for a, _, k, _ in parts])
        area = np.concatenate([np.ravel(value) for *_, value in parts])
        rest = np.linalg.norm(points[trusses[:, 1]] - points[trusses[:, 0]], axis=1)
        cells = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1).reshape(-1, 4)
        share = np.outer(wide_x / hx, wide_y / hy).ravel()
        return cls(nx, ny, points, trusses, family, rest, area, cells, share, half)

    def line(self, name):
        """Mask of the nodes of an edge: clamp (x = L/2), free (y = B/2), or a symmetry plane."""
        x, y = self.points[:, 0], self.points[:, 1]
        ends = {"clamp": x == x.max(), "free": y == y.max(), "x0": x == 0, "y0": y == 0}
        return ends[name]


class Trusses:
    """All trusses of the lattice; `carry`: function of compressive Hencky strain giving (stress, slope), or None."""

    def __init__(self, lattice, laws, *, carry=None, nodes=None):
        self.nodes = lattice.trusses if nodes is None else nodes
        self.rest, self.area, self.family, self.laws = lattice.rest.copy(), lattice.area.copy(), lattice.family, laws
        self.carry = carry
        self.factor = np.ones(len(self.rest))

    def start(self):
        return np.zeros(len(self.rest))

    def __call__(self, x, travel, p_old):
        d = x[self.nodes[:, 1]] - x[self.nodes[:, 0]]
        length = np.maximum(np.linalg.norm(d, axis=1), 1e-9)
        unit = d / length[:, None]
        eps = np.log(length / self.rest)
        stress, slope, p, flow = np.zeros_like(eps), np.zeros_like(eps), p_old.copy(), np.zeros_like(eps)
        for k, law in enumerate(self.laws):
            own = np.flatnonzero(self.family == k)
            e, po = eps[own], p_old[own]
            new = np.interp(e, law.total, law.p)
            plastic = new > po
            pk = np.where(plastic, new, po)
            harden = np.interp(pk, law.p, law.slope)
            s = np.where(plastic, np.interp(pk, law.p, law.undamaged), law.E * (e - pk))
            t = np.where(plastic, law.E * harden / (law.E + harden), law.E)
            slack = s < 0
            left = np.interp(pk, law.p, law.kept)
            s, t = s * left, t * left
            s[slack], t[slack] = 0.0, 0.0
            if self.carry is not None:
                extra, extra_slope = self.carry(np.minimum(e - pk, 0.0), law)
                s, t = s + extra, t + extra_slope
            stress[own], slope[own], p[own] = s * self.factor[own], t * self.factor[own], pk
            flow[own] = np.where(plastic, law.E / (law.E + harden), 0.0)
        area = self.area * np.exp(-p)
        force = stress * area
        along = area * (slope - stress * flow) / length
        return Part(self.nodes, unit, force, along, force / length), p


@dataclass
class Part:
    """Two-node elements at a trial: unit vectors, tension, stiffness along and across."""

    nodes: np.ndarray
    unit: np.ndarray
    force: np.ndarray
    along: np.ndarray
    across: np.ndarray

    def add(self, gradient, entries):
        f = self.force[:, None] * self.unit
        np.add.at(gradient, self.nodes[:, 1], f)
        np.add.at(gradient, self.nodes[:, 0], -f)
        along, across = np.maximum(self.along, 0.0), np.maximum(self.across, 0.0)
        block = across[:, None, None] * np.eye(3) + (along - across)[:, None, None] * (
            self.unit[:, :, None] * self.unit[:, None, :]
        )
        a, b = self.nodes.T
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            entries.append((i, j, sign * block))


@dataclass
class General:
    """Elements of k nodes with gradient (n, k, 3) and positive tangent (n, k, 3, k, 3)."""

    nodes: np.ndarray
    gradient: np.ndarray
    tangent: np.ndarray

    def add(self, gradient, entries):
        np.add.at(gradient, self.nodes.ravel(), self.gradient.reshape(-1, 3))
        for i in range(self.nodes.shape[1]):
            for j in range(self.nodes.shape[1]):
                entries.append((self.nodes[:, i], self.nodes[:, j], self.tangent[:, i, :, j, :]))


class Ball:
    """Rigid sphere rising from below: stiff penalty on nodes, and friction that grips smoothly over a short slip."""

    def __init__(self, lattice, *, radius=15.0, friction=0.0, stiffness=20000.0, grip=0.02, offset=0.0):
        self.nodes = np.flatnonzero(~lattice.line("clamp"))
        self.share = lattice.share[self.nodes]
        self.radius, self.friction, self.stiffness, self.grip, self.offset = radius, friction, stiffness, grip, offset

    def start(self):
        return np.full((len(self.nodes), 3), np.nan)

    def __call__(self, x, travel, anchor):
        place = x[self.nodes] - np.array([0.0, 0.0, travel - self.radius])
        distance = np.linalg.norm(place, axis=1)
        normal = place / distance[:, None]
        gap = distance - self.radius
        push = self.stiffness * self.share * np.maximum(-gap, 0.0)
        touch = push > 0
        k = np.where(touch, self.stiffness * self.share, 0.0)
        gradient = -push[:, None] * normal
        tangent = k[:, None, None] * normal[:, :, None] * normal[:, None, :]
        new = np.where(touch[:, None], place, np.nan)
        if self.friction > 0:
            held = touch & np.isfinite(anchor[:, 0])
            slip = np.where(held[:, None], place - np.nan_to_num(anchor), 0.0)
            slip -= np.einsum("ij,ij->i", slip, normal)[:, None] * normal
            size = np.linalg.norm(slip, axis=1)
            grip = np.tanh(size / self.grip) / np.maximum(size, 1e-12)
            grip = np.where(size < 1e-9, 1.0 / self.grip, grip)
            pull = np.where(held, self.friction * push * grip, 0.0)
            gradient += pull[:, None] * slip
            tangent += pull[:, None, None] * (np.eye(3) - normal[:, :, None] * normal[:, None, :])
            # the anchor trails behind by the slip at which grip is fully used
            keep = np.minimum(1.0, 2.0 * self.grip / np.maximum(size, 1e-12))
            new = np.where(held[:, None], place - keep[:, None] * slip, new)
        self.force = -float(gradient[:, 2].sum())
        return General(self.nodes[:, None], gradient[:, None, :], tangent[:, None, :, None, :]), new


@dataclass
class Result:
    """Converged steps: travel (S,), force (S,) of the whole specimen, positions (S, N, 3), worst relative residual."""

    travel: np.ndarray
    force: np.ndarray
    positions: np.ndarray
    lattice: Lattice
    residual: float = 0.0
    notes: list = field(default_factory=list)


def march(points, fixed, parts, ball, travels, *, tolerance=2e-5, most=200, before_step=None):
    """Follow the punch through `travels`, there and back; returns forces and positions, halves steps when needed."""
    x = points.copy()
    states = [part.start() for part in parts]
    done, last, last_travel, worst = 0.0, points.copy(), 0.0, 0.0
    forces, positions = [], []
    for target in travels:
        step = target - done
        while abs(target - done) > 1e-12:
            step = min(step, target - done, key=abs)
            guess = x + (x - last) * (step / (done - last_travel)) if done != last_travel else x
            if before_step is not None:
                before_step(x, states, done)
            found = balance(np.where(fixed, x, guess), fixed, parts, states, done + step, tolerance, most)
            if found is None:
                found = balance(x, fixed, parts, states, done + step, tolerance, most)
            if found is None:
                step /= 2
                if abs(step) < 1e-3:
                    raise RuntimeError(f"no balance at {done + step:.3f} mm")
                continue
            last, last_travel = x, done
            x, states, residual = found
            done += step
            worst = max(worst, residual)
        forces.append(4.0 * ball.force)  # of the balance itself: from its end on anchors trail, and friction is less
        positions.append(x.copy())
    return np.array(forces), np.array(positions), worst


def gather(x, parts, states, travel):
    """Evaluate all parts: gradient (N, 3), tangent entries and the states they would leave."""
    gradient, entries, new = np.zeros_like(x), [], []
    for part, state in zip(parts, states, strict=True):
        found, after = part(x, travel, state)
        found.add(gradient, entries)
        new.append(after)
    return gradient, entries, new


def balance(x, fixed, parts, states, travel, tolerance, most):
    """Newton with damping that follows the residual; None when it does not arrive."""
    free = np.flatnonzero(~fixed.ravel())
    gradient, entries, new = gather(x, parts, states, travel)
    damping = 1.0
    for _ in range(most):
        residual = np.where(fixed, 0.0, gradient)
        scale = np.abs(gradient[fixed]).max(initial=0.0) + 1e-3
        worst = float(np.abs(residual).max())
        if worst < tolerance * scale + FLOOR:
            return x, new, worst / scale
        step = newton_step(entries, residual, free, max(damping * worst, 1e-7))
        largest = np.abs(step).max()
        step *= min(1.0, 1.0 / largest) if largest > 0 else 1.0
        start = float(np.vdot(residual, step))
        length = 1.0
        for _ in range(8):
            trial = x + length * step
            after = gather(trial, parts, states, travel)
            slope = float(np.vdot(np.where(fixed, 0.0, after[0]), step))
            if slope < 0.5 * abs(start):
                break
            length *= max(0.15, min(0.6, -start / (slope - start)))
        x, (gradient, entries, new) = trial, after
        damping = damping * 0.2 if length == 1.0 else min(damping * 3.0, 1e3)
        damping = max(damping, 1e-4)
    return None


def newton_step(entries, residual, free, grip):
    """Solve (K + grip) step = -residual on the free components by a banded Cholesky factor."""
    band, order = assemble(entries, residual.size, free)
    band[0] += grip
    step = np.zeros(residual.size)
    step[free[order]] = solveh_banded(
        band, -residual.ravel()[free[order]], lower=True, overwrite_ab=True, check_finite=False
    )
    return step.reshape(residual.shape)


PATTERNS = {}


def assemble(entries, size, free):
    """Sum 3 x 3 blocks (i, j, block) into the lower band of the free components, ordered for a small bandwidth.

    Returns the band (b + 1, n) and the order (n,) of the free components; the pattern is laid out once.
    """
    key = (size, len(free), tuple(len(i) for i, _, _ in entries), int(sum(int(i.sum()) for i, _, _ in entries)))
    if key not in PATTERNS:
        offset = np.arange(3)
        rows = np.concatenate(
            [np.broadcast_to((3 * i[:, None] + offset)[:, :, None], (len(i), 3, 3)).ravel() for i, _, _ in entries]
        )
        columns = np.concatenate(
            [np.broadcast_to((3 * j[:, None] + offset)[:, None, :], (len(j), 3, 3)).ravel() for _, j, _ in entries]
        )
        number = np.full(size, -1)
        number[free] = np.arange(len(free))
        rows, columns = number[rows], number[columns]
        kept = (rows >= 0) & (columns >= 0)
        graph = sparse.csr_matrix((np.ones(int(kept.sum())), (rows[kept], columns[kept])), shape=(len(free), len(free)))
        order = reverse_cuthill_mckee(graph, symmetric_mode=True)
        rank = np.empty(len(free), dtype=np.int64)
        rank[order] = np.arange(len(free))
        rows, columns = rank[rows], rank[columns]
        kept = np.flatnonzero(kept & (rows >= columns))
        below = rows[kept] - columns[kept]
        PATTERNS[key] = (kept, below * len(free) + columns[kept], (int(below.max()) + 1, len(free)), order)
    kept, place, shape, order = PATTERNS[key]
    values = np.concatenate([block.ravel() for _, _, block in entries])[kept]
    return np.bincount(place, values, minlength=shape[0] * shape[1]).reshape(shape), order
