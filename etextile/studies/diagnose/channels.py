"""What measured channels have that the case cannot have: other edges, places outside, another unit or origin.

All of it is found before anything is simulated, and named with the line it stands in.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.diagnose.data.measured import ClampLine, FreeEdge, Measurements, StrainField, WireStates
from etextile.errors import Problem
from etextile.types import Array
from loadcases.build_wires import wire_layout
from loadcases.fabric import load_fabric
from loadcases.schema import Case


BEYOND = 1.5
"""Share of the force record, or of what the case reaches, that no other channel goes beyond."""
MOVE, START = 2.0, 5.0
"""A point moves by no more than this multiple of the displacement, and lies this near (mm) to where it belongs."""


def of_channels(case: Case, measured: Measurements) -> Iterator[Problem]:
    """Yield what a channel has that the case cannot have."""
    yield from of_load(case, measured)
    if case.worn:
        yield from _of_worn(case, measured)
        return
    edge, field, clamp, wires = measured.free_edge, measured.strain_field, measured.clamp_line, measured.wires
    if case.fabric.outline is not None or case.fabric.warp_angle != 0.0:
        for item in (edge, field, clamp):
            if item is not None:
                yield Problem("belongs to a rectangular piece with the warp along x", file=item.file)
        return
    for channel in (edge, field, clamp, wires):
        if channel is not None:
            yield from _too_deep(channel, case, measured)
    length, width = case.pattern
    if edge is not None:
        yield from _of_edge(edge, case)
    if field is not None:
        yield from _inside(field, field.warp0, length, "warp0_mm")
        yield from _inside(field, field.weft0, width, "weft0_mm")
    if clamp is not None:
        if "x_max" not in case.supports.clamped:
            yield Problem("the case has no clamp at x_max, where the slip is measured", file=clamp.file)
        yield from _inside(clamp, clamp.weft0, width, "weft0_mm")
    if wires is not None:
        yield from _inside(wires, wires.warp0, length, "warp0_mm")
        yield from _no_such_wire(wires, case)


def of_load(case: Case, measured: Measurements) -> Iterator[Problem]:
    """Yield the channels that were measured over another load than that of the case."""
    unit, target = case.motion.unit, case.motion.target
    if measured.moment_curvature:
        yield from _of_bending(case, measured)
    fits = {
        "punch_force": (unit == "mm", "a force over displacement needs a motion by displacement"),
        "clamp_force": (
            unit == "mm" and target != "body", "the force of a pulled clamp needs motion.target: x_max or another edge",
        ),
        "cyclic_force": (
            target == "body" or (unit == "mm" and target != "joint"),
            "a force over a motion there and back needs a punch or a pulled clamp",
        ),
        "pressure_height": (unit == "bar", "a height over pressure needs motion.target: pressure"),
        "joint_moment": (unit == "deg", "a moment over the angle needs motion.target: joint"),
        "mark_slip": (unit == "deg", "slip on the skin needs a worn piece and motion.target: joint"),
    }  # fmt: skip
    for name, (fine, message) in fits.items():
        if getattr(measured, name) and not fine:
            yield Problem(message, key="motion.target")
    for item in measured.displacement_field:
        if item.unit != unit:
            yield Problem(f"its first column is in {item.unit}, the motion of the case in {unit}", file=item.file)
    if measured.wires is not None and measured.wires.unit != unit:
        words = f"its first column is in {measured.wires.unit}, the motion of the case in {unit}"
        yield Problem(words, file=measured.wires.file)
    for channel in ("free_edge", "strain_field", "clamp_line"):
        found = getattr(measured, channel)
        if found is not None and unit != "mm":
            yield Problem(f"its first column is in mm, the motion of the case in {unit}", file=found.file)


def _of_bending(case: Case, measured: Measurements) -> Iterator[Problem]:
    """Yield what keeps a bending test from being one: another load beside it, or a piece that is not bent alike."""
    others = [name for name in measured.channels if name not in ("moment_curvature", "tensile")]
    if others:
        message = f"a bending moment is measured in a test of its own, not with {', '.join(others)}; give it one"
        yield Problem(f"{message} under tests", file=measured.file, key="channels.moment_curvature")
    if case.worn or case.fabric.outline is not None or case.fabric.warp_angle % 90.0:
        yield Problem("a bending test needs a flat rectangle with yarns along its sides", key="fabric")


def _of_worn(case: Case, measured: Measurements) -> Iterator[Problem]:
    """Yield marks and wires that a worn piece does not have, and channels that only a flat one has."""
    length, width = case.pattern
    marks, wires = measured.mark_slip, measured.wires
    for channel in ("punch_force", "free_edge", "strain_field", "clamp_line", "displacement_field"):
        if getattr(measured, channel):
            yield Problem(f"{channel} is measured on a flat piece, the case is worn on a joint", key="fabric.shape")
    if marks is not None:
        yield from _inside(marks, marks.warp0, length, "warp0_mm")
        yield from _inside(marks, marks.weft0, width, "weft0_mm")
    if wires is not None:
        yield from _too_deep(wires, case, measured)
        yield from _inside(wires, wires.warp0, length, "warp0_mm")
        yield from _no_such_wire(wires, case)


def _too_deep(
    channel: FreeEdge | StrainField | ClampLine | WireStates, case: Case, measured: Measurements
) -> Iterator[Problem]:
    """Yield a displacement far beyond the force record, or beyond what the case reaches where there is none.

    Wires are also looked at after a test whose force was recorded in part only, so they go by the case.
    """
    ends = [float(curve.displacement[-1]) for curve in measured.punch_force]
    ends += [float(curve.displacement[-1]) for curve in measured.clamp_force]
    unit = case.motion.unit
    end, words = max(case.motion.reach, 0.0 if case.worn else 0.5 * case.pattern[0]), "a test of this case reaches"
    if ends and not isinstance(channel, WireStates):
        end, words = max(ends), "the force was recorded up to"
    for row in np.flatnonzero(channel.displacement > BEYOND * end)[:1]:
        remedy = "um? convert to mm, and count from where contact starts"
        remedy = "count flexion from the straight limb" if case.worn else remedy
        message = f"{channel.displacement[row]:g} {unit} is beyond the test, {words} {end:g} {unit}; {remedy}"
        key = "angle_deg" if case.worn else "displacement_mm"
        yield Problem(message, file=channel.file, line=channel.line(int(row)), key=key)


def _of_edge(edge: FreeEdge, case: Case) -> Iterator[Problem]:
    """Yield a free edge that the case clamps, that lies outside, or that is not where the case has it."""
    if "y_max" in case.supports.clamped:
        yield Problem("the case clamps the edges along the warp, so it has no free edge there", file=edge.file)
        return
    outside = list(_inside(edge, edge.warp0, case.pattern[0], "warp0_mm"))
    yield from outside or _misplaced(edge, 0.5 * case.pattern[1])


def _misplaced(edge: FreeEdge, half: float) -> Iterator[Problem]:
    """Yield a point that is further from (warp0, +-half, 0) than the displacement explains."""
    side = np.where(edge.weft < 0.0, -half, half)
    found = np.stack([edge.warp, edge.weft, edge.height])
    start = np.stack([edge.warp0, side, np.zeros(len(side))])
    moved = np.linalg.norm(found - start, axis=0)
    for row in np.flatnonzero(moved > MOVE * np.maximum(edge.displacement, 0.0) + START)[:1]:
        worst = int(np.abs(found - start)[:, row].argmax())
        message = (
            f"{found[worst, row]:g} mm, where the point of the case starts from {start[worst, row]:g} mm and the punch "
            f"has moved {edge.displacement[row]:g} mm; m? cm? convert to mm, check the sign, count from the specimen's "
            "centre and the flat fabric, or correct fabric.size of the case"
        )
        key = ("warp_mm", "weft_mm", "height_mm")[worst]
        yield Problem(message, file=edge.file, line=edge.line(int(row)), key=key)


def _inside(channel: Channel, place: Array, length: float, key: str) -> Iterator[Problem]:
    """Yield the coordinate furthest outside of the specimen: another origin, or another specimen."""
    row = int(np.abs(place).argmax())
    if abs(place[row]) > 0.5 * length * (1.0 + 1e-6):
        message = (
            f"{place[row]:g} mm lies outside of the specimen, which reaches {0.5 * length:g} mm from its centre; "
            "count from the specimen's centre, or correct fabric.size of the case"
        )
        yield Problem(message, file=channel.file, line=channel.line(row), key=key)


def _no_such_wire(wires: WireStates, case: Case) -> Iterator[Problem]:
    """Yield a number that no wire of the whole specimen has."""
    layout = wire_layout(case, load_fabric(case.fabric.set))
    if layout is None:
        return
    count = int(layout.wire_copies.sum())
    for row in np.flatnonzero((wires.wire < 0) | (wires.wire >= count))[:1]:
        known = f"the specimen has wires 0 to {count - 1}, counted from -y" if count else "the specimen has no wires"
        message = f"no such wire (got {wires.wire[row]}), {known}; correct the number, or wires of the case"
        yield Problem(message, file=wires.file, line=wires.line(int(row)), key="wire")
