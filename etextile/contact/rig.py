"""Rigs and weights of a mesh that bends: bones with head, tail and parent, and how much of a vertex each bone moves.

Both are JSON as animation programs export them: a mapping from bone to {head, tail, parent}, and from bone to a list
of [vertex, weight], either at the top of the file or under `bones` and `weights`. An end of a bone is a point [x, y, z]
of the mesh file, or follows it as in the rigs of MakeHuman: {strategy: CUBE, cube_name} is the middle of a group,
{strategy: MEAN, vertex_indices} that of some vertices. A joint is the head of a bone that has a parent; all bones
beyond it move with the lower segment, everything else with the upper.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from etextile.contact.mesh_obj import OrderedMesh
from etextile.errors import BadInput, nearest
from etextile.files import read_bounded
from etextile.types import Array


MAX_BYTES = 100_000_000
COMMON = {"elbow": ("lowerarm", "forearm"), "knee": ("calf", "shin", "lowerleg", "leg")}
"""Joints by the usual names of the bone beyond them."""
LISTED = 12
"""Bones named in a message."""


@dataclass(frozen=True)
class Hinge:
    """A joint: its place, where the upper segment begins and the lower ends (3,), and the bones (names) beyond it."""

    place: Array
    upper: Array
    lower: Array
    beyond: frozenset[str]


def read_rig(file: Path) -> Mapping[str, Any]:
    """Return the bones of a rig by name; raises BadInput for what is no rig."""
    bones = _read(file, "rig", "bones")
    for name, bone in bones.items():
        if not (isinstance(bone, dict) and {"head", "tail"} <= set(bone)):
            message = f"bone {name!r} has no head and tail, export the rig as {{bone: {{head, tail, parent}}}}"
            raise BadInput.of(message, file=str(file), key="body.rig")
    return bones


def joints_of(bones: Mapping[str, Any]) -> dict[str, str]:
    """Return the bones beyond a joint by the names that `body.joint` takes: elbow_left and the like, then the bones."""
    inner = [name for name, bone in bones.items() if bone.get("parent") in bones]
    found: dict[str, str] = {}
    for name in inner:
        plain = re.sub(r"[^a-z]", "", name.rpartition(":")[2].lower())
        for joint, words in COMMON.items():
            for side in ("left", "right"):
                spelled = {form for word in words for form in (word + side[0], side + word, word + side)}
                found.setdefault(f"{joint}_{side}", name) if plain in spelled else None
    return {**found, **{name: name for name in inner}}


def hinge_of(bones: Mapping[str, Any], joint: str, mesh: OrderedMesh, *, rig: Path) -> Hinge:
    """Return a joint of a rig in the coordinates of the mesh file; raises BadInput that lists the joints."""
    joints = joints_of(bones)
    if joint not in joints:
        common = sorted(name for name, bone in joints.items() if name != bone)
        others = [name for name in joints if name not in common][:LISTED]
        known = ", ".join([*common, *others]) or "none: no bone has a parent"
        rest = len(joints) - len(common) - len(others)
        more = f" and {rest} further bones" if rest else ""
        message = f"the rig has no such joint (got {joint!r}), it has {known}{more}{nearest(joint, joints)}"
        raise BadInput.of(message, key="body.joint")
    lower = joints[joint]
    upper = bones[lower]["parent"]
    place, start, end = (
        _place(bones[bone][end], mesh, where=f"{end} of bone {bone!r}", rig=rig)
        for bone, end in ((lower, "head"), (upper, "head"), (lower, "tail"))
    )
    return Hinge(place, start, end, frozenset(_beyond(bones, lower)))


def read_weights(file: Path, bones: Mapping[str, Any], beyond: frozenset[str], count: int) -> Array:
    """Return the share (v,) of the bones `beyond` a joint in `count` vertices, nan where no bone moves a vertex.

    Raises BadInput for bones that the rig does not have and vertices that the mesh does not have.
    """
    named = _read(file, "weights", "weights")
    unknown = [name for name in named if name not in bones]
    if unknown:
        message = f"weights are given for the bone {unknown[0]!r}, which the rig does not have"
        raise BadInput.of(f"{message}{nearest(unknown[0], bones)}; use rig and weights of one model", file=str(file))
    total, lower = np.zeros(count), np.zeros(count)
    for name, pairs in named.items():
        vertex, share = _pairs(pairs, name, file=file, count=count)
        np.add.at(total, vertex, share)
        if name in beyond:
            np.add.at(lower, vertex, share)
    with np.errstate(invalid="ignore"):
        return np.where(total > 0.0, lower / total, np.nan)


def _pairs(pairs: Any, bone: str, *, file: Path, count: int) -> tuple[Any, Array]:
    """Return vertices (n,) and weights (n,) of a bone."""
    try:
        table = np.asarray(pairs, dtype=float).reshape(-1, 2)
    except (TypeError, ValueError):
        table = np.full((1, 2), np.nan)
    vertex = table[:, 0]
    if not np.isfinite(table).all() or np.any(vertex != np.round(vertex)) or table.min(initial=0.0) < 0.0:
        message = f"the weights of bone {bone!r} are no list of [vertex, weight], neither below 0; export them again"
        raise BadInput.of(message, file=str(file), key="body.weights")
    if vertex.max(initial=0.0) >= count:
        message = (
            f"weights are given for vertex {vertex.max():.0f} of bone {bone!r}, but the mesh has {count} (counted from "
            "0): these are the weights of another mesh, or the mesh was changed after it was weighted"
        )
        raise BadInput.of(message, file=str(file), key="body.weights")
    return vertex.astype(np.int64), table[:, 1]


def _place(end: Any, mesh: OrderedMesh, *, where: str, rig: Path) -> Array:
    """Return an end of a bone (3,) in the coordinates of the mesh file."""
    if isinstance(end, dict):
        if end.get("strategy") == "CUBE":
            cube = end.get("cube_name")
            if cube in mesh.groups:
                return np.asarray(mesh.vertices[np.unique(mesh.groups[cube])].mean(axis=0))
            message = f"{where} is the middle of the group {cube!r}, which the mesh does not have; export both together"
            raise BadInput.of(message, file=str(rig), key="body.rig")
        if end.get("strategy") == "MEAN":
            end = _mean(end.get("vertex_indices"), mesh)
    try:
        point = np.asarray(end, dtype=float)
    except (TypeError, ValueError):
        point = np.zeros(0)
    if point.shape != (3,) or not np.isfinite(point).all():
        message = f"{where} is no point: write [x, y, z] in the coordinates of the mesh file"
        raise BadInput.of(message, file=str(rig), key="body.rig")
    return point


def _mean(indices: Any, mesh: OrderedMesh) -> Any:
    """Return the middle of some vertices, None when there are none of these numbers."""
    whole = isinstance(indices, list) and indices and all(type(index) is int for index in indices)
    if not whole or not 0 <= min(indices) <= max(indices) < len(mesh.vertices):
        return None
    return mesh.vertices[indices].mean(axis=0)


def _beyond(bones: Mapping[str, Any], first: str) -> set[str]:
    """Return a bone with all that hang on it."""
    found, fresh = {first}, {first}
    while fresh:
        fresh = {name for name, bone in bones.items() if bone.get("parent") in fresh} - found
        found |= fresh
    return found


def _read(file: Path, key: str, inner: str) -> Mapping[str, Any]:
    """Return a mapping of a JSON file, at its top or under `inner`."""
    if not file.is_file():
        near = nearest(file.name, [other.name for other in file.parent.iterdir()]) if file.parent.is_dir() else ""
        message = f"there is no such file{near}; a relative path counts from the case file"
        raise BadInput.of(message, file=str(file), key=f"body.{key}")
    try:
        data = json.loads(read_bounded(file, MAX_BYTES))
    except (ValueError, RecursionError) as error:
        message = f"cannot be read as JSON ({' '.join(str(error).split())[:120]}), export it again"
        raise BadInput.of(message, file=str(file), key=f"body.{key}") from error
    found = data.get(inner, data) if isinstance(data, dict) else None
    if not isinstance(found, dict) or not found:
        message = f"holds no mapping of bones, neither at the top nor under {inner!r}"
        raise BadInput.of(message, file=str(file), key=f"body.{key}")
    return found
