"""Sliding wires against closed forms: shear lag at constant line friction, the frictionless and the sticking limit."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from support.embedding import embedded

from etextile.lattice.piece import divide, weave_piece
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.solve.path import Increment, advance
from etextile.types import Array
from loadcases.build import build, settings
from loadcases.reader import load_case
from wires.embed import EmbeddedWires
from wires.embed_slip import WeaveHold
from wires.layout import Portion, lay_out
from wires.slip import SlidingWires
from wires.slip_pairs import Rub
from wires.slip_trial import SlipState
from wires.strain import wire_strains


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
FABRIC = PowerLaw(3000.0, 0.2, 9960.0, 1.5)
ELASTIC = PowerLaw(1e5, 1e5, 1e5, 1.0)
"""Copper that stays elastic: it yields at 100 %."""
COPPER = PowerLaw(1e5, 79.0, 600.0, 0.5)
AREA = 0.005
STICKING = WeaveHold(1e3)


@dataclass(frozen=True)
class Strip:
    """A strip whose lattice nodes are all moved, so that only the wire is free."""

    model: Model
    wires: EmbeddedWires

    @property
    def sliding(self) -> SlidingWires:
        return next(part for part in self.model.contributions if isinstance(part, SlidingWires))

    def increments(self) -> list[Increment]:
        return list(advance(self.model))

    def strains(self, increment: Increment | None = None) -> dict[str, Array]:
        return wire_strains(self.wires, self.model, increment or self.increments()[-1])


def strip(
    *,
    law: PowerLaw = COPPER,
    channel: WeaveHold | None,
    slack: float = 0.0,
    crimp: float = 0.0,
    strain: float = 0.01,
    uneven: float = 0.0,
    component: float = 0.0,
    travel: tuple[float, ...] = tuple(np.linspace(0.05, 1.0, 20)),
    portion: Portion = "whole",
    weft: float = 0.0,
) -> Strip:
    """A strip of 100 x 12 mm with one wire and a 4 mm loop in its middle, stretched by `strain` plus a bulge."""
    lattice = weave_piece(WEAVE, divide(WEAVE, (100.0, 12.0), 10.0, portion))
    trusses = TrussBlock.between_nodes(
        "lattice",
        lattice.trusses,
        length=lattice.rest_length,
        area=lattice.area,
        family=lattice.family,
        laws=(FABRIC, FABRIC, FABRIC),
    )
    x = lattice.points[:, 0]
    moved = np.zeros_like(lattice.points)
    moved[:, 0] = strain * x + uneven * 25.0 * np.sin(np.pi * x / 25.0) / np.pi
    moved[:, 1] = weft * lattice.points[:, 1]
    model = Model(
        lattice,
        lattice.points,
        np.ones(lattice.points.shape, dtype=bool),
        moved,
        (trusses,),
        np.array(travel),
        np.array([1.0, 0.0, 0.0]),
    )
    layout = lay_out(
        length_mm=100.0,
        width_mm=12.0,
        portion=portion,
        wire_spacing_mm=50.0,
        loop_spacing_mm=200.0,
        loop_length_mm=4.0,
        loop_slack=slack,
        loop_rigid_mm=component,
    )
    return Strip(*embedded(model, layout, law, area_mm2=AREA, crimp=crimp, channel=channel))


def test_force_beside_a_slack_loop_falls_by_the_friction_over_a_zone_of_force_over_friction() -> None:
    """Shear lag: loop force f, far force F, zone z = (F - f) / q on each side, each feeding (F - f)^2 / (2 q EA)."""
    friction, slack, strain = 0.1, 0.012, 0.01
    stiffness = ELASTIC.E * AREA
    case = strip(law=ELASTIC, channel=WeaveHold(friction, element_mm=0.2), slack=slack, strain=strain)
    found = case.strains()
    far = stiffness * np.log1p(strain)
    near = np.linspace(0.0, far, 200_001)
    held = 4 * (1 + slack) - (far - near) ** 2 / (friction * stiffness)  # what the loop keeps of its length
    near = near[np.argmin(np.abs(held * np.exp(near / stiffness) - 4 * (1 + strain)))]
    assert found["wire_strain"][0] == pytest.approx(np.expm1(near / stiffness), rel=0.01)
    right = case.wires.element_warp_mm > 0.0
    distance = case.wires.element_warp_mm[right] - 2.0
    force = stiffness * np.log1p(found["element_strain"][right])
    zone = (far - near) / friction
    inside = (distance > 0.05 * zone) & (distance < 0.85 * zone)
    assert 10.0 < zone < 40.0
    assert inside.sum() > 30
    assert force[inside] == pytest.approx(near + friction * distance[inside], rel=0.01)
    slope, start = np.polyfit(distance[inside], force[inside], 1)
    assert (far - start) / slope == pytest.approx(zone, rel=0.01)
    assert force[distance > 1.2 * zone] == pytest.approx(far, rel=0.01)


def test_without_friction_the_wire_strain_is_uniform_between_its_anchors() -> None:
    """Total length over total rest length, though the fabric's strain runs from 2 to 10 %."""
    case = strip(channel=WeaveHold(0.0), slack=0.02, crimp=0.005, strain=0.06, uneven=0.04)
    found = case.strains()
    whole = 100.0 * 1.06 / (4.0 * 1.02 + 96.0 * 1.005) - 1.0
    assert found["element_strain"] == pytest.approx(whole, rel=0.01)
    assert found["wire_strain"] == pytest.approx(whole, rel=0.01)


@pytest.mark.parametrize(("slack", "crimp"), [(0.0, 0.0), (0.02, 0.005), (0.0, 0.02)])
def test_friction_that_never_gives_way_is_perfect_bond(slack: float, crimp: float) -> None:
    common = {"slack": slack, "crimp": crimp, "strain": 0.06, "uneven": 0.04}
    held, bonded = (strip(channel=channel, **common) for channel in (STICKING, None))
    there, ideal = held.strains(), bonded.strains()
    assert there["wire_strain"] == pytest.approx(ideal["wire_strain"], rel=0.01)
    fine, coarse = held.wires.element_warp_mm, bonded.wires.element_warp_mm
    column = np.abs(fine[:, None] - coarse).argmin(axis=1)
    assert there["element_strain"] == pytest.approx(ideal["element_strain"][column], rel=0.01)
    assert ideal["element_strain"].min() < 0.5 * ideal["element_strain"].max()


@pytest.mark.slow
def test_a_tight_loop_feeds_on_the_crimp_beside_it_and_a_slack_loop_is_fed_upon() -> None:
    """Both regimes: sliding relieves a loop that has less excess than the weave and strains one that has more."""
    bonded = {slack: (1.08 / (1.0 + slack)) - 1.0 for slack in (0.0, 0.06)}
    crimped = 1.08 / 1.03 - 1.0
    tight, loose = (
        [
            strip(channel=WeaveHold(q), slack=slack, crimp=0.03, strain=0.08).strains()["wire_strain"][0]
            for q in (0.05, 0.5)
        ]
        for slack in (0.0, 0.06)
    )
    assert crimped < tight[0] < tight[1] < bonded[0.0]
    assert bonded[0.06] < loose[1] < loose[0] < crimped
    assert tight[0] < bonded[0.0] - 0.01
    assert loose[0] > bonded[0.06] + 0.01


def test_what_has_slid_stays_when_the_fabric_goes_back() -> None:
    """History: a tight loop has drawn wire in; back at no strain that wire has not slid out again."""
    there = tuple(np.linspace(0.05, 1.0, 20))
    case = strip(channel=WeaveHold(0.05), crimp=0.03, strain=0.08, travel=(*there, *there[-2::-1], 1e-6))
    increments = case.increments()
    fed = [_state(case, increment).fed for increment in (increments[19], increments[-1])]
    assert np.abs(fed[0]).max() > 0.03
    assert fed[1] == pytest.approx(fed[0], abs=0.2 * np.abs(fed[0]).max())
    friction = [increment.energy.friction for increment in increments]
    assert (np.diff(friction) >= -1e-12).all()


def test_wire_is_neither_made_nor_lost() -> None:
    case = strip(channel=WeaveHold(0.02), slack=0.01, crimp=0.03, strain=0.08, uneven=0.03)
    first, last = case.sliding.initial_state(), _state(case, case.increments()[-1])
    assert last.virgin.sum() == pytest.approx(first.virgin.sum(), rel=1e-9)
    assert np.abs(last.virgin - first.virgin).max() > 0.01
    assert (last.free >= last.virgin).all()


def _state(case: Strip, increment: Increment) -> SlipState:
    return increment.state.states[case.model.contributions.index(case.sliding)]


def test_a_component_leaves_less_wire_to_stretch() -> None:
    """Rigid 2.5 mm in a 4 mm loop with 2 % slack: the rest takes all of the span's elongation."""
    case = strip(channel=WeaveHold(held=True), slack=0.02, strain=0.05, component=2.5)
    assert case.strains()["wire_strain"][0] == pytest.approx((4 * 1.05 - 2.5) / (4 * 1.02 - 2.5) - 1.0, rel=1e-6)
    bare = strip(channel=None, slack=0.02, strain=0.05)
    assert case.strains()["wire_strain"][0] > 2.0 * bare.strains()["wire_strain"][0]


def test_half_the_strip_gives_what_the_whole_gives() -> None:
    common = {"channel": WeaveHold(0.1), "slack": 0.0, "crimp": 0.02, "strain": 0.06, "component": 1.0}
    whole, half = (strip(portion=portion, **common) for portion in ("whole", "half"))
    assert half.strains()["wire_strain"] == pytest.approx(whole.strains()["wire_strain"], rel=5e-3)
    assert half.sliding.anchored.sum() == 2


def test_a_wire_that_ends_at_a_free_edge_is_drawn_in() -> None:
    """Its tension grows from zero at the edge by the friction, so that the outermost millimetres stay slack."""
    case = strip(channel=WeaveHold(0.05, element_mm=0.5), strain=0.03)
    ends = np.flatnonzero(case.sliding.anchored)
    points = replace(case.sliding, anchored=np.zeros_like(case.sliding.anchored))
    fixed = case.model.fixed.copy()
    fixed[case.sliding.points[ends], 0] = False
    parts = tuple(points if part is case.sliding else part for part in case.model.contributions)
    loose = Strip(replace(case.model, fixed=fixed, contributions=parts), case.wires)
    increment = loose.increments()[-1]
    force = increment.truss_force[-len(points.nodes) :][: case.wires.count]
    inside = 50.0 - np.abs(case.wires.element_warp_mm)
    rising = (inside > 1.0) & (inside < 8.0)
    assert force[rising] == pytest.approx(0.05 * inside[rising], rel=0.01)


def test_friction_grows_with_the_tension_of_the_weft() -> None:
    tension = np.array([0.0, 10.0])
    gripping = WeaveHold(0.01, tension_factor=0.2, strain=np.array([0.0, 0.1]), tension=tension)
    case = strip(channel=gripping, crimp=0.03, strain=0.08, weft=0.05)
    x = case.model.points + case.model.carried
    # 5 N/mm at 5 % weft strain
    assert case.sliding.limit_at(x) == pytest.approx(case.sliding.channel * (0.01 + 0.2 * 5.0))
    free = strip(channel=WeaveHold(0.01), crimp=0.03, strain=0.08, weft=0.05)
    assert case.strains()["wire_strain"][0] > free.strains()["wire_strain"][0] + 0.005


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_gradient_and_tangent_are_the_derivatives_of_the_energy(friction: float) -> None:
    case = strip(channel=WeaveHold(friction), slack=0.01, crimp=0.02, strain=0.05, uneven=0.03, component=1.0)
    block = case.sliding
    state = _state(case, case.increments()[-1])
    rng = np.random.default_rng(3)
    x = case.model.points + 1.2 * case.model.carried + 0.02 * rng.normal(size=case.model.points.shape)
    x[block.points, 0] = state.anchor + (1e-5 if friction else 0.05) * rng.normal(size=len(block.points))
    way = rng.normal(size=x.shape) * 0.1
    way[block.points] = [1e-5 if friction else 0.1, 0.0, 0.0] * rng.normal(size=(len(block.points), 1))
    way[block.points[block.anchored]] = 0.0

    def at(step: float) -> tuple[float, Array]:
        response = block.respond(x + step * way, 0.0, state)
        gradient = np.zeros_like(x)
        response.add_gradient(gradient)
        found = response.energy()
        return found.stored + found.plastic + found.friction, gradient

    h = 1e-5
    assert (at(h)[0] - at(-h)[0]) / (2 * h) == pytest.approx(np.vdot(at(0.0)[1], way), rel=1e-5)
    change = (at(h)[1] - at(-h)[1]) / (2 * h)
    change[block.points[block.anchored]] = 0.0
    assert np.vdot(change, way) == pytest.approx(way.ravel() @ tangent(case, x, state) @ way.ravel(), rel=1e-4)


def tangent(case: Strip, x: Array, state: SlipState, *, exact: bool = True) -> Array:
    """The full tangent of the wires as a dense matrix."""
    from etextile.solve.pattern import lay_out as pattern_of

    block = case.sliding
    pattern = pattern_of(len(x), [block.nodes])
    values = np.zeros(len(pattern.indices))
    block.respond(x, 0.0, state).add_tangent(pattern.rows, pattern.pairs[0], values, exact=exact, damping=0.0)
    upper = pattern.matrix(values).toarray()
    return np.asarray(upper + upper.T - np.diag(np.diag(upper)))


def test_the_energy_is_convex() -> None:
    case = strip(channel=WeaveHold(0.0), slack=0.01, crimp=0.02, strain=0.05)
    rng = np.random.default_rng(5)
    x = case.model.points + 2.0 * case.model.carried
    x[case.sliding.points, 0] = 0.2 * rng.normal(size=len(case.sliding.points))
    whole = tangent(case, x, case.sliding.initial_state())
    used = np.flatnonzero(np.diag(whole))
    assert np.linalg.eigvalsh(whole[np.ix_(used, used)])[0] > -1e-6


def test_friction_lifted_to_pairs_settles_at_its_law() -> None:
    """Steps at a fixed slip: traction k d while |k d| < q, else q, and the rest of d is slip."""
    slip, limit, stick = np.array([1e-5, -4e-5, 3e-4, -0.2, 0.0]), np.full(5, 0.1), np.full(5, 1e3)
    rub = Rub.start(slip, limit, stick)
    for _ in range(60):
        rub = rub.linearised(slip).moved(np.zeros(5))
    law = np.clip(stick * slip, -limit, limit)
    assert rub.traction == pytest.approx(law, abs=1e-6)
    assert rub.forward - rub.backward == pytest.approx(slip - law / stick, abs=1e-9)


def test_pairs_at_their_law_have_the_gradient_and_tangent_of_the_wires() -> None:
    """With every element's stretch that of the geometry nothing but friction differs from the law itself."""
    case = strip(channel=WeaveHold(0.0), crimp=0.02, strain=0.08, uneven=0.02, component=1.0)
    block, increments = case.sliding, case.increments()
    state, x = _state(case, increments[10]), increments[-1].state.x
    response = block.respond(x, 0.0, state)
    side = block.one_sided(response, state)
    assert (side.stretch > 0.0).all()
    force, along = side.bear(side.stretch)
    assert force == pytest.approx(response.force, rel=1e-9)
    assert along == pytest.approx(response.along, rel=1e-6)
    own, law = np.zeros_like(x), np.zeros_like(x)
    side.add_gradient(force, own)
    response.add_gradient(law)
    assert own == pytest.approx(law, abs=1e-9)
    way = 1e-6 * np.random.default_rng(1).normal(size=x.shape)
    way[block.points[block.anchored]] = 0.0
    change = block.respond(x + way, 0.0, state).force - response.force
    assert change == pytest.approx(along * side.rate(way), abs=1e-4 * np.abs(change).max())


def test_sliding_costs_few_linear_solves() -> None:
    """Most points change between sticking and sliding at once; one by one they take four times as many solves."""
    sliding = ["wires.bond={line_friction: 0.1}", "wires.loops.slack=5 %"]
    case = load_case("punch", overrides=[*sliding, "motion.total=25", "motion.steps=10"]).case
    verdicts = [increment.verdict for increment in advance(build(case).model, settings(case))]
    assert sum(verdict.linear_solves for verdict in verdicts) < 250
    assert sum(verdict.cut_backs for verdict in verdicts) == 0
