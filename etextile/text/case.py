"""A case in words, and how large the model would be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from etextile import foreign_code


if TYPE_CHECKING:
    from loadcases.reader import LoadedCase
    from loadcases.schema import Case
    from loadcases.schema_parts import Effect


MOST_STATIONS = 12
"""Turning points that are written out."""


def case_text(loaded: LoadedCase, counts: Mapping[str, Any], *, every: bool = False) -> str:
    """Return what would be run; `counts` as returned by `loadcases.build.plan`; `every`: with the canonical case."""
    lines = summary_lines(loaded, counts)
    if every:
        from loadcases.reader import dump_case

        lines += ["", "# the case as it is run, with all defaults", dump_case(loaded.case).rstrip("\n")]
    return "\n".join(lines)


def summary_lines(loaded: LoadedCase, counts: Mapping[str, Any]) -> list[str]:
    """Return the lines of the summary."""
    case = loaded.case
    rows = [("fabric", _fabric(case)), ("wires", _wires(case))]
    rows += [(name, text) for name, text in (("parts", _parts(case)), ("nets", _nets(case))) if text]
    rows += [("body", _body(case)), ("motion", _motion(case))]
    rows.append(("contact", f"friction {case.contact.friction}" if case.body is not None else "none"))
    if case.effects:
        rows.append(("effects", "; ".join(_effect(effect) for effect in case.effects)))
    rows.append(("failure", _failure(case)))
    rows += [("code", text) for text in _code(case)]
    notes = counts.get("notes", ())
    rows += [(name, _count(value)) for name, value in counts.items() if name != "notes"]
    rows += [("note", str(note)) for note in notes]
    rows.append(("sha256", loaded.sha256))
    width = max(len(name) for name, _ in rows)
    return [f"{case.title}: ready to run", *(f"  {name:<{width}}  {text}" for name, text in rows)]


def _effect(effect: Effect) -> str:
    """Name an effect with its parameters as they were given."""
    numbers = [f"{name} {value}" for name, value in effect.parameters.items() if name != "file"]
    return ", ".join([effect.id, *numbers])


def _code(case: Case) -> Iterator[str]:
    """Say which Python files a run executes."""
    from loadcases.names import code_files

    for route, name in code_files(case.model_dump()):
        path = Path(name).expanduser().resolve()
        key = ".".join(str(part) for part in route)
        yield f"{key} runs {path}, sha256 {foreign_code.hash_of(path.read_bytes())}"


def _failure(case: Case) -> str:
    """Say the criterion and where the first filament of the case's wires breaks by it."""
    from loadcases.judging import break_strain, judge_for

    judge = judge_for(case)
    if case.failure.file is not None:
        return f"{case.failure.criterion}: {judge.criterion.summary}"
    whose = " of the fabric" if judge.criterion.name == "span_strain" else " of the wire"
    return f"{case.failure.criterion}, first filament at {100 * break_strain(case, judge):.3g} %{whose}"


def _count(value: Any) -> str:
    """Write a number with thin groups, a pair as `9 x 16`."""
    if isinstance(value, (list, tuple)):
        return " x ".join(_count(item) for item in value)
    return f"{value:,}".replace(",", " ") if isinstance(value, int) else str(value)


def _fabric(case: Case) -> str:
    """Describe the piece of fabric."""
    piece = case.fabric
    angle = f", warp at {piece.warp_angle:g} deg" if piece.warp_angle else ""
    length, width = case.pattern
    if case.worn:
        return f"{piece.set}, {piece.portion} of {_worn(case)}, coarsening {piece.coarsening:g}"
    size = f"{length:g} x {width:g} mm"
    if piece.outline is not None:
        circle = getattr(piece.outline, "circle", None)
        size = f"a polygon within {size}" if circle is None else f"a circle of {2 * circle:g} mm diameter"
    return f"{piece.set}, {piece.portion} of {size}, coarsening {piece.coarsening:g}{angle}"


def _worn(case: Case) -> str:
    """Describe a piece that is worn: its size as it lies flat, ease, ends."""
    from loadcases.schema_body import LIMBS

    length, width = case.pattern
    ease = ""
    if case.fabric.shape == "tube" and isinstance(case.body, LIMBS):
        ease = f" (ease {100 * (width / case.body.girth - 1):+.3g} %)"
    ends = case.supports.ends
    how = f"ends {ends[0]}" if ends[0] == ends[1] else f"upper end {ends[0]}, lower end {ends[1]}"
    sides = f", sides {case.supports.sides}" if case.fabric.shape == "panel" else ""
    return f"a {case.fabric.shape} of {length:g} x {width:.4g} mm{ease}, {how}{sides}"


def _wires(case: Case) -> str:
    """Describe the wires."""
    wires = case.wires
    if wires is None:
        return "none"
    if wires.drawn:
        from loadcases.build_paths import drawn_wires

        drawn = drawn_wires(case)
        names, modelled = tuple(drawn.images), drawn.layout.names
        source = f"drawn in {Path(wires.layout).name}" if wires.layout is not None else "drawn"
        rest = "" if len(modelled) == len(names) else f"; modelled {_some(modelled)}, the others are mirror images"
        return f"{source}: {_some(names)}{rest}"
    strands = f"{wires.filaments} filaments of {wires.filament_diameter:g} mm {wires.material}"
    loops = "no loops"
    if wires.loops is not None:
        loops = (
            f"loops of {wires.loops.length:g} mm every {wires.loops.spacing:g} mm, slack {100 * wires.loops.slack:g} %"
        )
    return f"one in {wires.every_warp_yarns:g} warp yarns, {strands}, {loops}"


def _parts(case: Case) -> str:
    """Name the parts of drawn wires and what they connect; '' without parts."""
    if case.wires is None or not case.wires.drawn:
        return ""
    from loadcases.build_paths import drawn_wires

    drawn = drawn_wires(case)
    on: dict[str, list[str]] = {part.name: [] for part in drawn.parts}
    for item in drawn.terminals:
        on[drawn.parts[item.part].name].append(item.wire)
    return _some([f"{name} on {' '.join(dict.fromkeys(wires)) or 'no wire'}" for name, wires in on.items()])


def _nets(case: Case) -> str:
    """Name the nets with their wires and parts; '' without nets."""
    wires = case.wires
    if wires is None:
        return ""
    return _some([
        f"{net.name} (wire {net.wire}, loops {net.from_loop} to {net.to_loop})" if net.wire is not None
        else f"{net.name} (wires {' '.join(net.wires)}; {net.parts[0]} to {', '.join(net.parts[1:])})"
        for net in wires.nets
    ])  # fmt: skip


def _some(names: Sequence[str]) -> str:
    """Return the first names of a list."""
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _body(case: Case) -> str:
    """Describe the body by its own keys."""
    if case.body is None:
        return "none"
    keys = case.body.model_dump(exclude={"type", "position", "rotation", "centred"}, exclude_none=True)
    sizes = ", ".join(
        name.replace("_", " ") if value is True else f"{name} {_plain(value)}"
        for name, value in keys.items()
        if value is not False
    )
    return f"{case.body.type}, {sizes}" if sizes else case.body.type


def _plain(value: Any) -> str:
    """Write a number, a list of numbers or a text."""
    if isinstance(value, (list, tuple)):
        return " x ".join(f"{item:g}" for item in value)
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_plain(item)}" for name, item in value.items())
    return f"{value:g}" if isinstance(value, float) else str(value)


def _motion(case: Case) -> str:
    """Describe the motion."""
    motion = case.motion
    words = {
        "body": "body pushed up",
        "pressure": "pressure up to",
        "weight": "hanging by its own weight up to",
        "joint": "joint bent to",
    }
    what = words.get(motion.target, f"clamp {motion.target} pulled outwards")
    unit = motion.unit.replace("**", "")
    path = "" if motion.path is None else f" by way of {_stations(motion.path)} {unit}"
    if motion.unit != "mm":
        return f"{what} {motion.reach:g} {unit}{path} in {motion.steps} steps"
    return f"{what} {motion.reach:g} {unit}{path} in {motion.steps} steps at {motion.speed:g} mm/s"


def _stations(path: Sequence[float]) -> str:
    """Write the turning points of a path; of many only their number and range."""
    if len(path) > MOST_STATIONS:
        return f"{len(path)} turning points between {min(path):g} and {max(path):g}"
    return ", ".join(f"{station:g}" for station in path)
