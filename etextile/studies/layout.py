"""The wires and parts of a case as a drawing: of the whole specimen, whatever part of it the case models."""

from __future__ import annotations

from pathlib import Path

from etextile.errors import BadInput
from etextile.results.wire_layout import ALONG_WARP
from etextile.studies.cases import AnyCase, loaded_case
from loadcases.build_paths import drawing_of
from loadcases.build_wires import wire_layout
from loadcases.fabric import load_fabric
from loadcases.schema import Case
from wires.drawing import Drawing
from wires.drawing_files import write_drawing
from wires.drawn import LoopSpec, PathSpec
from wires.layout import WireLayout


def layout(case: AnyCase, path: str | Path, *, force: bool = False) -> Drawing:
    """Write the wires, loops and parts of a case as a drawing (.dxf or .csv) and return what was written.

    A case that names the file as `wires.layout`, with the fabric and the nets of the first, is the same model. Raises
    BadInput for a case without wires, for a file that is there already unless `force`, and for what the format cannot
    hold.
    """
    path = Path(path)
    found = read_layout(case)
    if path.exists() and not force:
        raise BadInput.of("is there already; choose another file or give --force", file=str(path))
    if not path.parent.is_dir():
        raise BadInput.of("there is no such folder to write into", file=str(path.parent))
    write_drawing(found, path)
    return found


def read_layout(case: AnyCase) -> Drawing:
    """Return the wires, loops and parts of a case; raises BadInput for a case without wires and for what is wrong."""
    loaded = loaded_case(case)
    with loaded.locating():
        wires = loaded.case.wires
        if wires is None:
            raise BadInput.of("the case has no wires to draw", key="wires")
        return drawing_of(loaded.case) if wires.drawn else _of_comb(loaded.case)


def _of_comb(case: Case) -> Drawing:
    """Return the comb of the whole specimen, wire by wire."""
    whole = case.model_copy(update={"fabric": case.fabric.model_copy(update={"portion": "whole"})})
    comb = wire_layout(whole, load_fabric(case.fabric.set))
    return Drawing(()) if comb is None else Drawing(tuple(_spec(comb, wire) for wire in range(comb.n_wires)))


def _spec(comb: WireLayout, wire: int) -> PathSpec:
    at = float(comb.weft_mm[wire])
    ends = tuple((float(place), at) for place in (comb.start_mm[wire], comb.end_mm[wire]))
    loops = tuple(
        LoopSpec(
            float(comb.loop_warp_mm[loop]),
            float(comb.loop_span_mm[loop]),
            float(comb.loop_slack[loop]),
            float(comb.loop_rigid_mm[loop]),
        )
        for loop in range(comb.n_loops)
        if comb.loop_wire[loop] == wire
    )
    return PathSpec(comb.names[wire], ALONG_WARP, ends, loops)
