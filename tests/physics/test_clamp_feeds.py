"""Clamps that feed fabric past a jaw edge: a strip over the punch in closed form, and what tells mount from lining.

The closed form shares nothing with the package: path of a taut yarn over a sphere's profile, force from its own law by
bisection.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from etextile.effects.base import Effect
from etextile.effects.clamp_compliance import ClampCompliance
from etextile.effects.clamp_slip import ClampSlip
from etextile.effects.clamps import ClampBlock
from etextile.lattice.weave import DIAGONAL
from etextile.mechanics.model import Model
from etextile.solve.path import Increment, advance
from loadcases.build import build
from loadcases.reader import load_case


HALF, RADIUS, WIDTH = 50.0, 15.0, 8.0
E, YIELD0, H, N, AREA, CELL = 3000.0, 0.2, 9960.0, 1.5, 0.0155, 0.1603


def tension(stretch: float) -> float:
    """Force per width (N/mm) of warp yarns of the mid set at a stretch: sigma exp(-p), E (eps - p) = s(p)."""
    eps = np.log(stretch)
    low, high = 0.0, max(eps, 0.0)
    for _ in range(200):
        p = 0.5 * (low + high)
        s = YIELD0 * p / (p + 1e-3) + H * p**N
        low, high = (p, high) if E * (eps - p) > s else (low, p)
    return (YIELD0 * p / (p + 1e-3) + H * p**N) * np.exp(-p) * AREA / CELL


@dataclass(frozen=True)
class Strip:
    """A strip over the punch: force per width N/mm, stretch, feed mm of unstretched strip."""

    force: float
    stretch: float
    feed: float


def closed_form(depth: float, limit: float) -> Strip:
    """Return the strip at a depth when its clamps hold `limit` N/mm."""
    c = depth - RADIUS
    far = np.hypot(HALF, c)
    slope = np.arctan2(c, HALF) + np.arcsin(RADIUS / far)
    path = np.sqrt(far**2 - RADIUS**2) + RADIUS * slope
    stretch, feed = path / HALF, 0.0
    if tension(stretch) > limit:
        low, high = 0.0, path - HALF
        for _ in range(200):
            feed = 0.5 * (low + high)
            low, high = (feed, high) if tension(path / (HALF + feed)) > limit else (low, feed)
        stretch = path / (HALF + feed)
    return Strip(2.0 * tension(stretch) * np.sin(slope), stretch, feed)


def test_the_closed_form_meets_its_published_numbers() -> None:
    """Numbers of the model: 12.1 N/mm at 40 mm, 13.9 at 52.5 with a strain of 0.081 and a feed of 18.4 mm."""
    deep = closed_form(52.5, 9.0)
    assert closed_form(40.0, 9.0).force == pytest.approx(12.1, abs=0.05)
    assert deep.force == pytest.approx(13.9, abs=0.05)
    assert deep.stretch - 1.0 == pytest.approx(0.081, abs=5e-4)
    assert deep.feed == pytest.approx(18.4, abs=0.05)


def strip(*effects: Effect, travel: tuple[float, ...], diagonals: float = 1.0) -> Model:
    """Return a narrow strip of the fabric over the punch."""
    case = load_case("punch", overrides=["wires=null", "fabric.coarsening=10", f"fabric.size=[100,{WIDTH}]"]).case
    model = build(case).model
    block = model.lattice_block
    area = np.where(block.family == DIAGONAL, diagonals, 1.0) * block.area
    model = replace(model, contributions=(replace(block, area=area), *model.contributions[1:]), travel=np.array(travel))
    for effect in effects:
        model = effect.apply(model)
    return model


def run(model: Model) -> list[Increment]:
    return [item for item in advance(model) if item.output]


def clamp(model: Model) -> tuple[int, ClampBlock]:
    return next((k, part) for k, part in enumerate(model.contributions) if isinstance(part, ClampBlock))


def test_a_strip_over_the_punch_is_fed_as_the_closed_form_says() -> None:
    """Force, stretch of the warp at the edge and feed at 40 and 52.5 mm within 1 %; the edge stays where it is."""
    model = strip(ClampSlip(9.0), travel=(20.0, 30.0, 40.0, 52.5), diagonals=1e-6)
    index, block = clamp(model)
    warp = np.flatnonzero(
        (model.lattice_block.nodes == block.nodes[0, 0]).any(axis=1) & (model.lattice_block.family == 0)
    )
    for found in run(model)[2:]:
        exact = closed_form(found.displacement_mm, 9.0)
        assert found.punch_force_N / WIDTH == pytest.approx(exact.force, rel=0.01)
        stretch = 1.0 + float(found.truss_strain[warp[0]])
        assert stretch == pytest.approx(exact.stretch, abs=2e-3)
        assert found.state.states[index].slip[0] / stretch == pytest.approx(exact.feed, rel=0.01)
        np.testing.assert_allclose(found.state.x[block.nodes[:, 1]], block.place, atol=1e-12)
        assert abs(found.clamp_force_N) == pytest.approx(found.punch_force_N, rel=1e-6)


def test_diagonals_are_fed_with_the_yarns() -> None:
    """With its diagonals the strip still meets the limit: what crosses the edge pulls together, and gives together."""
    found = run(strip(ClampSlip(9.0), travel=(20.0, 30.0, 40.0, 52.5)))[-1]
    assert found.punch_force_N / WIDTH == pytest.approx(closed_form(52.5, 9.0).force, rel=0.015)


def test_below_the_limit_nothing_is_fed() -> None:
    found, free = (run(strip(*effects, travel=(10.0, 20.0)))[-1] for effects in ((ClampSlip(9.0),), ()))
    assert closed_form(20.0, 9.0).feed == 0.0
    assert found.punch_force_N == pytest.approx(free.punch_force_N, rel=2e-3)


@pytest.mark.parametrize("lining", [0.0, 0.5, 1.0])
def test_a_lining_gives_by_the_tension_and_a_mount_by_its_part_along_the_pull(lining: float) -> None:
    """What is let out is c T, how far the edge moves is c T cos(alpha), each times its share of the compliance."""
    model = strip(ClampCompliance(0.3, lining), travel=(10.0, 20.0, 30.0))
    _, block = clamp(model)
    x = run(model)[-1].state.x
    fabric, jaw = x[block.nodes[0, 0]], x[block.nodes[0, 1]]
    node = int(
        np.flatnonzero((model.points[:, 1] == model.points[block.nodes[0, 0], 1]) & (model.points[:, 0] < HALF))[-1]
    )
    way = x[node] - jaw
    response = block.respond(x, 30.0, block.initial_state())
    pull = float(response.tension[0])
    assert pull > 5.0
    assert np.linalg.norm(fabric - jaw) == pytest.approx(0.3 * lining * pull, rel=2e-3, abs=2e-3)
    assert block.place[0, 0] - jaw[0] == pytest.approx(
        0.3 * (1 - lining) * pull * -way[0] / np.linalg.norm(way), rel=0.02
    )
    assert jaw[2] == 0.0


def test_lining_and_mount_are_two_answers() -> None:
    """Deep under the punch fabric leaves the clamp at 50 degrees: the lining sees the whole tension and gives more."""
    mount, lining = (run(strip(ClampCompliance(0.3, share), travel=(20.0, 40.0)))[-1].punch_force_N for share in (0, 1))
    assert lining < 0.9 * mount
