"""Yarns lose stiffness from a strain on: fibres break or are pulled out, and what is left carries less.

Damage d = 1 - exp(-rate (eps_p - onset_p)) of the plastic strain eps_p beyond the one at the engineering strain `onset`
multiplies stress and modulus by 1 - d, so unlike a flatter law it shows in unloading too. Past a force maximum damage
gathers in single trusses; what a lattice says there depends on its coarsening.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import YARNS, plastic_part, with_laws
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class YarnDamage(Effect):
    """Warp and weft lose the share 1 - exp(-rate (eps_p - onset)) of stress and modulus."""

    rate: float = 0.0
    onset: float = 0.12

    stage: ClassVar[Stage] = Stage.LAW
    card: ClassVar[Card] = Card(
        id="yarn_damage",
        mechanism="Yarns lose stiffness from a strain on.",
        parameters=(
            Parameter("rate", "", 0.0, 10.0, "the share of stiffness lost per unit of plastic strain past the onset"),
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
        example=Example({"rate": 3.0, "onset": 0.12}, (0.0, 0.0, -0.1, -2.6, -11.4), (0.0, 0.0, 0.0, 0.0, -0.25)),
        signature=(
            Signature("punch_force", -1, 25.0, "nothing, then softening that grows faster than with a flatter law"),
            Signature("tensile", 0, 0.0, "none before the onset; unloading beyond it is softer"),
            Signature("strain_field", 1, 25.0, "strain gathers over the punch"),
        ),
        confused_with=("yarn_tail", "clamp_slip", "yarn_sliding"),
        separate="Unload from above the onset: the slope of unloading falls with damage and with nothing else.",
        literature="Continuum damage of fibre bundles: Lemaitre and Chaboche, Mechanics of Solid Materials (1990), "
        "chapter 7; Daniels, Proc. R. Soc. A 183 (1945) 405.",
        limits="Past the force maximum of a yarn the result depends on the coarsening.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with damage in the laws of warp and weft."""
        return with_laws(model, YARNS, self._damaged)

    def _damaged(self, law: PowerLaw) -> PowerLaw:
        return replace(law, damage_rate=self.rate, damage_onset=plastic_part(law, self.onset))
