"""The seal of a report: a hash over its own content, by which a report that was changed or torn is known."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any


SEAL = "seal"
"""Key of the hash, the last of a report."""


def sealed(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return a report (JSON types) with the hash of all its other keys, whatever their order."""
    return {**_content(report), SEAL: _digest(report)}


def broken(report: Mapping[str, Any]) -> bool:
    """Tell whether a report is not as it was sealed; one without a seal is not broken."""
    return SEAL in report and report[SEAL] != _digest(report)


def _content(report: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in report.items() if key != SEAL}


def _digest(report: Mapping[str, Any]) -> str:
    text = json.dumps(_content(report), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
