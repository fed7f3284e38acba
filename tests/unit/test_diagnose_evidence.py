"""What is said of the level of evidence: a class is never sold as a name, a further test is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from etextile.diagnose.decide.verdict import Answer
from etextile.studies.diagnose.evidence import evidence_words


def words(kind: str, *, rounds: tuple[Any, ...] = (), **changes: Any) -> str:
    part = SimpleNamespace(what="displacements beyond 30 mm", shrinks=True)
    usual = {
        "best": SimpleNamespace(held_out=(part,)),
        "classes": (),
        "sets": (),
        "lattice_doubt": False,
    }
    return evidence_words(
        SimpleNamespace(verdict=SimpleNamespace(kind=Answer(kind), **(usual | changes)), rounds=rounds)
    )  # type: ignore[arg-type]


def test_a_name_says_what_it_rests_on_and_whether_a_further_test_bears_it_out() -> None:
    alone = words("named")
    assert "displacements beyond 30 mm" in alone
    assert "one kind of test" in alone
    assert "bears it out (second radius)" in words("named", rounds=(SimpleNamespace(test="second_radius"),))


def test_a_class_is_called_a_class_and_no_name() -> None:
    text = words("ambiguous", classes=(("yarn_tail", "yarn_damage"), ("geometry",)), sets=(("yarn_tail",),))
    assert text.startswith("A class, not a name: yarn_tail or yarn_damage,")
    assert "geometry" not in text


@pytest.mark.parametrize(
    ("kind", "changes", "said"),
    [
        ("no_gap", {}, "would not have been seen"),
        ("ambiguous", {"sets": (("a",), ("b",))}, "2 explanations are left"),
        ("ambiguous", {"sets": (("a",),)}, "something that a name needs is missing"),
        ("unexplained", {"lattice_doubt": True}, "lattice"),
        ("unexplained", {}, "no finding"),
    ],
)
def test_every_other_verdict_says_how_far_it_goes(kind: str, changes: dict[str, Any], said: str) -> None:
    assert said in words(kind, **changes)
