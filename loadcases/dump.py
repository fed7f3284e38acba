"""Models written back as YAML that reads to the same model: the canonical text of a case and of a fabric."""

from __future__ import annotations

import io
from typing import Any

from pydantic import BaseModel
from ruamel.yaml import YAML


def dump(model: BaseModel, *, unset: bool = True) -> str:
    """Return a model as block-style YAML in the order of its fields; `unset=False` leaves out what is None."""
    yaml: Any = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False
    yaml.allow_unicode = True
    yaml.width = 100_000
    stream = io.StringIO()
    yaml.dump(_plain(model.model_dump(exclude_none=not unset)), stream)
    return stream.getvalue()


def _plain(value: Any) -> Any:
    """Return nested data with lists for tuples, which YAML does not know."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return float(value) if isinstance(value, float) else value
