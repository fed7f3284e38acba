"""Wires that slide along their channel in the weave against a line friction: bond with slip, with history.

Every wire point keeps its material place in the fabric. One further unknown per point, s (mm), is the stress-free
length of wire that has passed it towards the wire's start, so an element from point a to point b holds
R = R_old + s_b - s_a and stores A_p R w(ln(l / R)): convex in node positions and s together. Its derivative over R is
the wire's tension (up to the elastic strain, 1e-3 for copper), so frictionless sliding makes the tension uniform
whatever the plastic strains. Friction is the incremental potential of elastic-plastic stick: the tension changes by
at most q per mm.

The loop shares s of its exit and entry with the woven-in neighbours, so that it can feed on them or they on it.

Approximations. Within an increment fed wire has the section and hardening of the element it enters; at its end virgin
and stress-free lengths are moved on (upwind), which keeps the volume and averages the plastic stretch of what an
element holds. Friction acts per mm of undeformed channel. Friction that grows with the weft's tension lags one
increment and follows the weft's loading curve, also in unloading. Increments matter little: halving those of 2.5 mm in
the punch test changes the strain of loops by up to 0.004.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.mechanics.protocol import Energy
from etextile.types import Array
from wires import slip_kernels as kernels
from wires.slip_pairs import SlidingPairs
from wires.slip_trial import LEAST_SHARE, SlidingElements, SlidingResponse, SlipState


@dataclass(frozen=True)
class SlidingWires(SlidingElements):
    """Wire elements that slide, as a contribution to the model."""

    def initial_state(self) -> SlipState:  # type: ignore[override]
        """Return the state as mounted: nothing fed, nothing strained."""
        none = np.zeros(len(self.points))
        rest = self.rest_length - self.rigid
        return SlipState(none, none, self.channel * self.line_friction, rest, rest)

    def respond(self, x: Array, travel: float, state: SlipState) -> SlidingResponse:  # type: ignore[override]
        """Evaluate elements and channel friction at positions x (P, 3)."""
        count, slips = len(self.nodes), len(self.points)
        unit = np.empty((count, 3))
        chord, length, free, chain, force, along, pull, plastic = (np.empty(count) for _ in range(8))
        fed = state.fed[self.ends]
        stored, dissipated = kernels.sliding_response(
            x, self.nodes, self.weights, self.rigid, self.offset, self.area, self.row, LEAST_SHARE * self.rest_length,
            fed[:, 1] - fed[:, 0], state.free, state.virgin,
            unit, chord, length, free, chain, force, along, pull, plastic,
        )  # fmt: skip
        traction, grip = np.empty(slips), np.empty(slips)
        spring, rubbed = kernels.channel_friction(
            x, self.points, state.anchor, state.limit, self.stick(state.limit), traction, grip
        )
        energy = Energy(stored + spring, state.plastic_work + dissipated, state.friction_work + rubbed)
        return SlidingResponse(
            self, unit, chord, force, along, plastic, state, x, length, free, chain, pull, traction, grip, energy
        )

    def one_sided(self, response: SlidingResponse, state: SlipState) -> SlidingPairs:  # type: ignore[override]
        """Return elements that slacken and points that slide, for the interior-point solver."""
        return SlidingPairs(response)
