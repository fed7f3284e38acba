"""The pages on file formats, made from the code: JSON Schemas of case, fabric and wire, and the layout of result files.

They are written into the stage of the build before Sphinx looks for pages, so no table of keys is kept by hand.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sphinx.application import Sphinx

import etextile as et
from etextile.results import layout
from loadcases.json_schema import json_schema


Schema = dict[str, Any]

INTRODUCTIONS = {
    "case": (
        "A case file is YAML and holds one simulation from the fabric to the pictures. It is read strictly: keys that "
        "are unknown or stand twice are errors, and all mistakes are reported at once with their lines. "
        "Plain numbers are mm, N, MPa and s; text may carry a unit (`30 mm`, `7 %`, `0.35 GPa`). "
        "`extends` lays a file over another or over a shipped case. `etextile schema > case.schema.json` writes this "
        "page as a JSON Schema, with which an editor completes and checks."
    ),
    "fabric": (
        "A fabric file holds the laws of the three truss families, the cell and where the numbers come from. A case "
        "names it as `fabric.set`; `etextile identify` writes one. `etextile list fabrics -v` prints the shipped ones. "
        "Schema: `etextile schema fabric`."
    ),
    "wire": (
        "A wire file holds the copper of the filaments and its numbers with their sources. A case names it as "
        "`wires.material`; `etextile list wires -v` prints the shipped ones. Schema: `etextile schema wire`."
    ),
}
GROUPS = (
    ("VTKHDF/PointData", "of every point", layout.POINT_ARRAYS),
    ("VTKHDF/CellData", "of every truss and wire element", (*layout.CELL_ARRAYS, *layout.CELL_LABELS)),
    ("etextile/lattice", "the undeformed piece", layout.LATTICE),
    ("etextile/body", "the body that is pressed in", layout.BODY),
    ("etextile/skin", "how the surface of a skinned limb bends", layout.SKIN),
    ("etextile/wires", "the wires and their loops", layout.WIRES),
    ("etextile/histories", "of every loop over the increments", layout.HISTORIES),
    ("etextile/increments", "one entry per converged increment", layout.INCREMENTS),
)
EXAMPLE = 48
TYPES = {
    dict: "section",
    list: "list",
    str: "text",
    float: "number",
    int: "integer",
    bool: "true or false",
    type(None): "null",
}


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages before Sphinx collects what there is."""
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(app: Sphinx) -> None:
    """Write every page whose text has changed."""
    folder = Path(app.srcdir) / "formats"
    pages = {f"{kind}.md": schema_page(kind) for kind in INTRODUCTIONS}
    pages |= {"results.md": results_page(), "report.md": report_page()}
    for name, text in pages.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def schema_page(kind: str) -> str:
    """Return the page on a kind of file: a table of its keys, then one for every part that has keys of its own."""
    schema = json_schema(kind)
    definitions = schema.get("$defs", {})
    parts = [f"# {kind.capitalize()} file\n", INTRODUCTIONS[kind] + "\n", *_table(schema, kind)]
    for name, part in sorted(definitions.items(), key=lambda item: _place(schema, item[0])):
        if part.get("properties"):
            parts += [
                f"\n({kind}-{name.lower()})=\n## {name}\n",
                part.get("description", "") + "\n",
                *_table(part, kind),
            ]
    return "\n".join(parts) + "\n"


def results_page() -> str:
    """Return the page on `results.vtkhdf`."""
    version = ".".join(map(str, layout.VERSION))
    vtkhdf = ".".join(map(str, layout.VTKHDF_VERSION))
    parts = [
        "# Result file\n",
        f"`{layout.FILE_NAME}` is HDF5 in the VTKHDF format {vtkhdf} (an unstructured grid of line cells with time "
        "steps), which ParaView and pyvista open; a group `etextile` beside it holds what these have no word for. "
        f"Format `{layout.FORMAT}`, version {version}: a reader refuses another major number, the minor number grows "
        "when arrays are added. Every array carries its `unit` and `description` as attributes. The file is valid "
        "after every converged increment, so an interrupted run can be read and goes on with `--resume`.\n",
    ]
    for group, meaning, arrays in GROUPS:
        parts += [
            f"\n## {group}\n",
            f"{meaning[0].upper()}{meaning[1:]}.\n",
            "| array | unit | type | meaning |",
            "|---|---|---|---|",
        ]
        parts += [f"| `{q.name}` | {q.unit or '–'} | {_array_type(q)} | {q.description} |" for q in arrays]
    return "\n".join(parts) + "\n"


def _array_type(quantity: layout.StoredQuantity) -> str:
    """Return number type and shape of one entry."""
    kind = "text" if quantity.dtype.startswith("S") else quantity.dtype
    return f"{kind} ({', '.join(map(str, quantity.shape))})" if quantity.shape else kind


def _place(schema: Schema, name: str) -> tuple[int, str]:
    """Return where a definition is first used among the keys of the file, for the order of the page."""
    for order, item in enumerate(schema.get("properties", {}).values()):
        if name in _references(item):
            return order, name
    return len(schema.get("properties", {})), name


def _table(part: Schema, kind: str) -> Iterator[str]:
    """Yield the lines of the table of a part's keys."""
    yield "| key | value | default | meaning |"
    yield "|---|---|---|---|"
    for key, item in part.get("properties", {}).items():
        meaning = _cell(item.get("description", ""))
        if origin := item.get("origin"):
            meaning += f" *{_cell(origin)}*"
        yield f"| `{key}` | {_cell(_value(item, kind))} | {_default(item)} | {meaning} |"


def _default(item: Schema) -> str:
    """Return the default as YAML would have it; nested defaults stand in the table of the part."""
    if "default" not in item:
        return ""
    value = item["default"]
    if value is None:
        return "`null`"
    if isinstance(value, dict):
        return "see below"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`" if value != "" else "empty"


def _value(item: Schema, kind: str) -> str:
    """Return in words what a key accepts."""
    unit = f", {item['unit']}" if item.get("unit") not in (None, "1", "") else ""
    if "$ref" in item:
        name = item["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{kind}-{name.lower()})"
    if "const" in item:
        return f"`{item['const']}`"
    if "enum" in item:
        return " ".join(f"`{choice}`" for choice in item["enum"])
    for choice in ("anyOf", "oneOf"):
        if choice in item:
            return (
                " or ".join(_distinct(_value(option, kind) for option in item[choice] if not _is_text(option))) + unit
            )
    if item.get("type") == "array":
        return _array(item, kind)
    if item.get("type") == "object":
        return _mapping(item, kind)
    found = item.get("type", "anything")
    return f"{' or '.join(found) if isinstance(found, list) else found}{_bounds(item)}{unit}"


def _is_text(option: Schema) -> bool:
    """Whether an option only says that a number may be text with a unit, which holds everywhere."""
    return option.get("type") == "string" and "pattern" in option


def _array(item: Schema, kind: str) -> str:
    """Return in words what a list holds."""
    if "prefixItems" in item:
        inner = _distinct(_value(entry, kind) for entry in item["prefixItems"])
        return f"list of {len(item['prefixItems'])}: {', '.join(inner)}"
    return f"list of {_value(item.get('items', {}), kind)}"


def _mapping(item: Schema, kind: str) -> str:
    """Return in words what a mapping holds."""
    if inner := item.get("properties"):
        return "{" + ", ".join(f"`{key}`: {_value(entry, kind)}" for key, entry in inner.items()) + "}"
    extra = item.get("additionalProperties")
    return f"mapping to {_value(extra, kind)}" if isinstance(extra, dict) and extra else "mapping"


def _bounds(item: Schema) -> str:
    """Return the bounds of a number."""
    words = (("minimum", ">="), ("exclusiveMinimum", ">"), ("maximum", "<="), ("exclusiveMaximum", "<"))
    found = [f"{sign} {item[key]:g}" for key, sign in words if key in item]
    return f" {' and '.join(found)}" if found else ""


def _distinct(words: Iterable[str]) -> list[str]:
    """Return the words without repetition, in order."""
    return list(dict.fromkeys(words))


def _references(item: Any) -> set[str]:
    """Return the names of all definitions that a part of a schema refers to."""
    if isinstance(item, dict):
        own = {item["$ref"].rsplit("/", 1)[1]} if "$ref" in item else set()
        return own.union(*(_references(part) for part in item.values()))
    return set().union(*(_references(part) for part in item)) if isinstance(item, list) else set()


def _cell(text: str) -> str:
    """Return text that may stand in a table."""
    return text.replace("|", r"\|").replace("\n", " ")


def report_page() -> str:
    """Return the page on report.json: every key that a run of the punch writes, with an example of its value."""
    with TemporaryDirectory() as folder:
        case = et.load("punch", {"motion.total": "25 mm", "motion.steps": 5, "fabric.coarsening": 25})
        report = et.run(case, Path(folder) / "run").report
    lines = [
        "# report.json\n",
        "`report.json` holds what the report says, as a run of the case `punch` writes it. `[]` stands for every entry "
        "of a list. Programs may rely on these keys; more may be added, and other cases have more: `joint` where a "
        "joint bends, `pressure` where one is applied, `life` where a load returns.\n",
        "| key | type | for example |",
        "|---|---|---|",
    ]
    return "\n".join([*lines, *(f"| `{key}` | {kind} | {text} |" for key, kind, text in _leaves(report, ""))]) + "\n"


def _leaves(value: Any, key: str) -> Iterator[tuple[str, str, str]]:
    """Yield key, type and an example of every value below a key; lists of sections by their first entry."""
    if isinstance(value, Mapping):
        for name, item in value.items():
            yield from _leaves(item, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list) and value and isinstance(value[0], Mapping):
        yield from _leaves(value[0], f"{key}[]")
    else:
        text = json.dumps(value, ensure_ascii=False)
        shown = text if len(text) <= EXAMPLE else f"{text[: EXAMPLE - 1]}…"
        yield key, TYPES.get(type(value), type(value).__name__), f"`{shown}`" if "|" not in shown else ""
