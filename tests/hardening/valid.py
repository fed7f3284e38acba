"""Random cases that are all valid, over bodies, frictions, specimens, wires and effects: each ends, or says why not.

Lattices are coarse and ways short, so that a case takes a second or two; that such a lattice passes a trust limit is
one of the right answers. What is never right: a report with a number that is none, an end without a reason.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import isolated
import numpy as np
import trimesh
from kills import Take
from mutate import Random, dumped

import etextile as et
from etextile.effects.registry import EFFECTS
from etextile.studies.run import run as runner
from wires.failure import CRITERIA


FABRICS = ("estimated_low", "estimated_mid", "estimated_high", "nylon_woven", "valmex_7318")
CELLS = (5, 13)
"""Lattice cells along the longest side, from and below."""
KINDS = ("body", "body", "body", "tension", "pressure", "weight", "worn")
WORN = ["compression_carry", "pretension", "punch_friction", "rate_dependence", "yarn_damage", "yarn_tail"]
WITHOUT_BODY = sorted(set(EFFECTS) - {"datum_offset", "machine_compliance", "geometry", "punch_friction"})
STRAIGHT = ("clamp_slip", "clamp_compliance", "yarn_sliding")
"""Effects that act on a worn piece, without a body, on straight clamps alone."""
PAGES = 8
"""Of so many cases one has its page drawn."""


def case(rng: Random, mesh: str) -> dict[str, Any]:
    """Return a random valid case; `mesh` is the file of a ball of 15 mm radius."""
    kind = KINDS[int(rng.integers(len(KINDS)))]
    made: dict[str, Any] = {"schema_version": 1, "title": f"random {kind}", "outputs": {"maps": []}}
    made |= _worn(rng) if kind == "worn" else _flat(rng, kind, mesh)
    turned = made["fabric"].get("warp_angle", 0.0) != 0.0
    made["wires"] = None if turned or kind in ("weight", "pressure") else _wires(rng)
    made["contact"] = {"friction": (0, float(rng.uniform(0.05, 1.0)), "stick")[int(rng.integers(3))]}
    made["failure"] = {"criterion": str(rng.choice(sorted(CRITERIA)))}
    made["effects"] = _effects(rng, kind)
    if kind == "weight" and "bending_stiffness" not in [item["id"] for item in made["effects"]]:
        made["effects"] += [{"id": "bending_stiffness", **_parameters("bending_stiffness", rng)}]
    return made


def _flat(rng: Random, kind: str, mesh: str) -> dict[str, Any]:
    """Return a flat piece that a body, a clamp, a pressure or its own weight loads."""
    size = [float(rng.uniform(40.0, 200.0)) for _ in range(2)]
    fabric: dict[str, Any] = {"set": str(rng.choice(FABRICS)), "size": size}
    step = int(rng.integers(3, 7))
    if kind == "body":
        body = _body(rng, size, mesh)
        quarter = body["type"] not in ("mesh", "elbow", "knee") and rng.random() < 0.5
        fabric["portion"] = "quarter" if quarter else "whole"
        clamped = (["x_min", "x_max"], ["y_min", "y_max"], ["outline"])[int(rng.integers(3))]
        motion = {"total": float(rng.uniform(0.1, 0.4)) * min(size), "steps": step}
        if fabric["portion"] == "whole":
            fabric["warp_angle"] = float(rng.choice([0.0, 30.0, 45.0, 90.0]))
        if rng.random() < 0.3:
            motion["path"] = [motion["total"], 0.5 * motion["total"]]
    elif kind == "tension":
        clamped, body = ["x_min", "x_max"], None
        fabric |= {"portion": "whole", "warp_angle": float(rng.choice([0.0, 45.0, 90.0, rng.uniform(0.0, 90.0)]))}
        motion = {"target": "x_max", "total": float(rng.uniform(0.02, 0.25)) * size[0], "steps": step}
    elif kind == "pressure":
        clamped, body, radius = ["outline"], None, float(rng.uniform(20.0, 60.0))
        fabric |= {"size": [2.0 * radius, 2.0 * radius], "portion": "quarter", "outline": {"circle": radius}}
        motion = {"target": "pressure", "total": float(rng.uniform(0.2, 5.0)), "steps": step}
    else:
        clamped, body = ["x_min"], None
        fabric |= {"size": [float(rng.uniform(40.0, 120.0)), 25.0], "portion": "whole", "compression_ratio": 1}
        motion = {"target": "weight", "total": float(rng.uniform(50.0, 400.0)), "steps": step}
    fabric["coarsening"] = _coarsening(fabric, rng)
    return {"fabric": fabric, "supports": {"clamped": clamped}, "motion": motion} | ({"body": body} if body else {})


def _coarsening(fabric: dict[str, Any], rng: Random) -> float:
    """Return the coarsening that gives a lattice of a few cells."""
    cell = et.build(et.load("punch", {"fabric.set": fabric["set"], "wires": None})).fabric.cell
    longest = max(length / width for length, width in zip(fabric["size"], cell, strict=True))
    return round(max(1.0, longest / float(rng.integers(*CELLS))), 2)


def _body(rng: Random, size: list[float], mesh: str) -> dict[str, Any]:
    """Return one of all bodies, on the middle of the piece or beside it."""
    r = float(rng.uniform(0.15, 0.35)) * min(size)
    bodies: list[dict[str, Any]] = [
        {"type": "sphere", "radius": r},
        {"type": "ellipsoid", "semi_axes": [1.4 * r, r, 0.8 * r]},
        {"type": "capsule", "radius": r, "length": r},
        {"type": "mesh", "file": mesh, "scale": r / 15.0},
        {"type": "elbow", "flexion": float(rng.uniform(60.0, 150.0))},
        {"type": "knee", "flexion": float(rng.uniform(60.0, 140.0))},
    ]
    return bodies[int(rng.integers(len(bodies)))]


def _worn(rng: Random) -> dict[str, Any]:
    """Return a sleeve or a pad on a limb that bends a little."""
    shape = str(rng.choice(["tube", "panel"]))
    joint = str(rng.choice(["elbow", "knee"]))
    fabric: dict[str, Any] = {"set": str(rng.choice(FABRICS[:3])), "shape": shape, "portion": "half", "coarsening": 65}
    fabric |= {"size": [200.0, None], "ease": float(rng.uniform(0.0, 0.1))} if shape == "tube" else {"size": [160, 120]}
    ends = [str(rng.choice(["held", "band"])) for _ in range(2)] if shape == "tube" else ["held", "held"]
    return {
        "fabric": fabric, "supports": {"ends": ends}, "body": {"type": "limb", "joint": joint},
        "motion": {"target": "joint", "flexion": float(rng.uniform(5.0, 25.0)), "steps": int(rng.integers(2, 4))},
    }  # fmt: skip


def _wires(rng: Random) -> dict[str, Any] | None:
    """Return a comb of wires, with loops or without, held or slipping; None for a piece without wires."""
    if rng.random() < 0.25:
        return None
    spacing, length = float(rng.uniform(10.0, 30.0)), float(rng.uniform(2.0, 6.0))
    loops: dict[str, Any] | None = {
        "spacing": spacing, "length": length, "slack": float(rng.uniform(0.0, 0.1)), "offset": float(rng.uniform(0, 5)),
        "component": float(rng.choice([0.0, 0.2])) * length,
    }  # fmt: skip
    return {
        "every_warp_yarns": float(rng.uniform(40.0, 200.0)), "first_offset": float(rng.uniform(0.0, 5.0)),
        "material": str(rng.choice(["copper_soft", "copper_drawn"])), "filaments": int(rng.integers(1, 20)),
        "filament_diameter": float(rng.uniform(0.02, 0.06)), "loops": None if rng.random() < 0.2 else loops,
        "bond": "perfect" if rng.random() < 0.6 else {"line_friction": float(10.0 ** rng.uniform(-2, 0))},
    }  # fmt: skip


def _effects(rng: Random, kind: str) -> list[dict[str, Any]]:
    """Return up to two effects that act in such a test, their parameters anywhere in the usual range."""
    acting = WITHOUT_BODY if kind not in ("body", "worn") else WORN if kind == "worn" else sorted(EFFECTS)
    acting = [name for name in acting if kind != "pressure" or name not in STRAIGHT]
    names = rng.choice(acting, size=int(rng.integers(0, 3)), replace=False)
    return [{"id": str(name), **_parameters(str(name), rng)} for name in names]


def _parameters(name: str, rng: Random) -> dict[str, float]:
    found = {}
    for item in EFFECTS[name].card.parameters:
        share = float(rng.random())
        log = item.scale == "log" and item.low > 0.0
        value = item.low * (item.high / item.low) ** share if log else item.low + share * (item.high - item.low)
        found[item.name] = value
    return found


def cases(folder: Path, numbers: Iterator[int], seed: int, take: Take) -> Counter[str]:
    """Run random valid cases; return how many converged with trust, passed a limit, ended early, were refused."""
    trimesh.creation.icosphere(subdivisions=3, radius=15.0).export(folder / "ball.stl")
    counts = Counter[str]()
    for number in numbers:
        rng = np.random.default_rng((seed, 8, number))
        path, out = folder / "case.yaml", folder / f"out_{number}"
        path.write_bytes(dumped(case(rng, "ball.stl")))
        before = None if number % PAGES == 0 else _without_page
        done = isolated.verb(["run", str(path), "-o", str(out), "--quiet"], before=before)
        counts[WORDS.get(done.code, "other")] += 1
        take(done, str(number), lie=untold(done, out))
    return counts


WORDS = {0: "trusted", 4: "beyond a limit of trust", 3: "without equilibrium", 2: "refused"}


def _without_page() -> None:
    """Draw no page: what counts is the report."""
    nothing: Callable[..., None] = lambda *_, **__: None  # noqa: E731
    vars(runner).update(live_scenes=nothing, write_page=nothing)


def untold(done: isolated.Ended, out: Path) -> str:
    """Say what is wrong with the report of a run, or that it ended without a reason."""
    if done.code == 2:
        return "" if done.said.strip() else "refused without a word"
    if done.code not in WORDS:
        return ""
    try:
        report = json.loads((out / "report.json").read_text(encoding="utf-8"), parse_constant=_refuse)
    except (OSError, ValueError) as error:
        return f"no strict report: {error}"
    trust = report["trust"]
    if done.code == 0:
        return "" if trust["ok"] and report["solver"]["all_converged"] else "trusted without reason"
    said = trust["limits"] and all(item["sentence"] for item in trust["limits"]) and report["verdict"]["withheld"]
    return "" if said and (done.code == 4 or report["solver"]["all_converged"] is False) else "no reason is given"


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number" if not math.isfinite(float(word)) else word)
