"""A round limb as a rigged mesh: what `limb_mesh` reads, made from formulas."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from etextile.types import Array, IntArray


def tube(radius: float, half: float, *, rows: int, around: int) -> tuple[Array, IntArray]:
    """Return an open cylinder along x from -half to half, wound outward."""
    x = np.linspace(-half, half, rows)
    angle = 2.0 * np.pi * np.arange(around) / around
    vertices = np.array([[place, radius * np.sin(a), radius * np.cos(a)] for place in x for a in angle])
    faces = []
    for row in range(rows - 1):
        for a in range(around):
            one, two = row * around + a, row * around + (a + 1) % around
            faces += [[one, one + around, two], [two, one + around, two + around]]
    return vertices, np.array(faces)


def write_limb(
    folder: Path, *, radius: float = 20.0, half: float = 130.0, fade: float = 20.0, rest: float = 0.5
) -> dict[str, str]:
    """Write a cylinder, its rig and weights; return the paths as keys of the body.

    Shares of the lower bone grow over `fade` mm on either side of the hinge; the file holds the pose bent by `rest`
    (rad), made by turning every vertex by its share, and is not in the frame of the hinge.
    """
    vertices, faces = tube(radius, half, rows=41, around=24)
    share = np.clip(0.5 + vertices[:, 0] / (2.0 * fade), 0.0, 1.0)
    turn = (share - 0.5) * rest
    cos, sin = np.cos(turn), np.sin(turn)
    x, y, z = vertices.T
    bent = np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=1)

    def placed(points: Array) -> Array:
        return points[..., [1, 2, 0]] + np.array([300.0, -40.0, 7.0])

    end = half * np.array([np.cos(0.5 * rest), 0.0, -np.sin(0.5 * rest)])
    upper, hinge, lower = placed(np.stack([end * [-1.0, 1.0, 1.0], np.zeros(3), end])).tolist()
    lines = [f"v {a!r} {b!r} {c!r}" for a, b, c in placed(bent).tolist()]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces.tolist()]
    bones = {
        "arm": {"head": upper, "tail": hinge, "parent": ""},
        "forearm_l": {"head": hinge, "tail": lower, "parent": "arm"},
    }
    named = {"arm": 1.0 - share, "forearm_l": share}
    weights = {name: [[i, w] for i, w in enumerate(values.tolist()) if w > 0.0] for name, values in named.items()}
    texts = {
        "limb.obj": "\n".join(lines),
        "rig.json": json.dumps({"bones": bones}),
        "weights.json": json.dumps(weights),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return {"file": str(folder / "limb.obj"), "rig": str(folder / "rig.json"), "weights": str(folder / "weights.json")}
