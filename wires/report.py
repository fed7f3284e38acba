"""The reliability report as plain data: what `report.json` holds.

Text, page and maps are drawn from this dictionary alone. Numbers that do not exist are null, never NaN. When a trust
limit is exceeded the verdict is withheld: `verdict.withheld` is true and `verdict.survive` null, while the states stay
in the table as what the model says, to be read as provisional.

A quarter or half stands for the whole specimen: verdict and counts are those of the whole, the table lists what is
modelled, and `copies` says how many wires or loops of the specimen a row stands for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from etextile.results.wire_layout import KINDS
from etextile.types import IntArray
from etextile.vocabulary import STATES
from wires.axis import JOINT, PUNCH
from wires.bending import stress_raiser
from wires.construction import laid
from wires.damage import FailureResult
from wires.facts import CaseFacts, RunCurves, SolverFacts, WireFacts, WornFacts
from wires.failure import CRITERIA
from wires.life import Life
from wires.report_files import plain
from wires.trust import TrustCheck, exceeded, trusted
from wires.verdict import verdict


REPORT_VERSION = 1


def build_report(
    *,
    case: CaseFacts,
    curves: RunCurves,
    solver: SolverFacts,
    checks: Sequence[TrustCheck],
    damage: FailureResult | None = None,
    wires: WireFacts | None = None,
    versions: Mapping[str, str] | None = None,
    notes: Iterable[str] = (),
    electrical: Mapping[str, Any] | None = None,
    worn: WornFacts | None = None,
    life: Life | None = None,
    parts: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """Return the report of a run; `damage` is None when there are no wires, `notes` are remarks for the reader.

    `electrical` are the keys of `wires.electrical`, `life` adds to the loops and is the block of that name, `parts`
    are the rows of `wires.part_rows`. A worn case has its curves in `joint`, none in `punch`.
    """
    rows = [] if damage is None else wire_rows(damage, life)
    if worn is not None:
        rows = over_angle(rows, worn.folded)
    reliability = None if damage is None else _reliability(damage, (electrical or {}).get("nets", ()))
    ok = trusted(checks)
    report = {
        "report_version": REPORT_VERSION,
        "case": asdict(case),
        "verdict": verdict(
            rows,
            reliability=reliability,
            life=None if life is None else life.block,
            exceeded=exceeded(checks),
        ),
        **_motion(curves, worn),
        "strain": {
            "warp_max": curves.warp_max,
            "weft_max": curves.weft_max,
            "diagonal_max": curves.diagonal_max,
        },
        "solver": asdict(solver),
        "wires": rows,
        "parts": list(parts),
        "reliability": reliability,
        "wire_model": None if wires is None else {**asdict(wires), **({} if damage is None else laid(damage.layout))},
        "failure": None if damage is None else _criterion(damage),
        "damage": None if damage is None else _over_displacement(damage, worn=worn is not None),
        "loop_damage": None if damage is None else _loops_over_displacement(damage, worn=worn is not None),
        "trust": {
            "ok": ok,
            "limits": [_check(check) for check in checks if not check.ok],
            "checks": [_check(check) for check in checks],
        },
        "notes": list(notes),
        "versions": dict(versions or {}),
        "life": None if life is None else life.block,
        **(electrical or {"resistance": None, "nets": []}),
    }
    cleaned: dict[str, Any] = plain(report)
    return cleaned


def _motion(curves: RunCurves, worn: WornFacts | None) -> dict[str, Any]:
    """Return the blocks of the motion: punch and free edge, or joint, skin, putting on and weak hold."""
    if worn is None:
        return {
            "punch": {"displacement_mm": curves.displacement_mm, "force_N": curves.force_N},
            "edge": {"displacement_mm": curves.displacement_mm, "draw_in_mm": curves.draw_in_mm},
        }
    own = {"angle_deg": curves.displacement_mm, "moment_Nmm": curves.force_N, "slip_mm": curves.draw_in_mm}
    return {
        "punch": {"displacement_mm": [], "force_N": []},
        "edge": {"displacement_mm": [], "draw_in_mm": []},
        "joint": {**own, **worn.joint},
        "contact": worn.contact,
        "donning": worn.donning,
        "weak_hold": worn.hold,
    }


def over_angle(rows: Sequence[Mapping[str, Any]], folded: Sequence[bool] | np.ndarray) -> list[dict[str, Any]]:
    """Return rows of wires of a worn case: failures at angles (0 for those while it is put on), loops in folds told."""
    number = iter(folded)

    def turned(row: Mapping[str, Any]) -> dict[str, Any]:
        at = row["first_failure_mm"]
        return {**row, "first_failure_mm": None, "first_failure_deg": None if at is None else max(at, 0.0)}

    return [
        {
            **turned(wire),
            "woven": [turned(piece) for piece in wire["woven"]],
            "loops": [{**turned(loop), "folded": bool(next(number))} for loop in wire["loops"]],
        }
        for wire in rows
    ]


def wire_rows(damage: FailureResult, life: Life | None = None) -> list[dict[str, Any]]:
    """Return one row per wire, each with its loops, in the order of the layout."""
    layout = damage.layout
    loops = [{**row, **({} if life is None else life.loop(loop))} for loop, row in enumerate(_loop_rows(damage))]
    rows = []
    for wire in range(layout.n_wires):
        own = [loops[loop] for loop in np.flatnonzero(layout.loop_wire == wire)]
        worst = max(own, key=lambda row: (STATES.index(row["state"]), row["max_strain"]), default=None)
        rows.append(
            {
                "wire": wire,
                "name": layout.names[wire],
                "lies": KINDS[layout.kind[wire]],
                "weft_mm": layout.weft_mm[wire],
                "state": STATES[damage.wire_state[wire]],
                "first_failure_mm": damage.wire_first_failure_mm[wire],
                "max_strain": damage.wire_max_strain[wire],
                "failure_probability": damage.wire_failure_probability[wire],
                "open_probability": damage.wire_open_probability[wire],
                "filaments_broken": damage.wire_broken[wire],
                "strain_kind": damage.strain_kind,
                "worst_loop": None if worst is None else worst["loop"],
                "woven": _woven_rows(damage, wire),
                "copies": layout.wire_copies[wire],
                "loops": own,
            }
        )
    cleaned: list[dict[str, Any]] = plain(rows)
    return cleaned


def _loop_rows(damage: FailureResult) -> list[dict[str, Any]]:
    """Return one row per loop."""
    layout = damage.layout
    return [
        {
            "loop": layout.loop_index[loop],
            "warp_mm": layout.loop_warp_mm[loop],
            "weft_mm": layout.loop_weft_mm[loop],
            "state": STATES[damage.loop_state[loop]],
            "first_failure_mm": damage.first_failure_mm[loop],
            "max_strain": damage.max_strain[loop],
            "strain_kind": damage.strain_kind,
            "filaments_broken": damage.loop_broken[loop],
            "failure_probability": damage.failure_probability[loop],
            "open_probability": damage.open_probability[loop],
            "slack": layout.loop_slack[loop],
            "copies": layout.loop_copies[loop],
            **_filaments(damage, loop),
        }
        for loop in range(layout.n_loops)
    ]


def _filaments(damage: FailureResult, loop: int) -> dict[str, Any]:
    """Return what criteria that look at filaments and at bending know beyond the others."""
    more: dict[str, Any] = {}
    if damage.exit_strain is not None:
        more["exit_bending_strain"] = damage.exit_strain[loop]
        more["stress_raiser"] = stress_raiser(damage.max_strain[loop], damage.exit_strain[loop])
    if damage.broken_counts is not None:
        more["broken_count_probabilities"] = damage.broken_counts[loop]
    return more


def _woven_rows(damage: FailureResult, wire: int) -> list[dict[str, Any]]:
    """Return one row per woven-in piece of a wire, none where the criterion does not look at them."""
    woven = damage.woven
    if woven is None:
        return []
    pieces = woven.pieces
    middle = damage.layout.places(pieces.wire, 0.5 * (pieces.start_mm + pieces.end_mm))
    return [
        {
            "from_mm": pieces.start_mm[piece],
            "to_mm": pieces.end_mm[piece],
            "warp_mm": middle[piece, 0],
            "weft_mm": middle[piece, 1],
            "state": STATES[woven.state[-1, piece]],
            "first_failure_mm": woven.first_failure_mm[piece],
            "max_strain": woven.max_strain[piece],
            "failure_probability": woven.failure_probability[piece],
            "open_probability": woven.open_probability[piece],
            "copies": pieces.copies[piece],
        }
        for piece in np.flatnonzero(pieces.wire == wire)
    ]


def _reliability(damage: FailureResult, nets: Iterable[Mapping[str, Any]]) -> dict[str, Any] | None:
    """Return the garment as a whole, with the nets of the case; None for damage that was not judged."""
    if damage.reliability is None:
        return None
    lost = [
        {"name": net["name"], "p_lost": net["loss_probability"], "low": net["low"], "high": net["high"]} for net in nets
    ]
    return {**damage.reliability.report(), "strain_kind": damage.strain_kind, "nets": lost}


def _criterion(damage: FailureResult) -> dict[str, Any]:
    """Return the criterion with the origin and source of every number."""
    known = CRITERIA[damage.criterion]
    parameters = {}
    for parameter in known.parameters:
        value = damage.parameters[parameter.name]
        default = value == parameter.default
        parameters[parameter.name] = {
            "value": value,
            "unit": parameter.unit,
            "origin": parameter.origin if default else "case",
            "source": parameter.source if default else f"set in the case (default {parameter.default:g})",
        }
    judged = "loops" if damage.woven is None else "loops and weave"
    return {
        "criterion": known.name,
        "summary": known.summary,
        "ignores": getattr(known, "ignores", ""),
        "strain_kind": damage.strain_kind,
        "judged": judged,
        "parameters": parameters,
    }


def _over_displacement(damage: FailureResult, *, worn: bool) -> dict[str, Any]:
    """Return how many wires of the whole specimen are in each state, step by step; of a worn case from straight on."""
    states, shown = damage.wire_states, _shown(damage, worn=worn)
    counts = {name: ((states == code) @ damage.layout.wire_copies)[shown] for code, name in enumerate(STATES)}
    return {(JOINT if worn else PUNCH).key: damage.displacement_mm[shown], "wires": counts}


def _shown(damage: FailureResult, *, worn: bool) -> IntArray:
    """Return the steps of the report: all, or those of a joint from where it is straight."""
    return np.flatnonzero(~(worn & (damage.displacement_mm < 0.0)))


def _loops_over_displacement(damage: FailureResult, *, worn: bool) -> dict[str, Any]:
    """Return state and share of broken filaments of every loop of the modelled part, step by step."""
    layout, shown = damage.layout, _shown(damage, worn=worn)
    return {
        (JOINT if worn else PUNCH).key: damage.displacement_mm[shown],
        "wire": layout.loop_wire,
        "loop": layout.loop_index,
        "state": [[STATES[code] for code in damage.state[shown, loop]] for loop in range(layout.n_loops)],
        "filaments_broken": damage.filaments_broken[shown].T,
    }


def _check(check: TrustCheck) -> dict[str, Any]:
    return {**asdict(check), "ok": check.ok, "sentence": check.sentence}
