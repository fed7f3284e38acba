"""Compressed yarns carry a share of the tensile stiffness instead of buckling at once.

The base model drops a compressed truss entirely. Neighbours support a yarn in the weave, so it may carry some load
before it buckles: the paper's own unit-cell check keeps a compressive branch ten times more compliant than tension.
Here every compressed fabric truss bears `ratio` times the force of its loading curve at the same size of strain,
without loss.

Compressed fabric escapes by folding. Up to 15 mm the height of its free edge at mid-span differs by 1 to 2 mm from one
lattice to the next, so the card leaves it undetermined. A little resistance does most of it: the edge of the punch test
is drawn in less by 0.5, 0.8, 1.0 and 1.3 mm at ratios of 0.003, 0.01, 0.03 and 0.08, so beyond `proportional` the ratio
is searched by its logarithm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage, Undetermined
from etextile.effects.change import FABRIC, with_laws
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class CompressionCarry(Effect):
    """Stress of compressed trusses as a share of the loading curve, on top of what the case gives."""

    ratio: float = 0.0

    stage: ClassVar[Stage] = Stage.LAW
    card: ClassVar[Card] = Card(
        id="compression_carry",
        mechanism="Compressed yarns carry a share of the tensile stiffness.",
        parameters=(
            Parameter("ratio", "", 0.0, 0.3, "the force in compression over that in tension", proportional=0.003),
        ),
        example=Example({"ratio": 0.1}, (4.7, 1.5, 0.7, 0.3, 0.0), (-0.17, -0.55, -0.6, -0.75, -0.67)),
        signature=(
            Signature("punch_force", 1, 0.0, "more at small displacement, fading with depth"),
            Signature("free_edge", -1, 0.0, "the edge is drawn in less, since the weft resists being shortened"),
            Signature("tensile", 0, 0.0, "little: coupons may still narrow"),
        ),
        confused_with=("rotational_shear", "bending_stiffness"),
        separate="The free edge: compression holds it back by far more than bending or shear do.",
        undetermined=(Undetermined("free_edge", "height", 1.0),),
        literature="Beex et al., section 4.4 (compressive branch ten times more compliant than tension).",
    )

    def transform(self, model: Model) -> Model:
        """Return the model whose fabric trusses resist compression."""
        return with_laws(model, FABRIC, self._carrying)

    def _carrying(self, law: PowerLaw) -> PowerLaw:
        return replace(law, compression_ratio=law.compression_ratio + self.ratio)
