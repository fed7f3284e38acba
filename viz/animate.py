"""A run as a moving picture: the deformed map of every step, seen from one place and with one colour scale."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.errors import BadInput
from etextile.files import replacing
from viz.legend import finish
from viz.maps import View, deformed_figure, seen
from viz.scene import Scene


if TYPE_CHECKING:
    from PIL.Image import Image

SIZE = (1120, 770)
_LAST_FRAME = 8
"""The last picture stays this many times longer."""


def animate(
    scenes: Sequence[Scene], path: Path, *, view: View | None = None, loops: bool = True, frame_s: float = 0.2
) -> list[Path]:
    """Draw scenes as a GIF, or as numbered PNGs when the path ends in `.png`; return the files written.

    Another ending raises BadInput, a missing OpenGL library NoGraphics.
    """
    path = Path(path)
    if path.suffix not in (".gif", ".png"):
        raise BadInput.of(
            f"an animation is a .gif or numbered .png files (got {path.suffix or 'no ending'!r})", key="animation"
        )
    if not scenes:
        raise BadInput.of("there are no steps to animate", key="animation")
    common = _common(scenes, view or View(size=SIZE))
    if path.suffix == ".png":
        width = len(str(len(scenes) - 1))
        places = [path.with_name(f"{path.stem}_{number:0{width}d}.png") for number in range(len(scenes))]
        pairs = zip(scenes, places, strict=True)
        return [finish(deformed_figure(scene, common, loops=loops), place) for scene, place in pairs]
    frames = [_frame(scene, common, loops=loops) for scene in scenes]
    path.parent.mkdir(parents=True, exist_ok=True)
    duration = round(1000 * frame_s)
    durations = [*[duration] * (len(frames) - 1), _LAST_FRAME * duration]
    with replacing(path) as part:
        frames[0].save(part, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=False)
    return [path]


def _common(scenes: Sequence[Scene], view: View) -> View:
    """Return the view with one colour scale and one field of sight for all scenes."""
    limit = max(float(scene.colouring.cells.max(initial=0.0)) for scene in scenes)
    in_sight = np.concatenate([seen(scene) for scene in scenes])
    return replace(view, limit=view.limit or limit, in_sight=in_sight if view.in_sight is None else view.in_sight)


def _frame(scene: Scene, view: View, *, loops: bool) -> Image:
    """Return the map of a scene as a picture with 256 colours."""
    from PIL import Image

    memory = io.BytesIO()
    deformed_figure(scene, view, loops=loops).savefig(memory, format="png")
    return Image.open(memory).convert("RGB").quantize(256, dither=Image.Dither.NONE)
