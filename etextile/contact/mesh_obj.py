"""An OBJ file with its vertices in the order of the file, which weights refer to and mesh libraries do not keep.

Only the lines v, f, g and o are looked at; materials and textures that the file names are never opened.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from etextile.errors import BadInput, nearest
from etextile.files import read_bounded
from etextile.types import Array, IntArray


MAX_BYTES = 100_000_000
LISTED = 8
"""Groups named in a message."""


@dataclass(frozen=True)
class OrderedMesh:
    """Vertices (v, 3) in the unit and order of the file, and triangles (f, 3) by group."""

    vertices: Array = field(repr=False)
    groups: dict[str, IntArray] = field(repr=False)

    def triangles(self, group: str | None, *, file: Path) -> IntArray:
        """Return the triangles (f, 3) of a group, of all when None; raises BadInput that lists the groups."""
        if group is None:
            return np.concatenate(list(self.groups.values()))
        if group not in self.groups:
            message = f"the mesh has no group {group!r}, it has {self.listed}{nearest(group, self.groups)}"
            raise BadInput.of(message, file=str(file), key="body.group")
        return self.groups[group]

    @property
    def listed(self) -> str:
        """The groups in words, the largest first."""
        names = sorted(self.groups, key=lambda name: -len(self.groups[name]))
        more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
        return ", ".join(repr(name) for name in names[:LISTED]) + more


def read_ordered(file: Path) -> OrderedMesh:
    """Return an OBJ file as it stands; polygons are cut into triangles from their first corner. Raises BadInput."""
    if file.suffix.lower() != ".obj":
        message = f"must be an OBJ file, whose vertices keep the order that weights refer to (got {file.name!r})"
        raise BadInput.of(f"{message}; export it as OBJ", file=str(file), key="body.file")
    if not file.is_file():
        near = nearest(file.name, [other.name for other in file.parent.iterdir()]) if file.parent.is_dir() else ""
        message = f"there is no such mesh file{near}; a relative path counts from the case file"
        raise BadInput.of(message, file=str(file), key="body.file")
    text = read_bounded(file, MAX_BYTES).decode("utf-8", errors="replace")
    vertices: list[list[float]] = []
    faces: dict[str, list[list[int]]] = {}
    group = "default"
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        try:
            if words[:1] == ["v"]:
                vertices.append([float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                ring = [_corner(word, len(vertices)) for word in words[1:]]
                faces.setdefault(group, []).extend([ring[0], *pair] for pair in pairwise(ring[1:]))
            elif words[:1] in (["g"], ["o"]):
                group = " ".join(words[1:]) or "default"
        except (ValueError, IndexError):
            message = f"is no line of an OBJ file (got {line.strip()[:60]!r}), export it again"
            raise BadInput.of(message, file=str(file), line=number) from None
    return _checked(vertices, faces, file)


def _corner(word: str, count: int) -> int:
    """Return the vertex of a corner `v/vt/vn`, counted from 0; negative numbers count back from the last one."""
    number = int(word.partition("/")[0])
    return number - 1 if number > 0 else count + number


def _checked(vertices: list[list[float]], faces: dict[str, list[list[int]]], file: Path) -> OrderedMesh:
    """Return the mesh; raises BadInput without triangles or with corners that are not there."""
    if not faces or not vertices:
        raise BadInput.of("holds no triangles, export the body as a mesh", file=str(file))
    if any(len(point) != 3 for point in vertices) or not np.isfinite(vertices).all():
        raise BadInput.of("has vertices that are not three finite numbers, export it again", file=str(file))
    groups = {name: np.array(corners, dtype=np.int64).reshape(-1, 3) for name, corners in faces.items() if corners}
    lowest = min((corners.min() for corners in groups.values()), default=-1)
    highest = max((corners.max() for corners in groups.values()), default=0)
    if lowest < 0 or highest >= len(vertices):
        raise BadInput.of("has triangles of vertices that are not there, export it again", file=str(file))
    return OrderedMesh(np.array(vertices), groups)
