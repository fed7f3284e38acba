"""The same punch with etextile and with FElupe: time, force and penetration on the same lattice.

    python tests/benchmarks/felupe_side_by_side.py [--coarsening 4.875] [--steps 100] [--seconds 1800]

FElupe (pip install felupe==11.3.0, the extra `benchmark`) is given the same trusses with the same law, compiled here,
its own rigid contact with a sphere added as its manual shows, its line search, its cut-backs and PARDISO. It does not
start from flat and slack, so its trusses are 0.5 % short; that changes the force most at the beginning.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from typing import Any

import numpy as np
from scipy.sparse import eye_array

from etextile.compiled import njit
from etextile.laws.powerlaw import respond
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.solve.path import advance
from etextile.types import Array
from loadcases.build import build, settings
from loadcases.reader import load_case


AT = (5.0, 25.0, 40.0, 50.0, 52.5)
RADIUS, SHORT = 15.0, 0.005
PENALTY = 0.3
"""Multiple of the stiffness FElupe takes for its contact; with 1 or more it does not get past the first touch."""
SOFTEST = 1e-6
"""On the diagonal, N/mm: nodes whose trusses are all slack have no stiffness at all."""

Curve = dict[float, tuple[float, float]]
"""Force N and penetration mm by displacement mm."""


@njit
def fill(table, law, strain, plastic, found):  # type: ignore[no-untyped-def]
    """Fill the rows tau, d tau / d eps, eps_p of found (3, M) at Hencky strains (M,)."""
    for e in range(len(strain)):
        found[0, e], found[1, e], found[2, e] = respond(table[law[e]], strain[e], plastic[e])


class Law:
    """The truss law as FElupe asks for it: first and second derivative of the energy by the stretch."""

    def __init__(self, block: TrussBlock) -> None:
        self.block = block
        self.x = [np.zeros(1), np.zeros(0)]

    def evaluate(self, stretch: Array, plastic: Array) -> tuple[Array, Array, Array]:
        """Return stress and slope by the stretch, MPa on A0, and the plastic strain, each (M,)."""
        found = np.empty((3, len(stretch)))
        fill(self.block.table, self.block.law, np.log(stretch / (1.0 - SHORT)), plastic, found)
        tau, slope, p = found
        return tau / stretch, (slope - tau) / stretch**2, p

    def gradient(self, x: list[Any]) -> list[Any]:
        stress, _, plastic = self.evaluate(x[0], x[-1])
        return [stress, plastic]

    def hessian(self, x: list[Any]) -> list[Any]:
        return [self.evaluate(x[0], x[-1])[1]]


def ours(model: Model, chosen: Any) -> tuple[Curve, float, str]:
    """Return the curve of etextile, its seconds and what it took."""
    begun, curve, solves = time.perf_counter(), {}, 0
    for step in advance(model, chosen):
        solves += step.verdict.linear_solves
        curve[round(step.displacement_mm, 6)] = (step.punch_force_N, step.max_penetration_mm)
    return curve, time.perf_counter() - begun, f"{len(curve)} increments, {solves} linear solves"


def theirs(model: Model, steps: int, seconds: float) -> tuple[Curve, float, str]:
    """Return the curve of FElupe, its seconds and how it ended."""
    import felupe as fem
    from felupe.mechanics import ContactRigidBase
    from pypardiso import spsolve

    class ContactRigidSphere(ContactRigidBase):  # type: ignore[misc]
        def _kinematics(self, dx: Array) -> tuple[Array, Array, Array]:
            distance = np.linalg.norm(dx, axis=1)
            normal = dx / distance[:, None]
            plane = np.eye(3) - np.einsum("ai,aj->aij", normal, normal)
            return distance - RADIUS, normal, plane / distance[:, None, None]

    def solver(matrix: Any, load: Array) -> Array:
        return np.asarray(spsolve(matrix + SOFTEST * eye_array(matrix.shape[0], format="csr"), load))

    class Recorder(fem.Plugin):  # type: ignore[misc]
        def after_substep(self, context: Any, state: Any) -> None:
            x = mesh.points + field[0].values
            travel = float(field[0].values[centre, 2])
            depth = RADIUS - float(np.linalg.norm(x[points] - x[centre], axis=1).min())
            force = contact.assemble.vector(field).toarray()[3 * centre + 2, 0]
            curve[round(travel, 6)] = (abs(float(force)) * model.force_factor, max(depth, 0.0))
            if time.perf_counter() - begun > seconds:
                raise TimeoutError(f"stopped at {travel:.4g} mm after {seconds:g} s")

    lattice = model.lattice_block
    mesh = fem.Mesh(model.points, lattice.nodes, cell_type="line")
    mesh.add_points([0.0, 0.0, -RADIUS])
    field = fem.Field(fem.RegionTruss(mesh), dim=3).as_container()
    centre = len(model.points)
    held = np.vstack([model.fixed, [[True, True, False]]])
    moved = np.zeros_like(held)
    moved[centre, 2] = True
    fixed, move = fem.Boundary(field[0], mask=held), fem.Boundary(field[0], mask=moved)
    truss = fem.TrussBody(Law(lattice), field, area=lattice.area, statevars=np.zeros(len(lattice.nodes)))
    points = np.flatnonzero(~model.fixed.all(axis=1))
    contact = ContactRigidSphere(field, points, centre, multiplier=PENALTY, items=[truss])
    ramp = np.linspace(0.0, model.travel[-1], steps + 1)
    step = fem.Step(items=[truss, contact], ramp={move: ramp}, boundaries={"fixed": fixed, "move": move})
    plugins = [fem.LinesearchPlugin(admissible=False), fem.CutbackPlugin(), Recorder()]
    curve: Curve = {}
    begun, ended = time.perf_counter(), "to the end"
    try:
        fem.Job(steps=[step], plugins=plugins).evaluate(verbose=0, solver=solver, maxiter=60, tol=1e-5)
    except (fem.NewtonConvergenceError, TimeoutError) as error:
        ended = str(error).splitlines()[0]
    return curve, time.perf_counter() - begun, f"{len(curve)} of {steps} increments, {ended}"


def main() -> int:
    """Print both side by side; 2 when FElupe is not there."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--coarsening", type=float, default=4.875)
    parser.add_argument("--steps", type=int, default=105, help="increments of FElupe")
    parser.add_argument("--seconds", type=float, default=1800.0, help="FElupe is stopped after about this long")
    options = parser.parse_args()
    if importlib.util.find_spec("felupe") is None:
        print("FElupe is not installed; it is needed for this comparison only: pip install felupe==11.3.0")
        return 2
    case = load_case("punch", overrides=["wires=null", f"fabric.coarsening={options.coarsening}"]).case
    model = build(case).model
    runs = {"etextile": ours(model, settings(case)), "FElupe": theirs(model, options.steps, options.seconds)}
    print(f"{model.truss_count} trusses, {' x '.join(map(str, model.lattice.cells))} cells of a quarter")
    print(f"{'':10}{'s':>8}" + "".join(f"{f'{at:g} mm':>20}" for at in AT) + "  force N (penetration mm)")
    for name, (curve, seconds, ended) in runs.items():
        cells = [f"{force:.1f} ({depth:.3f})" for force, depth in (curve.get(at, (np.nan, np.nan)) for at in AT)]
        print(f"{name:10}{seconds:>8.1f}" + "".join(f"{cell:>20}" for cell in cells) + f"  {ended}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
