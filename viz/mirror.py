"""The whole specimen of a quarter or half model: a scene and its mirror images."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.types import Array
from viz.scene import Scene, SceneLoops


_ON_PLANE_MM = 1e-6
"""Points and loops as near to a symmetry plane lie in it."""


def whole(scene: Scene) -> Scene:
    """Return the whole specimen: the scene and its mirror images in the symmetry planes it has."""
    for axis in (0, 1):
        if scene.symmetry[axis]:
            scene = _mirror(scene, axis)
    return scene


def _mirror(scene: Scene, axis: int) -> Scene:
    """Add the mirror image in the plane where coordinate `axis` is zero; points on it are shared."""
    shared = np.abs(scene.flat[:, axis]) < _ON_PLANE_MM
    n_points = len(scene.flat)
    image = np.where(shared, np.arange(n_points), n_points + np.cumsum(~shared) - 1)
    sign = np.ones(3)
    sign[axis] = -1.0
    wires, loops = scene.wires, scene.loops
    double = ~np.all(shared[wires.segments], axis=1)
    return replace(
        scene,
        flat=np.concatenate([scene.flat, scene.flat[~shared] * sign]),
        points=np.concatenate([scene.points, scene.points[~shared] * sign]),
        touched=np.concatenate([scene.touched, scene.touched[~shared]]),
        clamped=np.concatenate([scene.clamped, scene.clamped[~shared]]),
        quads=np.concatenate([scene.quads, image[scene.quads][:, ::-1]]),
        colouring=replace(scene.colouring, cells=np.tile(scene.colouring.cells, 2)),
        wires=replace(
            wires,
            segments=np.concatenate([wires.segments, image[wires.segments[double]]]),
            wire=np.concatenate([wires.wire, wires.wire[double]]),
            strain=np.concatenate([wires.strain, wires.strain[double]]),
        ),
        loops=_mirror_loops(loops, axis, sign),
        folded=np.tile(scene.folded, 2),
        symmetry=(scene.symmetry[0] and axis != 0, scene.symmetry[1] and axis != 1),
    )


def _mirror_loops(loops: SceneLoops, axis: int, sign: Array) -> SceneLoops:
    """Add the mirror images of the loops that do not lie on the plane themselves."""
    double = np.abs(loops.flat[:, axis]) > _ON_PLANE_MM

    def twice(values: Array) -> Array:
        return np.concatenate([values, values[double]])

    return SceneLoops(
        wire=np.concatenate([loops.wire, loops.wire[double]]),
        index=np.concatenate([loops.index, loops.index[double]]),
        state=np.concatenate([loops.state, loops.state[double]]),
        span_strain=twice(loops.span_strain),
        wire_strain=twice(loops.wire_strain),
        flat=np.concatenate([loops.flat, loops.flat[double] * sign[:2]]),
        half_span=np.concatenate([loops.half_span, loops.half_span[double] * sign[:2]]),
        deformed=np.concatenate([loops.deformed, loops.deformed[double] * sign]),
        folded=np.concatenate([loops.folded, loops.folded[double]]) if len(loops.folded) else loops.folded,
    )
