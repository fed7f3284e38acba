"""Triangles from a mesh file: what programs write, with equal positions welded, and nothing outside of the file read.

Modellers split vertices by normals, texture seams and materials, so a closed surface looks open until equal positions
are one vertex again. Materials and textures named in a file are never opened.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from etextile.errors import BadInput, nearest
from etextile.importers.foreign import what_it_is
from etextile.types import Array, IntArray


FORMATS = (".stl", ".obj", ".ply", ".3mf")
MAX_BYTES = 500_000_000
WELD = 1e-6
"""Vertices closer than this share of the body's size are one: what single precision makes of one position."""
UNITS = {"micron": 0.001, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}


def read_triangles(file: Path) -> tuple[Array, IntArray, tuple[str, ...]]:
    """Return vertices (v, 3), triangles (f, 3) and notes on what was welded; raises BadInput for what is no mesh."""
    data = _content(file)
    try:
        vertices, faces = _parsed_3mf(data) if file.suffix.lower() == ".3mf" else _parsed(data, file.suffix.lower())
    except BadInput:
        raise
    except Exception as error:
        kind = file.suffix[1:].upper()
        text = f"cannot be read as a {kind} mesh ({type(error).__name__}: {error}), export it again"
        raise BadInput.of(" ".join(text.split())[:300], file=str(file)) from error
    if len(faces) == 0:
        raise BadInput.of("holds no triangles, export the body as a triangle mesh", file=str(file))
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise BadInput.of("has triangles of vertices that are not there, export it again", file=str(file))
    if not np.isfinite(vertices[faces]).all():
        raise BadInput.of("has vertices that are not finite numbers, export it again", file=str(file))
    vertices, faces, notes = welded(vertices, faces)
    return vertices, faces, () if file.suffix.lower() == ".stl" else notes  # an STL file repeats every corner


def _content(file: Path) -> bytes:
    """Return the bytes of a mesh file; what is something else is named."""
    if file.suffix.lower() not in FORMATS:
        raise BadInput.of(f"mesh format {file.suffix!r} is not known, use one of {', '.join(FORMATS)}", file=str(file))
    if not file.is_file():
        near = nearest(file.name, [other.name for other in file.parent.iterdir()]) if file.parent.is_dir() else ""
        message = f"there is no such mesh file{near}; a relative path counts from the case file"
        raise BadInput.of(message, file=str(file))
    if file.stat().st_size > MAX_BYTES:
        raise BadInput.of(f"larger than {MAX_BYTES // 10**6} MB, simplify the mesh first", file=str(file))
    data = file.read_bytes()
    words = what_it_is(data[:1024])
    if words and not (file.suffix.lower() == ".3mf" and data.startswith(b"PK")):
        raise BadInput.of(f"holds no triangles: this is {words}", file=str(file))
    return data


def _parsed(data: bytes, suffix: str) -> tuple[Array, IntArray]:
    """Return what the library reads of STL, OBJ and PLY; it gets the bytes alone, so it can open nothing else."""
    import trimesh

    options: dict[str, Any] = {"skip_materials": True} if suffix == ".obj" else {}
    loaded: Any = trimesh.load(io.BytesIO(data), file_type=suffix[1:], process=False, **options)
    parts = list(loaded.geometry.values()) if isinstance(loaded, trimesh.Scene) else [loaded]
    meshes = [part for part in parts if len(getattr(part, "faces", ())) > 0]
    return joined([(np.asarray(part.vertices, np.float64), np.asarray(part.faces, np.int64)) for part in meshes])


def joined(parts: list[tuple[Array, IntArray]]) -> tuple[Array, IntArray]:
    """Return several meshes as one."""
    if not parts:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [part + start for (_, part), start in zip(parts, starts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def _parsed_3mf(data: bytes) -> tuple[Array, IntArray]:
    """Return the meshes of a 3MF file in mm, each where the build puts it; parts in other files are not followed."""
    from xml.etree import ElementTree

    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        name = next((name for name in archive.namelist() if name.lower().endswith(".model")), None)
        if name is None:
            raise ValueError("no model in it")
        if archive.getinfo(name).file_size > MAX_BYTES:
            raise ValueError("the model in it is too large")
        text = archive.read(name)
    if b"<!DOCTYPE" in text[:4096] or b"<!ENTITY" in text:
        raise ValueError("a document type, which a 3MF model has not")
    root = ElementTree.fromstring(text)
    space = root.tag.partition("}")[0] + "}" if root.tag.startswith("{") else ""
    scale = UNITS.get(root.get("unit", "millimeter"), 1.0)
    objects: dict[str | None, tuple[Array, IntArray]] = {}
    for item in root.iter(f"{space}object"):
        points = [[float(point.get(axis, "nan")) for axis in "xyz"] for point in item.iter(f"{space}vertex")]
        corners = [[int(face.get(key, "-1")) for key in ("v1", "v2", "v3")] for face in item.iter(f"{space}triangle")]
        if corners:
            objects[item.get("id")] = np.array(points, dtype=np.float64), np.array(corners, dtype=np.int64)
    parts = []
    for item in root.iter(f"{space}item"):
        if item.get("objectid") in objects:
            placed, triangles = objects[item.get("objectid")]
            numbers = [float(word) for word in item.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()]
            matrix = np.array(numbers).reshape(4, 3)
            parts.append((scale * (placed @ matrix[:3] + matrix[3]), triangles))
    return joined(parts or [(scale * placed, triangles) for placed, triangles in objects.values()])


def welded(vertices: Array, faces: IntArray) -> tuple[Array, IntArray, tuple[str, ...]]:
    """Return a mesh whose equal positions are one vertex, without triangles that have no area, and notes.

    Equal: the same numbers, and if edges are open then, closer than WELD of the body's size.
    """
    used = np.unique(faces)
    points, place = np.unique(vertices[used] + 0.0, axis=0, return_inverse=True)
    number = np.zeros(len(vertices), dtype=np.int64)
    number[used] = place.reshape(-1)
    faces = _with_area(number[faces])
    if open_edges(faces):
        points, faces = _merged(points, faces)
    merged = len(used) - len(points)
    split = f"{merged} vertices that stand where another one stands were welded"
    return points, faces, (split,) if merged else ()


def _merged(points: Array, faces: IntArray) -> tuple[Array, IntArray]:
    """Return a mesh whose nearly equal positions are one vertex."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    reach = WELD * float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points).query_pairs(reach, output_type="ndarray") if reach > 0.0 else np.zeros((0, 2), int)
    if not len(pairs):
        return points, faces
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, group = connected_components(links, directed=False)
    first = np.unique(group, return_index=True)[1]
    return points[first], _with_area(group[faces].astype(np.int64))


def _with_area(faces: IntArray) -> IntArray:
    """Return the triangles of three different corners."""
    return np.asarray(faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)])


def open_edges(faces: IntArray) -> int:
    """Return the number of edges that one triangle alone has."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return int(np.sum(np.unique(edges, axis=0, return_counts=True)[1] == 1))
