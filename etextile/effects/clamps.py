r"""Clamps that give way: fabric is fed past a jaw edge, and the jaws may move with their mount.

Every clamped node of the fabric is set free and hangs on a point of the jaw edge by what the jaws let out. That length
r = |x_fabric - x_jaw| runs from the edge along the fabric, whatever way the fabric leaves the clamp; so what is limited
is the tension T of the fabric, not its part along the clamp, and all that is tied to the node (warp, weft, diagonals)
is fed with it. With T in N per mm of edge and the length s that has slipped out,

    T(r) = k max(r - s, 0),   T <= T0 + h s  (h >= 0),   T0 exp(h s / T0)  (h < 0),       1 / k = lining + 1 / RIGID

s only grows and a slack length does not push. Within an increment that is the derivative of the potential
min over s of k (r - s)^2 / 2 + the friction work, so line search, tangent and energy balance see it. What has been let
out is counted as it lies there, stretched: r = lambda u with the stretch lambda of the fabric at the edge and the feed
u in unstretched fabric; the work T dr is friction in the jaws and the (lasting) stretch of what is fed.

The jaw edge stands still, or moves on a spring along the pull (`mount`): then what counts is T cos(alpha).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.effects.change import clamped_edges, line_width, outward
from etextile.effects.yarn_sliding import Crossings
from etextile.errors import BadInput
from etextile.mechanics.kernels import add_dense_blocks
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, BoolArray, IntArray


RIGID = 1e4
"""Stiffness of jaws that hold, N/mm per mm of width: 12 N/mm let out about a micrometre."""


@dataclass(frozen=True)
class ClampLaw:
    """Give of lining and mount in mm per N/mm, largest tension in N/mm (inf: holds), its growth in N/mm per mm."""

    lining: float = 0.0
    mount: float = 0.0
    limit: float = np.inf
    hardening: float = 0.0

    @property
    def stiffness(self) -> float:
        """Stiffness of the grip, N/mm per mm."""
        return 1.0 / (self.lining + 1.0 / RIGID)

    def friction(self, slip: Array) -> tuple[Array, Array, Array]:
        """Return friction T (n,), its slope, and its integral at slips (n,) mm."""
        if self.hardening >= 0.0:
            force = self.limit + self.hardening * slip
            return force, np.full_like(slip, self.hardening), 0.5 * (self.limit + force) * slip
        fading = np.exp(self.hardening * slip / self.limit)
        work = self.limit**2 / self.hardening * (fading - 1.0)
        return self.limit * fading, self.hardening * fading, work

    def slide(self, trial: Array, slip: Array) -> Array:
        """Return the growth (n,) mm of slips (n,) at which friction balances the elastic trial tension (n,)."""
        more = np.zeros_like(trial)
        for _ in range(50):
            force, slope, _ = self.friction(slip + more)
            change = (trial - self.stiffness * more - force) / (self.stiffness + slope)
            before, more = more, np.maximum(more + change, 0.0)
            if np.all(np.abs(more - before) <= 1e-14 + 1e-12 * more):
                break
        return more


@dataclass(frozen=True)
class ClampState:
    """Length (n,) mm that has slipped out of the jaws."""

    slip: Array


@dataclass(frozen=True)
class ClampBlock(Contribution):
    """Nodes (n, 2) of the fabric and of the jaw edge; pull (n, 3) into the jaws, place of the edge and its motion per
    mm of travel (n, 3), width (n,) mm.
    """

    nodes: IntArray
    pull: Array
    place: Array
    carried: Array
    width: Array
    law: ClampLaw
    name: str = "clamp"

    def initial_state(self) -> ClampState:
        """Return no slip."""
        return ClampState(np.zeros(len(self.nodes)))

    def respond(self, x: Array, travel: float, state: ClampState) -> ClampResponse:
        """Evaluate grip, friction and mount at positions x (P, 3)."""
        law = self.law
        apart = x[self.nodes[:, 0]] - x[self.nodes[:, 1]]
        let_out = np.linalg.norm(apart, axis=1)
        trial = law.stiffness * np.maximum(let_out - state.slip, 0.0)
        more, slope = np.zeros_like(trial), np.where(let_out >= state.slip, law.stiffness, 0.0)
        if np.isfinite(law.limit):
            more = law.slide(trial, state.slip)
            grows = law.friction(state.slip + more)[1]
            slope = np.where(more > 0.0, law.stiffness * grows / (law.stiffness + grows), slope)
        moved = x[self.nodes[:, 1]] - self.place - travel * self.carried
        sunk = -np.einsum("nc,nc->n", moved, self.pull)
        tension = trial - law.stiffness * more
        return ClampResponse(self, apart, let_out, tension, slope, sunk, ClampState(state.slip + more))

    @property
    def mount(self) -> float:
        """Stiffness of the mount along the pull, N/mm per mm; 0 where the edge is held by the supports."""
        return 1.0 / self.law.mount if self.law.mount > 0.0 else 0.0


@dataclass(frozen=True)
class ClampResponse(Response):
    """Clamps at a trial: fabric from edge (n, 3) and its length (n,) mm, tension (n,) N/mm and its slope, motion of the
    edge into the specimen (n,) mm, state to keep.
    """

    block: ClampBlock
    apart: Array
    let_out: Array
    tension: Array
    slope: Array
    sunk: Array
    after: ClampState

    @property
    def state(self) -> ClampState:
        """Slip to carry over."""
        return self.after

    @property
    def secant(self) -> Array:
        """Tension over length (n,), N/mm per mm; the stiffness of the grip where nothing is let out yet."""
        some = self.let_out > 0.0
        grip = np.where(self.after.slip > 0.0, 0.0, self.block.law.stiffness)
        return np.where(some, self.tension / np.where(some, self.let_out, 1.0), grip)

    @property
    def on_fabric(self) -> Array:
        """Derivative of the energy with respect to the fabric's nodes (n, 3), N."""
        return (self.block.width * self.secant)[:, None] * self.apart

    @property
    def on_mount(self) -> Array:
        """Derivative of the mount's energy with respect to the jaw edge (n, 3), N."""
        return -(self.block.width * self.block.mount * self.sunk)[:, None] * self.block.pull

    @property
    def driving_force(self) -> float:
        """Force that works on the travel of moved mounts, N (edges on supports are driven by those)."""
        return -float(np.vdot(self.on_mount, self.block.carried))

    @property
    def giving_way(self) -> str:
        """Clamps whose hold fades, in words."""
        fades = bool(np.any((self.slope < 0.0) & (self.tension > 0.0)))
        return "clamps let go, their hold fading with slip (clamp_slip: hardening below 0)" if fades else ""

    def energy(self) -> Energy:
        """Return the elastic energy of grip and mount and the work of what was let out, N mm."""
        block = self.block
        elastic = block.width @ (self.tension**2 / block.law.stiffness + block.mount * self.sunk**2)
        lost = float(block.width @ block.law.friction(self.after.slip)[2]) if np.isfinite(block.law.limit) else 0.0
        return Energy(stored=0.5 * float(elastic), friction=lost)

    def add_gradient(self, gradient: Array) -> None:
        """Add the forces of the clamps, as derivative of the energy, to gradient (P, 3)."""
        fabric, jaw = self.block.nodes.T
        np.add.at(gradient, fabric, self.on_fabric)
        np.add.at(gradient, jaw, self.on_mount - self.on_fabric)

    def add_support_force(self, force: Array) -> None:
        """Add the forces of mounts that stand still."""
        still = ~self.block.carried.any(axis=1)
        np.add.at(force, self.block.nodes[still, 1], -self.on_mount[still])

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangents; friction that fades with slip makes them negative."""
        block = self.block
        along = np.where(self.let_out > 0.0, self.slope if exact else np.maximum(self.slope, 0.0), self.secant)
        way = self.apart / np.where(self.let_out > 0.0, self.let_out, 1.0)[:, None]
        own = self.secant[:, None, None] * np.eye(3)
        own = block.width[:, None, None] * (
            own + (along - self.secant)[:, None, None] * way[:, :, None] * way[:, None, :]
        )
        both = np.concatenate([np.concatenate([own, -own], axis=2), np.concatenate([-own, own], axis=2)], axis=1)
        both[:, 3:, 3:] += (block.width * block.mount)[:, None, None] * block.pull[:, :, None] * block.pull[:, None, :]
        add_dense_blocks(block.nodes, both, rows, pairs, values)


def with_clamps(model: Model, effect: str, *, lining: float = 0.0, mount: float = 0.0, **slip: float) -> Model:
    """Return the model whose clamps give way; what is given adds to an earlier effect on the clamps.

    `lining` and `mount` (mm per N/mm) are put in series with what is there; `slip`: limit and hardening of `ClampLaw`.
    BadInput without clamps.
    """
    block = next((part for part in model.contributions if isinstance(part, ClampBlock)), None)
    if block is None:
        return with_clamps(_released(model, effect), effect, lining=lining, mount=mount, **slip)
    law = replace(block.law, lining=block.law.lining + lining, mount=block.law.mount + mount, **slip)
    parts = tuple(replace(part, law=law) if isinstance(part, ClampBlock) else part for part in model.contributions)
    fixed = model.fixed.copy()
    jaw = block.nodes[:, 1]
    fixed[jaw] = (block.pull == 0.0) | (law.mount == 0.0)
    return replace(model, contributions=parts, fixed=fixed)


def _released(model: Model, effect: str) -> Model:
    """Return the model whose clamped nodes hang on points of their jaw edges, which stand where the nodes stood."""
    edges = clamped_edges(model)
    if not edges:
        raise BadInput.of(f"{effect} needs clamped edges, the case has none", key="id")
    held = {name: np.flatnonzero(mask) for name, mask in edges.items()}
    away = {name: outward(name) for name in held}
    inside = {name: model.fixed[own, "xy".index(name[0])] for name, own in held.items()}
    fabric = np.concatenate([own[inside[name]] for name, own in held.items()])
    pull = np.concatenate([np.tile(away[name], (inside[name].sum(), 1)) for name in held])
    jaw = len(model.points) + np.arange(len(fabric))
    carried = model.carried[fabric]
    block = ClampBlock(
        nodes=np.stack([fabric, jaw], axis=1),
        pull=pull,
        place=model.points[fabric],
        carried=carried,
        width=np.concatenate([line_width(model.lattice, name)[inside[name]] for name in held]),
        law=ClampLaw(),
    )
    fixed, moved = model.fixed.copy(), model.carried.copy()
    free = np.concatenate([fabric, *_partners(model, fabric)])
    fixed[free], moved[free] = on_symmetry(model, free), 0.0
    return replace(
        model,
        points=np.concatenate([model.points, block.place]),
        fixed=np.concatenate([fixed, np.ones_like(block.place, dtype=np.bool_)]),
        carried=np.concatenate([moved, carried]),
    ).with_contribution(block)


def _partners(model: Model, fabric: IntArray) -> list[IntArray]:
    """Return the nodes of weft yarns that cross at clamped nodes, where warp and weft have nodes of their own."""
    parts = [part for part in model.contributions if isinstance(part, Crossings)]
    return [part.nodes[np.isin(part.nodes[:, 0], fabric), 1] for part in parts]


def on_symmetry(model: Model, nodes: IntArray) -> BoolArray:
    """Return the components (n, 3) in which nodes of the fabric lie on a symmetry plane."""
    found = np.zeros((len(nodes), 3), dtype=np.bool_)
    for axis, cut in enumerate(model.lattice.symmetry):
        if cut:
            found[:, axis] = model.points[nodes, axis] == 0.0
    return found
