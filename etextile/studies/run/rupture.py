"""Where on its path a run tears the first yarn, from the rupture strains of the fabric and their spread.

The path goes on with yarns that do not break, so what follows the first rupture is no prediction, and the run says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from etextile.types import Array
from loadcases.build import Built
from loadcases.measured import Measured
from wires.axis import axis_of


FAMILIES = ("warp", "weft")
QUANTILE = 1.96
"""Standard deviations of the rupture strain on both sides of a 95 % interval."""


def rupture_block(report: Mapping[str, Any], built: Built) -> dict[str, Any] | None:
    """Return the first rupture on the path, None for a fabric that states no rupture strain.

    `passed`: whether a family reaches its mean rupture strain; `first`: family and values of the path there
    (displacement_mm, force_N, with a load also its own), `low` and `high` those at the 2.5 and 97.5 % quantile of the
    rupture strain, null where the path ends before; `reached`: greatest strain over rupture strain of each family.
    """
    known = {name: item for name in FAMILIES if (item := getattr(built.fabric, name).rupture_strain) is not None}
    if not known:
        return None
    path = _path(report)
    strain = {name: np.array([0.0, *report["strain"][f"{name}_max"]]) for name in known}
    found = {name: _place(strain[name], item.value) for name, item in known.items()}
    places = {name: place for name, place in found.items() if place is not None}
    first = min(places, key=lambda name: places[name]) if places else max(
        known, key=lambda name: float(strain[name].max()) / known[name].value
    )  # fmt: skip
    return {
        "passed": bool(places),
        "first": None if not places else {"family": first, **_at(path, places[first])},
        **_bounds(path, strain, known),
        "reached": {name: float(strain[name].max()) / item.value for name, item in known.items()},
        "strain": {name: _stated(item) for name, item in known.items()},
    }


def rupture_note(block: Mapping[str, Any]) -> str | None:
    """Return what a reader must know of a run that goes past the first rupture."""
    first = block["first"]
    if first is None:
        return None
    family = first["family"]
    stated = block["strain"][family]
    guess = ", an estimate" if stated["estimated"] else ""
    load = f"{first['pressure_bar']:.3g} bar, " if "pressure_bar" in first else ""
    place = f"{first['angle_deg']:.3g} deg" if "angle_deg" in first else f"{first['displacement_mm']:.3g} mm"
    load += f"{first['gauge_bar']:.3g} bar on the gauge, " if "gauge_bar" in first else ""
    return (
        f"a {family} yarn reaches its rupture strain ({100 * stated['value']:.3g} %{guess}) at {load}"
        f"{place}; the path goes on as if no yarn broke, what follows is no prediction"
    )


def _stated(item: Measured) -> dict[str, Any]:
    return {"value": item.value, "std": item.std, "estimated": item.estimated or item.source is None}


def _path(report: Mapping[str, Any]) -> dict[str, Array]:
    """Return what a place on the path is described by, from the flat piece on."""
    axis = axis_of(report)
    columns = {axis.key: axis.values(report), axis.response_key: axis.responses(report)}
    if "pressure" in report:
        block = report["pressure"]
        columns |= {name: block[name] for name in ("pressure_bar", "diaphragm_bar", "gauge_bar") if name in block}
    return {name: np.array([0.0, *values]) for name, values in columns.items()}


def _place(strain: Array, limit: float) -> float | None:
    """Return where on the path (in steps) a strain first reaches the limit, None when it does not."""
    over = np.flatnonzero(strain >= limit)
    if not len(over):
        return None
    after = int(over[0])
    if after == 0:
        return 0.0
    return after - 1 + float((limit - strain[after - 1]) / (strain[after] - strain[after - 1]))


def _at(path: Mapping[str, Array], place: float | None) -> dict[str, float]:
    """Return the values of the path at a place."""
    if place is None:
        return {}
    return {name: float(np.interp(place, np.arange(len(values)), values)) for name, values in path.items()}


def _bounds(
    path: Mapping[str, Array], strain: Mapping[str, Array], known: Mapping[str, Measured]
) -> dict[str, dict[str, float] | None]:
    """Return the places of the first rupture when all yarns break early (low) or late (high); None without spread."""
    if any(item.std is None for item in known.values()):
        return {"low": None, "high": None}
    ends: dict[str, dict[str, float] | None] = {}
    for name, sign in (("low", -1.0), ("high", 1.0)):
        limits = {key: item.value + sign * QUANTILE * float(item.std or 0.0) for key, item in known.items()}
        places = [_place(strain[key], limit) for key, limit in limits.items()]
        reached = [place for place in places if place is not None]
        ends[name] = _at(path, min(reached)) if reached else None
    return ends
