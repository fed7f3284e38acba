"""Small changes of models that several effects share: laws of families, the lattice block, contacts, clamps."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from etextile.contact.contact import Contact
from etextile.errors import BadInput
from etextile.lattice.piece import EDGES, Lattice
from etextile.lattice.weave import DIAGONAL, LAND, WARP, WEFT
from etextile.laws.powerlaw import PowerLaw, plastic_strain
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution
from etextile.mechanics.truss import TrussBlock
from etextile.types import Array, BoolArray


YARNS = (WARP, WEFT)
FABRIC = (WARP, WEFT, DIAGONAL)


def lattice_block(model: Model) -> TrussBlock:
    """Return the block of the fabric's own trusses (wires stand behind it)."""
    return model.lattice_block


def with_lattice_block(model: Model, block: TrussBlock) -> Model:
    """Return the model with another block of fabric trusses in place of its own."""
    old = lattice_block(model)
    return replace(model, contributions=tuple(block if part is old else part for part in model.contributions))


def with_fabric_trusses(model: Model, change: Callable[[TrussBlock], TrussBlock]) -> Model:
    """Return the model with changed trusses of the lattice, those that pass a land among them."""
    own = lattice_block(model)
    parts = (
        change(part) if isinstance(part, TrussBlock) and (part is own or (part.family == LAND).any()) else part
        for part in model.contributions
    )
    return replace(model, contributions=tuple(parts))


def with_laws(model: Model, families: Iterable[int], change: Callable[[PowerLaw], PowerLaw]) -> Model:
    """Return the model with changed laws of some fabric families, also of their trusses that pass a land."""
    chosen = set(families)

    def changed(block: TrussBlock) -> TrussBlock:
        laws = enumerate(block.laws)
        return replace(block, laws=tuple(change(law) if k % len(FABRIC) in chosen else law for k, law in laws))

    return with_fabric_trusses(model, changed)


def plastic_part(law: PowerLaw, engineering_strain: float) -> float:
    """Return the plastic Hencky strain of a law's loading curve at an engineering strain."""
    return float(plastic_strain(law.row(), float(np.log1p(engineering_strain)), 0.0))


def with_contact(model: Model, effect: str, change: Callable[[Contact], Contact]) -> Model:
    """Return the model with its contacts changed, also one that rides on a machine spring; BadInput without contact."""
    parts = tuple(_changed(part, change) for part in model.contributions)
    if all(a is b for a, b in zip(parts, model.contributions, strict=True)):
        raise BadInput.of(f"{effect} needs a body that is pressed into the fabric, the case has none", key="id")
    return replace(model, contributions=parts)


def _changed(part: Contribution, change: Callable[[Contact], Contact]) -> Contribution:
    if isinstance(part, Contact):
        return change(part)
    inner = getattr(part, "contact", None)
    return replace(part, contact=change(inner)) if isinstance(inner, Contact) else part  # type: ignore[type-var]


def clamped_edges(model: Model) -> dict[str, BoolArray]:
    """Return the clamped edges with their lattice nodes (N,): all of them are held out of the plane."""
    lattice = model.lattice
    held = model.fixed[: len(lattice.points), 2]
    real = {name: nodes for name, nodes in lattice.edges.items() if nodes.any()}
    return {name: nodes for name, nodes in real.items() if held[nodes].all()}


def outward(edge: str) -> Array:
    """Return the unit vector (3,) that points out of the specimen at an edge; raises BadInput for an outline."""
    if edge not in EDGES:
        raise BadInput.of("the clamps of this effect are straight, a clamped outline is a ring", key="id")
    vector = np.zeros(3)
    vector["xy".index(edge[0])] = 1.0 if edge.endswith("max") else -1.0
    return vector


def line_width(lattice: Lattice, edge: str) -> Array:
    """Return the width (n,) mm of edge that each node of an edge stands for."""
    along = lattice.points[lattice.edges[edge], 1 - "xy".index(edge[0])]
    order = np.argsort(along)
    gaps = np.diff(along[order])
    width = np.zeros(len(along))
    width[order[:-1]] += 0.5 * gaps
    width[order[1:]] += 0.5 * gaps
    return width


def half_length(model: Model) -> float:
    """Return half the distance of the clamps, mm (of the length where nothing is clamped)."""
    lattice, edges = model.lattice, clamped_edges(model)
    axis = 1 if edges and all(name[0] == "y" for name in edges) else 0
    extent = float(np.ptp(lattice.points[:, axis]))
    return extent if lattice.symmetry[axis] else 0.5 * extent
