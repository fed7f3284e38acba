r"""Directed tests: faults of a test that no effect of the library holds, looked for where they would show.

A library answers with what is in it. A weft that is not the one of the coupons makes a softer machine, an offset of the
load cell makes a little pretension, and both would be named with certainty. So such faults compete as explanations
without a mechanism, each with a few patterns x_j of known shape and wide sizes s_j,

    r = sum_j a_j x_j + noise,   a_j ~ N(0, s_j^2),

and two tests look at what no effect changes: whether mirrored points of a field moved alike, and whether one specimen
stands out of the others by more than specimens scatter.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.noise import FIELD_FLOOR, FIELD_SHARE
from etextile.diagnose.data.points import Points
from etextile.diagnose.decide.rank import Contender, Kind
from etextile.diagnose.decide.where import NAMES as WHERE_NAMES
from etextile.diagnose.infer.fit import FORM, judge
from etextile.diagnose.infer.whitened import Workbench
from etextile.types import Array, IntArray
from etextile.vocabulary import CLAMP, EDGE, FABRIC_FAMILIES, FORCES, STRAIN


PRIOR = 0.03
"""Prior weight of all faults together, beside those of the ranking."""
LAW_SIZES = (0.3, 0.25, 0.08)
"""Standard deviations of ln E, ln s and n of a family that is not the one of its coupons."""
DRIFT = 0.03
"""Standard deviation of an offset of the load cell, and of its drift over a test, as a share of the largest force."""
LEVEL = 0.001
"""Chance below which a directed test counts as failed."""
MIN_PAIRS, SHARED = 6, 4.0
"""Mirrored pairs that a test of symmetry needs, and how many of them share one smooth error."""
PRIOR_GAIN, PRIOR_COUNT = 0.01, 4
"""Scatter of specimens that is usual, and how many specimens the knowledge of it is worth."""
NAMES = {"warp": "warp", "weft": "weft", "diagonal": "shear"}


@dataclass(frozen=True)
class Fault:
    """A fault as an explanation: what is said of it, what tells it apart, its contender; `family` whose law it is."""

    id: str
    words: str
    separate: str
    contender: Contender
    family: str = ""


@dataclass(frozen=True)
class _Suspect:
    """A fault before it is judged: columns (n, k) of changes it may make, `offset` (n,) of what it surely makes."""

    id: str
    words: str
    separate: str
    columns: Array
    offset: Array | None = None
    family: str = ""


@dataclass(frozen=True)
class Check:
    """A test of what no effect changes: p-value and a sentence when it fails; `words` say what was tested."""

    id: str
    p_value: float
    words: str

    @property
    def failed(self) -> bool:
        """Whether noise and scatter do not explain what was seen."""
        return self.p_value < LEVEL


def faults(
    bench: Workbench, form: Array, jacobian: Array, *, exponents: Sequence[float], coupons: bool = True,
    turned: Array | None = None,
) -> tuple[Fault, ...]:  # fmt: skip
    """Return all faults as explanations; `coupons`: whether the laws come from coupons, or are the case's own.

    `jacobian` (n, 9): change per (ln E, ln s, n) of every family; `exponents` (3,): n of each; `turned` (n,): change
    when warp and weft are exchanged, None where that makes no difference or was not run.
    """
    found = [_other_law(i, jacobian, exponents, coupons=coupons) for i in range(len(FABRIC_FAMILIES))]
    found += _drifting(bench)
    if turned is not None and np.all(np.isfinite(turned)):
        words = "a specimen clamped along its weft instead of its warp"
        found.append(
            _Suspect("turned", words, "Look at a specimen that was tested.", np.zeros((len(turned), 1)), offset=turned)
        )
    prior = float(np.log(PRIOR / max(len(found), 1)))
    return tuple(
        Fault(item.id, item.words, item.separate, _contender(item, bench, form, prior), item.family) for item in found
    )


def _other_law(i: int, jacobian: Array, exponents: Sequence[float], *, coupons: bool) -> _Suspect:
    """Return that the law of one family is another than the model has."""
    family = FABRIC_FAMILIES[i]
    sizes = np.array([LAW_SIZES[0], LAW_SIZES[1], LAW_SIZES[2] * exponents[i]])
    return _Suspect(
        f"other_{family}", f"a {NAMES[family]} law that is not the one of the {'coupons' if coupons else 'case'}",
        "Cut coupons from the specimens that were tested.", jacobian[:, 3 * i : 3 * i + 3] * sizes, family=family,
    )  # fmt: skip


def _drifting(bench: Workbench) -> list[_Suspect]:
    """Return that the load cell drifts; nothing without a channel of it."""
    force = np.any([bench.points.of(name) for name in FORCES], axis=0)
    if not force.any():
        return []
    size = DRIFT * float(np.abs(bench.base[force]).max())
    share = bench.points.displacement / max(float(bench.points.displacement.max()), 1e-9)
    columns = np.where(force[:, None], size * np.stack([np.ones_like(share), share], axis=1), 0.0)
    separate = "Read the load cell without load before and after the test."
    return [_Suspect("load_cell_drift", "an offset or a drift of the load cell", separate, columns)]


def in_words(faults: Sequence[Fault]) -> str:
    """Return faults as alternatives in one phrase, the laws of several families together."""
    laws = [item for item in faults if item.family]
    phrases = [item.words for item in faults if item not in laws]
    if laws:
        families = " or ".join(NAMES[item.family] for item in laws)
        phrases.insert(0, f"a {families} {laws[0].words.partition(' ')[2].partition(' ')[2]}")
    return " or ".join(phrases)


def _contender(item: _Suspect, bench: Workbench, form: Array, log_prior: float) -> Contender:
    """Return a fault judged with smooth factors of its likeliest change, as effects have them."""
    sample, columns = bench.mean_sample, item.columns
    residual = sample.residual if item.offset is None else sample.residual - sample.whiten(item.offset)
    white = sample.whiten(columns)
    weights = np.linalg.solve(np.eye(columns.shape[1]) + white.T @ white, white.T @ residual)
    change = columns @ weights + (0.0 if item.offset is None else item.offset)
    extra = np.concatenate([columns, FORM * change[:, None] * form], axis=1)
    evidence = judge(bench.samples, (), form, extra=extra, offset=item.offset)
    return Contender(Kind.FAULT, evidence, log_prior, item.offset, fault=item.id)


def checks(bench: Workbench) -> tuple[Check, ...]:
    """Return the tests of symmetry and of specimens that these measurements allow."""
    return (*_symmetry(bench), *_odd(bench))


def _symmetry(bench: Workbench) -> list[Check]:
    """Return, per field channel with mirrored points, whether both sides moved alike.

    chi^2 of the differences of pairs, each in the instrument's noise and a smooth error of either side.
    """
    from scipy.stats import chi2

    raw, found = bench.raw, []
    for channel in (EDGE, STRAIN, CLAMP):
        own = np.flatnonzero(raw.of(channel))
        if not len(own):
            continue
        differences, variance = _mirrored(raw, own, bench.raw.value, bench.white_raw, _smooth(bench))
        if len(differences) < MIN_PAIRS:
            continue
        # differences of one step share a smooth error: they count as one in so many
        statistic = float((differences**2 / variance).mean())
        free = max(len(differences) / SHARED, 2.0)
        p = float(chi2.sf(statistic * free, free))
        size = float(np.sqrt(np.mean(differences**2)))
        unit = f" {raw.series[int(raw.owner[own[0]])].unit}".rstrip()
        name = channel.replace("_", " ")
        found.append(Check(f"symmetry_{channel}", p, f"mirrored points of the {name} differ by {size:.2g}{unit} (rms)"))
    return found


def _smooth(bench: Workbench) -> Array:
    """Return the smooth error (N,) of one side of a field at raw points, from that of the bins."""
    return np.asarray(
        np.hypot(FIELD_SHARE * np.abs(bench.shape.motion)[bench.bins.bin_of], FIELD_FLOOR * bench.white_raw)
    )


def _mirrored(raw: Points, own: IntArray, value: Array, white: Array, smooth: Array) -> tuple[Array, Array]:
    """Return differences (p,) of mirrored pairs and their variance (p,), each pair once.

    Partners have opposite weft0, or opposite warp0, at one displacement; what is odd under the mirror is added.
    """
    index: dict[tuple[int, float, float, float], int] = {}
    for i in own.tolist():
        index[_key(raw, i, 1.0, 1.0)] = i
    differences, variance = [], []
    for i, (a, b) in itertools.product(own.tolist(), ((-1.0, 1.0), (1.0, -1.0))):
        partner = index.get(_key(raw, i, a, b))
        if partner is None or partner <= i:
            continue
        quantity = raw.series[int(raw.owner[i])].quantity
        odd = (quantity == "warp" and a < 0.0) or (quantity == "weft" and b < 0.0)
        differences.append(value[i] + value[partner] if odd else value[i] - value[partner])
        variance.append(white[i] ** 2 + white[partner] ** 2 + smooth[i] ** 2 + smooth[partner] ** 2)
    return np.array(differences), np.array(variance)


def _key(raw: Points, i: int, a: float, b: float) -> tuple[int, float, float, float]:
    warp0, weft0 = float(np.nan_to_num(raw.warp0[i])), float(np.nan_to_num(raw.weft0[i], posinf=1e6, neginf=-1e6))
    return int(raw.owner[i]), round(float(raw.displacement[i]), 6), round(a * warp0, 6) + 0.0, round(b * weft0, 6) + 0.0


def _odd(bench: Workbench) -> list[Check]:
    """Return whether one specimen's curve stands out of the mean of the others, with three specimens or more.

    Mean difference to the others over the upper half of the travel, relative; in its standard deviation between the
    others (Student t), at least what the noise leaves.
    """
    from scipy.stats import t as student

    points, own = bench.points, bench.points.curves
    numbers = np.unique(points.owner[own])
    if len(numbers) < 3:
        return []
    far = own & (points.displacement > 0.5 * points.displacement.max())
    ratio = np.array([
        float(np.sum(bench.residual[far & (points.owner == k)] * bench.base[far & (points.owner == k)]))
        / max(float(np.sum(bench.base[far & (points.owner == k)] ** 2)), 1e-12)
        for k in numbers
    ])  # fmt: skip
    floor = float(np.mean(bench.white[far] / np.abs(bench.base[far]))) / np.sqrt(max(far.sum() / len(numbers), 1.0))
    scatter = np.sqrt(sum(item.weight * (item.scatter.gain**2 + item.scatter.drift**2) for item in bench.scatters))
    worst, p = 0, 1.0
    for k in range(len(numbers)):
        rest = np.delete(ratio, k)
        spread = np.hypot(max(float(rest.std(ddof=1)), min(float(scatter), PRIOR_GAIN)), floor)
        z = abs(ratio[k] - rest.mean()) / (spread * np.sqrt(1.0 + 1.0 / len(rest)))
        chance = min(1.0, len(numbers) * float(2.0 * student.sf(z, len(rest) - 1 + PRIOR_COUNT)))
        worst, p = (k, chance) if chance < p else (worst, p)
    label = points.series[int(numbers[worst])].label
    apart = 100.0 * (ratio[worst] - np.delete(ratio, worst).mean())
    name = WHERE_NAMES[points.series[int(numbers[worst])].channel]
    return [Check("odd_specimen", p, f"the {name} of {label} is {apart:+.1f} % off the others' in the upper half")]
