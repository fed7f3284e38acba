r"""Clamps that give way along the pull: an elastic spring in series with friction, per width of the clamped edge.

The nodes of a clamped edge become free along the direction out of the specimen and hang on their places by

    t(u) = k (u - s),   |t| <= T(a),   T(a) = T0 + h a  (h >= 0),   T0 exp(h a / T0)  (h < 0)

with the line force t in N/mm, the motion u of the node into the specimen, the slip s and its path a. Within an
increment that is the derivative of the potential min over s of k (u - s)^2 / 2 + the friction work, so line search and
energy balance see it. The node takes the end of the free length along with it, as if the clamp line moved by u.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.effects.change import clamped_edges, line_width, outward
from etextile.errors import BadInput
from etextile.mechanics.kernels import add_node_blocks
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


RIGID = 1e4
"""Stiffness of a clamp that holds, N/mm per mm of width: 12 N/mm move it by about a micrometre."""


@dataclass(frozen=True)
class ClampLaw:
    """Stiffness in N/mm per mm, largest line force in N/mm (inf: holds), its growth with slip in N/mm per mm."""

    stiffness: float = RIGID
    limit: float = np.inf
    hardening: float = 0.0

    def friction(self, path: Array) -> tuple[Array, Array, Array]:
        """Return friction T (n,), its slope, and its integral at slip paths (n,) mm."""
        if self.hardening >= 0.0:
            force = self.limit + self.hardening * path
            return force, np.full_like(path, self.hardening), 0.5 * (self.limit + force) * path
        fading = np.exp(self.hardening * path / self.limit)
        work = self.limit**2 / self.hardening * (fading - 1.0)
        return self.limit * fading, self.hardening * fading, work

    def slide(self, trial: Array, path: Array) -> Array:
        """Return the slip (n,) mm at which friction balances the elastic trial line force (n,) >= 0, by Newton."""
        slip = np.zeros_like(trial)
        for _ in range(50):
            force, slope, _ = self.friction(path + slip)
            change = (trial - self.stiffness * slip - force) / (self.stiffness + slope)
            before, slip = slip, np.maximum(slip + change, 0.0)
            if np.all(np.abs(slip - before) <= 1e-14 + 1e-12 * slip):
                break
        return slip


@dataclass(frozen=True)
class ClampState:
    """Slip (n,) into the specimen and path (n,) it went, mm."""

    slip: Array
    path: Array


@dataclass(frozen=True)
class ClampBlock(Contribution):
    """Nodes (n, 1) of clamped edges: outward direction, place, motion per mm of travel (n, 3), width (n,) mm."""

    nodes: IntArray
    outward: Array
    place: Array
    carried: Array
    width: Array
    law: ClampLaw
    name: str = "clamp"

    def initial_state(self) -> ClampState:
        """Return no slip."""
        return ClampState(np.zeros(len(self.nodes)), np.zeros(len(self.nodes)))

    def motion(self, x: Array, travel: float) -> Array:
        """Return how far (n,) mm the nodes have come out of the clamps, at positions x (P, 3)."""
        away = x[self.nodes[:, 0]] - self.place - travel * self.carried
        return np.asarray(-np.einsum("nc,nc->n", away, self.outward))

    def respond(self, x: Array, travel: float, state: ClampState) -> ClampResponse:
        """Evaluate springs and friction at node positions x (P, 3)."""
        law = self.law
        motion = self.motion(x, travel)
        trial = law.stiffness * (motion - state.slip)
        slip = np.zeros_like(trial)
        slope = np.full_like(trial, law.stiffness)
        if np.isfinite(law.limit):
            slip = law.slide(np.abs(trial), state.path)
            grows = law.friction(state.path + slip)[1]
            slope = np.where(slip > 0.0, law.stiffness * grows / (law.stiffness + grows), law.stiffness)
        after = ClampState(state.slip + np.sign(trial) * slip, state.path + slip)
        return ClampResponse(self, motion, law.stiffness * (motion - after.slip), slope, after)


@dataclass(frozen=True)
class ClampResponse(Response):
    """Clamps at a trial: motion (n,) mm, line force (n,) N/mm and its slope, state to keep."""

    block: ClampBlock
    motion: Array
    line_force: Array
    slope: Array
    after: ClampState

    @property
    def state(self) -> ClampState:
        """Slip and its path to carry over."""
        return self.after

    @property
    def nodal(self) -> Array:
        """Derivative of the energy with respect to the nodes (n, 3), N."""
        return -(self.block.width * self.line_force)[:, None] * self.block.outward

    @property
    def driving_force(self) -> float:
        """Force that works on the travel of moved clamps, N."""
        return -float(np.vdot(self.nodal, self.block.carried))

    def energy(self) -> Energy:
        """Return the spring energy and the friction work, N mm."""
        block = self.block
        spring = 0.5 * float(block.width @ self.line_force**2) / block.law.stiffness
        lost = float(block.width @ block.law.friction(self.after.path)[2]) if np.isfinite(block.law.limit) else 0.0
        return Energy(stored=spring, friction=lost)

    def add_gradient(self, gradient: Array) -> None:
        """Add the forces of the clamps, as derivative of the energy, to gradient (P, 3)."""
        gradient[self.block.nodes[:, 0]] += self.nodal

    def add_support_force(self, force: Array) -> None:
        """Add the reactions of clamps that stand still."""
        still = ~self.block.carried.any(axis=1)
        force[self.block.nodes[still, 0]] -= self.nodal[still]

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangents; friction that fades with slip makes them negative."""
        slope = self.block.width * (self.slope if exact else np.maximum(self.slope, 0.0))
        out = self.block.outward
        add_node_blocks(self.block.nodes[:, 0], slope[:, None, None] * out[:, :, None] * out[:, None, :], rows, values)


def with_clamps(model: Model, effect: str, **changes: float) -> Model:
    """Return the model whose clamps give way; changes to the clamp law add to those of an earlier effect.

    `limit` and `hardening` are those of `ClampLaw`; `compliance` in mm per N/mm is put in series. BadInput without
    clamps.
    """
    block = next((part for part in model.contributions if isinstance(part, ClampBlock)), None)
    if block is None:
        return with_clamps(_released(model, effect), effect, **changes)
    compliance = 1.0 / block.law.stiffness + changes.pop("compliance", 0.0)
    law = replace(block.law, stiffness=1.0 / compliance, **changes)
    parts = tuple(replace(part, law=law) if isinstance(part, ClampBlock) else part for part in model.contributions)
    return replace(model, contributions=parts)


def _released(model: Model, effect: str) -> Model:
    """Return the model whose clamped edges hang on rigid springs along the pull."""
    edges = clamped_edges(model)
    if not edges:
        raise BadInput.of(f"{effect} needs clamped edges, the case has none", key="id")
    fixed, carried = model.fixed.copy(), model.carried
    nodes, out, width, moved = [], [], [], []
    for name, mask in edges.items():
        own, axis = np.flatnonzero(mask), "xy".index(name[0])
        held = fixed[own, axis]
        own = own[held]
        nodes.append(own)
        out.append(np.tile(outward(name), (len(own), 1)))
        width.append(line_width(model.lattice, name)[held])
        moved.append(carried[own] * np.abs(outward(name)))
        fixed[own, axis] = False
    numbers = np.concatenate(nodes)
    block = ClampBlock(
        nodes=numbers[:, None],
        outward=np.concatenate(out),
        place=model.points[numbers],
        carried=np.concatenate(moved),
        width=np.concatenate(width),
        law=ClampLaw(),
    )
    return replace(model, fixed=fixed).with_contribution(block)
