"""Hostile and broken inputs, made from sound ones by a seed: the same number makes the same file."""

from __future__ import annotations

import copy
import io
import json
import struct
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from ruamel.yaml import YAML


Random = np.random.Generator

STRANGE: tuple[Any, ...] = (
    None, True, "", " ", "x", "\x00", "\u202e\x1b[31m", "[bold]x[/nope]", "$\\frac{1$", "../../etc/passwd", "/dev/zero",
    "a" * 5000, "a/" * 3000, 0, -1, 1e-300, 1e300, -1e300, 1e-7, 10**30, float("inf"), float("nan"), "1_000", "7 %",
    "-5 mm", "50 m", "1e9 mm", "3 kg", "١٢", "1,5", "nan", [], {}, [[]], [1, 2, 3], [0, 0], {"a": 1}, "stick", "null",
    "mesh", "2026-01-01",
)  # fmt: skip
"""Values that people, machines and attackers write."""


def shipped(folder: Path) -> list[Path]:
    """Return the case files of a folder."""
    return sorted(folder.glob("*.yaml"))


def case(path: Path, rng: Random) -> bytes:
    """Return a case file in which something is wrong: values, structure, text or bytes."""
    text = path.read_text(encoding="utf-8")
    if rng.random() < 0.25:
        return damaged(text.encode(), rng)
    data = YAML(typ="safe", pure=True).load(text)
    changes = int(rng.integers(1, 4))
    if rng.random() < 0.6:
        data = {"schema_version": 1, "extends": path.stem}
        data |= _section(rng)
        changes = int(rng.integers(0, 3))
    for _ in range(changes):
        _change(data, rng)
    return dumped(data)


def dumped(data: Any) -> bytes:
    """Return data as YAML."""
    stream = io.BytesIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.allow_unicode = True
    yaml.dump(data, stream)
    return stream.getvalue()


def _section(rng: Random) -> dict[str, Any]:
    """Return a section that a case may have, with numbers from a wide range."""
    number = float(10.0 ** rng.uniform(-6, 6))
    sections: list[dict[str, Any]] = [
        {"body": {"type": "sphere", "radius": number}},
        {"body": {"type": "cylinder", "radius": number, "length": float(10.0 ** rng.uniform(-3, 4))}},
        {"body": {"type": "ellipsoid", "semi_axes": [number, 10.0, 10.0]}},
        {"body": {"type": "capsule", "radius": number, "length": 10.0}},
        {"body": {"type": "box", "size": [number, 10.0, 10.0], "edge_radius": 1.0}},
        {"motion": {"total": number}},
        {"motion": {"path": [number, 0.0, number], "total": number}},
        {"fabric": {"size": [number, number]}},
        {"fabric": {"coarsening": number}},
        {"fabric": {"warp_angle": float(rng.uniform(-400, 400)), "portion": "whole"}},
        {"fabric": {"outline": {"circle": number}}},
        {"fabric": {"outline": {"polygon": rng.normal(0, 50, (5, 2)).tolist()}}},
        {"wires": {"every_warp_yarns": number}},
        {"wires": {"loops": {"spacing": number, "length": number / 3}}},
        {"wires": {"paths": [{"name": "a", "path": rng.normal(0, 40, (4, 2)).tolist()}]}},
        {"wires": {"filaments": int(min(number, 1e9)) + 1, "filament_diameter": number}},
        {"contact": {"friction": number}},
        {"failure": {"criterion": "wire_strain", "onset": number}},
        {"effects": [{"id": "clamp_slip", "limit": number}]},
        {"solver": {"tolerance": number}},
        {"supports": {"clamped": ["outline"]}},
        {"title": str(STRANGE[int(rng.integers(len(STRANGE)))])},
    ]
    return sections[int(rng.integers(len(sections)))]


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    """Yield containers and keys of everything in nested data."""
    items = list(data.items()) if isinstance(data, dict) else list(enumerate(data)) if isinstance(data, list) else []
    for key, value in items:
        yield data, key
        yield from _places(value)


def _change(data: dict[str, Any], rng: Random) -> None:
    """Replace, remove, rename, double or scale something."""
    places = list(_places(data))
    if not places:
        data["title"] = "x"
        return
    container, key = places[int(rng.integers(len(places)))]
    value, kind = container[key], int(rng.integers(7))
    if kind <= 2:
        container[key] = copy.deepcopy(STRANGE[int(rng.integers(len(STRANGE)))])
    elif kind == 3 and isinstance(container, dict):
        del container[key]
    elif kind == 4 and isinstance(container, dict):
        container[f"{key}x"] = container.pop(key)
    elif kind == 5 and isinstance(value, list):
        container[key] = value * int(rng.integers(0, 40))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        container[key] = float(value) * float(10.0 ** rng.uniform(-8, 8)) * (-1.0 if rng.random() < 0.3 else 1.0)
    else:
        container[key] = {"value": value}


def damaged(data: bytes, rng: Random) -> bytes:
    """Return bytes of which some are lost, turned, doubled or replaced."""
    found, kind = bytearray(data), int(rng.integers(6))
    at = int(rng.integers(max(1, len(found))))
    if kind == 0:
        del found[at:]
    elif kind == 1:
        for _ in range(int(rng.integers(1, 6))):
            if found:
                found[int(rng.integers(len(found)))] = int(rng.integers(256))
    elif kind == 2:
        length = int(rng.integers(1, 513))
        found[at : at + length] = bytes(len(found[at : at + length]))
    elif kind == 3:
        del found[at : at + int(rng.integers(1, 200))]
    elif kind == 4:
        found[at:at] = found[max(0, at - int(rng.integers(1, 300))) : at]
    else:
        lines = bytes(found).split(b"\n")
        chosen = int(rng.integers(len(lines)))
        lines[chosen] = [b"\t" + lines[chosen], lines[chosen] * 50, b"\xff\xfe" + lines[chosen], b""][
            int(rng.integers(4))
        ]
        return b"\n".join(lines)
    return bytes(found)


def folder(source: Path, target: Path, rng: Random) -> None:
    """Copy a folder of measurements with one or two files changed: values, columns, rows, text or bytes."""
    target.mkdir(parents=True)
    names = [item for item in sorted(source.rglob("*")) if item.is_file()]
    chosen = {int(rng.integers(len(names))) for _ in range(2)}
    for number, item in enumerate(names):
        place = target / item.relative_to(source)
        place.parent.mkdir(parents=True, exist_ok=True)
        content = item.read_bytes()
        if number in chosen:
            content = (
                _table(content, rng) if item.suffix == ".csv" and rng.random() < 0.6 else _described(content, item, rng)
            )
        place.write_bytes(content)


def _described(content: bytes, item: Path, rng: Random) -> bytes:
    if item.suffix != ".yaml" or rng.random() < 0.3:
        return damaged(content, rng)
    data = YAML(typ="safe", pure=True).load(content.decode("utf-8"))
    _change(data, rng)
    return dumped(data)


def _table(content: bytes, rng: Random) -> bytes:
    """Return a table with a cell, a column, a row or the dialect changed."""
    lines = content.decode("utf-8", "replace").splitlines()
    row, kind = int(rng.integers(len(lines))), int(rng.integers(9))
    cells = lines[row].split(",")
    strange = ("", "nan", "inf", "1e300", "-1", "x", '"', "1_000", "١", "0x1F", "9" * 5000, "\x00", "1;2", "1e-320")
    if kind <= 2:
        cells[int(rng.integers(len(cells)))] = strange[int(rng.integers(len(strange)))]
        lines[row] = ",".join(cells)
    elif kind == 3:
        lines[row] = ",".join(cells[:-1])
    elif kind == 4:
        lines = lines[: row + 1]
    elif kind == 5:
        lines = [lines[0], *rng.permutation(lines[1:]).tolist()]
    elif kind == 6:
        lines = [line.replace(",", ";") for line in lines]
    elif kind == 7:
        lines = [lines[0], *lines[1:] * 3]
    else:
        lines[row:row] = [lines[row]] * int(rng.integers(1, 50))
    return "\n".join(lines).encode("utf-8", "replace")


def mesh(rng: Random) -> tuple[str, bytes]:
    """Return the suffix and the content of a mesh file: a ball, badly scaled, open, torn, or other bytes."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=int(rng.integers(1, 4)), radius=float(10.0 ** rng.uniform(-3, 4)))
    vertices, faces = np.array(ball.vertices), np.array(ball.faces)
    kind = int(rng.integers(8))
    if kind == 0:
        faces = faces[: int(rng.integers(len(faces)))]
    elif kind == 1:
        vertices[int(rng.integers(len(vertices)))] = (np.nan, np.inf, 1e300)[int(rng.integers(3))]
    elif kind == 2:
        faces[int(rng.integers(len(faces)))] = faces[0][0]
    elif kind == 3:
        vertices += rng.normal(0.0, np.ptp(vertices) * 0.3, vertices.shape)
    elif kind == 4:
        vertices *= [1.0, 1.0, 10.0 ** rng.uniform(-9, 3)]
    elif kind == 5:
        faces = faces[:, ::-1] if rng.random() < 0.5 else np.concatenate([faces, faces[::-1]])
    suffix = ("stl", "obj", "ply", "3mf")[int(rng.integers(4))]
    made = trimesh.Trimesh(vertices, faces, process=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            content = made.export(file_type=suffix)
        except Exception:  # no format holds every mesh
            content = made.export(file_type="stl")
    data = content.encode() if isinstance(content, str) else bytes(content)
    return suffix, damaged(data, rng) if rng.random() < 0.5 else data


def result_file(path: Path, rng: Random) -> str:
    """Damage a result file in place, in its bytes or in its structure; return how."""
    kind = int(rng.integers(8))
    if kind <= 3:
        path.write_bytes(damaged(path.read_bytes(), rng) if kind else _block(path.read_bytes(), rng))
        return "bytes"
    with h5py.File(path, "r+") as file:
        names: list[str] = []
        file.visit(names.append)
        sets = [name for name in names if isinstance(file[name], h5py.Dataset)]
        name = sets[int(rng.integers(len(sets)))] if kind < 7 else names[int(rng.integers(len(names)))]
        if kind == 4:
            del file[name]
        elif kind == 5:
            attributes = dict(file[name].attrs)
            values = np.asarray(file[name][()])
            del file[name]
            other: tuple[Any, ...] = (np.zeros(0), "text", np.full(3, np.nan), values.astype("S1"), values[..., None])
            file[name] = other[int(rng.integers(len(other)))]
            for key, value in attributes.items():
                file[name].attrs[key] = value
        elif kind == 6:
            flat = np.array(file[name][()], copy=True)
            if flat.dtype.kind in "iuf" and flat.size:
                flat.flat[int(rng.integers(flat.size))] = rng.choice([0, 99, 127])
                file[name][...] = flat
        else:
            keys = list(file[name].attrs) or list(file.attrs)
            place = file[name] if list(file[name].attrs) else file
            if keys:
                place.attrs[keys[int(rng.integers(len(keys)))]] = rng.choice([-1.0, 1e9, 0.0])
    return f"structure {kind}"


def _block(data: bytes, rng: Random) -> bytes:
    """Return a file of which a disk lost a block."""
    found = bytearray(data)
    start = 512 * int(rng.integers(max(1, len(found) // 512)))
    found[start : start + 4096] = bytes(len(found[start : start + 4096]))
    return bytes(found)


def record(data: bytes, rng: Random) -> bytes:
    """Return a damaged record of a cache."""
    if rng.random() < 0.2:
        return struct.pack("<Q", int(rng.integers(2**40))) + data
    return damaged(data, rng)


def damaged_json(content: bytes, rng: Random) -> bytes:
    """Return a JSON file with a value or some bytes changed."""
    if rng.random() < 0.3:
        return damaged(content, rng)
    data = json.loads(content)
    _change(data, rng)
    return json.dumps(data).encode()
