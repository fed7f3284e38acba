"""What does not fit together in a case whose fabric is worn on a limb, and keys that only such a case has."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from loadcases.conflicts import Conflict
from loadcases.schema_body import LIMBS, Body, Limb, LimbMesh
from loadcases.schema_parts import Effect, FabricPiece, Motion, Supports
from loadcases.schema_wires import Wires


class CaseLike(Protocol):
    """What is looked at of a case."""

    @property
    def fabric(self) -> FabricPiece:
        """Its fabric."""

    @property
    def wires(self) -> Wires | None:
        """Its wires."""

    @property
    def supports(self) -> Supports:
        """How it is held."""

    @property
    def body(self) -> Body | None:
        """Its body."""

    @property
    def motion(self) -> Motion:
        """What moves."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Its effects."""


WIDEST_PANEL = 0.8
"""Width of a panel over the girth of the limb, at most: it lies on the outer side."""
EFFECTS = (
    "compression_carry", "pretension", "punch_friction", "rate_dependence", "yarn_damage", "yarn_tail"
)  # fmt: skip
"""Effects that change laws, rest lengths or friction; the others are written for a flat piece and its clamps."""


def not_worn_conflicts(case: CaseLike) -> Iterator[Conflict]:
    """Yield keys of a flat piece that belong to a worn one."""
    if isinstance(case.body, LIMBS):
        message = f"a limb bends inside of a worn piece (got shape {case.fabric.shape}), set it to tube or panel"
        yield Conflict(message, (("fabric", "shape"), ("body", "type")))
    if case.motion.target == "joint":
        message = "a joint needs fabric that is worn on it, set fabric.shape to tube or panel and give body.type limb"
        yield Conflict(message, (("motion", "target"), ("fabric", "shape")))
    if case.fabric.ease is not None or case.fabric.size[1] is None:
        key = "ease" if case.fabric.ease is not None else "size"
        yield Conflict(
            "only a tube has its width from ease, give the width in size", (("fabric", key), ("fabric", "shape"))
        )
    fresh = Supports()
    for key in ("ends", "sides", "band"):
        if getattr(case.supports, key) != getattr(fresh, key):
            yield Conflict("only a worn piece has these, a flat one is clamped", (("supports", key),))


def worn_conflicts(case: CaseLike) -> Iterator[Conflict]:
    """Yield everything in a worn case that does not fit together."""
    if not isinstance(case.body, LIMBS):
        got = "no body" if case.body is None else case.body.type
        message = f"a {case.fabric.shape} is worn on a limb (got {got}), give body.type limb"
        yield Conflict(message, (("fabric", "shape"), ("body", "type")))
        return
    if case.motion.target != "joint":
        message = f"a worn piece is moved by its joint (got {case.motion.target!r}), set it to joint"
        yield Conflict(message, (("motion", "target"), ("fabric", "shape")))
    yield from _piece_conflicts(case)
    yield from limb_conflicts(case, case.body) if isinstance(case.body, Limb) else ()
    yield from _support_conflicts(case)
    yield from _effect_conflicts(case)
    loops = None if case.wires is None else case.wires.loops
    if loops is not None and loops.length >= case.fabric.size[0]:
        message = f"loops are longer than the piece (got {loops.length:g} mm), stay below {case.fabric.size[0]:g} mm"
        yield Conflict(message, (("wires", "loops", "length"), ("fabric", "size")))


def _piece_conflicts(case: CaseLike) -> Iterator[Conflict]:
    """Yield what is wrong with the piece whatever the limb's size."""
    piece = case.fabric
    width = piece.size[1]
    if piece.outline is not None:
        yield Conflict("a worn piece is a rectangle as it lies flat, leave the outline away", (("fabric", "outline"),))
    if piece.portion == "quarter":
        message = "a joint bends in one plane only (got quarter), model the half or the whole"
        yield Conflict(message, (("fabric", "portion"), ("fabric", "shape")))
    if piece.warp_angle != 0.0:
        message = f"the warp of a worn piece runs along the limb (got {piece.warp_angle:g} deg), use 0"
        yield Conflict(message, (("fabric", "warp_angle"), ("fabric", "shape")))
    if piece.shape == "tube" and (width is None) == (piece.ease is None):
        message = "a tube has its girth either from ease (size: [length, null]) or from its width, give one of the two"
        yield Conflict(message, (("fabric", "ease"), ("fabric", "size")))
    if piece.shape == "panel" and (width is None or piece.ease is not None):
        message = "a panel has a width of its own and no ease, give size: [length, width]"
        yield Conflict(message, (("fabric", "size"), ("fabric", "ease")))
    if piece.portion == "half" and isinstance(case.body, LimbMesh):
        message = "a mesh has no plane of symmetry (got half), model the whole"
        yield Conflict(message, (("fabric", "portion"), ("body", "type")))


def limb_conflicts(case: CaseLike, limb: Limb | LimbMesh) -> Iterator[Conflict]:
    """Yield a piece that does not fit its limb, whose files are looked at where its size is not given."""
    piece = case.fabric
    length, width = piece.size
    if piece.shape == "panel" and width is not None and width > WIDEST_PANEL * limb.girth:
        message = (
            f"a panel lies on the outer side of the limb (got {width:g} of a girth of {limb.girth:g} mm), stay below "
            f"{WIDEST_PANEL * limb.girth:.0f} mm or set fabric.shape to tube"
        )
        yield Conflict(message, (("fabric", "size"), ("fabric", "shape")))
    reach = 2.0 * limb.length
    if length > reach:
        message = f"the piece is longer than the limb (got {length:g} mm), stay below {reach:g} mm"
        yield Conflict(message, (("fabric", "size"), ("body", "segment_length")))


def _support_conflicts(case: CaseLike) -> Iterator[Conflict]:
    """Yield supports that are not those of the shape."""
    fresh = Supports()
    if case.supports.clamped != fresh.clamped:
        yield Conflict("a worn piece is not clamped, say in supports.ends how it is held", (("supports", "clamped"),))
    if case.supports.sides != fresh.sides and case.fabric.shape != "panel":
        yield Conflict("only a panel has sides", (("supports", "sides"), ("fabric", "shape")))
    if case.fabric.shape == "panel" and "band" in case.supports.ends:
        yield Conflict("a band goes round the limb, a panel does not; hold its ends", (("supports", "ends"),))


def _effect_conflicts(case: CaseLike) -> Iterator[Conflict]:
    """Yield effects that need a flat piece."""
    for number, effect in enumerate(case.effects):
        if effect.id not in EFFECTS:
            message = f"{effect.id} is written for a flat piece; on a worn one there are {', '.join(EFFECTS)}"
            yield Conflict(message, (("effects", str(number)), ("fabric", "shape")))
