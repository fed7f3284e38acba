"""A limb cut from files of a body mesh: scaled to a girth, cut to a length, measured; its distance is not yet baked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from etextile.contact.body import require, require_positive
from etextile.contact.limb_cut import LENGTH, HingeFrame, cut_limb, require_scale
from etextile.contact.mesh_obj import read_ordered
from etextile.contact.rig import hinge_of, read_rig, read_weights
from etextile.contact.sections import Sections, sections_of
from etextile.contact.skinning import KINDS, SkinnedMesh
from etextile.errors import BadInput


LEAST_FADE, MOST_FADE = 0.05, 0.95
"""Shares of the lower segment between which a vertex counts for the length of skin that stretches."""


@dataclass(frozen=True)
class LimbRecipe:
    """What a limb is cut by, named as in the case file: lengths in mm, `axis` (3,) in coordinates of the mesh file."""

    file: str | Path
    rig: str | Path
    weights: str | Path
    joint: str
    group: str | None = None
    scale: float = 1.0
    axis: tuple[float, float, float] | None = None
    skinning: str = "linear"
    joint_girth: float | None = None
    segment_length: float | None = None

    @property
    def paths(self) -> tuple[Path, Path, Path]:
        """Mesh, rig and weights."""
        return Path(self.file), Path(self.rig), Path(self.weights)


@dataclass(frozen=True)
class UnbakedLimb:
    """A limb before its grids are made: mesh, sections, length of its segments (mm), what was found out."""

    mesh: SkinnedMesh
    sections: Sections
    length: float
    notes: tuple[str, ...]

    @property
    def girth(self) -> float:
        """Girth at the joint, straight, mm."""
        return float(2.0 * np.pi * self.sections.radius(np.zeros(1))[0])


def unbaked(recipe: LimbRecipe) -> UnbakedLimb:
    """Return a limb without its grids, from memory where its files have not changed; raises BadInput."""
    stamps = tuple(path.stat().st_mtime_ns if path.is_file() else 0 for path in recipe.paths)
    return _unbaked(recipe, stamps)


@lru_cache(maxsize=8)
def _unbaked(recipe: LimbRecipe, stamps: tuple[int, ...]) -> UnbakedLimb:
    """Return what `unbaked` does; `stamps`: when the files were changed."""
    require_usable(recipe)
    file, rig, weights = recipe.paths
    ordered, bones = read_ordered(file), read_rig(rig)
    hinge = hinge_of(bones, recipe.joint, ordered, rig=rig)
    frame = HingeFrame.of(hinge, recipe.axis)
    require_scale(frame.length, recipe.scale)
    share = read_weights(weights, bones, hinge.beyond, len(ordered.vertices))
    triangles = ordered.triangles(recipe.group, file=file)

    def cut(factor: float, length: float) -> tuple[SkinnedMesh, tuple[str, ...]]:
        scale = recipe.scale * factor
        return cut_limb(
            ordered, triangles, share, frame=frame, scale=scale, length=length, kind=recipe.skinning, file=file
        )  # fmt: skip

    own_length = LENGTH * frame.length * recipe.scale
    mesh, notes = cut(1.0, own_length)
    sections = sections_of(mesh, own_length)
    factor = _factor(recipe.joint_girth, sections)
    length = _length(recipe.segment_length, factor * own_length, longest=factor * recipe.scale * frame.length)
    if (factor, length) != (1.0, own_length):
        mesh, notes = cut(factor, length)
        sections = sections_of(mesh, length)
    return UnbakedLimb(mesh, sections, length, (*_facts(mesh, sections, length, factor), *notes))


def _factor(girth: float | None, sections: Sections) -> float:
    """Return the factor on the mesh that gives it a `girth` (mm) at the joint; 1 where none is asked for."""
    return 1.0 if girth is None else girth / float(2.0 * np.pi * sections.radius(np.zeros(1))[0])


def _length(given: float | None, usual: float, *, longest: float) -> float:
    """Return the length of the segments, mm; raises BadInput for one longer than the bones."""
    length = usual if given is None else given
    if length > longest:
        message = f"the segment is longer than its bone (got {length:g} mm), stay below {longest:.0f} mm"
        raise BadInput.of(message, key="body.segment_length")
    return length


def require_usable(recipe: LimbRecipe) -> None:
    """Raise BadInput for a scale, a girth or a length that is none, and for an unknown kind of skinning."""
    given = {"joint_girth": recipe.joint_girth, "segment_length": recipe.segment_length}
    numbers = {name: value for name, value in given.items() if value is not None}
    require_positive(scale=recipe.scale, **numbers)
    if recipe.skinning not in KINDS:
        require([(f"no such skinning (got {recipe.skinning!r}), known are {', '.join(KINDS)}", "skinning")])


def _facts(mesh: SkinnedMesh, sections: Sections, length: float, factor: float) -> tuple[str, ...]:
    """Return what is to be known of a limb."""
    ends = 2.0 * np.pi * sections.radius(np.array([-0.75 * length, 0.0, 0.75 * length]))
    where = f"{0.75 * length:.0f} mm above the joint, at it and below it"
    scaled = "" if factor == 1.0 else f", scaled by {factor:.4g} to the girth at the joint"
    deg = np.degrees(mesh.rest)
    return (
        f"limb of {len(mesh.faces)} triangles{scaled}: girths {', '.join(f'{end:.0f}' for end in ends)} mm {where}",
        f"its rest pose is bent by {deg:.3g} deg; weights fade over {fading_length(mesh):.0f} mm of skin",
    )


def fading_length(mesh: SkinnedMesh) -> float:
    """Return the length (mm) over which the weights of the straight limb go from the upper segment to the lower.

    One over the slope of a straight line through the shares of the vertices that both segments move.
    """
    both = (mesh.weight > LEAST_FADE) & (mesh.weight < MOST_FADE)
    x, share = mesh.bent(0.0)[both, 0], mesh.weight[both]
    spread = np.ptp(x) if both.any() else 0.0
    if spread <= 0.0:
        return 1.0
    slope = float(np.polyfit(x, share, 1)[0])
    return float(1.0 / slope) if slope * spread > 0.1 else float(spread)
