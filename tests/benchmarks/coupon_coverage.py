"""How often the 95 % intervals of E, H and n hold the truth, by what hides in the curves; made without the package.

    python tests/benchmarks/coupon_coverage.py [campaigns, 100 by default] [names of rows]

A campaign is three specimens of one direction. Curves come from numpy alone, parametrised by plastic strain, with noise
of 0.5 % of the peak; specimens scatter by 3 % in E and stress and 1.5 % in n. About half a second a campaign; the
table is that of the validation page.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.identify.curves import TensileCurve
from etextile.identify.fit import fit_direction


LAWS = {"warp": (3000.0, 0.2, 9960.0, 1.5, 0.12), "bias": (1500.0, 0.2, 1550.0, 2.2, 0.45)}
"""E, sigma_y0, H in MPa, n, largest strain."""
RATIO = {"warp": 0.0561 / 0.0155, "bias": 0.0489 / 0.0155}
AREA, LENGTH = 29.0 * 0.35, 60.0
NOISE, SPECIMENS, POINTS = 0.005, 3, 121
INSIDE = 1.96
Curve = tuple[np.ndarray, np.ndarray]


def pulled(E: float, sigma_y0: float, H: float, n: float, *, top: float, ratio: float) -> Curve:
    """Engineering strain and fabric stress of loading to `top` and unloading; s(p) on a fine grid of p."""
    p = np.concatenate([[0.0], np.geomspace(1e-9, 1.5 * np.log1p(top), 40000)])
    stress = sigma_y0 * p / (p + 1e-3) + H * p**n
    hencky = np.log1p(np.linspace(0.0, top, POINTS))
    kept = np.interp(hencky, p + stress / E, p)
    loading = np.interp(kept, p, stress) * np.exp(-kept)
    back = E * np.exp(-kept[-1]) * (np.linspace(hencky[-1], kept[-1], 30)[1:] - kept[-1])
    strain = np.expm1(np.r_[hencky, kept[-1] + back / (E * np.exp(-kept[-1]))])
    return strain, np.r_[loading, back] / ratio


def plain(curve: Curve, rng: np.random.Generator) -> Curve:
    return curve


def with_toe(curve: Curve, rng: np.random.Generator) -> Curve:
    """0.2 to 1.5 % that yarns take up over 1 to 10 % of the peak stress."""
    strain, stress = curve
    toe, over = rng.uniform(0.002, 0.015), rng.uniform(0.01, 0.1) * stress.max()
    return np.expm1(np.log1p(strain) + toe * (1.0 - np.exp(-stress / over))), stress


def with_machine(curve: Curve, rng: np.random.Generator) -> Curve:
    """A compliance of half-normal 1 / (1000 N/mm)."""
    strain, stress = curve
    return strain + abs(rng.normal()) * 1e-3 * AREA / LENGTH * stress, stress


def with_both(curve: Curve, rng: np.random.Generator) -> Curve:
    return with_machine(with_toe(curve, rng), rng)


def set_to_zero(curve: Curve, rng: np.random.Generator) -> Curve:
    """Strain and stress set to zero at 0.5 to 3 % of the peak."""
    strain, stress = curve
    top = int(np.argmax(strain))
    preload = rng.uniform(0.005, 0.03) * stress.max()
    start = float(np.interp(preload, stress[: top + 1], strain[: top + 1]))
    kept = np.r_[strain[: top + 1] > start, stress[top + 1 :] > preload]
    return (1.0 + np.r_[start, strain[kept]]) / (1.0 + start) - 1.0, np.r_[preload, stress[kept]] - preload


@dataclass(frozen=True)
class Row:
    """What hides in the curves of a row; `on_specimen`: strain known to be measured there."""

    law: str
    hides: Callable[[Curve, np.random.Generator], Curve]
    on_specimen: bool


ROWS = {
    f"{law}, {name}{', strain of the specimen' * known}": Row(law, hides, known)
    for law in LAWS
    for name, hides, known in (
        ("nothing", plain, True),
        ("nothing", plain, False),
        ("toe", with_toe, True),
        ("machine", with_machine, False),
        ("toe and machine", with_both, False),
        ("set to zero at a preload", set_to_zero, True),
        ("set to zero at a preload", set_to_zero, False),
    )
}


def campaign(row: Row, seed: int) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Deviations that E, H and n are off, their standard deviations, and what was said."""
    rng = np.random.default_rng(seed)
    E, sigma_y0, H, n, top = LAWS[row.law]
    reference, curves = np.log(0.6 * np.log1p(top)), []
    # what testers do, they do to every specimen alike in kind, and by another amount
    machine = int(rng.integers(2**31))
    for number in range(SPECIMENS):
        own = (E * np.exp(0.03 * rng.normal()), n * (1.0 + 0.015 * rng.normal()), 0.03 * rng.normal())
        law = (own[0], sigma_y0, H * np.exp(own[2] - (own[1] - n) * reference), own[1])
        curve = pulled(*law, top=top, ratio=RATIO[row.law])
        same = np.random.default_rng(machine) if row.hides is with_machine else rng
        strain, stress = row.hides(curve, same)
        loud = stress + rng.normal(0.0, NOISE * stress.max(), len(stress))
        curves.append(replace(TensileCurve.of(f"s{number}", strain, loud), on_specimen=row.on_specimen))
    fit = fit_direction(curves, RATIO[row.law])
    spread = np.sqrt(np.diag(fit.covariance))
    off = np.array([np.log(fit.law.E / E), np.log(fit.law.H / H), fit.law.n - n])
    said = [note for specimen in fit.specimens for note in specimen.notes]
    return off / spread, spread, said


def main(campaigns: int, names: list[str]) -> None:
    print(f"{'':52}hold the truth, %      median deviation, %        said of how many")
    print(f"{'':52}   E    H    n       ln E   ln H   n         zeroed, toe out")
    for name, row in ROWS.items():
        if names and not any(part in name for part in names):
            continue
        held, spreads, zeroed, toes, failed = [], [], 0, 0, 0
        for seed in range(campaigns):
            try:
                off, spread, said = campaign(row, seed)
            except BadInput:
                failed += 1
                continue
            held.append(np.abs(off) < INSIDE)
            spreads.append(spread)
            zeroed += sum("were set to zero" in note for note in said)
            toes += sum("progressive toe" in note and "taken out" in note for note in said)
        shares, median = 100.0 * np.mean(held, axis=0), 100.0 * np.median(spreads, axis=0)
        print(
            f"{name:52}" + "".join(f"{share:5.0f}" for share in shares) + "   "
            + "".join(f"{value:7.2f}" for value in median)
            + f"     {zeroed}, {toes} of {SPECIMENS * len(held)}" + (f", {failed} refused" if failed else ""),
            flush=True,
        )  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100, sys.argv[2:])
