"""Every case, however it is made, is written as YAML that reads back to the same case with the same hash."""

from __future__ import annotations

import inspect
from typing import Any, get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from etextile.contact.bodies import BODIES as SHAPES
from loadcases import catalogue
from loadcases.fabric import dump_fabric, load_fabric
from loadcases.reader import as_loaded, dump_case, load_case, read_case
from loadcases.schema import Case
from loadcases.schema_body import BODIES, Placed
from loadcases.schema_parts import EDGES
from wires.failure import CRITERIA, DEFAULT_CRITERION


MODELS = {get_args(model.model_fields["type"].annotation)[0]: model for model in BODIES}


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


def sections(**keys: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Mappings in which any of the keys may be left to its default."""
    return st.fixed_dictionaries({}, optional=keys)


words = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z")), min_size=1, max_size=30)
texts = st.text(st.sampled_from("abc xyz:#-'\"[]{}%&*!|>?@`,\n\täß√0123456789."), max_size=40)
lengths = numbers(1e-3, 1e3)
angles = numbers(-360.0, 360.0)
placed = {"rotation": st.tuples(angles, angles, angles)}
bodies = st.one_of(
    st.none(),
    st.fixed_dictionaries({"type": st.just("sphere"), "radius": lengths}, optional=placed),
    st.fixed_dictionaries({"type": st.just("ellipsoid"), "semi_axes": st.tuples(lengths, lengths, lengths)}),
    st.fixed_dictionaries({"type": st.just("capsule"), "radius": lengths, "length": lengths}, optional=placed),
    st.fixed_dictionaries({"type": st.just("elbow")}, optional={"flexion": numbers(60.0, 150.0)}),
    st.fixed_dictionaries({"type": st.just("knee")}, optional=placed),
)
wires = st.none() | sections(
    every_warp_yarns=numbers(1, 1000),
    first_offset=numbers(-50, 50),
    material=st.sampled_from(catalogue.names("wire material")),
    filaments=st.integers(1, 100),
    filament_diameter=numbers(1e-3, 5.0),
    crimp=numbers(0, 1),
    loops=st.none() | st.fixed_dictionaries({"spacing": numbers(20, 100), "length": numbers(0.5, 9)}),
    bond=st.just("perfect") | st.fixed_dictionaries({"line_friction": numbers(0, 100)}),
    nets=st.just([])
    | st.lists(
        st.fixed_dictionaries(
            {"name": words, "wire": st.integers(0, 9), "from_loop": st.just(0), "to_loop": st.integers(0, 9)}
        ),
        max_size=2,
        unique_by=lambda net: net["name"],
    ),
)


@st.composite
def case_data(draw: st.DrawFn) -> dict[str, Any]:
    """Data of a whole specimen with everything that fits together, most of it optional."""
    body = draw(bodies)
    clamped = draw(st.lists(st.sampled_from(EDGES), min_size=1, unique=True))
    total = draw(lengths)
    target = draw(st.sampled_from([*clamped, "body"] if body is not None else clamped))
    path = draw(st.none() | st.just([total, 0.0, total]) | st.just([total / 2, total]))
    criterion = draw(st.sampled_from(list(CRITERIA)))
    known = {parameter.name for parameter in CRITERIA[criterion].parameters}
    ranges = {"onset": (0.05, 1), "scale": (1e-3, 1), "shape": (0.1, 50), "scatter": (0, 1), "spread": (0, 1)}
    extra = draw(sections(**{name: numbers(*span) for name, span in ranges.items() if name in known}))
    cyclic = {"exponent": numbers(-1, -0.1), "coefficient": numbers(1e-3, 10), "source": words}
    extra |= draw(sections(cyclic=st.none() | st.fixed_dictionaries(cyclic)))
    embedded = draw(wires)
    return {
        "schema_version": 1,
        "title": draw(words),
        "description": draw(texts),
        "fabric": {
            "set": draw(st.sampled_from(catalogue.names("fabric"))),
            "coarsening": draw(numbers(1, 100)),
            "size": [draw(numbers(10, 1000)), draw(numbers(10, 1000))],
            "warp_angle": draw(angles) if embedded is None else 0.0,
            "compression_ratio": draw(numbers(0, 1)),
        },
        "wires": embedded,
        "supports": {"clamped": clamped},
        "body": body,
        "motion": {"total": total, "steps": draw(st.integers(1, 10**5)), "target": target, "path": path},
        "contact": {"friction": draw(st.just("stick") | numbers(0, 2)), "max_penetration": draw(numbers(1e-4, 1.0))},
        "failure": {"criterion": criterion, **extra},
        "solver": {"tolerance": draw(numbers(1e-14, 0.5)), "max_cut_backs": draw(st.integers(0, 50))},
    }


@settings(max_examples=40)
@given(case_data())
def test_any_case_survives_the_round_trip(data: dict[str, Any]) -> None:
    case = Case.model_validate(data)
    again = read_case(dump_case(case))
    assert again.case == case
    assert dump_case(again.case) == dump_case(case)
    assert again.sha256 == as_loaded(case).sha256


@given(case_data(), st.sampled_from([("motion", "speed"), ("contact", "max_penetration"), ("fabric", "coarsening")]))
@pytest.mark.slow
def test_every_number_counts_for_the_hash(data: dict[str, Any], key: tuple[str, str]) -> None:
    case = Case.model_validate(data)
    section = getattr(case, key[0])
    changed = section.model_copy(update={key[1]: getattr(section, key[1]) * 1.0000001})
    assert as_loaded(case.model_copy(update={key[0]: changed})).sha256 != as_loaded(case).sha256


@pytest.mark.parametrize("name", catalogue.names("case"))
def test_shipped_cases_survive_the_round_trip(name: str) -> None:
    loaded = load_case(name)
    again = read_case(dump_case(loaded.case))
    assert again.case == loaded.case
    assert again.sha256 == loaded.sha256


@pytest.mark.parametrize("name", catalogue.names("fabric"))
def test_shipped_fabrics_survive_the_round_trip(name: str, tmp_path: Any) -> None:
    fabric = load_fabric(name)
    path = tmp_path / "fabric.yaml"
    path.write_text(dump_fabric(fabric), encoding="utf-8")
    assert load_fabric(path) == fabric


def test_the_bodies_of_the_schema_are_those_of_the_registry() -> None:
    assert set(MODELS) == set(SHAPES)


@pytest.mark.parametrize("name", SHAPES)
def test_keys_of_a_body_are_the_arguments_of_its_builder(name: str) -> None:
    keys = {key: info for key, info in MODELS[name].model_fields.items() if key not in {*Placed.model_fields, "type"}}
    arguments = inspect.signature(SHAPES[name]).parameters
    assert set(keys) == set(arguments)
    for key, argument in arguments.items():
        required = argument.default is inspect.Parameter.empty
        assert keys[key].is_required() == required
        assert required or keys[key].default == argument.default


def test_defaults_are_those_of_the_registries() -> None:
    fields = {item.name: item.default for item in CRITERIA[DEFAULT_CRITERION].parameters}
    failure = Case.model_fields["failure"].default
    assert failure.criterion == DEFAULT_CRITERION
    assert failure.onset == fields["onset"]
