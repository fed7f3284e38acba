"""What of an answer hangs on laws beyond their range: the block `extrapolation` of report.json and its sentence."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from etextile.studies.run.continuation import FAMILIES, WAYS, Continued, follow, identified_to, reached_in
from etextile.studies.run.simulate import Simulation
from etextile.types import Array
from wires.damage import FailureResult
from wires.judge import Judge
from wires.report import wire_rows
from wires.report_files import plain
from wires.verdict import keeps_all


VERDICTS = {"intact": "whole", "plastic": "whole", "partial": "damaged", "open": "interrupted"}
"""What a state means for the wire: plastic metal still conducts with every filament."""


@dataclass(frozen=True)
class LawExtrapolation:
    """Ranges (3,) of the laws and what was reached, and the answer under the low and the high continuation.

    `leaves_at`: travel, in `unit`, of the first output beyond a range; `response`: key of the force or moment.
    `continued` is empty when the ranges were kept, when there are no wires, or when the run itself broke off.
    """

    identified_to: Array
    reached: Array
    leaves_at: float | None
    unit: str
    response: str
    slopes: Mapping[str, Mapping[str, float | str]]
    damage: FailureResult | None
    continued: Mapping[str, Continued]

    @property
    def beyond(self) -> tuple[str, ...]:
        """Names of the families that pass their range."""
        return tuple(name for name, over in zip(FAMILIES, self.reached > self.identified_to, strict=True) if over)

    @cached_property
    def headline_flips(self) -> int:
        """Number of continuations under which it is another answer whether every wire keeps every filament."""
        if self.damage is None:
            return 0
        own = keeps_all_of(self.damage)
        return sum(keeps_all_of(item.damage) != own for item in self.continued.values() if item.damage is not None)

    @property
    def hanging(self) -> list[dict[str, Any]]:
        """Loops and pieces in the weave whose verdict differs between the continuations."""
        if self.damage is None:
            return []
        own = parts_of(self.damage)
        others = {way: parts_of(item.damage) for way, item in self.continued.items() if item.damage is not None}
        found = []
        for place, part in own.items():
            verdicts = {way: VERDICTS[other[place]["state"]] for way, other in others.items()}
            if any(verdict != VERDICTS[part["state"]] for verdict in verdicts.values()):
                found.append({**_where(place, part), "verdict": VERDICTS[part["state"]], **verdicts})
        return found

    def as_dict(self) -> dict[str, Any]:
        """Return the block of report.json."""
        ranges = {
            name: {"identified_to": self.identified_to[k], "reached": self.reached[k], **self.slopes[name]}
            for k, name in enumerate(FAMILIES)
        }
        hanging = self.hanging
        loops = 0 if self.damage is None else self.damage.layout.n_loops
        open_loops = sum(part["loop"] is not None for part in hanging)
        answers = {
            way: {
                self.response: item.force,
                "trouble": item.trouble,
                "survive": None if item.damage is None else keeps_all_of(item.damage),
                **_expected(item.damage),
            }
            for way, item in self.continued.items()
        }
        block: dict[str, Any] = plain(
            {
                **ranges,
                "beyond": list(self.beyond),
                "leaves_at": self.leaves_at,
                "unit": self.unit,
                "continuations": answers,
                "loops": loops,
                "decided_by_geometry": loops - open_loops if self.continued or not self.beyond else None,
                "verdicts_that_hang_on_it": hanging,
                "headline_flips": self.headline_flips,
                "sentence": self.sentence(loops, hanging),
            }
        )
        return block

    def sentence(self, loops: int, hanging: list[dict[str, Any]]) -> str:
        """Say how far the laws are beyond their range and what hangs on it."""
        if not self.beyond:
            return "Every law stays within the range it was identified in."
        far = ", ".join(
            f"{name} {self.reached[k]:.2f} (identified to {self.identified_to[k]:.2f})"
            for k, name in enumerate(FAMILIES)
            if name in self.beyond
        )
        start = f"From {self.leaves_at:.1f} {self.unit} on laws are used beyond their range: {far}."
        if not self.continued:
            return start
        open_loops = sum(part["loop"] is not None for part in hanging)
        woven = len(hanging) - open_loops
        broken = [f"{way}: {item.trouble}" for way, item in self.continued.items() if item.trouble]
        if broken:
            start += f" A continuation could not be followed to the end and is left out ({'; '.join(broken)})."
        return (
            f"{start} In {loops - open_loops} of {loops} loops geometry alone decides: their verdict is the same under "
            f"the low and the high continuation of the laws. {_open(open_loops, woven)}{self._headline()}"
        )

    def _headline(self) -> str:
        if self.headline_flips:
            return " Whether every wire keeps every filament hangs on the law."
        return " The headline is the same under both."


def _open(loops: int, woven: int) -> str:
    """Count what is open to the law."""
    parts = [
        f"{count} {name if count == 1 else many}"
        for count, name, many in ((loops, "loop", "loops"), (woven, "piece in the weave", "pieces in the weave"))
        if count
    ]
    return f"Open to the law: {' and '.join(parts) or 'none'}."


def _expected(damage: FailureResult | None) -> dict[str, float]:
    """Return the expected numbers of wires, where the garment was judged as a whole."""
    if damage is None or damage.reliability is None:
        return {}
    found = damage.reliability.report()
    return {name: found[name] for name in ("expected_wires_broken", "expected_wires_open")}


def keeps_all_of(damage: FailureResult) -> bool:
    """Tell whether every wire of the garment keeps every filament, as the headline says it."""
    reliability = None if damage.reliability is None else damage.reliability.report()
    return keeps_all(wire_rows(damage), reliability)


def parts_of(damage: FailureResult) -> dict[tuple[int, int, bool], dict[str, Any]]:
    """Return loops and woven pieces by (wire, number, whether in the weave)."""

    def places() -> Iterator[tuple[tuple[int, int, bool], dict[str, Any]]]:
        for row in wire_rows(damage):
            for woven, parts in ((False, row["loops"]), (True, row["woven"])):
                for number, part in enumerate(parts):
                    yield (row["wire"], number, woven), {**part, "weft_mm": row["weft_mm"]}

    return dict(places())


def _where(place: tuple[int, int, bool], part: Mapping[str, Any]) -> dict[str, Any]:
    """Return where a part is: the loop's number, or the ends of a piece in the weave."""
    wire, _, woven = place
    if woven:
        return {
            "wire": wire,
            "loop": None,
            "weft_mm": part["weft_mm"],
            "from_mm": part["from_mm"],
            "to_mm": part["to_mm"],
        }
    return {"wire": wire, "loop": part["loop"], "weft_mm": part["weft_mm"], "warp_mm": part["warp_mm"]}


def examine(done: Simulation, judge: Judge, damage: FailureResult | None) -> LawExtrapolation:
    """Return how far the laws were used, and follow their continuations when wires are judged beyond their range."""
    built = done.built
    limit, ways = identified_to(built), reached_in(done.results, built)
    over = np.flatnonzero((ways > limit).any(axis=1))
    continued: dict[str, Continued] = {}
    if damage is not None and len(over) and not done.trouble:
        continued = {way: follow(built, done.results, judge, way=way, inside=done.inside) for way in WAYS}
    laws = {name: getattr(built.fabric, name).beyond for name in FAMILIES}
    slopes: dict[str, dict[str, float | str]] = {
        name: {way: getattr(law, way) for way in WAYS} for name, law in laws.items()
    }
    return LawExtrapolation(
        identified_to=limit,
        reached=ways[-1] if len(ways) else np.zeros(len(FAMILIES)),
        unit=built.case.motion.unit,
        response="moment_Nmm" if built.worn is not None else "force_N",
        leaves_at=float(done.results.displacement_mm[over[0]]) if len(over) else None,
        slopes=slopes,
        damage=damage,
        continued=continued,
    )


def add_extrapolation(report: dict[str, Any], laws: LawExtrapolation) -> None:
    """Add the block `extrapolation` to a report, and to every loop whether it is open to the law."""
    block = laws.as_dict()
    report["extrapolation"] = block
    hanging = {(part["wire"], part["loop"]) for part in block["verdicts_that_hang_on_it"] if part["loop"] is not None}
    for wire in report["wires"]:
        for loop in wire["loops"]:
            loop["open_to_the_law"] = (wire["wire"], loop["loop"]) in hanging
