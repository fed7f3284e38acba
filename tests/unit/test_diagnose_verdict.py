"""What is named, what stays ambiguous or unexplained, and when there is no gap: the rules on made-up finalists."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.finalists import NOTHING, OTHER, SURE, contender, finalist, held_out

from etextile.diagnose.decide.rank import Contender, Ranking
from etextile.diagnose.decide.residual_test import Settled, falsified
from etextile.diagnose.decide.rivals import possible
from etextile.diagnose.decide.verdict import Answer, Finalist, Verdict, decide


def verdict(
    contenders: list[Contender], finalists: list[Finalist], *, detected: bool = True, doubt: bool = False
) -> Verdict:
    return decide(Ranking.of(contenders), finalists, detected=detected, lattice_doubt=doubt)


def test_a_sure_effect_is_named() -> None:
    found = verdict([SURE, OTHER, NOTHING], [finalist(SURE, 0.97), finalist(OTHER, 0.02)])
    assert (found.kind, found.effects) == (Answer.NAMED, ("clamp_slip",))


def test_a_class_is_told_as_a_whole_and_not_by_its_first() -> None:
    ranking, classes = Ranking.of([SURE, OTHER, NOTHING]), (("clamp_slip", "yarn_tail"),)
    found = decide(ranking, [finalist(SURE, 0.97)], detected=True, lattice_doubt=False, classes=classes)
    assert found.kind is Answer.AMBIGUOUS
    assert found.sentence.startswith("clamp_slip or yarn_tail is the best explanation")


def test_nothing_is_named_where_nothing_was_detected() -> None:
    assert verdict([SURE, NOTHING], [finalist(SURE, 0.97)], detected=False).kind is Answer.NO_GAP


def test_a_large_lattice_error_forbids_naming() -> None:
    assert verdict([SURE, NOTHING], [finalist(SURE, 0.97)], doubt=True).kind is Answer.UNEXPLAINED


@pytest.mark.parametrize(
    "change",
    [
        {"at_bound": ("limit",)},
        {"rest_p": 1e-4},
        {"held_out": (held_out(-0.9, -0.1),)},
        {"probability": 0.7},
        {"alone": 0.5},
        {"simulated": False},
        {"faint": ("clamp_slip",)},
    ],
)
def test_each_condition_alone_keeps_an_effect_from_being_named(change: dict) -> None:
    found = verdict([SURE, OTHER, NOTHING], [replace(finalist(SURE, 0.97), **change), finalist(OTHER, 0.02)])
    assert found.kind is not Answer.NAMED


def test_two_explanations_of_like_probability_are_ambiguous() -> None:
    first, second = contender("one", "clamp_slip", probability=0.55), contender("one", "yarn_tail", probability=0.44)
    found = verdict([first, second, NOTHING], [finalist(first, 0.55), finalist(second, 0.44)])
    assert found.kind is Answer.AMBIGUOUS
    assert found.effects == ("clamp_slip",)
    assert found.ambiguous_with == ("yarn_tail",)


@pytest.mark.parametrize(("odds", "kind"), [(300.0, Answer.AMBIGUOUS), (3000.0, Answer.NAMED)])
def test_a_name_needs_decisive_odds_against_an_effect_it_is_confused_with(odds: float, kind: str) -> None:
    confused = {"yarn_damage": ("yarn_tail",)}
    best = contender("two", "yarn_damage", "pretension", probability=odds / (odds + 1.0))
    rival = contender("two", "yarn_tail", "pretension", probability=1.0 / (odds + 1.0))
    finalists = [finalist(best, odds / (odds + 1.0)), finalist(rival, 1.0 / (odds + 1.0))]
    found = decide(Ranking.of([best, rival]), finalists, detected=True, lattice_doubt=False, confused=confused)
    assert found.kind == kind
    assert found.effects == ("yarn_damage", "pretension")
    assert found.ambiguous_with == (("yarn_tail",) if kind == Answer.AMBIGUOUS else ())
    assert decide(Ranking.of([best, rival]), finalists, detected=True, lattice_doubt=False).kind is Answer.NAMED


def test_what_the_leader_is_confused_with_is_simulated_for_itself_unless_decisively_less_likely() -> None:
    """A rival of another kind is left alone at the same odds."""
    confused = {"yarn_damage": ("yarn_tail",)}
    best = contender("two", "yarn_damage", "pretension", probability=0.98)
    near, far = (contender("two", "yarn_tail", "pretension", probability=p) for p in (0.01, 1e-4))
    other = contender("two", "clamp_slip", "pretension", probability=0.01)
    assert possible(Ranking.of([best, near, other, NOTHING]), confused) == [best, near]
    assert possible(Ranking.of([best, far, other, NOTHING]), confused) == [best]
    assert possible(Ranking.of([NOTHING]), confused) == []


@pytest.mark.parametrize(
    ("before", "rest_p", "kind"), [(0.01, 0.4, Answer.AMBIGUOUS), (0.2, 0.4, Answer.NAMED), (0.01, 1e-4, Answer.NAMED)]
)
def test_a_name_has_to_stand_before_the_finer_lattices_too(before: float, rest_p: float, kind: str) -> None:
    """Unless what led there leaves a rest that noise does not explain."""
    best = replace(finalist(SURE, 0.97), probability_coarse=before)
    led = replace(finalist(OTHER, 1e-9), probability_coarse=0.9, rest_p=rest_p)
    found = verdict([SURE, OTHER, NOTHING], [best, led])
    assert found.kind == kind
    assert found.effects == ("clamp_slip",)
    assert found.ambiguous_with == (("yarn_tail",) if kind == Answer.AMBIGUOUS else ())


def test_a_set_of_three_is_not_held_against_the_pair_that_led_before_it_was_tried() -> None:
    three = contender("three", "clamp_slip", "yarn_tail", "geometry", probability=0.98)
    pair = contender("two", "clamp_slip", "yarn_tail", probability=1e-6)
    found = verdict(
        [three, pair, NOTHING],
        [
            replace(finalist(three, 0.98), probability_coarse=0.0),
            replace(finalist(pair, 1e-6), probability_coarse=0.9),
        ],
    )
    assert (found.kind, found.effects) == (Answer.NAMED, three.ids)


def test_an_effect_that_moves_the_force_against_its_card_is_no_explanation() -> None:
    found = verdict([SURE, NOTHING], [replace(finalist(SURE, 0.97), undeclared=("clamp_slip",))])
    assert (found.kind, found.effects) == (Answer.UNEXPLAINED, ())
    assert "as its card says" in found.sentence
    found = verdict([SURE, OTHER], [replace(finalist(SURE, 0.97), undeclared=("clamp_slip",)), finalist(OTHER, 0.02)])
    assert found.kind is not Answer.NAMED
    assert "yarn_tail" in found.sentence


def test_a_small_rest_beside_the_best_leaves_an_effect_it_is_confused_with_possible() -> None:
    """More than half of the probability has a free rest, all of it beside the best, which has no other objection."""
    best = contender("one", "yarn_damage", probability=0.42)
    rests = [
        contender("rest", "yarn_damage", probability=0.40),
        contender("rest", "yarn_damage", "geometry", probability=0.14),
    ]
    rival = contender("one", "yarn_tail", probability=0.01)
    ranking = Ranking.of([best, *rests, rival, contender("two", "yarn_damage", "geometry", probability=0.03)])
    sure = replace(finalist(best, ranking.including("yarn_damage")), alone=ranking.support(("yarn_damage",)))
    assert not sure.objections()
    found = decide(
        ranking, [sure, finalist(rival, 0.01)], detected=True, lattice_doubt=False,
        confused={"yarn_damage": ("yarn_tail",)},
    )  # fmt: skip
    assert (found.kind, found.effects, found.ambiguous_with) == (Answer.AMBIGUOUS, ("yarn_damage",), ("yarn_tail",))


def test_a_free_discrepancy_wins_but_has_no_name() -> None:
    free = contender("free", probability=0.97)
    weak = contender("one", "yarn_tail", probability=0.02)
    found = verdict([free, weak, NOTHING], [finalist(weak, 0.02)])
    assert found.kind is Answer.UNEXPLAINED
    assert found.effects == ()
    assert "yarn_tail" in found.sentence


def test_a_small_rest_beside_an_effect_supports_it_and_a_large_one_does_not() -> None:
    alone = contender("one", "clamp_slip", probability=0.6)
    rest = contender("rest", "clamp_slip", probability=0.35)
    assert Ranking.of([alone, rest, NOTHING]).support(("clamp_slip",)) == pytest.approx(0.95 / 0.96)
    assert Ranking.of([replace(alone, log_prior=-2.0), rest]).support(("clamp_slip",)) < 0.3


def test_a_second_effect_that_noise_could_hide_takes_nothing_from_the_first() -> None:
    alone = contender("one", "clamp_slip", probability=0.5)
    more = contender("two", "clamp_slip", "yarn_tail", probability=0.4)
    ranking = Ranking.of([alone, more, contender("none", probability=0.1)])
    assert ranking.support(("clamp_slip",)) == pytest.approx(0.5)
    assert ranking.support(("clamp_slip",), {more.ids: ("yarn_tail",)}) == pytest.approx(0.9)
    assert ranking.support(("clamp_slip",), {more.ids: ("clamp_slip",)}) == pytest.approx(0.5)
    assert ranking.support(more.ids, {more.ids: ("yarn_tail",)}) == pytest.approx(0.4)


def ruled_out(behind: float = 0.5, **rest_p: float) -> list[tuple[str, ...]]:
    """Return what is ruled out of hypotheses that are named by their effects, most probable first."""
    settled = [
        Settled(contender("one", *name.split("_"), probability=behind**number), None, p)  # type: ignore[arg-type]
        for number, (name, p) in enumerate(rest_p.items())
    ]
    return falsified(settled)


def test_a_leader_that_leaves_a_rest_gives_way_to_a_rival_that_leaves_none() -> None:
    assert ruled_out(a=0.0002, b=0.2) == [("a",)]
    assert ruled_out(a=0.0002, c=0.0002, b=0.2) == [("a",), ("c",)]


def test_a_leader_does_not_give_way_to_itself_with_another_effect_nor_to_equals() -> None:
    assert ruled_out(a=0.0002, a_b=0.2) == []
    assert ruled_out(a=0.0002, b=0.0002) == []
    assert ruled_out(a=0.1, b=0.2) == []


def test_a_rival_far_behind_rules_nothing_out() -> None:
    assert ruled_out(behind=1e-3, a=0.0002, b=0.2) == [("a",)]
    assert ruled_out(behind=1e-6, a=0.0002, b=0.2) == []


def test_what_is_ruled_out_keeps_its_place_in_the_table_without_probability() -> None:
    ranking = Ranking.of([
        contender("one", "a", probability=0.9), contender("two", "a", "b", probability=0.06),
        contender("one", "d", probability=0.04),
    ])  # fmt: skip
    kept = ranking.without([("a",)])
    assert kept.probability(("a",)) == 0.0
    assert kept.probability(("a", "b")) == pytest.approx(0.6)
    assert [item.ids for item in kept.contenders] == [("a", "b"), ("d",), ("a",)]


@pytest.mark.parametrize(("odds", "kind"), [(300.0, Answer.AMBIGUOUS), (3000.0, Answer.NAMED)])
def test_a_member_of_the_class_is_told_apart_by_decisive_odds_alone(odds: float, kind: str) -> None:
    """No card names the two together: that they look alike was worked out."""
    best = contender("two", "rotational_shear", "yarn_tail", probability=odds / (odds + 1.0))
    rival = contender("two", "compression_carry", "yarn_tail", probability=1.0 / (odds + 1.0))
    finalists = [finalist(best, odds / (odds + 1.0)), finalist(rival, 1.0 / (odds + 1.0))]
    classes = (("rotational_shear", "compression_carry"), ("yarn_tail",))
    found = decide(Ranking.of([best, rival]), finalists, detected=True, lattice_doubt=False, classes=classes)
    assert found.kind == kind
    assert found.classes == (classes if kind == Answer.AMBIGUOUS else (("rotational_shear",), ("yarn_tail",)))
    assert found.ambiguous_with == (("compression_carry",) if kind == Answer.AMBIGUOUS else ())


def test_a_member_of_the_class_that_finds_no_equilibrium_is_not_ruled_out() -> None:
    best = contender("one", "rotational_shear", probability=1.0 - 1e-6)
    rival = contender("one", "compression_carry", probability=1e-6)
    lost = replace(finalist(rival, 1e-6), simulated=False)
    classes = (("rotational_shear", "compression_carry"),)
    found = decide(
        Ranking.of([best, rival]), [finalist(best, 1.0), lost], detected=True, lattice_doubt=False, classes=classes
    )
    assert (found.kind, found.classes) == (Answer.AMBIGUOUS, classes)
    assert "cannot tell rotational_shear from compression_carry" in found.sentence
