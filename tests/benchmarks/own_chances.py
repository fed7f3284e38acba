"""What a run says of its wires and nets, worked out again from the strains in its result file by other means.

    python tests/benchmarks/own_chances.py [cases]

Nothing of the package takes part behind the result file: places break by the weakest link, scatter that garments and
wires share is integrated by Gauss and Hermite's rule in each of its parts (the product uses one grid), the doubt about
the coupons is drawn at random, and nets are taken from the drawing by hand. Rows of the validation page of claims.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np
from own_solutions import run
from scipy.interpolate import RectBivariateSpline


LN2 = float(np.log(2.0))
GRID = np.linspace(-1.8, 1.8, 3601)
"""Logarithms of what parts of a wire have in common."""
Z, WEIGHT = np.polynomial.hermite_e.hermegauss(48)
WEIGHT = WEIGHT / WEIGHT.sum()
DOUBT = np.linspace(-5.0, 5.0, 101)
DRAWS = 400_000

NETS = {
    "knee_pad": {
        "supply": [("VCC", -94.0, 94.0)],
        "data": [("SDA", -94.0, 82.0)],
        "return": [("GND", -94.0, 94.0), [("GND", 94.0, 98.0), ("RTN", -10.0, 10.0), ("SHD", -94.0, 98.0)]],
    }
}
"""Stretches of wire between the outer parts of a net; of one with two ways round, both."""


@dataclass(frozen=True)
class Strains:
    """Greatest strains that a run wrote, and the numbers of its criterion."""

    wires: dict[str, np.ndarray]
    loop: np.ndarray
    element: np.ndarray
    numbers: dict[str, float]

    @classmethod
    def read(cls, path: Path, numbers: dict[str, float]) -> Strains:
        with h5py.File(path) as file:
            own = file["etextile"]
            wires = {name: own["wires"][name][()] for name in own["wires"]}
            loop, element = (
                np.maximum(own["histories"][name][()].reshape(-1, len(wires[of])).max(axis=0), 0.0)
                for name, of in (("wire_strain", "loop_wire"), ("element_strain", "element_wire"))
            )
        return cls(wires, loop, element, numbers)

    @cached_property
    def onsets(self) -> tuple[float, float]:
        """Median strains of the coupons' loops and of wire in their weave."""
        n = self.numbers
        loop, weave = ((1.0 + n["onset"]) / (1.0 + n[name]) - 1.0 for name in ("coupon_slack", "coupon_crimp"))
        return n["strength_factor"] * loop, n["strength_factor"] * n["stress_raiser"] * weave

    @cached_property
    def doubts(self) -> tuple[float, float]:
        """Deviations of the logarithm of both onsets, by differences."""
        n, found = self.numbers, []
        for name in ("coupon_slack", "coupon_crimp"):
            up, down = ((1.0 + n["onset"]) / (1.0 + n[name] + step) - 1.0 for step in (1e-5, -1e-5))
            found.append(n[name + "_std"] * np.log(down / up) / 2e-5)
        return found[0], float(np.hypot(found[1], n["stress_raiser_std"]))

    @cached_property
    def opening(self) -> tuple[np.ndarray, np.ndarray]:
        """Logarithm of strain over onset of a place, and chance that all its filaments break, over its first break."""
        n = self.numbers
        u = (np.arange(100_000) + 0.5) / 100_000
        first = (-np.log1p(-(u**2)) / LN2) ** (1.0 / n["weibull_shape"])
        width = n["scale"] / (1.0 + n["coupon_slack"]) / ((1.0 + n["onset"]) / (1.0 + n["coupon_slack"]) - 1.0)
        places = np.linspace(np.log(0.2), np.log(8.0), 900)
        share = [-np.expm1(-((np.maximum(np.exp(x) / first - 1.0, 0.0) / width) ** n["shape"])) for x in places]
        return places, np.array([(2.0 * u * s ** n["filaments"]).mean() for s in share])

    def broken(self, place: np.ndarray) -> np.ndarray:
        return -np.expm1(-LN2 * np.exp(self.numbers["weibull_shape"] * place))

    def opened(self, place: np.ndarray) -> np.ndarray:
        return np.interp(place, *self.opening, left=0.0)

    def kept(self, chance: Callable, wire: int, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
        """Chances over GRID that loops and weave of a stretch of wire last."""
        w, n = self.wires, self.numbers
        shape, l0 = n["weibull_shape"], n["reference_length"]
        middle = 0.5 * (w["loop_exit_mm"] + w["loop_entry_mm"])
        on = (w["loop_wire"] == wire) & (middle >= low) & (middle <= high)
        span = (w["loop_entry_mm"] - w["loop_exit_mm"])[on]
        loops = np.log(np.maximum(self.loop[on] / self.onsets[0], 1e-9) * (span / l0) ** (1.0 / shape))
        between = np.searchsorted(np.sort(middle[w["loop_wire"] == wire]), w["element_along_mm"])
        twice = 2.0 if np.all(w["vertex_warp_mm"] >= 0.0) and w["start_mm"][wire] == 0.0 else 1.0
        pieces, counts = [], []
        for piece in np.unique(between[w["element_wire"] == wire]):
            own = (w["element_wire"] == wire) & (between == piece)
            length, at = w["element_length_mm"][own], w["element_along_mm"][own]
            inside = np.clip(np.minimum(at + length / 2, high) - np.maximum(at - length / 2, low), 0.0, None)
            one = twice if piece == 0 else 1.0  # what the plane of symmetry cuts is one piece, twice as long
            rate = one * (length / l0 * (self.element[own] / self.onsets[1]) ** shape).sum()
            pieces.append(np.log(max(rate, 1e-300)) / shape)
            counts.append(twice / one * inside.sum() / length.sum())
        return self._lasting(chance, loops, w["loop_copies"][on]), self._lasting(chance, pieces, counts)

    @staticmethod
    def _lasting(chance: Callable, places: np.ndarray | list[float], counts: np.ndarray | list[float]) -> np.ndarray:
        logs = np.zeros(len(GRID))
        for place, count in zip(places, counts, strict=True):
            logs += count * np.log1p(-np.minimum(chance(place - GRID), 1.0 - 1e-16))
        return np.exp(logs)

    def given(self, kept: tuple[np.ndarray, np.ndarray], doubt: np.ndarray) -> np.ndarray:
        """Chance (G, n, n) that a stretch lasts, given the garment and the doubts about loops and weave."""
        n, common = self.numbers, self.numbers["garment_scatter"] * Z
        places = [common[:, None] + std * doubt for std in self.doubts]
        total = 0.0
        for z, weight in zip(n["wire_scatter"] * Z, WEIGHT, strict=True):
            loops, weave = (np.interp(at + z, GRID, part) for at, part in zip(places, kept, strict=True))
            total = total + weight * loops[:, :, None] * weave[:, None, :]
        return total


def event(lost: Callable[[np.ndarray], np.ndarray]) -> str:
    """The mean of an event (G, n, n) of the doubts and the ends of 95 % of what they make of it."""
    mean = np.einsum("i,j,k,ijk", WEIGHT, WEIGHT, WEIGHT, lost(Z))
    over = np.einsum("i,ijk->jk", WEIGHT, lost(DOUBT))
    spline = RectBivariateSpline(DOUBT, DOUBT, np.log(np.maximum(over, 1e-300)))
    drawn = np.exp(spline.ev(*np.random.default_rng(0).standard_normal((2, DRAWS))))
    return "{:.4g} ({:.3g} to {:.3g})".format(mean, *np.quantile(drawn, [0.025, 0.975]))


def beside(case: str) -> None:
    """Print what `etextile run` says of a case and what follows from its strains."""
    with tempfile.TemporaryDirectory() as folder:
        report = run(case, ("outputs.maps=[]",), Path(folder) / "out")
        numbers = {key: item["value"] for key, item in report["failure"]["parameters"].items()}
        strains = Strains.read(Path(folder) / "out" / "results.vtkhdf", numbers)
    copies, found = strains.wires["wire_copies"], report["reliability"]
    names = [name.decode() for name in strains.wires["names"]]
    ends = {name: (strains.wires["start_mm"][k], strains.wires["end_mm"][k]) for k, name in enumerate(names)}

    def said(name: str) -> str:
        return "{:.4g} ({:.3g} to {:.3g})".format(found[name], *found["intervals"][name])

    for name, chance in (("broken", strains.broken), ("open", strains.opened)):
        wires = [strains.kept(chance, k, *ends[wire]) for k, wire in enumerate(names)]

        def lost(doubt: np.ndarray, wires: list = wires) -> np.ndarray:
            return sum(count * (1.0 - strains.given(kept, doubt)) for count, kept in zip(copies, wires, strict=True))

        def some(doubt: np.ndarray, wires: list = wires) -> np.ndarray:
            return 1.0 - np.prod([strains.given(kept, doubt) ** n for n, kept in zip(copies, wires, strict=True)], 0)

        print(f"{case}: wires {name}: product {said(f'expected_wires_{name}')}, own {event(lost)}")
        print(f"{case}: any wire {name}: product {said(f'p_any_wire_{name}')}, own {event(some)}", flush=True)
    for net, ways in NETS.get(case, {}).items():
        row = next(item for item in report["nets"] if item["name"] == net)

        def apart(doubt: np.ndarray, ways: list = ways) -> np.ndarray:
            total = 1.0
            for way in ways:
                stretches = way if isinstance(way, list) else [way]
                total = total * (1.0 - np.prod([strains.given(_on(*part), doubt) for part in stretches], axis=0))
            return total

        def _on(wire: str, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
            return strains.kept(strains.opened, names.index(wire), low, high)

        product = f"{row['loss_probability']:.4g} ({row['low']:.3g} to {row['high']:.3g})"
        print(f"{case}: net {net} lost: product {product}, own {event(apart)}", flush=True)


if __name__ == "__main__":
    for one in sys.argv[1:] or ["elbow", "knee", "knee_pad"]:
        beside(one)
