"""JSON Schema of case, fabric, wire and measured files, for completion and checking in editors.

A file that extends another need not repeat its keys, so keys are required only where `extends` is absent.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from loadcases.fabric import Fabric
from loadcases.schema import Case
from loadcases.schema_measured import MeasuredFolder
from loadcases.wire_material import WireMaterial


DIALECT = "https://json-schema.org/draft/2020-12/schema"
MODELS: dict[str, type[BaseModel]] = {"case": Case, "fabric": Fabric, "wire": WireMaterial, "measured": MeasuredFolder}


def json_schema(kind: str = "case") -> dict[str, Any]:
    """Return the JSON Schema of a kind of file: case, fabric, wire or measured."""
    schema = MODELS[kind].model_json_schema()
    schema = {"$schema": DIALECT, **schema, "title": f"etextile {kind} file"}
    return _with_extends(schema) if kind == "case" else schema


def _with_extends(schema: dict[str, Any]) -> dict[str, Any]:
    """Add `extends` and let it lift every `required`."""
    definitions = schema["$defs"]
    requirements = _requirements(schema, definitions)
    for part in (schema, *(item for name, item in definitions.items() if name != "Effect")):
        part.pop("required", None)  # lists are never merged, so an effect in one is always complete
    schema["properties"]["extends"] = {
        "type": ["string", "null"],
        "description": "Case file or shipped case over which this file is laid.",
    }
    schema["if"] = {"properties": {"extends": {"type": "string"}}, "required": ["extends"]}
    schema["else"] = requirements
    result: dict[str, Any] = _any_of(schema)
    return result


def _requirements(part: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """Return what a schema requires, and nothing else of it."""
    if "$ref" in part:
        return _requirements(definitions[part["$ref"].rsplit("/", 1)[1]], definitions)
    for choice in ("anyOf", "oneOf"):
        options = [(option, _requirements(option, definitions)) for option in part.get(choice, ())]
        if any(required for _, required in options):
            return {"anyOf": [_guarded(option, required, definitions) for option, required in options]}
    inner = {name: _requirements(item, definitions) for name, item in part.get("properties", {}).items()}
    inner = {name: required for name, required in inner.items() if required}
    result: dict[str, Any] = {"required": list(part["required"])} if part.get("required") else {}
    return {**result, "properties": inner} if inner else result


def _guarded(option: dict[str, Any], required: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """Tie the requirements of one option of a union to the value that selects it."""
    if not required:
        return option
    if "$ref" not in option:
        return required
    kind = definitions[option["$ref"].rsplit("/", 1)[1]].get("properties", {}).get("type")
    return {"allOf": [{"properties": {"type": {"const": kind["const"]}}}, required]} if kind else required


def _any_of(part: Any) -> Any:
    """Return a schema with anyOf for oneOf: without required keys a mapping may fit several bodies."""
    if isinstance(part, dict):
        kept = {key: item for key, item in part.items() if key != "discriminator"}
        return {("anyOf" if key == "oneOf" else key): _any_of(item) for key, item in kept.items()}
    return [_any_of(item) for item in part] if isinstance(part, list) else part
