"""Numbers and pictures of the virtual coupons: departures from single elements, the bias test, the nylon prediction.

    python tests/benchmarks/coupon_departure.py [folder for the pictures, viz/pictures by default]

Takes about two minutes; the numbers it prints are those of the validation pages.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np


sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.coupon_plots import bias_departure, prediction_figure, yarn_departures
from support.departure import along_yarns, held_width_share, in_bias_direction
from support.nylon import predictions, under_assumptions

from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.identify import weave_of
from loadcases.fabric import load_fabric
from viz.style import drawing


SIZE, COARSENING = (60.0, 29.0), 6.0
PICTURES = Path(__file__).resolve().parents[2] / "viz" / "pictures"


def main(folder: Path) -> None:
    fabric = load_fabric("estimated_mid")
    weave = weave_of(fabric)
    families = (fabric.warp, fabric.weft, fabric.diagonal)
    laws = [PowerLaw(f.E.value, f.sigma_y0.value, f.H.value, f.n.value, e0=f.e0) for f in families]
    strain = np.linspace(0.0, 0.12, 13)[1:]
    found = {}
    for number, name in enumerate(("warp", "weft")):
        found[name] = along_yarns(weave, laws, number, size=SIZE, coarsening=COARSENING, strain=strain)
        table(f"coupon along the {name} over a single element - 1, %", strain, found[name].coupons)
        closed = 100.0 * held_width_share(weave, laws, number, strain=0.12)
        print(f"  width held, closed form, both diagonals at 12 %: {closed:.2f} %\n")
    strain = np.linspace(0.0, 0.32, 17)[1:]
    bias = in_bias_direction(weave, laws, size=SIZE, coarsening=COARSENING, strain=strain)
    table("bias over a single diagonal - 1, %", strain, bias.coupons)
    nylon = predictions((0, 30, 45, 90))
    print("\nnylon: mean error, mean absolute error, rms, at the end, datum")
    for angle, item in nylon.items():
        numbers = (item.mean_error, item.mean_absolute_error, item.rms, item.at_end)
        print(
            f"  {angle:2d} deg " + "".join(f"{100.0 * number:+8.1f} %" for number in numbers) + f"  {item.datum:+.4f}"
        )
    print("\nnylon at 30 deg under other assumptions (unit cell): mean error, at the end")
    for name, item in under_assumptions().items():
        print(f"  {name:28}{100.0 * item.mean_error:+8.1f} %{100.0 * item.at_end:+8.1f} %")
    folder.mkdir(parents=True, exist_ok=True)
    with drawing():
        for name, figure in (
            ("coupon_departure", yarn_departures(found)),
            ("bias_departure", bias_departure(bias)),
            ("nylon_prediction", prediction_figure(nylon, predicted=(30,))),
        ):
            figure.savefig(folder / f"{name}.png", dpi=130)
            print(f"wrote {name}.png")


def table(title: str, strain: np.ndarray, columns: dict[str, np.ndarray]) -> None:
    chosen = np.linspace(0, len(strain) - 1, 7).round().astype(int)[1:]
    print(title)
    print(f"  {'at strain':28}" + "".join(f"{100.0 * strain[k]:8.0f}" for k in chosen))
    for name, values in columns.items():
        print(f"  {name:28}" + "".join(f"{100.0 * values[k]:+8.2f}" for k in chosen))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
