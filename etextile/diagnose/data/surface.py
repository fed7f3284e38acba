"""What a run of any lattice shows of its surface: height and motion of material points over pressure or travel.

Unlike the records of the punch diagnosis these need no rectangular lattice. Between nodes the motion is linear on the
Delaunay triangles of the flat nodes, between steps it is interpolated by monotone cubics; beyond a held rim it is zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from etextile.diagnose.data.inflated import DisplacementField, PressureHeight
from etextile.mechanics.model import Model
from etextile.types import Array


if TYPE_CHECKING:
    from scipy.spatial import Delaunay

ORIGIN = (0.0, 0.0)


@dataclass(frozen=True)
class Surface:
    """One run, the flat start included as first step.

    load (S,): travel in its unit; force (S,) N; flat (N, 2) mm; motion (S, N, 3) mm; symmetry (2,); angle (rad) of the
    warp to x; completed: False where no equilibrium was found beyond the last step. Of a worn piece the first step is
    the straight limb, and slip (S, N) mm is how far nodes have slipped along the skin since.
    """

    load: Array
    force: Array
    flat: Array
    motion: Array
    symmetry: tuple[bool, bool]
    angle: float = 0.0
    completed: bool = True
    slip: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @classmethod
    def of(cls, model: Model, steps: Sequence[tuple[float, float, Array]], *, completed: bool = True) -> Surface:
        """Return the surface of a model from (travel, force, positions) of its output steps."""
        lattice = model.lattice
        count = len(lattice.points)
        motion = [np.zeros((count, 3)), *(positions[:count] - lattice.points for _, _, positions in steps)]
        return cls(
            np.array([0.0, *(travel for travel, _, _ in steps)]),
            np.array([0.0, *(force for _, force, _ in steps)]),
            lattice.points[:, :2],
            np.array(motion),
            lattice.symmetry,
            float(np.radians(lattice.warp_angle)),
            completed,
        )

    @cached_property
    def triangles(self) -> Delaunay:
        """The triangles of the flat nodes."""
        from scipy.spatial import Delaunay

        return Delaunay(self.flat)

    @cached_property
    def height(self) -> Array:
        """Height (S,) of the highest node, mm."""
        return np.asarray(self.motion[:, :, 2].max(axis=1))

    def at_load(self, values: Array, load: Array) -> Array:
        """Return values (S, ...) at loads (n,), NaN beyond the last step."""
        from scipy.interpolate import PchipInterpolator

        found = np.asarray(PchipInterpolator(self.load, values, axis=0)(np.clip(load, 0.0, self.load[-1])))
        found[load > self.load[-1] * (1.0 + 1e-9)] = np.nan
        return found

    def at_places(self, places: Array) -> Array:
        """Return the motion (S, n, 3) along warp, weft and up at material places (n, 2) along warp and weft, mm."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[c, s], [-s, c]])  # rows: warp and weft in x and y
        x = places @ turn
        sign = np.where(self.symmetry, np.where(x < 0.0, -1.0, 1.0), 1.0)
        nodes, weights = self._in_triangles(x * sign)
        found = np.einsum("nk,snkc->snc", weights, self.motion[:, nodes])
        found[..., :2] *= sign
        found[..., :2] = found[..., :2] @ turn.T
        return np.asarray(found)

    def motion_of(self, places: Array, load: Array) -> Array:
        """Return the motion (n, 3) of material places (n, 2) at loads (n,), NaN beyond the last step."""
        distinct, number = np.unique(places, axis=0, return_inverse=True)
        loads, when = np.unique(load, return_inverse=True)
        table = self.at_load(self.at_places(distinct), loads)
        return np.asarray(table[when.reshape(-1), number.reshape(-1)])

    def slips(self, places: Array, load: Array) -> Array:
        """Return how far material places (n, 2) have slipped along the skin at loads (n,), NaN beyond the last step."""
        mirrored = np.where(self.symmetry, np.abs(places), places)
        distinct, number = np.unique(mirrored, axis=0, return_inverse=True)
        nodes, weights = self._in_triangles(np.clip(distinct, self.flat.min(axis=0), self.flat.max(axis=0)))
        loads, when = np.unique(load, return_inverse=True)
        table = self.at_load(np.einsum("nk,snk->sn", weights, self.slip[:, nodes]), loads)
        return np.asarray(table[when.reshape(-1), number.reshape(-1)])

    def _in_triangles(self, x: Array) -> tuple[Array, Array]:
        """Return the corners (n, 3) around places (n, 2) and their weights; beside the piece those are zero."""
        inside = self.triangles.find_simplex(x)
        transform = self.triangles.transform[inside]
        first = np.einsum("nij,nj->ni", transform[:, :2], x - transform[:, 2])
        weights = np.concatenate([first, 1.0 - first.sum(axis=1, keepdims=True)], axis=1)
        return self.triangles.simplices[inside], np.where((inside >= 0)[:, None], weights, 0.0)


def pulls(surface: Surface, displacement: Array, preload: float) -> Array:
    """Return the predicted forces (n,) N at displacements (n,) mm that count from where the force is the preload, N."""
    start = float(np.interp(preload, np.maximum.accumulate(surface.force), surface.load))
    return surface.at_load(surface.force, displacement + start)


def heights(surface: Surface, curve: PressureHeight) -> Array:
    """Return the predicted heights (n,) of a curve, mm."""
    return surface.at_load(surface.height, curve.pressure)


def motions(surface: Surface, field: DisplacementField, *, centre: tuple[float, float] = ORIGIN) -> Array:
    """Return the predicted displacements (n, 3) of a field whose coordinates have the piece's centre at `centre`."""
    return surface.motion_of(field.places - np.array(centre), field.load)
