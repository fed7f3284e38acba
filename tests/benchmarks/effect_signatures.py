"""Print how every effect of the library shows in the paper's punch test: the numbers on the cards.

    python tests/benchmarks/effect_signatures.py [ID ...] [--coarsening 19.5] [--step 2.5]

Change of the punch force (per cent) and of the largest draw-in of the free edge (mm) at 10, 20, 25, 30 and 40 mm for
the example on each card; quarter of 9 x 16 cells, estimated_mid, no wires. The guide is the table of expected
signatures that the library was started from; its sizes are not stated for all effects, so only shapes compare.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from etextile.effects.registry import EFFECTS, build_effect
from etextile.errors import NoEquilibrium
from etextile.mechanics.model import Model
from etextile.solve.newton import Settings
from etextile.solve.path import advance
from loadcases.build import build, settings
from loadcases.reader import load_case


AT = (10.0, 20.0, 25.0, 30.0, 40.0)
GUIDE = {
    "rotational_shear": "-6/-12/-15/-17/-22",
    "yarn_tail": "0/0/0/-6/-24",
    "yarn_damage": "softening",
    "clamp_slip": "0, plateau",
    "clamp_compliance": "-5/-6/-6/-5/-3",
    "machine_compliance": "0/-3/-5/-7/-9",
    "datum_offset": "-36/-19/-14/-11/-6",
    "pretension": "+127/+29/+18/+12/+6",
    "punch_friction": "0/+1/+2/+4/+8",
    "yarn_sliding": "softening late",
    "shear_locking": "corners",
    "crimp_interchange": "0/+2/+3/+5/+10",
    "rate_dependence": "flat",
    "bending_stiffness": "+18/+4/+2/+1/+1",
    "compression_carry": "+5/+1/0/0/0",
    "geometry": "flat",
}


@dataclass
class Run:
    """Force N and draw-in mm by displacement, linear solves, how the run ended."""

    force: dict[float, float] = field(default_factory=dict)
    edge: dict[float, float] = field(default_factory=dict)
    solves: int = 0
    end: str = ""
    seconds: float = 0.0


def run(model: Model, chosen: Settings) -> Run:
    """Return the curves of a model."""
    edge = model.lattice.edges["y_max"]
    found, start = Run(), time.perf_counter()
    try:
        for item in advance(model, chosen):
            at = round(item.displacement_mm, 6)
            found.force[at] = item.punch_force_N
            found.edge[at] = float((model.lattice.points[edge, 1] - item.positions[: len(edge)][edge, 1]).max())
            found.solves += item.verdict.linear_solves
    except NoEquilibrium:
        found.end = f"ends at {max(found.force, default=0.0):.1f} mm"
    found.seconds = time.perf_counter() - start
    return found


def compare(base: Run, found: Run) -> tuple[list[float], list[float]]:
    """Return changes of force in per cent and of draw-in in mm; NaN beyond the end."""
    force = [100.0 * (found.force.get(at, np.nan) / base.force[at] - 1.0) for at in AT]
    return force, [found.edge.get(at, np.nan) - base.edge[at] for at in AT]


def text(parameters: Mapping[str, float]) -> str:
    """Return parameters in one word each."""
    return ", ".join(f"{name} {value:g}" for name, value in parameters.items())


def main() -> None:
    """Print one row per effect."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("ids", nargs="*")
    parser.add_argument("--coarsening", type=float, default=19.5)
    parser.add_argument("--step", type=float, default=2.5)
    options = parser.parse_args()
    loaded = load_case("punch", overrides=["wires=null", f"fabric.coarsening={options.coarsening}"])
    model, chosen = build(loaded.case).model, settings(loaded.case)
    model = replace(model, travel=np.arange(1, round(45.0 / options.step) + 1) * options.step)
    base = run(model, chosen)
    print(f"base {base.solves} solves, {base.seconds:.1f} s, force", *(f"{base.force[at]:.1f}" for at in AT))
    for name in options.ids or EFFECTS:
        parameters = EFFECTS[name].card.example.parameters
        found = run(build_effect(name, parameters).apply(model), chosen)
        force, edge = compare(base, found)
        print(
            f"{name:18s} {text(parameters):36s} ({', '.join(f'{v:+.1f}' for v in force)}) "
            f"({', '.join(f'{v:+.2f}' for v in edge)})  guide {GUIDE.get(name, ''):22s} "
            f"{found.solves} solves {found.seconds:.1f} s {found.end}",
            flush=True,
        )


if __name__ == "__main__":
    main()
