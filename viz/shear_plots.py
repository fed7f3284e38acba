"""The shear law of bias coupons: normalised shear force over shear angle, and measured and fitted forces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from etextile.files import replacing
from etextile.identify.bias_extension import BiasCoupon, ShearLaw
from viz.style import EDGE, FAINT, SERIES, drawing


LAW = SERIES[0]
"""Colour of what the law gives."""


def save_shear(law: ShearLaw, coupons: Sequence[BiasCoupon], path: Path, *, title: str) -> Path:
    """Draw the law on the left, forces of all coupons with those that it gives on the right; return the path."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with drawing():
        figure = Figure(figsize=(9.0, 4.3), dpi=110, layout="constrained")
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2)
        angle = np.linspace(0.0, law.angle[-1], 181)
        left.plot(np.degrees(angle), law.shear_force(angle), color=LAW, linewidth=1.8)
        left.set(xlabel="shear angle, deg", ylabel="normalised shear force, N/mm", ylim=(0.0, None), xlim=(0.0, None))
        for item, marker in zip(coupons, "osD^v" * len(coupons), strict=False):
            length, width = item.size
            label = f"{item.name}, {length:g} x {width:g} mm"
            thin = slice(None, None, max(1, len(item.force) // 60))
            right.plot(
                item.displacement[thin], item.force[thin], linestyle="none", marker=marker, markersize=3.4,
                color=EDGE, alpha=0.55, label=label,
            )  # fmt: skip
            right.plot(item.displacement, law.force(item.displacement, item.size), color=LAW, linewidth=1.5)
        right.set(xlabel="displacement, mm", ylabel="force, N", ylim=(0.0, None), xlim=(0.0, None))
        right.legend(fontsize=8.5, frameon=False, loc="upper left")
        for axes in (left, right):
            axes.grid(color=FAINT, linewidth=0.6)
            axes.set_axisbelow(True)
        figure.suptitle(f"{title}: shear law (lines) and bias coupons (marks)", x=0.01, ha="left", fontsize=12)
        with replacing(path) as part:
            figure.savefig(part, metadata={"Software": None})
    return path
