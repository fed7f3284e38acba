"""What each device of the solver buys: linear solves of the punch with one device at a time switched off.

    python tests/benchmarks/ablation.py [--coarsening 19.5 4.87] [--set estimated_mid]

Sphere of 30 mm to 52.5 mm from flat and slack, frictionless, 21 increments. `failed` means that some increment found
no equilibrium with the device off; the solves until then are given.
"""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.mechanics.model import Model
from etextile.solve import barrier, interior, member, path, step
from etextile.solve.newton import Settings
from etextile.solve.path import advance
from etextile.solve.system import System
from etextile.types import Array
from loadcases.build import build, settings
from loadcases.reader import load_case


Switch = Callable[[], contextlib.AbstractContextManager[object]]


@dataclass(frozen=True)
class Device:
    """A row: what is switched off, how, and changes of settings, increments or initial model."""

    name: str
    switch: Switch = contextlib.nullcontext
    steps: int = 21
    nonlinear: str = "newton"
    kink: float = 1e-3


def no_prediction() -> contextlib.AbstractContextManager[object]:
    """Start every increment where the last one ended, supports and contact carried along."""
    predict = path.predict
    return patch.object(
        path, "predict", lambda system, now, travel: predict(system, replace(now, x_before=now.x), travel)
    )


def plain_aim(*, mehrotra: bool) -> contextlib.AbstractContextManager[object]:
    """Aim at one mu for all pairs, without second-order part; without `mehrotra` always at a tenth of the mean."""

    def aim(self: barrier.Linear, change: tuple[Array, Array], length: float, floor: float) -> Array:
        rise, widening = change
        now = float(np.mean(self.force * self.slack))
        force = np.maximum(self.force + length * self.slope * rise, 0.0)
        foreseen = float(np.mean(force * np.maximum(self.slack + length * widening, 0.0)))
        share = np.clip((foreseen / now) ** 2, barrier.LEAST_CENTRING, barrier.MOST_CENTRING) if mehrotra else 0.1
        return np.full(len(force), max(float(share) * now, floor))

    return patch.object(barrier.Linear, "aim", aim)


def no_second_order() -> contextlib.AbstractContextManager[object]:
    """Leave the second-order part of the products out of the corrector."""
    return plain_aim(mehrotra=True)


def no_mehrotra() -> contextlib.AbstractContextManager[object]:
    """Bring the mean product down to a tenth in every step, however well the predictor does."""
    return plain_aim(mehrotra=False)


@contextlib.contextmanager
def no_turning() -> Iterator[None]:
    """Leave the length that trusses gain by turning out of the corrector."""
    target = member.Target

    def flat(product: Array, bulge: Array) -> member.Target:
        return target(product, np.zeros_like(bulge))

    flat.zero = target.zero  # type: ignore[attr-defined]
    with patch.object(member, "Target", flat):
        yield


def common_step() -> contextlib.AbstractContextManager[object]:
    """Shorten the step of all elements so that the first pair to turn negative stops at 1 % of itself."""
    move = step.move

    def cut(system: System, now: step.Iterate, found: member.Step) -> step.Iterate:
        longest = found.length
        for one in now.members:
            if not isinstance(one, member.Linearised):
                continue
            for value, rate in zip((one.pairs.stretch, one.pairs.slack), one.change(found), strict=True):
                falls = rate < 0.0
                longest = min(longest, 0.99 * float((value[falls] / -rate[falls]).min(initial=np.inf)))
        return move(system, now, replace(found, length=longest))

    return patch.object(step, "move", cut)


def late_limits() -> contextlib.AbstractContextManager[object]:
    """Look at penetration only when an increment has converged."""
    return patch.object(interior, "NEAR", 0.0)


def whole_steps() -> contextlib.AbstractContextManager[object]:
    """Never shorten the steps, whatever the residual does."""
    return patch.object(interior, "HESITATION", 10**9)


def no_subdomains() -> contextlib.AbstractContextManager[object]:
    """Leave the worst nodes of a step to the next step of the whole lattice."""
    return patch.object(interior, "settle", lambda system, now, tolerance: now)


def no_softening() -> contextlib.AbstractContextManager[object]:
    """Leave the softening of trusses past their force peak out of the tangent."""
    linearise = member.Linear.of
    return patch.object(member.Linear, "of", lambda pair, *, exact: linearise(pair, exact=False))


DEVICES = (
    Device("all devices"),
    Device("no prediction from the increment before", no_prediction),
    Device("no second-order part of the products", no_second_order),
    Device("nor Mehrotra centring (a tenth each step)", no_mehrotra),
    Device("no turning of trusses in the corrector", no_turning),
    Device("one step length for all pairs", common_step),
    Device("penetration looked at only at the end", late_limits),
    Device("no shortened steps when the residual does not fall", whole_steps),
    Device("no subdomains settled apart", no_subdomains),
    Device("no softening in the tangent", no_softening),
    Device("a sharp yield point (e0 = 1e-6)", kink=1e-6),
    Device("half the increments (10 of 5.25 mm)", steps=10),
    Device("twice the increments (42 of 1.25 mm)", steps=42),
    Device("damped Newton on positions alone", nonlinear="damped"),
)


def model_of(device: Device, coarsening: float, fabric: str) -> tuple[Model, Settings]:
    """Return the model and the settings of a row."""
    chosen = ["wires=null", f"fabric.set={fabric}", f"fabric.coarsening={coarsening}", f"motion.steps={device.steps}"]
    case = load_case("punch", overrides=chosen).case
    model = build(case).model
    lattice, *others = model.contributions
    laws = tuple(replace(law, e0=device.kink) for law in lattice.laws)
    model = replace(model, contributions=(replace(lattice, laws=laws), *others))
    return model, replace(settings(case), nonlinear=device.nonlinear, max_iterations=150)


def run(device: Device, coarsening: float, fabric: str) -> str:
    """Return linear solves and cut-backs of one run as text."""
    model, chosen = model_of(device, coarsening, fabric)
    solves = cuts = 0
    with device.switch():
        try:
            for found in advance(model, chosen):
                solves, cuts = solves + found.verdict.linear_solves, cuts + found.verdict.cut_backs
        except NoEquilibrium as error:
            return f"{solves} failed{str(error).split('at')[1].split('after')[0]}"
    return f"{solves}" + (f", {cuts} cut-backs" if cuts else "")


def main() -> None:
    """Print one row per device."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--coarsening", type=float, nargs="+", default=[19.5, 4.87])
    parser.add_argument("--set", default="estimated_mid", help="fabric set")
    options = parser.parse_args()
    print(f"{'switched off':52}" + "".join(f"{f'coarsening {value:g}':>26}" for value in options.coarsening))
    for device in DEVICES:
        print(
            f"{device.name:52}" + "".join(f"{run(device, value, options.set):>26}" for value in options.coarsening),
            flush=True,
        )


if __name__ == "__main__":
    main()
