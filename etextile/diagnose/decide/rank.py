"""Ranking of hypotheses: nothing, one effect, pairs, three, a free discrepancy, and an effect that leaves a rest.

Every pair is looked at (a stepwise search fails when effects are correlated): first quickly, with one mean covariance;
the best of them then like all others. A third effect is tried beside a pair that leads.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from etextile.diagnose.infer.fit import Evidence, ScatterSample, bound, judge
from etextile.diagnose.infer.gauss import log_sum
from etextile.diagnose.infer.lattice_doubt import facing
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable, each_with_its_own
from etextile.types import Array


class Kind(StrEnum):
    """What a hypothesis is made of."""

    NONE = "none"
    """Nothing is missing."""
    ONE, TWO, THREE = "one", "two", "three"
    """So many effects."""
    FREE = "free"
    """A free discrepancy."""
    REST = "rest"
    """Effects that leave a free discrepancy."""
    FAULT = "fault"
    """A fault of the test (`directed`)."""


OF_EFFECTS = (Kind.ONE, Kind.TWO, Kind.THREE)
# Prior weight of each kind of hypothesis, shared equally by the hypotheses of that kind.
PRIOR = {Kind.NONE: 0.40, Kind.ONE: 0.36, Kind.TWO: 0.12, Kind.THREE: 0.02, Kind.FREE: 0.07, Kind.REST: 0.03}
PAIRS_KEPT, THREES_KEPT = 8, 2
# Change by an effect in standard deviations below which these channels cannot show it.
VISIBLE = 3.0


@dataclass(frozen=True)
class Contender:
    """A hypothesis with its evidence and log prior; `offset` (n,): known interaction.

    `doubt` (n, n): what its own runs leave open, None where the doubts about its effects stand for that.
    `fault`: which, for a fault of the test.
    """

    kind: Kind
    evidence: Evidence
    log_prior: float
    offset: Array | None = None
    doubt: Array | None = None
    fault: str = ""

    @property
    def key(self) -> tuple[Kind, str, tuple[str, ...]]:
        """What tells it from others of a ranking."""
        return self.kind, self.fault, self.ids

    @property
    def ids(self) -> tuple[str, ...]:
        """Effects of the hypothesis."""
        return self.evidence.ids

    @property
    def score(self) -> float:
        """Logarithm of the unnormalised probability."""
        return self.evidence.log_evidence + self.log_prior

    def parts(self, tables: Mapping[str, EffectTable]) -> Iterator[tuple[EffectTable, Array]]:
        """Yield the table of every effect with its own coordinates at the likeliest point."""
        yield from each_with_its_own([tables[name] for name in self.ids], self.evidence.best)

    @property
    def label(self) -> str:
        """Name in tables."""
        names = " + ".join(self.ids)
        return {
            Kind.NONE: "no effect",
            Kind.FREE: "free discrepancy",
            Kind.REST: f"{names} + free discrepancy",
            Kind.FAULT: f"fault {self.fault.replace('_', ' ')}",
        }.get(self.kind, names)


@dataclass(frozen=True)
class Ranking:
    """Contenders by falling probability, and the probabilities."""

    contenders: tuple[Contender, ...]
    probabilities: Array

    @classmethod
    def of(cls, contenders: Sequence[Contender]) -> Ranking:
        """Sort and normalise."""
        order = sorted(contenders, key=lambda item: -item.score)
        scores = np.array([item.score for item in order])
        return cls(tuple(order), np.exp(scores - log_sum(scores)))

    @property
    def best(self) -> Contender:
        """The most probable hypothesis."""
        return self.contenders[0]

    @property
    def effects(self) -> tuple[Contender, ...]:
        """Hypotheses of named effects alone, by falling probability."""
        return tuple(item for item in self.contenders if item.kind in OF_EFFECTS)

    def probability(self, ids: Sequence[str]) -> float:
        """Return the probability of exactly these effects."""
        return float(sum(
            p for item, p in zip(self.contenders, self.probabilities, strict=True)
            if item.kind in (*OF_EFFECTS, Kind.NONE) and set(item.ids) == set(ids)
        ))  # fmt: skip

    def support(
        self, ids: Sequence[str], faint: Mapping[tuple[str, ...], Sequence[str]] = MappingProxyType({})
    ) -> float:
        """Return the probability that these effects act and no others that show, a free rest beside them allowed.

        `faint`: effects of a hypothesis whose own change noise could hide. They, and the rest, count as nothing beside
        as long as the effects are likelier without them: a small smooth error of the effect's form is no other cause.
        """
        alone = self.probability(ids)
        beside = [
            float(p) for item, p in zip(self.contenders, self.probabilities, strict=True)
            if (item.kind is Kind.REST and set(item.ids) == set(ids))
            or (item.kind is not Kind.REST and set(ids) < set(item.ids) <= {*ids, *faint.get(item.ids, ())})
        ]  # fmt: skip
        return alone + sum(p for p in beside if p <= alone)

    def of_kind(self, *kinds: Kind) -> float:
        """Return the probability of kinds of hypotheses."""
        return float(sum(p for item, p in zip(self.contenders, self.probabilities, strict=True) if item.kind in kinds))

    def of_fault(self, fault: str) -> float:
        """Return the probability of a fault of the test."""
        return float(sum(p for item, p in zip(self.contenders, self.probabilities, strict=True) if item.fault == fault))

    def including(self, *ids: str) -> float:
        """Return the probability that these effects take part, whatever else does."""
        wanted = set(ids)
        return float(
            sum(p for item, p in zip(self.contenders, self.probabilities, strict=True) if wanted <= set(item.ids))
        )

    def without(self, ruled_out: Sequence[tuple[str, ...]]) -> Ranking:
        """Return the ranking in which hypotheses of exactly these effects have no probability."""
        return Ranking.of([
            replace(item, log_prior=-np.inf) if item.ids and item.ids in ruled_out else item for item in self.contenders
        ])  # fmt: skip

    def replaced(self, contenders: Sequence[Contender]) -> Ranking:
        """Return the ranking with contenders of the same kind and effects replaced or added."""
        new = {item.key: item for item in contenders}
        kept = [item for item in self.contenders if item.key not in new]
        return Ranking.of([*kept, *new.values()])


def visible(tables: Mapping[str, EffectTable], sample: ScatterSample) -> dict[str, float]:
    """Return how many standard deviations the largest change within an effect's range is, per effect."""
    found = {}
    for name, table in tables.items():
        curves = table.basis @ table.amplitudes[:, table.valid]
        norms = np.linalg.norm(sample.whiten(curves), axis=0) if curves.shape[1] else np.zeros(1)
        found[name] = float(norms.max(initial=0.0))
    return found


def rank_singles(
    bench: Workbench, tables: Mapping[str, EffectTable], form: Array, free: tuple[Evidence, Array]
) -> Ranking:
    """Return the ranking of nothing, all single effects, the free discrepancy, and the best effect with a rest."""
    single = float(np.log(PRIOR[Kind.ONE] / max(len(tables), 1)))
    found = [Contender(Kind.NONE, judge(bench.samples, (), form), float(np.log(PRIOR[Kind.NONE])))]
    found += [
        Contender(Kind.ONE, judge(facing(bench, (table,)).samples, (table,), form), single) for table in tables.values()
    ]
    found.append(Contender(Kind.FREE, free[0], float(np.log(PRIOR[Kind.FREE]))))
    return Ranking.of(found)


def rank_pairs(
    bench: Workbench, tables: Mapping[str, EffectTable], form: Array, *, keep: int = PAIRS_KEPT,
    likely: Collection[str] | None = None,
) -> list[Contender]:  # fmt: skip
    """Return the best pairs, judged in full, out of all.

    `likely`: effects of which one takes part in every pair that is looked at: two that neither come near the best nor
    show in what it leaves have nothing to add to each other.
    """
    every = list(itertools.combinations(tables.values(), 2))
    pairs = [pair for pair in every if likely is None or any(table.id in likely for table in pair)]
    if not pairs:
        return []
    order = _most_evident(pairs, bench, form, keep)
    log_prior = float(np.log(PRIOR[Kind.TWO] / len(every)))
    return [Contender(Kind.TWO, judge(facing(bench, pairs[i]).samples, pairs[i], form), log_prior) for i in order]


def _most_evident(pairs: Sequence[Sequence[EffectTable]], bench: Workbench, form: Array, keep: int) -> list[int]:
    """Return the numbers of the pairs of most evidence under one mean covariance; none is judged that cannot be one."""
    faced = [facing(bench, pair).mean_sample for pair in pairs]
    most = np.array([bound(sample, pair, form) for sample, pair in zip(faced, pairs, strict=True)])
    rough: dict[int, float] = {}
    for i in (int(i) for i in np.argsort(-most, kind="stable")):
        if len(rough) >= keep and most[i] < sorted(rough.values())[-keep]:
            break
        rough[i] = judge((faced[i],), pairs[i], form).log_evidence
    return sorted(rough, key=lambda i: (-rough[i], i))[:keep]


def rank_threes(
    bench: Workbench, pair: Sequence[str], tables: Mapping[str, EffectTable], form: Array, *,
    offset: Array | None = None, doubt: Array | None = None, keep: int = THREES_KEPT,
) -> list[Contender]:  # fmt: skip
    """Return the best sets of three that contain a pair, judged in full, out of all with these tables.

    `offset` (n,): what the simulation of the pair has beyond the superposition of its effects; `doubt` (n, n): what
    that leaves open.
    """
    sets = [[tables[one] for one in (*pair, other)] for other in tables if other not in pair]
    if not sets:
        return []
    doubts = [_sum(doubt, item[-1].doubt) if doubt is not None else None for item in sets]
    faced = [facing(bench, item, own) for item, own in zip(sets, doubts, strict=True)]
    rough = [judge((own.mean_sample,), item, form, offset=offset) for own, item in zip(faced, sets, strict=True)]
    order = np.argsort([-item.log_evidence for item in rough])[:keep]
    count = len(tables)
    log_prior = float(np.log(PRIOR[Kind.THREE] / (count * (count - 1) * (count - 2) / 6.0)))
    return [
        Contender(Kind.THREE, judge(faced[i].samples, sets[i], form, offset=offset), log_prior, offset, doubts[i])
        for i in order
    ]


def _sum(doubt: Array, other: Array | None) -> Array:
    return doubt if other is None else doubt + other


def swapped(
    leader: Contender, groups: Sequence[Sequence[str]], bench: Workbench, tables: Mapping[str, EffectTable], form: Array
) -> list[Contender]:  # fmt: skip
    """Return a leader's rivals that have another effect of a class in the place of its first, judged in full.

    `groups`: one class per effect of the leader, the effect itself first.
    """
    found = []
    for own, *others in groups:
        for other in others:
            ids = [other if name == own else name for name in leader.ids]
            chosen = [tables[name] for name in ids]
            found.append(Contender(leader.kind, judge(facing(bench, chosen).samples, chosen, form), leader.log_prior))
    return found


def with_rest(
    contender: Contender, bench: Workbench, tables: Mapping[str, EffectTable], form: Array, rests: Sequence[Array]
) -> Contender:
    """Return the hypothesis that effects leave a free rest: as much less likely beforehand for pairs as for one.

    `rests`: columns (n, k) of rests of several sizes and lengths, all equally likely. The likeliest is judged in full,
    how far the others are behind it under the mean covariance.
    """
    chosen = [tables[name] for name in contender.ids]
    faced = facing(bench, chosen, contender.doubt)
    quick = np.array([
        judge((faced.mean_sample,), chosen, form, extra=columns, offset=contender.offset).log_evidence
        for columns in rests
    ])  # fmt: skip
    best = int(np.argmax(quick))
    behind = float(log_sum(quick - quick[best])) - np.log(len(quick))
    evidence = judge(faced.samples, chosen, form, extra=rests[best], offset=contender.offset)
    evidence = replace(evidence, log_evidence=evidence.log_evidence + float(behind))
    log_prior = contender.log_prior + float(np.log(PRIOR[Kind.REST] / PRIOR[Kind.ONE]))
    return Contender(Kind.REST, evidence, log_prior, contender.offset, contender.doubt)


def rejudged(
    contender: Contender, bench: Workbench, tables: Mapping[str, EffectTable], form: Array, *, offset: Array | None
) -> Contender:
    """Return a contender judged again, with corrected tables or a known interaction."""
    chosen = [tables[name] for name in contender.ids]
    samples = facing(bench, chosen, contender.doubt).samples
    return replace(contender, evidence=judge(samples, chosen, form, offset=offset), offset=offset)
