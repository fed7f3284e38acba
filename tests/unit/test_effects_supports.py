"""Clamps, machine, body and crossings against closed forms and independent small computations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.contact.contact import Contact
from etextile.contact.pose import place
from etextile.contact.sphere import Sphere
from etextile.effects.base import Effect
from etextile.effects.bodies import ParallelBody
from etextile.effects.change import lattice_block
from etextile.effects.clamp_compliance import ClampCompliance
from etextile.effects.clamp_slip import ClampSlip
from etextile.effects.clamps import ClampBlock, ClampLaw
from etextile.effects.crimp_interchange import CrimpInterchange
from etextile.effects.crimped import CrimpedTrusses
from etextile.effects.datum_offset import DatumOffset
from etextile.effects.geometry import Geometry
from etextile.effects.machine_compliance import MachineCompliance
from etextile.effects.punch_friction import PunchFriction
from etextile.effects.rotational_shear import RotationalShear
from etextile.effects.yarn_sliding import Crossings, YarnSliding
from etextile.errors import BadInput
from etextile.lattice.weave import WARP, WEFT
from etextile.laws.powerlaw import respond
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Response
from etextile.solve.path import Increment, advance
from etextile.solve.system import System
from etextile.types import Array
from loadcases.build import build
from loadcases.reader import load_case


def model(name: str = "punch", *overrides: str, travel: tuple[float, ...] = (10.0, 20.0)) -> Model:
    case = load_case(name, overrides=["wires=null", "fabric.coarsening=60", *overrides]).case
    return replace(build(case).model, travel=np.array(travel))


def strip(travel: tuple[float, ...]) -> Model:
    """A strip of 100 x 20 mm pulled at its end x_max, two cells wide."""
    return model(
        "tension_warp", "fabric.size=[100,20]", "fabric.coarsening=70", "supports.clamped=[x_min,x_max]", travel=travel
    )


def run(changed: Model) -> list[Increment]:
    return [item for item in advance(changed) if item.output]


def contact(changed: Model) -> Contact:
    return next(part for part in changed.contributions if isinstance(part, Contact))


def gradient(response: Response, x: Array) -> Array:
    total = np.zeros_like(x)
    response.add_gradient(total)
    return total


# clamps


def test_a_pulled_strip_comes_out_of_its_clamps_at_the_limit() -> None:
    """Both clamps of 20 mm hold 3 N/mm: the force is the fabric's own below 60 N and 60 N from then on."""
    travel = (1.0, 2.0, 4.0, 8.0)
    own, slipping = run(strip(travel)), run(ClampSlip(3.0).apply(strip(travel)))
    assert own[0].punch_force_N < 60.0 < own[-1].punch_force_N
    for base, found in zip(own, slipping, strict=True):
        expected = min(base.punch_force_N, 60.0)
        assert found.punch_force_N == pytest.approx(expected, rel=2e-3)
        assert abs(found.clamp_force_N) == pytest.approx(expected, rel=2e-3)


def test_the_rest_of_the_pull_is_slip_and_its_work_is_friction() -> None:
    pulled = ClampSlip(3.0).apply(strip((4.0, 12.0)))
    before, after = run(pulled)
    block = next(part for part in pulled.contributions if isinstance(part, ClampBlock))
    out = [np.abs(item.state.x[block.nodes[:, 0], 0] - item.state.x[block.nodes[:, 1], 0]) for item in (before, after)]
    edge = len(block.nodes) // 2
    assert (out[1] - out[0]).sum() / edge == pytest.approx(8.0, rel=1e-2)  # the free edges draw in, and slip less
    slipped = after.state.states[-1].slip - before.state.states[-1].slip
    assert after.energy.friction - before.energy.friction == pytest.approx(3.0 * block.width @ slipped, rel=1e-9)
    assert after.energy.friction - before.energy.friction == pytest.approx(60.0 * 8.0, rel=1e-2)


def test_hardening_clamps_hold_more_with_slip_and_fading_ones_less() -> None:
    travel = (6.0, 8.0)
    forces = {h: run(ClampSlip(3.0, h).apply(strip(travel)))[-1] for h in (-0.5, 0.0, 0.5)}
    assert forces[-0.5].punch_force_N < forces[0.0].punch_force_N < forces[0.5].punch_force_N
    width = np.array([5.0, 10.0, 5.0])
    slip = forces[0.5].state.states[-1].slip[:3]
    let_out = forces[0.5].state.x[:3] - strip(travel).points[:3]
    along = np.abs(let_out[:, 0]) / np.linalg.norm(let_out, axis=1)  # the free edges draw in by some per mille
    assert forces[0.5].punch_force_N == pytest.approx((width * along) @ (3.0 + 0.5 * slip), rel=1e-6)


def test_fading_friction_has_the_slope_and_the_work_of_its_law() -> None:
    law = ClampLaw(limit=4.0, hardening=-2.0)
    path = np.array([0.0, 0.3, 2.0])
    h = 1e-6
    force, slope, work = law.friction(path)
    assert force[0] == 4.0
    assert slope[0] == -2.0
    np.testing.assert_allclose((law.friction(path + h)[0] - law.friction(path - h)[0]) / (2 * h), slope, rtol=1e-6)
    np.testing.assert_allclose((law.friction(path + h)[2] - law.friction(path - h)[2]) / (2 * h), force, rtol=1e-6)
    assert work[0] == 0.0


def test_elastic_clamps_give_what_the_line_force_says() -> None:
    """A strip with two clamps of 0.1 mm per N/mm is a rigidly clamped strip pulled less far."""
    found = run(ClampCompliance(0.1).apply(strip((2.0, 4.0))))[-1]
    line_force = found.punch_force_N / 20.0
    rigid = run(strip((2.0, 4.0 - 2.0 * 0.1 * line_force)))[-1]
    assert found.punch_force_N == pytest.approx(rigid.punch_force_N, rel=1e-3)
    assert line_force > 2.0


@pytest.mark.parametrize("order", [1, -1])
def test_elastic_clamps_that_slip_are_a_series(order: int) -> None:
    effects = [ClampCompliance(0.1), ClampSlip(3.0)][::order]
    pulled = strip((4.0,))
    for effect in effects:
        pulled = effect.apply(pulled)
    block = next(part for part in pulled.contributions if isinstance(part, ClampBlock))
    assert block.law.limit == 3.0
    assert block.mount == pytest.approx(10.0)
    assert sum(isinstance(part, ClampBlock) for part in pulled.contributions) == 1


def test_a_slipped_clamp_does_not_push_the_fabric_back() -> None:
    unloaded = run(replace(ClampSlip(3.0).apply(strip((8.0,))), travel=np.array([8.0, 7.0, 4.0])))
    assert unloaded[-1].punch_force_N == pytest.approx(0.0, abs=1e-3)
    slip = unloaded[0].state.states[-1].slip
    np.testing.assert_allclose(unloaded[-1].state.states[-1].slip, slip, rtol=1e-9)


# machine and body


def test_the_recorded_displacement_is_the_true_one_and_the_give_of_the_machine() -> None:
    compliance = 5e-3
    recorded = run(MachineCompliance(compliance).apply(model(travel=(10.0, 20.0, 26.0))))
    true = [item.displacement_mm - compliance * item.punch_force_N for item in recorded]
    rigid = run(model(travel=tuple(true)))
    for found, base in zip(recorded, rigid, strict=True):
        assert found.punch_force_N == pytest.approx(base.punch_force_N, rel=2e-4)
    assert [item.displacement_mm for item in recorded] == [10.0, 20.0, 26.0]
    assert recorded[-1].displacement_mm - true[-1] > 1.0


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_the_machine_spring_unloads_along_its_own_line(friction: float) -> None:
    """Energy put into the spring comes back: a closed loop loses what the fabric without the spring loses."""
    soft = model("punch", f"contact.friction={friction}", travel=(10.0, 16.0, 12.0))
    found = run(MachineCompliance(5e-3).apply(soft))
    true = [item.displacement_mm - 5e-3 * item.punch_force_N for item in found]
    rigid = run(replace(soft, travel=np.array(true)))
    assert found[-1].punch_force_N == pytest.approx(rigid[-1].punch_force_N, rel=2e-3, abs=0.02)


def test_an_offset_shifts_the_curve() -> None:
    late = run(DatumOffset(1.5).apply(model(travel=(11.5, 21.5))))
    early = run(DatumOffset(-2.0).apply(model(travel=(8.0, 18.0))))
    own = run(model(travel=(10.0, 20.0)))
    for base, after, before in zip(own, late, early, strict=True):
        assert after.punch_force_N == pytest.approx(base.punch_force_N, rel=1e-3)
        assert before.punch_force_N == pytest.approx(base.punch_force_N, rel=1e-3)


def test_a_larger_punch_is_the_larger_sphere() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform(-30.0, 30.0, (50, 3))
    grown, real = place(ParallelBody(Sphere(15.0), 2.0)), place(Sphere(17.0))
    for name in ("gap", "normal", "hessian"):
        a, b = (getattr(body.distance(points), name) for body in (grown, real))
        np.testing.assert_allclose(a, b, atol=1e-12)
    np.testing.assert_allclose(grown.bounds(), real.bounds())
    changed = contact(Geometry(radius=2.0).apply(model())).body
    np.testing.assert_allclose(changed.distance(points).gap, real.distance(points).gap, atol=1e-12)
    vertices, _ = changed.surface()
    np.testing.assert_allclose(np.linalg.norm(vertices + np.array([0.0, 0.0, 17.0]), axis=1), 17.0, atol=1e-9)


def test_a_punch_off_centre_needs_the_whole_specimen() -> None:
    with pytest.raises(BadInput, match="symmetry plane") as caught:
        Geometry(x=1.0, y=0.5).apply(model())
    assert [problem.key for problem in caught.value.problems] == ["x", "y"]
    moved = Geometry(x=1.0, y=-0.5).apply(model("punch", "fabric.portion=whole"))
    gap = contact(moved).body.distance(np.array([[1.0, -0.5, 0.0], [0.0, 0.0, 0.0]])).gap
    assert gap[0] == pytest.approx(0.0, abs=1e-12)
    assert gap[1] > 0.03


def test_friction_is_added_to_the_case() -> None:
    given = model("punch", "contact.friction=0.1")
    assert contact(PunchFriction(0.2).apply(given)).friction == pytest.approx(0.3)
    sticky = model("punch", "contact.friction=stick")
    assert np.isinf(contact(PunchFriction(0.2).apply(sticky)).friction)
    behind = PunchFriction(0.2).apply(MachineCompliance(1e-3).apply(given))
    assert behind.contributions[-1].contact.friction == pytest.approx(0.3)  # type: ignore[attr-defined]


# crimp interchange


def stretched(changed: Model, warp: float, weft: float) -> Array:
    return changed.points * np.array([1.0 + warp, 1.0 + weft, 1.0])


def test_under_biaxial_stretch_each_yarn_follows_its_law_at_the_added_strain() -> None:
    c, warp, weft = 0.2, 0.05, 0.08
    changed = CrimpInterchange(c).apply(model())
    block = lattice_block(changed)
    assert isinstance(block, CrimpedTrusses)
    found = block.respond(stretched(changed, warp, weft), 0.0, block.initial_state())
    e = np.log1p([warp, weft]) - 1e-3  # the rounding takes half its width off the crossing strain
    own = np.log1p([warp, weft])
    taus = [respond(block.laws[k].row(), own[k] + c * e[1 - k], 0.0)[0] for k in (WARP, WEFT)]
    rest = block.rest_length
    for family, other in ((WARP, WEFT), (WEFT, WARP)):
        inner = np.flatnonzero((block.family == family) & (np.bincount(block.cells.ravel(), minlength=len(rest)) == 2))[
            0
        ]
        volume, ratio = block.area[inner] * rest[inner], 1.0
        across = np.flatnonzero((block.family == other) & (np.bincount(block.cells.ravel(), minlength=len(rest)) == 2))[
            0
        ]
        ratio = block.area[across] * rest[across] / volume
        slope = volume * (taus[family] + c * ratio * taus[other])
        assert found.force[inner] == pytest.approx(slope / found.length[inner], rel=1e-9)


def test_a_pulled_family_lets_the_free_one_contract_without_load() -> None:
    """At eps_weft = -c eps_warp the weft is at zero and the warp is as without interchange."""
    c, warp = 0.2, 0.06
    base = model()
    changed = CrimpInterchange(c).apply(base)
    reach = np.log1p(warp) - 1e-3
    x = stretched(changed, warp, np.expm1(-c * reach))
    found, plain = (
        lattice_block(item).respond(x, 0.0, lattice_block(item).initial_state()) for item in (changed, base)
    )
    yarn = lattice_block(base).family <= WEFT
    np.testing.assert_allclose(found.force[yarn], plain.force[yarn], rtol=1e-9, atol=1e-9)
    tightened = lattice_block(changed).respond(
        stretched(changed, warp, 0.0), 0.0, lattice_block(changed).initial_state()
    )
    assert np.all(tightened.force[lattice_block(base).family == WEFT] > 0.0)


# crossings


def crossings(changed: Model) -> Crossings:
    return next(part for part in changed.contributions if isinstance(part, Crossings))


def displaced(changed: Model, offset: tuple[float, float, float]) -> Array:
    """All weft nodes moved against the warp nodes."""
    x = changed.points.copy()
    x[crossings(changed).nodes[:, 1]] += offset
    return x


def test_weft_pulled_over_the_warp_meets_the_traction_of_its_limit() -> None:
    changed = YarnSliding(limit=0.5, compliance=0.2).apply(model())
    part = crossings(changed)
    area = float(np.prod(np.ptp(changed.points[:, :2], axis=0)))
    state = part.initial_state()
    elastic = part.respond(displaced(changed, (0.06, 0.08, 0.0)), 0.0, state)
    pull = gradient(elastic, changed.points)[part.nodes[:, 1]].sum(axis=0)
    np.testing.assert_allclose(pull, area * np.array([0.06, 0.08, 0.0]) / 0.2, rtol=1e-9)
    assert elastic.energy().stored == pytest.approx(0.5 * area * 0.1**2 / 0.2, rel=1e-9)
    sliding = part.respond(displaced(changed, (0.6, 0.8, 0.0)), 0.0, state)
    pull = gradient(sliding, changed.points)[part.nodes[:, 1]].sum(axis=0)
    np.testing.assert_allclose(pull, area * 0.5 * np.array([0.6, 0.8, 0.0]), rtol=1e-9)
    assert sliding.energy().friction == pytest.approx(area * 0.5 * (1.0 - 0.1), rel=1e-9)
    back = part.respond(displaced(changed, (0.6, 0.8, 0.0)), 0.0, sliding.state)
    assert back.energy().friction == pytest.approx(sliding.energy().friction, rel=1e-12)


def test_warp_and_weft_stay_together_across_the_fabric() -> None:
    changed = YarnSliding(limit=0.5).apply(model())
    part = crossings(changed)
    found = part.respond(displaced(changed, (0.0, 0.0, 0.1)), 0.0, part.initial_state())
    np.testing.assert_allclose(gradient(found, changed.points)[part.nodes[:, 1], 2], 0.1 * part.tie, rtol=1e-12)
    assert not found.state.path.any()


def test_the_normals_are_those_of_the_surface() -> None:
    """Upright on a plane however it leans."""
    changed = YarnSliding(limit=0.5).apply(model())
    lean = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
    normal = crossings(changed).normals(changed.points @ lean)
    np.testing.assert_allclose(normal, np.tile([-0.6, 0.0, 0.8], (len(normal), 1)), atol=1e-12)


def test_a_crossing_that_begins_to_slip_is_held_in_the_tangent_until_its_traction_is_at_the_limit() -> None:
    """Along the slip: stiff where the step foresaw no traction, nothing once it foresees the limit that way."""
    changed = YarnSliding(limit=0.5, compliance=0.1).apply(model())
    part = crossings(changed)
    node, rows = int(part.nodes[0, 1]), np.arange(3 * len(changed.points))
    system = System(changed)

    def along(response: Response) -> float:
        values = np.zeros(len(system.pattern.indices))
        pairs = system.pattern.pairs[changed.contributions.index(part)]
        response.add_tangent(system.pattern.rows, pairs, values, exact=True, damping=0.0)
        upper = system.pattern.matrix(values).toarray()
        return float(upper[rows[3 * node], rows[3 * node]])

    state = part.initial_state()
    still, slipped = (part.respond(displaced(changed, (way, 0.0, 0.0)), 0.0, state) for way in (0.0, 0.2))
    area = float(part.limit[0]) / 0.5
    assert along(still) == pytest.approx(area / 0.1)
    assert along(slipped) == pytest.approx(0.0, abs=1e-9)
    assert along(replace(slipped, foreseen=np.zeros_like(slipped.along))) == pytest.approx(float(part.limit[0]) / 0.2)
    reached = slipped.reached_from(still)
    assert np.linalg.norm(reached.traction, axis=1) == pytest.approx(part.limit)


def test_yarns_cut_in_a_stretched_film_build_up_their_force_by_shear_lag() -> None:
    """Film held at the strain e: a yarn that ends free carries E A e (1 - cosh(x / d) / cosh(L / d)), d^2 = E t c."""
    modulus, give, strain, half = 500.0, 0.4, 0.01, 50.0
    plain = strip((1.0,))
    law = replace(lattice_block(plain).laws[0], E=modulus, sigma_y0=1e6)
    plain = replace(plain, contributions=(replace(lattice_block(plain), laws=(law,) * 3),))
    changed = YarnSliding(compliance=give, film=1.0).apply(plain)
    count, places = len(plain.lattice.points), changed.points
    own = np.arange(len(places)) < count
    moved = np.where(own, strain * places[:, 0], 0.0)[:, None] * np.array([1.0, 0.0, 0.0])
    held = np.repeat(own[:, None], 3, axis=1) | (np.arange(3) > 0)
    (end,) = run(replace(changed, fixed=held, carried=moved))
    block = lattice_block(changed)
    inside = (block.family == WARP) & (np.abs(places[block.nodes[:, 0], 1]) < 1.0)
    x = places[block.nodes[inside], 0].mean(axis=1)
    thick = block.area[inside] / (20.0 / 2.0)
    length = np.sqrt(modulus * thick * give)
    expected = modulus * block.area[inside] * strain * (1.0 - np.cosh(x / length) / np.cosh(half / length))
    middle = np.abs(x) < 0.8 * half
    assert end.truss_force[: len(block.family)][inside][middle] == pytest.approx(expected[middle], rel=0.03)
    with pytest.raises(BadInput, match="0 or 1"):
        YarnSliding(compliance=0.1, film=0.5).apply(model())


@pytest.mark.parametrize("effect", [YarnSliding(limit=0.5), RotationalShear(share=1.0)])
def test_a_run_with_folds_or_slip_costs_less_than_two_plain_ones(effect: Effect) -> None:
    plain = model("punch", "fabric.coarsening=19.5", travel=tuple(np.arange(1, 17) * 2.5))
    solves = [sum(item.verdict.linear_solves for item in advance(m)) for m in (plain, effect.apply(plain))]
    assert solves[1] < 2 * solves[0]


def test_sliding_is_given_once() -> None:
    once = YarnSliding(limit=0.5).apply(model())
    with pytest.raises(BadInput, match="stands twice"):
        YarnSliding(limit=0.5).apply(once)


@pytest.mark.parametrize("effect", [ClampSlip(limit=5.0), ClampCompliance(compliance=0.05)])
def test_the_clamps_of_an_effect_are_straight_and_a_ring_is_refused(effect: Effect) -> None:
    ring = build(load_case("burst_7cm2", overrides=["fabric.coarsening=20"]).case).model
    with pytest.raises(BadInput, match="a clamped outline is a ring"):
        effect.apply(ring)
