"""Loop strains of a sleeve on the parametric elbow against the same sleeve on the skinned body mesh, equal girths.

    python tests/benchmarks/limb_mesh.py [--coarsening 39] [--folder DIR]

Runs the case elbow_sleeve_mesh with linear blend skinning and with dual quaternions, and the parametric elbow with the
girths that the mesh has at the joint and where the cuffs are, all with the same lattice and wires, to 90 degrees.
Prints, for 60 and 90 degrees and by the loops' place around the arm, the strain of the fabric under the loops and where
it differs by more than 0.02, and how far the outer line of the bare limb runs; --folder leaves results and a picture.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np


sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.limb_lines import fitted, outline, taut

import etextile as et
from etextile.contact.bending import Bending
from etextile.types import Array
from loadcases.build_worn import limb_of


ANGLES = (60.0, 90.0)
TELLING = 0.02
"""Difference of strain that is explained."""
SECTORS = ((0.0, 30.0), (30.0, 60.0), (60.0, 90.0), (90.0, 180.0))
"""Places around the arm from the outer line, deg."""
COMMON = {"fabric.portion": "whole", "motion.flexion": 90, "motion.steps": 9, "outputs.maps": []}


@dataclass(frozen=True)
class Bent:
    """Fabric strain (A, L) of loops at the angles, whether ever folded (L,), place around (L,) deg, moment N mm."""

    name: str
    limb: Bending
    strain: Array
    folded: Array
    around: Array
    moment: Array


def main() -> None:
    """Run, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--coarsening", type=float, default=39.0)
    parser.add_argument("--folder", type=Path)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = asked.folder or Path(scratch)
        found = [run(name, folder, asked.coarsening) for name in ("parametric", "linear", "dual_quaternion")]
        for other in found[1:]:
            table(found[0], other)
        outer_lines(found)
        if asked.folder:
            picture(found, folder / "limb_mesh.png")


def run(name: str, folder: Path, coarsening: float) -> Bent:
    """Return what becomes of the sleeve on one limb."""
    case = et.load("elbow_sleeve_mesh", {**COMMON, "fabric.coarsening": coarsening})
    if name == "parametric":
        case = et.load("elbow_sleeve", {**COMMON, "fabric.coarsening": coarsening, **fitted(limb_of(case.case))})
    else:
        changes = {**COMMON, "fabric.coarsening": coarsening, "body.skinning": name}
        case = et.load("elbow_sleeve_mesh", changes)
    target = folder / name
    made = et.open(target) if (target / "results.vtkhdf").is_file() else et.run(case, target)
    results = made.results
    steps = [int(np.argmin(np.abs(results.displacement_mm - angle))) for angle in ANGLES]
    wires = results.wires
    assert wires is not None
    layout = wires.layout
    around = 360.0 * layout.weft_mm[layout.loop_wire] / case.case.pattern[1]
    folded = (wires.span_strain[1:][results.displacement_mm > 0.0] < -0.05).any(axis=0)
    moment = np.degrees(results.curves.punch_force_N[steps])
    return Bent(name, limb_of(case.case), wires.span_strain[1:][steps], folded, around, moment)


def table(one: Bent, other: Bent) -> None:
    """Print strains by place around the arm."""
    print(f"\nloops on the {one.name} elbow | on the mesh, {other.name} | difference: mean, largest; over {TELLING:g}")
    open_ = ~(one.folded | other.folded)
    for row, angle in enumerate(ANGLES):
        for low, high in SECTORS:
            chosen = open_ & (np.abs(one.around) >= low) & (np.abs(one.around) < high)
            if not chosen.any():
                continue
            a, b = one.strain[row, chosen], other.strain[row, chosen]
            apart = b - a
            print(
                f"{angle:3.0f} deg, {low:3.0f} to {high:3.0f} deg around, {chosen.sum():3d} loops: "
                f"{a.mean():+.3f} | {b.mean():+.3f} | {apart.mean():+.3f}, {apart[np.abs(apart).argmax()]:+.3f}; "
                f"{np.sum(np.abs(apart) > TELLING)}"
            )
        print(
            f"{angle:3.0f} deg, moment: {one.moment[row] / 1e3:.1f} | {other.moment[row] / 1e3:.1f} N m; "
            f"loops in folds: {one.folded.sum()} | {other.folded.sum()} of {len(open_)}"
        )


def outer_lines(found: list[Bent]) -> None:
    """Print how far the skin of the outer line is from the hinge, and how long a taut line over it is."""
    print(
        "\nouter line of the bare limb: distance from the hinge over the joint, mm; taut line between the cuffs, strain"
    )
    for item in found:
        for degrees in (0.0, *ANGLES):
            line = outline(item.limb, degrees)
            size = np.hypot(*line.T)
            top = size[np.abs(np.arctan2(line[:, 0], line[:, 1])) < np.radians(max(0.5 * degrees, 5.0))]
            print(
                f"{item.name:16s} {degrees:3.0f} deg: {top.min():.1f} to {top.max():.1f}; "
                f"{taut(item.limb, degrees):+.3f}"
            )


def picture(found: list[Bent], path: Path) -> None:
    """Draw strain over the place around the arm at both angles, and the outer lines at 90 degrees."""
    from matplotlib.figure import Figure

    colours = {"parametric": "#1f4e79", "linear": "#c0392b", "dual_quaternion": "#d68910"}
    names = {"parametric": "parametric", "linear": "mesh, linear", "dual_quaternion": "mesh, dual quaternion"}
    figure = Figure(figsize=(11.0, 3.8), layout="constrained")
    axes = figure.subplots(1, 3)
    for row, (plot, angle) in enumerate(zip(axes, ANGLES, strict=False)):
        for item in found:
            clear = ~item.folded
            plot.plot(item.around[clear], 100 * item.strain[row, clear], ".", ms=4, color=colours[item.name], alpha=0.5)
            places = np.unique(item.around[clear])
            means = [100 * item.strain[row, clear & (item.around == place)].mean() for place in places]
            plot.plot(places, means, "-", color=colours[item.name], label=names[item.name])
        plot.set(
            title=f"{angle:g} deg", xlabel="place around the arm [deg], 0: outer line", ylabel="strain of loops [%]"
        )
        plot.set_xlim(-130, 130)
        plot.grid(alpha=0.3)
    axes[0].legend(frameon=False, fontsize=8)
    for item in found:
        line = outline(item.limb, 90.0)
        axes[2].plot(*line.T, color=colours[item.name], label=names[item.name])
    axes[2].plot(0.0, 0.0, "k+", ms=9)
    axes[2].annotate("hinge", (0.0, 0.0), textcoords="offset points", xytext=(6, -10), fontsize=8)
    axes[2].set(
        title="outer line at 90 deg, y = 0", xlabel="x [mm]", ylabel="z [mm]", xlim=(-100, 100), ylim=(-110, 60)
    )
    axes[2].set_aspect("equal")
    axes[2].grid(alpha=0.3)
    figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
