"""What every registered limb must fulfil: one that passes here can be worn by a tube or a panel and bent."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.tube_rig import write_limb

from etextile.contact.bending import Bending
from etextile.contact.bodies import BODIES, LIMBS
from etextile.contact.limb_mesh import SkinnedLimb
from etextile.contact.poses import PosedMesh
from etextile.motion.flexion import Flexion
from loadcases.schema_body import LIMBS as SCHEMAS


EXAMPLES: dict[str, dict[str, Any]] = {"limb": {"joint": "elbow"}, "limb_mesh": {"joint": "elbow_left"}}
STEP = 1e-4


@pytest.fixture(scope="module", params=sorted(EXAMPLES))
def limb(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bending]:
    """Each registered limb; the mesh's grids are coarse, at few poses and in a temporary folder."""
    folder = tmp_path_factory.mktemp("limbs")
    files = write_limb(folder, radius=30.0) if request.param == "limb_mesh" else {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ETEXTILE_CACHE_DIR", str(folder))
        found = LIMBS[request.param](**EXAMPLES[request.param], **files)
        if isinstance(found, SkinnedLimb):
            found = replace(found, source=PosedMesh(found.skin, 9.0, tuple(np.radians(np.arange(0.0, 121.0, 20.0)))))
        yield found


def test_every_registered_limb_is_tested_and_none_is_a_rigid_body() -> None:
    assert set(EXAMPLES) == set(LIMBS)
    assert not set(LIMBS) & set(BODIES)


@pytest.mark.parametrize("schema", SCHEMAS, ids=lambda schema: schema.__name__)
def test_case_file_offers_the_builder_keywords_and_defaults(schema: Any) -> None:
    name = schema.model_fields["type"].annotation.__args__[0]
    keywords = inspect.signature(LIMBS[name]).parameters
    assert set(keywords) == set(schema.model_fields) - {"type"}
    for key, parameter in keywords.items():
        info = schema.model_fields[key]
        assert parameter.default == (inspect.Parameter.empty if info.is_required() else info.default), key


def test_rate_is_the_derivative_of_the_gap(limb: Bending) -> None:
    points = np.random.default_rng(2).uniform(-70.0, 70.0, (400, 3))
    points = points[np.abs(limb.posed(flexion=1.2, deflated=1.0).distance(points).gap) < 15.0]
    assert len(points) > 50
    further, less = (limb.posed(flexion=1.2 + step, deflated=1.0) for step in (STEP, -STEP))
    rate = (further.distance(points).gap - less.distance(points).gap) / (2 * STEP)
    assert limb.posed(flexion=1.2, deflated=1.0).rate(points) == pytest.approx(rate, abs=1e-4)


def test_a_deflated_limb_stands_inside_of_its_surface(limb: Bending) -> None:
    points = np.random.default_rng(3).uniform(-50.0, 50.0, (50, 3))
    full, thin = (limb.posed(flexion=0.5, deflated=depth).distance(points).gap for depth in (0.0, 2.5))
    assert thin == pytest.approx(full + 2.5, abs=1e-12)


def test_the_drawn_surface_is_where_the_gap_is_nothing(limb: Bending) -> None:
    posed = limb.posed(flexion=0.0, deflated=0.0)
    vertices, _ = posed.surface()
    sides = vertices[np.abs(vertices[:, 0]) < 60.0]
    assert np.abs(posed.distance(sides).gap).max() < 0.3
    low, high = limb.bounds()
    assert np.all(sides > low - 1e-9)
    assert np.all(sides < high + 1e-9)


def test_a_round_piece_is_fitted_onto_the_skin_and_a_loose_one_keeps_its_girth(limb: Bending) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    for x in (-50.0, 40.0):
        own = float(limb.radius(np.array([x]))[0])
        for radius in (0.8 * own, 1.1 * own):
            off = radius * np.stack([np.zeros(12), np.sin(angle), np.cos(angle)], axis=1)
            fitted = limb.fitted(off + np.array([x, *limb.middle])) - np.array([0.0, *limb.middle])
            assert np.hypot(*fitted[:, 1:].T).mean() == pytest.approx(max(radius, own), rel=0.02)
            assert np.sum(fitted[:, 1:] * off[:, 1:], axis=1).min() > 0.0


def test_it_stays_within_the_surroundings_of_its_motion(limb: Bending) -> None:
    motion = Flexion(limb)
    low, high = motion.surroundings(limb)  # type: ignore[arg-type]
    for degrees in (0.0, 60.0, 120.0):
        vertices, _ = motion.posed(limb, degrees).surface()
        assert np.all(vertices > low - 0.3 * np.ptp([low, high]))
        assert np.all(np.abs(vertices[:, 1]) <= max(abs(low[1]), high[1]) + 1e-6)


def test_a_limb_can_be_sent_to_another_process(limb: Bending, tmp_path: Path) -> None:
    import pickle

    points = np.random.default_rng(5).uniform(-50.0, 50.0, (20, 3))
    again = pickle.loads(pickle.dumps(limb))
    assert np.array_equal(again.distance(points).gap, limb.distance(points).gap)
