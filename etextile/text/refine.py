"""What refinement found, as text: how far the direct use of each curve was off over strain, and what changed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from etextile.identify.result import DIRECTION_OF


if TYPE_CHECKING:
    from etextile.studies.identify.found import Identification, Refinement

COLUMNS = 7


def refinement_text(result: Identification) -> str:
    """Return the summary of a refinement, readable at 80 columns; empty without one."""
    found = result.refinement
    if found is None:
        return ""
    coupon = next(iter(found.coupons.values()))
    size = f"{coupon.size[0]:g} x {coupon.size[1]:g} mm, coarsening {coupon.coarsening:.3g}"
    end = "converged" if found.refined.converged else "NOT CONVERGED, the best round is kept"
    lines = [
        f"refined by virtual coupons of {size}: {found.refined.rounds} rounds, {end}",
        "",
        "direct use of a curve, simulated over measured stress:",
    ]
    for family in found.targets:
        curve, off = found.direct[family]
        strain = curve.strain
        chosen = np.linspace(0, len(strain) - 1, COLUMNS + 1).round().astype(int)[1:]
        lines.append(f"  {DIRECTION_OF[family]:5} at strain  " + "".join(f"{strain[k]:8.1%}" for k in chosen))
        lines.append(f"  {'':5} off by     " + "".join(f"{off[k]:+8.1%}" for k in chosen))
    lines += ["", f"  {'':9}{'H direct':>10}{'refined':>10}{'n direct':>10}{'refined':>10}{'coupon off by':>26}"]
    lines += [_row(family, result, found) for family in found.targets]
    return "\n".join(lines) + "\n"


def _row(family: str, result: Identification, found: Refinement) -> str:
    """Return the line of one family: parameters before and after, root mean square of what is left."""
    before, after = result.identified.families[family].law, found.refined.laws[family]
    target = found.targets[family]
    left = found.refined.after[family] * target.stress
    share = float(np.linalg.norm(left) / np.linalg.norm(target.stress))
    return (
        f"  {family:9}{before.H:10.0f}{after.H:10.0f}{before.n:10.3f}{after.n:10.3f}"
        f"{f'{share:.1%} rms up to {target.strain[-1]:.1%}':>26}"
    )
