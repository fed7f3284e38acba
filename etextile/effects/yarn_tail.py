"""Yarns flatten or steepen beyond the strain up to which their law was identified.

Warp and weft are identified from coupons that end near 12 % strain; the punch test goes far beyond, so the power law is
an extrapolation there. Yarn geometry says why it may fail: once crimp is used up a yarn stiffens towards its fibres,
and near its strength fibres slip and break and it yields. Here the yield stress beyond the plastic strain at the
engineering strain `onset` rises (1 + slope_change) times as fast as the identified law.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import YARNS, plastic_part, with_laws
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class YarnTail(Effect):
    """Slope of hardening beyond an onset changed by a share: -0.7 leaves 30 % of it, 0.5 adds a half."""

    slope_change: float = 0.0
    onset: float = 0.12

    stage: ClassVar[Stage] = Stage.LAW
    card: ClassVar[Card] = Card(
        id="yarn_tail",
        mechanism="The yarn law flattens or steepens beyond the strain up to which it was identified.",
        parameters=(
            Parameter("slope_change", "", -0.95, 2.0, "the relative change of the hardening slope beyond the onset"),
            Parameter(
                "onset",
                "",
                0.02,
                0.5,
                "the engineering yarn strain from which on",
                neutral=None,
                default=0.12,
                coupons_show=True,
            ),
        ),
        example=Example(
            {"slope_change": -0.7, "onset": 0.12}, (0.0, 0.0, -0.7, -8.3, -21.7), (0.0, 0.0, 0.0, -0.02, -0.32)
        ),
        signature=(
            Signature("punch_force", -1, 25.0, "nothing, then a kink where the first yarn passes the onset"),
            Signature("tensile", 0, 0.0, "none: the coupons end before the onset"),
            Signature("strain_field", 1, 25.0, "strain gathers over the punch, where yarns are past the onset"),
        ),
        confused_with=("clamp_slip", "yarn_damage", "yarn_sliding"),
        separate="Unload (only damage softens unloading) and watch the clamp line; or pull coupons beyond 12 %.",
        literature="Yarn response past crimp: de Jong and Postle, J. Textile Inst. 68 (1977) 350; the identified range "
        "ends at 12 %: Beex et al., section 2.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with the tail on the laws of warp and weft."""
        return with_laws(model, YARNS, self._tail)

    def _tail(self, law: PowerLaw) -> PowerLaw:
        return replace(law, tail_factor=self.slope_change, tail_onset=plastic_part(law, self.onset))
