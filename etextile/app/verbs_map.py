"""The verb that renders the maps of an output folder again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from etextile import foreign_code
from etextile.app.options import Folder, Quiet, warn
from etextile.errors import BadInput


Field = Literal["failure", "warp_strain", "weft_strain", "diagonal_strain", "wire_strain"]
Camera = Literal["iso", "inner", "top", "side"]


def map_(
    folder: Folder,
    /,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"], show_default=False)] = None,
    field: Annotated[tuple[Field, ...], Parameter(negative="", show_default=False)] = (),
    camera: Camera = "iso",
    size: Annotated[tuple[int, int], Parameter(negative="", validator=Number(gte=200, lte=8000))] = (1600, 1100),
    step: int = -1,
    animation: Annotated[Path | None, Parameter(show_default=False)] = None,
    quiet: Quiet = False,
) -> int:
    """Render the maps of a run again.

    Parameters
    ----------
    output
        Folder for the pictures [default: DIR/maps].
    field
        What to draw; repeatable [default: the maps the case asks for].
    camera
        From where the deformed fabric is seen.
    size
        Width and height of deformed maps in pixels.
    step
        Output step, from 0; negative counts from the end.
    animation
        Draw all steps of the first field into this .gif file (or numbered .png files) instead.
    """
    from etextile.results.reader import open_results
    from etextile.studies.run.drawing import animate_map, draw_maps
    from etextile.studies.run.judged import judged
    from etextile.studies.run.outcome import is_withheld, unfit
    from loadcases.reader import stored_case
    from viz.maps import View

    results = open_results(folder)
    if results.steps == 0:
        raise BadInput.of("no increment converged, there is nothing to draw", file=str(results.path))
    if why := unfit(folder):
        warn(f"the maps are of {results.path}, and report.json is not to be relied on: {why}")
    if not results.completed:
        warn(f"the run did not end: step {results.steps - 1} is the last that there is")
    case = stored_case(results.case.effective, str(results.path))
    names = field or case.outputs.maps
    if not field and case.failure.file is not None and "failure" in names:
        warn(f"the map of states is left out: {case.failure.file} judged this run, and map runs no Python code")
        names = tuple(name for name in names if name != "failure")
    with foreign_code.never("map"):
        found = judged(results, needed="failure" in names)
    view = View(camera=camera, size=size)
    passed = is_withheld(folder)
    if animation is not None:
        drawn = animate_map(
            results,
            animation,
            names[0] if names else "warp_strain",
            damage=found.damage,
            title=found.case.title,
            view=view,
            provisional=passed,
        )
        missing = ""
    else:
        drawn, missing = draw_maps(
            results,
            output or folder / "maps",
            names,
            damage=found.damage,
            onset=found.onset,
            title=found.case.title,
            provisional=passed,
            step=step,
            view=view,
        )
    if not quiet:
        print("\n".join(str(path) for path in drawn))
    if missing:
        raise BadInput.of(f"deformed maps left out: {missing}")
    return 0
