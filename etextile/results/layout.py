"""What a result file holds: one table of names, units and descriptions, and the version of the format.

Every array the store writes and the reader returns is listed here, so that unit and description travel with it and
nothing enters the file that a later reader cannot explain. A file is HDF5 in the VTKHDF format (UnstructuredGrid of
line cells with time steps, `/VTKHDF`) with a group `/etextile` beside it for everything ParaView has no word for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from etextile.contact.skinning import SkinnedMesh
from etextile.errors import EtextileError, nearest


FORMAT = "etextile results"
VERSION = (1, 1)
"""Format version: readers refuse another major number; the minor number grows when arrays are added."""

VTKHDF_VERSION = (2, 0)
VTK_LINE = 3
FILE_NAME = "results.vtkhdf"

TEXT_BYTES = 1024
NAME_BYTES = 128


@dataclass(frozen=True)
class StoredQuantity:
    """One stored array: name, unit, meaning, number type and the shape of one entry after the counting axis."""

    name: str
    unit: str
    description: str
    dtype: str = "float64"
    shape: tuple[int, ...] = ()


POINT_ARRAYS = (
    StoredQuantity("displacement", "mm", "displacement from the flat, undeformed piece", "float32", (3,)),
    StoredQuantity(
        "contact_force",
        "N",
        "force of the body on the fabric, on the modelled portion",
        "float32",
        (3,),
    ),
)
CELL_ARRAYS = (
    StoredQuantity("strain", "1", "engineering strain of the truss", "float32"),
    StoredQuantity("stress", "MPa", "true (Cauchy) stress of the truss, zero when slack", "float32"),
    StoredQuantity("plastic_strain", "1", "plastic Hencky strain of the truss", "float32"),
    StoredQuantity("force", "N", "axial force of the truss, zero when slack", "float32"),
)
CELL_LABELS = (
    StoredQuantity("family", "", "0 warp, 1 weft, 2 diagonal, 3 wire", "int8"),
    StoredQuantity("wire", "", "number of the conductive wire, -1 for lattice trusses", "int32"),
)
LATTICE = (
    StoredQuantity("reference", "mm", "points of the flat, undeformed piece", shape=(3,)),
    StoredQuantity("cells", "", "end points of every truss", "int64", (2,)),
    StoredQuantity("clamped", "", "1 where a lattice point is held by a clamp", "int8"),
    StoredQuantity(
        "quads", "", "lattice cells as four points in turn, for drawing the fabric as a surface", "int64", (4,)
    ),
    StoredQuantity(
        "symmetry", "", "1 where the plane x = 0, y = 0 is a symmetry plane of the modelled portion", "int8"
    ),
    StoredQuantity("warp_angle", "deg", "angle of the warp to the x axis"),
)
BODY = (
    StoredQuantity("vertices", "mm", "surface points of the pressed-in body at punch displacement zero", shape=(3,)),
    StoredQuantity("faces", "", "surface triangles of the body", "int64", (3,)),
    StoredQuantity("direction", "1", "unit vector along which the body travels"),
)
ELEMENTS = (
    StoredQuantity("element_wire", "", "wire each embedded wire element belongs to", "int64"),
    StoredQuantity("element_warp_mm", "mm", "material warp coordinate of the middle of each wire element"),
    StoredQuantity("element_along_mm", "mm", "coordinate along its wire of the middle of each wire element"),
    StoredQuantity("element_length_mm", "mm", "length of the path that each wire element covers"),
)
SKIN = (
    StoredQuantity(
        "rest", "mm", "surface points of a limb in its rest pose, the hinge in the origin along y", shape=(3,)
    ),
    StoredQuantity("weight", "1", "share of the lower segment in the motion of each surface point"),
    StoredQuantity("flexion", "deg", "flexion of the rest pose"),
    StoredQuantity("dual", "", "1 where rotations are blended (dual quaternions), 0 for linear blend skinning", "int8"),
)
"""How the surface of a limb that was skinned bends, so that it can be drawn without its mesh."""
WIRES = (
    StoredQuantity(
        "weft_mm", "mm", "material weft coordinate of each wire (of its middle when it does not follow the warp)"
    ),
    StoredQuantity("start_mm", "mm", "coordinate along each wire where its modelled part begins"),
    StoredQuantity("end_mm", "mm", "coordinate along each wire where it ends"),
    StoredQuantity("share", "1", "share of the cross-section of each wire that belongs to the modelled portion"),
    StoredQuantity("loop_wire", "", "wire each loop belongs to", "int64"),
    StoredQuantity("loop_index", "", "number of the loop within its wire", "int64"),
    StoredQuantity("loop_warp_mm", "mm", "material warp coordinate of the middle of each loop"),
    StoredQuantity("loop_exit_mm", "mm", "coordinate along the wire where it leaves the weave"),
    StoredQuantity("loop_entry_mm", "mm", "coordinate along the wire where it re-enters the weave"),
    StoredQuantity("loop_slack", "1", "excess length of the loop over its span"),
    StoredQuantity("loop_halved", "", "1 where a symmetry plane halves the loop in the model", "int8"),
    StoredQuantity("loop_copies", "", "loops of the same wire that each stored loop stands for", "int64"),
    StoredQuantity("wire_copies", "", "wires of the whole specimen that each stored wire stands for", "int64"),
    StoredQuantity(
        "symmetric", "", "0 when the symmetry planes mirror wires or loops the whole specimen does not have", "int8"
    ),
    *ELEMENTS,
    StoredQuantity("kind", "", "0 woven along the warp, 1 woven along the weft, 2 laid", "int64"),
    StoredQuantity("loop_rigid_mm", "mm", "length of the part in each loop that does not stretch"),
    StoredQuantity("vertex_wire", "", "wire each vertex of the paths belongs to", "int64"),
    StoredQuantity("vertex_along_mm", "mm", "coordinate along its wire of each vertex"),
    StoredQuantity("vertex_warp_mm", "mm", "material warp coordinate of each vertex"),
    StoredQuantity("vertex_weft_mm", "mm", "material weft coordinate of each vertex"),
    StoredQuantity("names", "", "name of each wire", f"S{NAME_BYTES}"),
    StoredQuantity("part_names", "", "name of each part on the fabric", f"S{NAME_BYTES}"),
    StoredQuantity("part_at_mm", "mm", "material warp and weft coordinate of the middle of each part", shape=(2,)),
    StoredQuantity("part_size_mm", "mm", "extent of the land of each part along warp and weft", shape=(2,)),
)
WIRES_SINCE_1_1 = (
    "element_along_mm", "element_length_mm", "kind", "loop_rigid_mm", "vertex_wire", "vertex_along_mm",
    "vertex_warp_mm", "vertex_weft_mm", "names", "part_names", "part_at_mm", "part_size_mm",
)  # fmt: skip
"""Arrays that files of version 1.0 lack; they hold straight wires along the warp."""
HISTORIES = (
    StoredQuantity("span_strain", "1", "engineering strain of the fabric span of each loop, exit to entry"),
    StoredQuantity("wire_strain", "1", "engineering strain of the wire in each loop after its slack is taken up"),
    StoredQuantity("element_strain", "1", "engineering strain of each embedded wire element", "float32"),
)
INCREMENTS = (
    StoredQuantity("displacement_mm", "mm", "punch displacement"),
    StoredQuantity("travel_mm", "mm", "path travelled by the punch, never decreasing"),
    StoredQuantity("punch_force_N", "N", "punch force along the motion, whole specimen"),
    StoredQuantity("clamp_force_N", "N", "force taken by the clamps along the motion, whole specimen"),
    StoredQuantity("max_penetration_mm", "mm", "deepest penetration of a fabric point into the body"),
    StoredQuantity("external_work", "N mm", "work of the punch on the modelled portion"),
    StoredQuantity("stored_energy", "N mm", "elastic energy of the modelled portion"),
    StoredQuantity("plastic_work", "N mm", "work dissipated by plastic flow"),
    StoredQuantity("friction_work", "N mm", "work dissipated by friction"),
    StoredQuantity("contact_energy", "N mm", "energy of the contact penalty"),
    StoredQuantity("work_doubt", "N mm", "how far the quadrature of the external work over the increments may be off"),
    StoredQuantity("softening", "", "trusses past their force peak", "int64"),
    StoredQuantity("converged", "", "1 when the increment met its tolerance", "int8"),
    StoredQuantity("iterations", "", "Newton iterations", "int64"),
    StoredQuantity("linear_solves", "", "linear systems factorised and solved", "int64"),
    StoredQuantity("cut_backs", "", "times the increment was cut before it converged", "int64"),
    StoredQuantity("residual_N", "N", "largest out-of-balance force at the end"),
    StoredQuantity("tolerance_N", "N", "out-of-balance force allowed"),
    StoredQuantity("worst_node", "", "point with the largest out-of-balance force", "int64"),
    StoredQuantity("wall_s", "s", "wall-clock time of the increment"),
    StoredQuantity("step", "", "output step that holds the fields of this increment, -1 when none does", "int64"),
    StoredQuantity("reason", "", "why the solver stopped", "S64"),
    StoredQuantity("sentence", "", "the solver's verdict in words", f"S{TEXT_BYTES}"),
)

_GROUPS: Mapping[str, tuple[StoredQuantity, ...]] = {
    "point": POINT_ARRAYS,
    "cell": CELL_ARRAYS,
    "label": CELL_LABELS,
    "lattice": LATTICE,
    "body": BODY,
    "skin": SKIN,
    "wires": WIRES,
    "histories": HISTORIES,
    "increments": INCREMENTS,
}


STATIC_SHAPES: Mapping[str, tuple[int, ...]] = {
    quantity.name: quantity.shape for table in (CELL_LABELS, LATTICE, BODY, SKIN, WIRES) for quantity in table
}
"""Shape of one entry of the arrays that do not change over a run."""


def names(table: Iterable[StoredQuantity]) -> tuple[str, ...]:
    """Return the names in a table, in its order."""
    return tuple(quantity.name for quantity in table)


def stored_name(name: str) -> bytes:
    """Return a name as UTF-8 of at most the bytes that are stored, cut at a character."""
    return name.encode()[:NAME_BYTES].decode(errors="ignore").encode()


def quantity(group: str, name: str) -> StoredQuantity:
    """Return the entry `name` of a table; an unknown name raises EtextileError that lists the known ones."""
    for entry in _GROUPS[group]:
        if entry.name == name:
            return entry
    known = names(_GROUPS[group])
    raise EtextileError(f"unknown {group} array {name!r}{nearest(name, known)}; known: {', '.join(known)}")


@dataclass(frozen=True)
class UndeformedGrid:
    """The undeformed piece: points (n, 3) mm, line cells (m, 2), family and wire number (m,), and how to show it.

    `quads` (q, 4) are the lattice cells, `clamped` (n,) marks held points, `symmetry` says whether x = 0 and y = 0 are
    symmetry planes, `warp_angle_deg` is the angle of the warp to x.
    """

    reference: NDArray[np.float64]
    cells: NDArray[np.int64]
    family: NDArray[np.int8]
    wire: NDArray[np.int32]
    quads: NDArray[np.int64] | None = None
    clamped: NDArray[np.bool_] | None = None
    symmetry: tuple[bool, bool] = (False, False)
    warp_angle_deg: float = 0.0


@dataclass(frozen=True)
class BodySurface:
    """Triangulated surface of the body at displacement zero, vertices (v, 3) mm, faces (f, 3), unit direction (3,).

    skin: how it bends, of a limb that is a skinned mesh.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    direction: NDArray[np.float64]
    skin: SkinnedMesh | None = None


@dataclass(frozen=True)
class CaseRecord:
    """Where a result comes from: case text verbatim, effective case (all defaults, `extends` and overrides resolved)
    with the hash that names it, file name, overrides, package versions, seed, time, unit of the travel.
    """

    text: str
    effective: str = ""
    sha256: str = ""
    source: str = ""
    overrides: tuple[str, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    seed: int = 0
    created: str = ""
    travel_unit: str = "mm"
