"""A flat piece of fabric as a continuous sheet, by finite elements: another way to a coupon cut at an angle.

Four families of fibres (warp, weft, both diagonals) carry N(lambda) = A0 sigma exp(-p) along F m, with E (eps - p) =
s(p) from a table; a compressed family carries a share of the mirrored curve. Linear triangles, squares with both
diagonals, so that at 45 degrees no fibre crosses an element askew. Nothing of the package takes part.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve
from solver import AREA, CELL, MID, Law


CW, CF = CELL
SLANTED = float(np.hypot(CW, CF))
PER_WIDTH = (AREA / CF, AREA / CW, AREA * SLANTED / (CW * CF), AREA * SLANTED / (CW * CF))
"""Cross-section of each family per width of the sheet, mm."""


def fibres(angle: float) -> np.ndarray:
    """Directions (4, 2) of warp, weft and diagonals; `angle` of the warp to the pull in degrees."""
    turn = np.radians(angle)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    flat = np.array([[1.0, 0.0], [0.0, 1.0], [CW / SLANTED, CF / SLANTED], [CW / SLANTED, -CF / SLANTED]])
    return flat @ rotation.T


def carried(law: Law, stretch: np.ndarray, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Force per A0 (n,) and its slope by the stretch; negative strain carries `share` of the mirrored curve."""
    eps = np.log(stretch)
    p = np.interp(np.abs(eps), law.total, law.p)
    s = np.interp(p, law.p, law.undamaged)
    hard = np.interp(p, law.p, law.slope)
    t = law.E * hard / (law.E + hard)
    flow = law.E / (law.E + hard)
    pulled = eps > 0
    force = np.where(pulled, s * np.exp(-p), -share * s)
    slope = np.where(pulled, (t - s * flow) * np.exp(-p), share * t) / stretch
    return force, slope


class Sheet:
    """Rectangle of nx x ny squares of four triangles, clamped at both ends of its length."""

    def __init__(self, size: tuple[float, float], nx: int, ny: int, *, angle: float, shares: tuple[float, ...]):
        x, y = np.linspace(0, size[0], nx + 1), np.linspace(0, size[1], ny + 1)
        corner = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
        number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
        a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
        middle = len(corner) + np.arange(len(a))
        self.points = np.concatenate([corner, 0.25 * (corner[a] + corner[b] + corner[c] + corner[d])])
        sides = ((a, b), (b, c), (c, d), (d, a))
        self.nodes = np.concatenate([np.stack([p, q, middle], 1) for p, q in sides])
        at = self.points[self.nodes]
        edges = np.stack([at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]], axis=2)
        self.area = 0.5 * np.abs(np.linalg.det(edges))
        own = np.linalg.inv(edges)
        self.slopes = np.concatenate([-own.sum(axis=1, keepdims=True), own], axis=1)
        self.directions, self.shares = fibres(angle), shares
        self.ends = self.points[:, 0] == 0, self.points[:, 0] == size[0]
        self.laws = [Law(*numbers) for numbers in (*MID, MID[2])]
        # weight of a node's place in F m: (triangles, 3 nodes) for each family
        self.weights = [self.slopes @ m for m in self.directions]

    def forces(self, x: np.ndarray) -> tuple[np.ndarray, sparse.csc_matrix]:
        """Gradient (N, 2) of the energy and its tangent with negative parts left out."""
        gradient = np.zeros_like(x)
        rows, columns, values = [], [], []
        for k, weight in enumerate(self.weights):
            way = np.einsum("tn,tnc->tc", weight, x[self.nodes])
            stretch = np.linalg.norm(way, axis=1)
            unit = way / stretch[:, None]
            force, slope = carried(self.laws[k], stretch, self.shares[k])
            volume = self.area * PER_WIDTH[k]
            pull = (volume * force)[:, None, None] * weight[:, :, None] * unit[:, None, :]
            np.add.at(gradient, self.nodes, pull)
            along, across = np.maximum(slope, 0.0), np.maximum(force / stretch, 0.0)
            block = across[:, None, None] * np.eye(2) + (along - across)[:, None, None] * (
                unit[:, :, None] * unit[:, None, :]
            )
            block = volume[:, None, None] * block
            for i in range(3):
                for j in range(3):
                    part = (weight[:, i] * weight[:, j])[:, None, None] * block
                    for c in range(2):
                        for d in range(2):
                            rows.append(2 * self.nodes[:, i] + c)
                            columns.append(2 * self.nodes[:, j] + d)
                            values.append(part[:, c, d])
        size = 2 * len(x)
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return gradient, sparse.csc_matrix(entries, shape=(size, size))

    def pulled(self, travels: np.ndarray) -> np.ndarray:
        """Force (S,) in N at the clamp that is pulled by `travels` (S,) mm."""
        x, found = self.points.copy(), []
        fixed = np.repeat(self.ends[0] | self.ends[1], 2)
        free = np.flatnonzero(~fixed)
        done = 0.0
        for travel in travels:
            length = self.points[:, 0].max()
            x[:, 0] += (travel - done) * self.points[:, 0] / length
            done = travel
            x = self.balanced(x, free)
            gradient, _ = self.forces(x)
            found.append(float(gradient[self.ends[1], 0].sum()))
        return np.array(found)

    def balanced(self, x: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Newton whose step is halved until the residual along it falls; raises RuntimeError without balance."""
        damping = 1e-3
        for _ in range(300):
            gradient, tangent = self.forces(x)
            residual = gradient.ravel()[free]
            if np.abs(residual).max() < 1e-6 * (np.abs(gradient).max() + 1e-3):
                return x
            inner = tangent[free][:, free] + damping * sparse.identity(len(free))
            step = np.zeros(x.size)
            step[free] = -spsolve(inner, residual)
            step = step.reshape(x.shape) * min(1.0, 1.0 / max(np.abs(step).max(), 1e-12))
            start, length = float(np.vdot(gradient.ravel()[free], step.ravel()[free])), 1.0
            for _ in range(12):
                slope = float(np.vdot(self.forces(x + length * step)[0].ravel()[free], step.ravel()[free]))
                if slope < 0.5 * abs(start):
                    break
                length *= 0.5
            x = x + length * step
        raise RuntimeError("the sheet found no balance")
