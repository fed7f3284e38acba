"""What a map shows, as plain arrays: one step of a run, without a word about how it is drawn.

A quarter or half model is shown as the whole specimen (`viz.mirror`), because that is what lies on the table.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from etextile.errors import BadInput, nearest
from etextile.results.reader import PartRecord, Results
from etextile.results.wire_history import WireHistory
from etextile.types import Array, BoolArray, IntArray
from etextile.vocabulary import STATES
from viz import surface
from wires.wording import spoken


WARP, WEFT, DIAGONAL, WIRE = range(4)
PORTIONS = {(False, False): "whole", (True, False): "half", (False, True): "half", (True, True): "quarter"}
FIRST_BROKEN = STATES.index("partial")


@dataclass(frozen=True)
class FieldKind:
    """A quantity the fabric can be coloured with: the stored array, its truss family, the name in legends, its unit."""

    array: str
    family: int
    label: str
    unit: str


FIELDS = {
    "warp_strain": FieldKind("strain", WARP, "warp strain", "%"),
    "weft_strain": FieldKind("strain", WEFT, "weft strain", "%"),
    "diagonal_strain": FieldKind("strain", DIAGONAL, "diagonal strain", "%"),
    "warp_force": FieldKind("force", WARP, "warp truss force", "N"),
    "weft_force": FieldKind("force", WEFT, "weft truss force", "N"),
    "warp_plastic_strain": FieldKind("plastic_strain", WARP, "plastic warp strain", "%"),
}


@dataclass(frozen=True)
class Colouring:
    """Values (q,) on the fabric cells, the largest over the trusses, and what they are; strains are in per cent."""

    label: str
    unit: str
    cells: Array
    peak: float

    @property
    def heading(self) -> str:
        """The label with a capital letter."""
        return self.label[0].upper() + self.label[1:]


@dataclass(frozen=True)
class SceneWires:
    """Wire segments (k, 2) between scene points with wire number and own strain (k,); name and state of each wire (W,).

    Without states a wire has that of its worst loop.
    """

    segments: IntArray
    wire: IntArray
    strain: Array
    names: tuple[str, ...] = ()
    state: IntArray | None = None

    def name(self, wire: int) -> str:
        """Return the name of a wire, its number where it has none."""
        return self.names[wire] if wire < len(self.names) else str(wire)

    @property
    def named(self) -> bool:
        """Whether somebody named the wires."""
        return any(name != str(number) for number, name in enumerate(self.names))


@dataclass(frozen=True)
class Parts:
    """Parts on the fabric: names (P,), corners of their lands (P, 4, 2) when flat and deformed (P, 4, 3), mm."""

    names: tuple[str, ...]
    flat: Array
    deformed: Array


@dataclass(frozen=True)
class SceneLoops:
    """Loops (L,): wire, number, state, strains; place and half span when flat (L, 2), deformed place (L, 3), mm.

    `folded` (L,): those that stand, or stood, in a fold of a worn piece; empty for none.
    """

    wire: IntArray
    index: IntArray
    state: IntArray
    span_strain: Array
    wire_strain: Array
    flat: Array
    half_span: Array
    deformed: Array
    folded: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @property
    def shown(self) -> IntArray:
        """States (L,) as drawn: a loop in a fold that had not failed before has one more than the states."""
        if not len(self.folded):
            return self.state
        return np.where(self.folded & (self.state < FIRST_BROKEN), len(STATES), self.state)


@dataclass(frozen=True)
class SceneBody:
    """Surface of the body where it is at this step: vertices (v, 3) mm, triangles (f, 3)."""

    vertices: Array
    faces: IntArray


@dataclass(frozen=True)
class Scene:
    """One step: flat and deformed points (n, 3) mm, fabric cells (q, 4) with colouring, wires, loops, body, clamps."""

    title: str
    displacement_mm: float
    force_N: float
    portion: str
    flat: Array
    points: Array
    quads: IntArray
    colouring: Colouring
    touched: BoolArray
    clamped: BoolArray
    wires: SceneWires
    loops: SceneLoops
    body: SceneBody | None
    symmetry: tuple[bool, bool]
    warp_angle_deg: float = 0.0
    travel_unit: str = "mm"
    folded: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    """(q,) True for cells of a worn piece that stand in folds; none for any other piece."""
    closed: bool = False
    """Whether the piece is a tube, cut open in flat maps."""
    worn: bool = False
    """Whether the piece is worn: `displacement_mm` is then the angle in degrees, `force_N` in N mm per degree."""
    parts: Parts | None = None
    provisional: bool = False
    """Whether the verdict of the run is withheld."""

    @property
    def moment(self) -> str:
        """The moment shown in words, by displacement, load or angle, and the force or moment then."""
        if not self.worn:
            name = {"bar": "Pressure", "g/m**2": "Mass"}.get(self.travel_unit, "Displacement")
            unit = self.travel_unit.replace("**", "")
            return f"{name} {self.displacement_mm:.4g} {unit}, force {spoken(self.force_N, 'N', digits=4)}."
        if self.displacement_mm <= 0.0:
            return f"Being put on, the limb still {-self.displacement_mm:.3g} mm too thin."
        return f"Bent to {self.displacement_mm:.4g} deg, moment {spoken(float(np.degrees(self.force_N)), 'N mm')}."

    @property
    def mirrored(self) -> bool:
        """Whether a quarter or half model was mirrored to show the whole specimen."""
        return self.portion != "whole" and not any(self.symmetry)


def build_scene(
    results: Results,
    *,
    step: int = -1,
    loop_state: IntArray | None = None,
    wire_state: IntArray | None = None,
    field: str = "warp_strain",
    title: str = "",
    limb: SceneBody | None = None,
    folded: BoolArray | None = None,
    folded_loops: BoolArray | None = None,
    closed: bool = False,
    provisional: bool = False,
) -> Scene:
    """Return the scene of a step (negative counts from the end), as modelled; `whole` mirrors it.

    `limb`: of a worn piece, the limb as it is at this step; `folded` (q,) its cells and
    `folded_loops` (L,) its loops in folds; `closed`: it is a tube.

    `loop_state` (L,) holds indices into `etextile.vocabulary.STATES`; without it every loop is shown intact.
    Without `wire_state` (W,) a wire is shown by its worst loop; `provisional`: the verdict is withheld.
    An unknown field or step raises BadInput.
    """
    number = results.step_index(step)
    grid = results.grid
    points = results.points(number)
    quads = _quads(results)
    clamped = np.zeros(len(points), dtype=bool) if grid.clamped is None else grid.clamped
    history = results.wires
    loops = _no_loops() if history is None else _loops(results, history, number, loop_state, quads, points)
    return Scene(
        title=title,
        displacement_mm=float(results.displacement_mm[number]),
        force_N=float(results.curves.punch_force_N[number]),
        portion=PORTIONS[grid.symmetry],
        flat=grid.reference,
        points=points,
        quads=quads,
        colouring=_colouring(results, number, quads, field),
        touched=np.any(results.array("contact_force", number) != 0.0, axis=1),
        clamped=clamped,
        wires=_wires(results, number, wire_state),
        loops=loops if folded_loops is None else replace(loops, folded=folded_loops),
        body=_body(results, number) if limb is None else limb,
        symmetry=grid.symmetry,
        warp_angle_deg=grid.warp_angle_deg,
        travel_unit=results.case.travel_unit,
        worn=limb is not None,
        folded=np.zeros(len(quads), dtype=bool) if folded is None else folded,
        closed=closed,
        parts=None if results.parts is None else _parts(results, results.parts, quads, points),
        provisional=provisional,
    )


def coloured(scene: Scene, results: Results, *, step: int, field: str) -> Scene:
    """Return the scene of the same step, mirrored or not, coloured by another field: all else is as it is."""
    single = _quads(results)
    own = _colouring(results, results.step_index(step), single, field)
    return replace(scene, colouring=replace(own, cells=np.tile(own.cells, len(scene.quads) // len(single))))


def wire_states(scene: Scene) -> dict[int, int]:
    """Return the state of each wire: as judged, else that of its worst loop."""
    worst: dict[int, int] = {} if scene.wires.state is None else dict(enumerate(scene.wires.state.tolist()))
    loops = scene.loops
    for wire, state in zip(loops.wire.tolist(), loops.state.tolist(), strict=True):
        worst[wire] = max(state, worst.get(wire, 0))
    return worst


def _quads(results: Results) -> IntArray:
    """Return the cells (q, 4) of the fabric, found from its yarns where the file does not hold them."""
    grid = results.grid
    if grid.quads is not None:
        return grid.quads
    warp, weft = (grid.cells[grid.family == name] for name in (WARP, WEFT))
    return surface.quads_of(grid.reference, warp, weft)


def _colouring(results: Results, step: int, quads: IntArray, field: str) -> Colouring:
    if field not in FIELDS:
        raise BadInput.of(f"no field {field!r}{nearest(field, FIELDS)}; there are {', '.join(FIELDS)}", key="field")
    kind = FIELDS[field]
    chosen = results.family == kind.family
    factor = 100.0 if kind.unit == "%" else 1.0
    values = factor * results.array(kind.array, step)[chosen].astype(np.float64)
    # one diagonal of a sheared cell is as short as the other is long: their mean would show nothing
    cells = surface.cell_values(
        quads, results.cells[chosen], values, n_points=len(results.grid.reference), largest=kind.family == DIAGONAL
    )
    return Colouring(kind.label, kind.unit, cells, float(values.max(initial=0.0)))


def _wires(results: Results, step: int, state: IntArray | None) -> SceneWires:
    chosen = results.family == WIRE
    wire = results.grid.wire[chosen].astype(np.int64)
    if results.wires is None:
        return SceneWires(results.cells[chosen], wire, np.zeros(len(wire)), state=state)
    strain = own_strain(results.wires, wire, step)
    return SceneWires(results.cells[chosen], wire, strain, results.wires.layout.names, state)


def own_strain(history: WireHistory, wire: IntArray, step: int) -> Array:
    """Return the wires' own strain (k,) along their trusses at an output step, after crimp or slack is taken up.

    `wire` (k,) of each truss in the order of the file: of every wire what is woven in comes before its loops.
    """
    order = np.argsort(wire, kind="stable")
    first = np.searchsorted(wire[order], wire)
    rank = np.empty(len(wire), dtype=np.int64)
    rank[order] = np.arange(len(wire))
    loops = rank - first >= np.bincount(history.element_wire, minlength=int(wire.max(initial=0)) + 1)[wire]
    strain = np.empty(len(wire))
    strain[~loops] = history.element_strain[1 + step]
    strain[order[loops[order]]] = history.wire_strain[1 + step][np.argsort(history.layout.loop_wire, kind="stable")]
    return strain


def _parts(results: Results, parts: PartRecord, quads: IntArray, points: Array) -> Parts:
    """Place the lands of parts on the specimen and on the deformed fabric."""
    frame = _frame(results)
    corner = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    flat = (parts.at_mm[:, None] + corner * parts.size_mm[:, None]) @ frame
    sides = np.ones((*flat.shape[:2], 3))  # of the specimen that a half or quarter has the images of
    sides[..., :2] = np.where(np.array(results.grid.symmetry[:2]) & (flat < 0.0), -1.0, 1.0)
    modelled = (flat * sides[..., :2]).reshape(-1, 2)
    deformed = sides * surface.at(results.grid.reference, quads, modelled, points).reshape(-1, 4, 3)
    return Parts(parts.names, flat, deformed)


def _frame(results: Results) -> Array:
    """Return the unit vectors (2, 2) of warp and weft on the specimen."""
    angle = np.deg2rad(results.grid.warp_angle_deg)
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _no_loops() -> SceneLoops:
    none, numbers = np.zeros(0), np.zeros(0, dtype=np.int64)
    places = np.zeros((0, 2))
    return SceneLoops(numbers, numbers, numbers, none, none, places, places, np.zeros((0, 3)))


def _loops(
    results: Results, history: WireHistory, step: int, state: IntArray | None, quads: IntArray, points: Array
) -> SceneLoops:
    """Place the loops, given in material coordinates, on the specimen and on the deformed fabric."""
    layout = history.layout
    frame = _frame(results)
    flat = np.stack([layout.loop_warp_mm, layout.loop_weft_mm], axis=1) @ frame
    ends = [layout.places(layout.loop_wire, place) for place in (layout.loop_exit_mm, layout.loop_entry_mm)]
    half = 0.5 * (ends[1] - ends[0]) @ frame
    return SceneLoops(
        wire=layout.loop_wire,
        index=layout.loop_index,
        state=np.zeros(len(flat), dtype=np.int64) if state is None else np.asarray(state, dtype=np.int64),
        span_strain=history.span_strain[1 + step],
        wire_strain=history.wire_strain[1 + step],
        flat=flat,
        half_span=half,
        deformed=surface.at(results.grid.reference, quads, flat, points) if len(flat) else np.zeros((0, 3)),
    )


def _body(results: Results, step: int) -> SceneBody | None:
    if results.body is None:
        return None
    travel = float(results.displacement_mm[step]) * np.asarray(results.body.direction)
    return SceneBody(results.body.vertices + travel, results.body.faces)
