"""What bias coupons alone gave, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np


if TYPE_CHECKING:
    from etextile.studies.identify.bias import BiasIdentification


SHOWN = (5.0, 15.0, 25.0, 35.0, 45.0)
"""Shear angles, deg, at which the law is told."""


def bias_text(found: BiasIdentification) -> str:
    """Return law, foretold sizes and what was assumed, readable at 80 columns."""
    law, diagonal = found.law, found.fabric.diagonal
    reach = float(np.degrees(law.angle[-1]))
    lines = [found.title, f"shear law of {len(found.coupons)} bias coupons, up to {reach:.1f} deg", ""]
    lines.append(f"  {'shear angle, deg':24}" + "".join(f"{x:9.0f}" for x in SHOWN if x <= reach))
    values = law.shear_force(np.radians([x for x in SHOWN if x <= reach]))
    lines.append(f"  {'shear force, N/mm':24}" + "".join(f"{value:9.4g}" for value in values))
    if found.foretold:
        lines += ["", "  foretold by the law of the other sizes, difference over the peak force:"]
        for item in found.foretold:
            more = ", sheared further than the others" if item.beyond else ""
            lines.append(f"    {item.name:22} mean {item.mean:6.1%}   largest {item.largest:6.1%}{more}")
    else:
        lines += ["", "  one size only: how well it foretells another one is not known"]
    lines += [
        "",
        f"  diagonals: H {diagonal.H.value:.4g} MPa, n {diagonal.n.value:.3g}; off the law by {found.missed:.1%}",
        "    of its largest moment (rms)",
        "  ! warp and weft were not measured and are near inextensible (0.1 % under the",
        "    largest stress of these coupons); give their curves to identify them",
        f"  weave from {found.base}",
    ]
    return "\n".join(lines) + "\n"
