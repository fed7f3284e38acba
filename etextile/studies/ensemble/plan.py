"""What scatters in a case: its `scatter` section, its fabric file and its body turned into distributions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from etextile.ensemble.inputs import (
    PARAMETERS,
    REACH,
    CovarianceScatter,
    FamilyScatter,
    Input,
    SpanScatter,
)
from etextile.ensemble.store import SampleKey
from etextile.errors import BadInput
from etextile.types import Array
from etextile.vocabulary import FABRIC_FAMILIES
from loadcases.build_wires import wire_layout
from loadcases.fabric import Fabric, Family, load_fabric
from loadcases.judging import judge_for
from loadcases.schema import Case
from loadcases.schema_body import Placed
from loadcases.schema_paths import Net
from loadcases.schema_scatter import POSITIONAL, Scatter
from wires import dependence
from wires.failure import DEFAULT_CRITERION
from wires.layout import WireLayout


MIDDLE, LOW, HIGH = "estimated_mid", "estimated_low", "estimated_high"
"""The shipped span of estimates that lends its width to fabrics whose file says nothing about scatter."""
PLAIN = "without_scatter"
"""Folder of the run without scatter, from which the limits of the case and the fabric of the page come."""
POSE = frozenset({"punch_x", "punch_y", "tilt_x", "tilt_y", "tilt_z"})
"""Inputs that shift (mm) and turn (deg) the body."""
SMALLEST_MM = 0.01
"""Shifts below this are none."""


@dataclass(frozen=True)
class ScatterPlan:
    """Everything that scatters: single inputs, laws of the families, slack of the loops; notes say what does not."""

    inputs: tuple[Input, ...]
    families: dict[str, FamilyScatter]
    loop_slack: float
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Ensemble:
    """An ensemble to be run: the case that is sampled, what scatters, rows of unit numbers, where it is kept."""

    case: Case
    case_text: str
    name: str
    key: SampleKey
    folder: Path
    plan: ScatterPlan
    rows: Any
    notes: tuple[str, ...]

    @property
    def count(self) -> int:
        """Number of samples."""
        return len(self.rows)


def ensemble_case(case: Case) -> tuple[Case, tuple[str, ...]]:
    """Return the case that is sampled and notes: a quarter or half becomes whole when positions shall scatter.

    Raises BadInput for a case without wires.
    """
    if case.wires is None:
        raise BadInput.of("there are no wires whose failure could be counted, give the case wires", key="wires")
    asked = [name for name in POSITIONAL if getattr(case.scatter, name)]
    if case.fabric.portion == "whole" or not asked:
        return case, ()
    whole = case.fabric.model_copy(update={"portion": "whole"})
    note = (
        f"scatter of {', '.join(asked)} breaks the symmetry: the whole specimen is modelled instead of a "
        f"{case.fabric.portion}"
    )
    return _renumbered(case, case.model_copy(update={"fabric": whole})), (note,)


def _renumbered(case: Case, whole: Case) -> Case:
    """Return the whole specimen with its nets on the same loops as in the modelled part, which has other numbers."""
    if whole.wires is None or not any(net.wire is not None for net in whole.wires.nets):
        return whole
    fabric = load_fabric(case.fabric.set)
    was, now = wire_layout(case, fabric), wire_layout(whole, fabric)
    if was is None or now is None:
        return whole
    nets = tuple(_moved_net(net, was, now) for net in whole.wires.nets)
    return whole.model_copy(update={"wires": whole.wires.model_copy(update={"nets": nets})})


def _moved_net(net: Net, was: WireLayout, now: WireLayout) -> Net:
    """Return a net by the numbers of another layout, on whose loops it lies at the same places."""
    if net.wire is None:
        return net

    def there(loop: int | None) -> int:
        own = np.flatnonzero((was.loop_wire == net.wire) & (was.loop_index == loop))[0]
        away = np.hypot(now.loop_warp_mm - was.loop_warp_mm[own], now.loop_weft_mm - was.loop_weft_mm[own])
        return int(np.argmin(away))

    first, last = there(net.from_loop), there(net.to_loop)
    numbers = {"wire": now.loop_wire[first], "from_loop": now.loop_index[first], "to_loop": now.loop_index[last]}
    return net.model_copy(update={name: int(number) for name, number in numbers.items()})


def plan_of(case: Case) -> ScatterPlan:
    """Return what scatters in a case."""
    scatter = case.scatter
    families = dict(_families(load_fabric(case.fabric.set), scatter.fabric))
    inputs = [item for item in (*_everywhere(case), *_positions(case)) if item.std > 0.0]
    slack = scatter.loop_slack if case.wires is not None and case.wires.loops is not None else 0.0
    return ScatterPlan(tuple(inputs), families, slack, tuple(_notes(case, inputs)))


def moved(case: Case, values: dict[str, float]) -> Case:
    """Return the case with wires, loops and body shifted and turned by the sampled values; itself when none is."""
    changes: dict[str, Any] = {}
    wires, body = case.wires, case.body
    if wires is not None and wires.loops is not None and "loop_offset" in values:
        loops = wires.loops.model_copy(update={"offset": wires.loops.offset + values["loop_offset"]})
        wires = changes["wires"] = wires.model_copy(update={"loops": loops})
    if wires is not None and "wire_offset" in values:
        changes["wires"] = wires.model_copy(update={"first_offset": wires.first_offset + values["wire_offset"]})
    if isinstance(body, Placed) and not POSE.isdisjoint(values):
        shift = [values.get(f"punch_{axis}", 0.0) for axis in "xy"]
        turn = [values.get(f"tilt_{axis}", 0.0) for axis in "xyz"]
        position, rotation = np.add(body.position, shift), np.add(body.rotation, turn)
        changes["body"] = body.model_copy(
            update={"position": tuple(position.tolist()), "rotation": tuple(rotation.tolist())}
        )
    return case.model_copy(update=changes) if changes else case


def _everywhere(case: Case) -> tuple[Input, ...]:
    """Return the inputs that leave symmetry alone."""
    mounting = case.scatter.mounting
    return _strength(case), Input("mounting", "mounting strain", "", mounting, _origin("mounting"))


def _strength(case: Case) -> Input:
    """Return the logarithm of the strain that the wires of a garment stand, which a run integrates over as far."""
    std = judge_for(case).parameters.get("garment_scatter", case.scatter.strength)
    return Input("strength", "strength of the wires, ln", "", std, _origin("strength"), dependence.REACH)


def _positions(case: Case) -> Iterator[Input]:
    """Yield what shifts or turns wires and body, on a whole specimen."""
    if case.fabric.portion != "whole":
        return
    std = {name: _or_default(getattr(case.scatter, name), default) for name, default in POSITIONAL.items()}
    shifts = [("wire_offset", "shift of the wires")]
    if case.wires is not None and case.wires.loops is not None and not case.wires.drawn:
        shifts.append(("loop_offset", "shift of the loops"))
    for name, label in shifts:
        yield Input(name, label, "mm", std[name], _origin(name), _reach(case, name, std[name]))
    if case.body is None or case.motion.target != "body":
        return
    for axis in "xy":
        yield Input(f"punch_{axis}", f"body along {axis}", "mm", std["punch_position"], _origin("punch_position"))
    if case.body.type != "sphere":
        for axis in "xyz":
            yield Input(f"tilt_{axis}", f"body about {axis}", "deg", std["punch_angle"], _origin("punch_angle"))


def _or_default(value: float | None, default: float) -> float:
    return default if value is None else value


def _origin(name: str) -> str:
    """Return where the default of a key of `scatter` comes from."""
    extra = Scatter.model_fields[name].json_schema_extra
    return str(extra.get("origin", "")) if isinstance(extra, dict) else ""


def _reach(case: Case, name: str, std: float) -> float:
    """Return how many standard deviations wires or loops may be shifted without losing or gaining one.

    Half a spacing at most: beyond it another one would stand in for the one that was lost.
    """
    if std == 0.0:
        return REACH
    usual = _sizes(case)
    reach = min(REACH, 0.5 * _spacing(case, name) / std)
    while any(_sizes(moved(case, {name: sign * reach * std})) != usual for sign in (-1.0, 1.0)):
        reach *= 0.75
        if reach * std < SMALLEST_MM:
            return 0.0
    return reach


def _sizes(case: Case) -> tuple[int, int]:
    """Return the numbers of wires and loops."""
    layout = wire_layout(case, load_fabric(case.fabric.set))
    return (0, 0) if layout is None else (layout.n_wires, layout.n_loops)


def _spacing(case: Case, name: str) -> float:
    """Return the distance of neighbouring wires or loops, mm."""
    wires = case.wires
    if wires is None or wires.loops is None or name == "wire_offset":
        yarns = 1.0 if wires is None else wires.every_warp_yarns
        return yarns / load_fabric(case.fabric.set).warp_density
    return wires.loops.spacing


def _notes(case: Case, inputs: list[Input]) -> Iterator[str]:
    """Say which inputs do not scatter, or less than asked for, and why."""
    if case.fabric.portion != "whole":
        yield (
            f"a {case.fabric.portion} keeps its symmetry: places of wires, loops and body do not scatter "
            "(--set fabric.portion=whole lets them, at about four times the cost)"
        )
    if case.wires is not None and not _sizes(case)[1] and case.failure.criterion != DEFAULT_CRITERION:
        yield f"wires without loops do not fail here: {case.failure.criterion} looks at loops"
    if case.motion.path is not None:
        yield "displacements are counted along the way there and back"
    for item in inputs:
        if item.reach < REACH:
            yield f"{item.label} is cut off at {item.reach * item.std:.3g} mm, beyond it one is lost or gained"


def _families(fabric: Fabric, width: float) -> Iterator[tuple[str, FamilyScatter]]:
    """Yield the scatter of each family, from its own file or from the shipped span of estimates."""
    if width == 0.0:
        return
    span = {name: load_fabric(name) for name in (LOW, MIDDLE, HIGH)}
    for name in FABRIC_FAMILIES:
        family: Family = getattr(fabric, name)
        covariance = _covariance(family)
        if covariance.any():
            yield name, CovarianceScatter(_values(family), width**2 * covariance)
            continue
        low, middle, high = (_values(getattr(span[estimate], name)) for estimate in (LOW, MIDDLE, HIGH))
        yield name, SpanScatter(low / middle, high / middle, width)


def _values(family: Family) -> Array:
    """Return E, H and n."""
    return np.array([getattr(family, name).value for name in PARAMETERS])


def _covariance(family: Family) -> Array:
    """Return the covariance (3, 3) of E, H, n for one specimen: of the mean and between specimens; zero if unknown."""
    found = np.diag([(getattr(family, name).std or 0.0) ** 2 for name in PARAMETERS])
    stated = family.covariance
    if stated is None:
        return found
    places = [(row, PARAMETERS.index(name)) for row, name in enumerate(stated.parameters) if name in PARAMETERS]
    for i, row in places:
        for j, column in places:
            between = stated.between_specimens[i][j] if stated.between_specimens is not None else 0.0
            found[row, column] = stated.matrix[i][j] + between
    return found
