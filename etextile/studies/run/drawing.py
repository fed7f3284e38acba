"""The maps of an output folder: which pictures there are and what they are drawn from."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.errors import BadInput
from etextile.results.reader import Results
from etextile.studies.run.worn import folded_cells, folded_loops
from etextile.types import Array, IntArray
from loadcases.reader import stored_case
from loadcases.schema import Case
from wires.axis import axis_of
from wires.damage import FailureResult


if TYPE_CHECKING:
    from etextile.contact.bending import Bending
    from viz.maps import View
    from viz.scene import Scene, SceneBody

DRAWN_EDGE_MM = 6.0
"""Sides of the triangles of a drawn limb: a page holds them at every step."""
ONTO_SKIN, DOWN_TO_SKIN, LONGEST_MM = 3, 9, 6.0
"""Steps that put the drawn limb onto its posed surface, further ones for what still stands out, how far one goes."""
SKIN_MM = 0.01
"""How far the drawn limb may stand out."""

FIELDS = ("warp_strain", "weft_strain", "diagonal_strain")


def draw_maps(
    results: Results,
    folder: Path,
    names: Sequence[str],
    *,
    damage: FailureResult | None,
    onset: float | None,
    title: str,
    provisional: bool = False,
    step: int = -1,
    view: View | None = None,
) -> tuple[tuple[Path, ...], str]:
    """Draw the named maps of one step into `folder`; return their paths and what could not be drawn, if anything.

    `provisional`: the verdict of the run is withheld, which the titles say.

    Flat maps need no OpenGL; without it the deformed ones are left out and the remedy is returned.
    """
    from viz import gl
    from viz.flat import flat_failure_map, wire_strain_map
    from viz.maps import View, failure_map, strain_map
    from viz.scene import coloured

    if not results.steps:
        return (), ""
    folder.mkdir(parents=True, exist_ok=True)
    trouble = ""
    deformed = gl.available()
    if not deformed:
        try:
            gl.require()
        except gl.NoGraphics as error:
            trouble = str(error)
    drawn: list[Path] = []
    usual = _scene(results, step, damage, field=FIELDS[0], title=title, provisional=provisional)
    for name in names:
        scene = coloured(usual, results, step=step, field=name) if name in FIELDS[1:] else usual
        if name == "failure":
            if deformed:
                drawn.append(failure_map(scene, folder / "failure.png", view=view))
                if scene.worn and view is None:
                    drawn.append(failure_map(scene, folder / "failure_inner.png", view=View(camera="inner")))
            drawn.append(flat_failure_map(scene, folder / "failure_flat.png"))
        elif name == "wire_strain":
            if results.wires is not None:
                drawn.append(wire_strain_map(scene, folder / "wire_strain.png", onset=onset))
        elif deformed:
            drawn.append(strain_map(scene, folder / f"{name}.png", view=view))
    return tuple(drawn), trouble


def draw_failure(
    results: Results,
    path: Path,
    *,
    damage: FailureResult | None,
    title: str,
    provisional: bool = False,
    step: int = -1,
    flat: bool = False,
) -> Path:
    """Draw the failure map of one step into a .png of any name and return its path; raises BadInput for another kind.

    Raises NoGraphics with the remedy where nothing deformed can be drawn.
    """
    from viz import gl
    from viz.flat import flat_failure_map
    from viz.maps import failure_map

    if path.suffix.lower() != ".png":
        raise BadInput.of(f"maps are .png files (got {path.name!r})", file=str(path))
    scene = _scene(results, step, damage, field=FIELDS[0], title=title, provisional=provisional)
    if not flat:
        gl.require()
    path.parent.mkdir(parents=True, exist_ok=True)
    return flat_failure_map(scene, path) if flat else failure_map(scene, path)


def _scene(
    results: Results, step: int, damage: FailureResult | None, *, field: str, title: str, provisional: bool = False
) -> Scene:
    """Return the whole specimen at a step, mirrored where a part was modelled."""
    from viz.mirror import whole
    from viz.scene import build_scene

    number = results.step_index(step)
    state = None if damage is None else damage.state[number + 1]
    case = stored_case(results.case.effective, str(results.path))
    wires = None if damage is None else damage.wire_states[number + 1]
    if not case.worn:
        flat = build_scene(
            results,
            step=number,
            loop_state=state,
            wire_state=wires,
            field=field,
            title=title,
            provisional=provisional,
        )
        return whole(flat)
    bends = results.displacement_mm[number] > 0.0
    scene = build_scene(
        results,
        step=number,
        loop_state=state,
        wire_state=wires,
        field=field,
        title=title,
        limb=limb_at(results, case, number),
        folded=folded_cells(results, number) if bends else None,
        folded_loops=folded_loops(results, until=number),
        closed=case.fabric.shape == "tube",
        provisional=provisional,
    )
    return whole(scene)


def live_scenes(
    results: Results, report: dict[str, Any], *, damage: FailureResult | None, onset: float | None, title: str
) -> str | None:
    """Return the scene of all steps for the page, None where nothing converged."""
    from viz.live import live_data

    fields = drawn_scenes(results, report, damage=damage, title=title)
    if not fields:
        return None
    along = _along(results, report)
    at = [float(along[step]) for step in drawn_steps(results, report)]
    return live_data(fields, report, onset=onset, at=at)


def drawn_scenes(
    results: Results, report: dict[str, Any], *, damage: FailureResult | None, title: str
) -> dict[str, list[Scene]]:
    """Return the scenes of the steps that a page draws, by the field that colours them; empty without steps."""
    if not results.steps:
        return {}
    return scenes_at(results, drawn_steps(results, report), damage=damage, title=title)


def drawn_steps(results: Results, report: dict[str, Any]) -> list[int]:
    """Return the steps that a page draws; those before and after the first break are among them."""
    from viz.live import chosen_steps

    cells = 0 if results.grid.quads is None else len(results.grid.quads)
    first = report["verdict"]["first_failure"]
    broken = _along(results, report) >= (np.inf if first is None else first[axis_of(report).key])
    after = int(np.argmax(broken)) if broken.any() else results.steps
    return chosen_steps(cells, results.steps, keep=(after - 1, after))


def _along(results: Results, report: dict[str, Any]) -> Array:
    """Return how far each step is along the axis of the report: where a load is raised, what it moves."""
    if "pressure" in report or "weight" in report:
        return np.array(axis_of(report).values(report), dtype=float)
    return results.displacement_mm


def scenes_at(
    results: Results, steps: Sequence[int], *, damage: FailureResult | None, title: str
) -> dict[str, list[Scene]]:
    """Return the scenes of steps by the field that colours them."""
    from viz.scene import coloured

    scenes = [_scene(results, step, damage, field=FIELDS[0], title=title) for step in steps]
    fields = {FIELDS[0]: scenes}
    for name in FIELDS[1:]:
        fields[name] = [
            coloured(scene, results, step=step, field=name) for step, scene in zip(steps, scenes, strict=True)
        ]
    return fields


def limb_at(results: Results, case: Case, step: int) -> SceneBody:
    """Return the limb of a worn case as it is at a step, to draw: the same triangles at every step.

    A skinned one bends as the result file says. Of another the straight surface goes with the skin and is then put onto
    the limb as it is posed; what the crook has swallowed stays inside.
    """
    from etextile.motion.flexion import Flexion
    from loadcases.build_worn import limb_of
    from viz.scene import SceneBody

    angle = float(results.displacement_mm[step])
    flexion, deflated = float(np.radians(max(angle, 0.0))), max(-angle, 0.0)
    body = results.body
    if body is not None and body.skin is not None:
        return SceneBody(body.skin.shrunk(flexion, deflated), body.faces)
    limb = limb_of(case)
    vertices, faces = _straight(limb)
    posed = limb.posed(flexion=flexion, deflated=deflated)
    places = Flexion(limb).carried(vertices, 0.0, max(angle, 0.0))
    for number in range(ONTO_SKIN + DOWN_TO_SKIN):
        found = posed.distance(places)
        if number >= ONTO_SKIN and found.gap.max() < SKIN_MM:
            break
        out = -LONGEST_MM if number < ONTO_SKIN else 0.0
        places = places - np.clip(found.gap, out, LONGEST_MM)[:, None] * found.normal
    return SceneBody(places, faces)


@lru_cache(maxsize=4)
def _straight(limb: Bending) -> tuple[Array, IntArray]:
    """Return the surface of a straight limb."""
    return limb.surface(edge=DRAWN_EDGE_MM)


def animate_map(
    results: Results,
    path: Path,
    name: str,
    *,
    damage: FailureResult | None,
    title: str,
    view: View,
    provisional: bool = False,
) -> tuple[Path, ...]:
    """Draw every step of a deformed map into a GIF or numbered PNGs; return the files written."""
    from viz import gl
    from viz.animate import animate

    gl.require()
    field = name if name in FIELDS else "warp_strain"
    scenes = [
        _scene(results, step, damage, field=field, title=title, provisional=provisional)
        for step in range(results.steps)
    ]
    return tuple(animate(scenes, path, view=view, loops=name == "failure"))
