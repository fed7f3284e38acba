"""The seal of a report: a hash over its own content, by which a report that was changed or torn is known."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any


SEAL = "seal"
"""Key of the hash, the last of a report."""
TIMES = ("wall_s", "solve_s")
"""What a report tells of the solver's time is not sealed: equal runs have equal seals."""


def sealed(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return a report (JSON types) with the hash of all its other keys, whatever their order, but for times."""
    return {**{key: value for key, value in report.items() if key != SEAL}, SEAL: _digest(report)}


def broken(report: Mapping[str, Any]) -> bool:
    """Tell whether a report is not as it was sealed; one without a seal is not broken."""
    return SEAL in report and report[SEAL] != _digest(report)


def _content(report: Mapping[str, Any]) -> dict[str, Any]:
    found = {key: value for key, value in report.items() if key != SEAL}
    solver = found.get("solver")
    if isinstance(solver, Mapping):
        found["solver"] = {key: value for key, value in solver.items() if key not in TIMES}
    return found


def _digest(report: Mapping[str, Any]) -> str:
    text = json.dumps(_content(report), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
