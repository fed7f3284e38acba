"""yarn_tail, geometry and yarn_sliding through the whole solver against solutions that share nothing with the package.

A taut frictionless strip over a cylinder has one tension T(stretch), from a law solved here by bisection; a yarn drawn
through a weave that is held is a chain, solved here by shooting from its free end.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.effects.base import Effect
from etextile.effects.geometry import Geometry
from etextile.effects.yarn_sliding import YarnSliding
from etextile.effects.yarn_tail import YarnTail
from etextile.identify.virtual import Coupon, coupon_model
from etextile.lattice.weave import DIAGONAL, WEFT, Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.solve.path import Increment, advance
from loadcases.build import build
from loadcases.reader import load_case


HALF, RADIUS, WIDTH, DEPTH = 50.0, 15.0, 6.0, 35.0
WARP, WEFT_LAW = (3000.0, 0.2, 9960.0, 1.5), (4500.0, 0.2, 4230.0, 1.1)
AREA, CELL_WARP, CELL_WEFT, E0 = 0.0155, 0.2849, 0.1603, 1e-3
DEPTHS = (20.0, 28.0, DEPTH)


def stress(law: tuple[float, ...], eps: float, *, onset: float = 0.0, change: float = 0.0) -> float:
    """Force over A0 (MPa) at a Hencky strain: s exp(-p) with E (eps - p) = s(p), the slope of s changed beyond q.

    q is the plastic strain of the plain law at the engineering strain `onset`.
    """
    modulus, yield0, hard, n = law

    def plain(p: float) -> float:
        return yield0 * p / (p + E0) + hard * p**n

    def root(s: object, at: float) -> float:
        low, high = 0.0, max(at, 0.0)
        for _ in range(100):
            p = 0.5 * (low + high)
            low, high = (p, high) if modulus * (at - p) > s(p) else (low, p)  # type: ignore[operator]
        return p

    q = root(plain, np.log1p(onset)) if change else np.inf

    def with_tail(p: float) -> float:
        return plain(p) if p <= q else plain(q) + (1.0 + change) * (plain(p) - plain(q))

    p = root(with_tail, eps)
    return with_tail(p) * np.exp(-p)


def over_cylinder(depth: float, radius: float, *, aside: float = 0.0, **tail: float) -> tuple[float, float]:
    """Force per width (N/mm) and stretch of the strip with the cylinder `aside` mm off the middle."""
    c = depth - radius
    path = sine = 0.0
    for half in (HALF - aside, HALF + aside):
        far = np.hypot(half, c)
        angle = np.arctan2(c, half) + np.arcsin(radius / far)
        path += np.sqrt(far**2 - radius**2) + radius * angle
        sine += np.sin(angle)
    stretch = path / (2.0 * HALF)
    return stress(WARP, np.log(stretch), **tail) * AREA / CELL_WEFT * sine, stretch


def strip(*effects: Effect, portion: str = "quarter") -> list[Increment]:
    """Return the outputs of a strip of warp over the cylinder, its diagonals taken out."""
    changes = [
        "wires=null", "fabric.coarsening=8", f"fabric.size=[100,{WIDTH}]", f"fabric.portion={portion}",
        f"body={{type: capsule, radius: {RADIUS}, length: 60, rotation: [0,0,90]}}",
    ]  # fmt: skip
    model = build(load_case("punch", overrides=changes).case).model
    block = model.lattice_block
    area = np.where(block.family == DIAGONAL, 1e-6, 1.0) * block.area
    model = replace(model, contributions=(replace(block, area=area), *model.contributions[1:]), travel=np.array(DEPTHS))
    for effect in effects:
        model = effect.apply(model)
    return [item for item in advance(model) if item.output]


@pytest.mark.parametrize(("change", "onset"), [(0.0, 0.12), (-0.7, 0.12), (1.0, 0.06)])
def test_a_strip_whose_yarns_pass_the_onset_bears_what_the_changed_law_says(change: float, onset: float) -> None:
    """Strains of 4 to 25 %; -0.7 takes 45 % of the force at the last depth, 1.0 adds 70 %."""
    effects = (YarnTail(change, onset),) if change else ()
    for found in strip(*effects):
        exact, stretch = over_cylinder(found.displacement_mm, RADIUS, onset=onset, change=change)
        assert found.punch_force_N / WIDTH == pytest.approx(exact, rel=0.01)
        assert float(found.truss_strain.max()) == pytest.approx(stretch - 1.0, abs=2e-3)


@pytest.mark.parametrize("radius", [-2.0, 2.0])
def test_a_strip_over_a_punch_of_another_radius(radius: float) -> None:
    for found in strip(Geometry(radius=radius)):
        exact, _ = over_cylinder(found.displacement_mm, RADIUS + radius)
        assert found.punch_force_N / WIDTH == pytest.approx(exact, rel=0.01)


def test_a_strip_over_a_punch_off_centre() -> None:
    """5 mm aside, the shorter side is steeper, and the tension is one."""
    for found in strip(Geometry(x=5.0), portion="whole"):
        exact, _ = over_cylinder(found.displacement_mm, RADIUS, aside=5.0)
        assert found.punch_force_N / WIDTH == pytest.approx(exact, rel=0.01)


def pulled_yarn(travel: float, *, count: int, length: float, area: float, tie: float, limit: float) -> list[float]:
    """Slips u (count,) mm of a weft drawn by `travel` through crossings that hold up to `limit` N, elastic `tie` N/mm.

    Shooting from the free end, which has half a cell: T_k = T_(k-1) + min(tie u_k, limit), u_(k+1) = u_k + length
    (exp(eps(T_k)) - 1).
    """
    modulus, yield0, hard, n = WEFT_LAW

    def strain(tension: float) -> float:
        low, high = 0.0, 0.5
        for _ in range(60):
            p = 0.5 * (low + high)
            s = yield0 * p / (p + E0) + hard * p**n
            low, high = (p, high) if area * s * np.exp(-p) < tension else (low, p)
        return float(p + s / modulus)

    def march(first: float) -> list[float]:
        u, tension = [first], 0.0
        for _ in range(count - 1):
            tension += min(tie * u[-1], limit) * (0.5 if len(u) == 1 else 1.0)
            u.append(u[-1] + length * np.expm1(strain(tension)))
            if u[-1] > 2.0 * travel:
                return u
        return u

    low, high = 0.0, travel
    for _ in range(60):
        first = 0.5 * (low + high)
        low, high = (first, high) if march(first)[-1] < travel else (low, first)
    return march(first)


def test_a_weft_drawn_through_the_weave_slips_as_a_chain_does() -> None:
    """Warp held, weft pulled at one end: 3, 7 and 10 crossings slip, each as far as the shooting says."""
    weave = Weave(CELL_WARP, CELL_WEFT, 0.35, AREA, 11.0, 8.9)
    laws = [PowerLaw(*WARP), PowerLaw(*WEFT_LAW), PowerLaw(1500.0, 0.2, 1550.0, 2.2)]
    coarsening, limit, give = 12.0, 0.5, 0.05
    size = (16 * coarsening * CELL_WEFT, 2 * coarsening * CELL_WARP)
    travels = np.array([0.25, 0.75, 1.5])
    plain = coupon_model(weave, laws, Coupon(size, 90.0, coarsening), strain=travels / size[0])
    model = YarnSliding(limit=limit, compliance=give).apply(plain)
    count = len(plain.points)
    fixed, carried = model.fixed.copy(), model.carried.copy()
    fixed[:count], carried[:count] = True, 0.0
    first = plain.lattice.edges["x_min"]
    fixed[count:][first, 0] = False
    model = replace(model, fixed=fixed, carried=carried)
    block = plain.lattice_block
    weft = block.family == WEFT
    pulled = np.flatnonzero(plain.points[:, 1] == plain.points[np.argmin(np.abs(plain.points[:, 1])), 1])
    own = count + pulled[np.argsort(plain.points[pulled, 0])]
    rest = float(block.rest_length[weft][0])
    cell = coarsening**2 * CELL_WARP * CELL_WEFT
    outputs = [item for item in advance(model) if item.output]
    for found, travel, slipping in zip(outputs, travels, (3, 7, 10), strict=True):
        x = found.state.x[own, 0] - model.points[own, 0]
        exact = pulled_yarn(
            float(travel), count=len(own), length=rest, area=coarsening * AREA, tie=cell / give, limit=limit * cell
        )
        np.testing.assert_allclose(x, exact, rtol=2e-3, atol=1e-6)
        assert np.count_nonzero(x[:-1] > limit * give) == slipping
