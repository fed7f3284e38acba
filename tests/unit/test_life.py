"""Lives with censoring: against published fits, likelihoods written out in plain numpy, and known closed forms."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2

import etextile as et
from etextile.app.cli import main
from etextile.life.curve import survival
from etextile.life.events import EventRule
from etextile.life.fit import FAMILIES, LOGNORMAL, WEIBULL, LifeFit, fit
from etextile.life.lives import Lives, read_lives
from etextile.types import Array


BEARINGS = np.array([
    17.88, 28.92, 33.00, 41.52, 42.12, 45.60, 48.48, 51.84, 51.96, 54.12, 55.56, 67.80, 68.64, 68.64, 68.88, 84.12,
    93.12, 98.64, 105.12, 105.84, 127.92, 128.04, 173.40,
])  # fmt: skip
"""Ball bearings, million revolutions to failure (Lieblein and Zelen 1956)."""
SHOCK = (
    "6700F 6950 7820 8790 9120F 9660 9820 11310 11690 11850 11880 12140 12200F 12870 13150F 13330 13470 14040 14300F "
    "17520F 17540 17890 18450 18960 18980 19410 20100F 20100 20150 20320 20900F 22700F 23490 26510F 27410 27490F "
    "27890 28100"
)
"""Shock absorbers, km; F: failed, others removed whole (Meeker and Escobar 1998, table C.2)."""
INSPECTED = (0.0, 6.12, 19.92, 29.64, 35.40, 39.72, 45.24, 52.32, 63.48)
CRACKED = (5, 16, 12, 18, 18, 2, 6, 17, 73)
"""Turbine parts cracked between inspections, months; the last 73 survived (Nelson 1982, page 415)."""


def lives(low: Array, high: Array) -> Lives:
    count = len(low)
    return Lives(
        tuple(map(str, range(count))), ("all",) * count, np.array(low, float), np.array(high, float), ("",) * count
    )


def shock_absorbers() -> Lives:
    words = SHOCK.split()
    low = np.array([float(word.rstrip("F")) for word in words])
    return lives(low, np.where([word.endswith("F") for word in words], low, np.inf))


def turbine() -> Lives:
    return lives(np.repeat(INSPECTED, CRACKED), np.repeat((*INSPECTED[1:], np.inf), CRACKED))


def fitted(found: LifeFit | str) -> LifeFit:
    assert isinstance(found, LifeFit)
    return found


def test_published_fit_of_complete_lives() -> None:
    """Lawless (2003), ball bearings: Weibull 2.10 and 81.9, lognormal 4.15 and 0.522."""
    weibull, lognormal = (fitted(fit(lives(BEARINGS, BEARINGS), family)) for family in (WEIBULL, LOGNORMAL))
    assert (1.0 / weibull.sigma, weibull.quantile(1.0 - np.exp(-1.0))) == pytest.approx((2.102, 81.88), rel=5e-4)
    assert (lognormal.mu, lognormal.sigma) == pytest.approx((4.150, 0.522), abs=5e-4)
    assert lognormal.mu == pytest.approx(np.log(BEARINGS).mean(), abs=1e-6)
    assert lognormal.sigma == pytest.approx(np.log(BEARINGS).std(), abs=1e-6)


def test_published_fit_of_lives_that_go_on() -> None:
    """Meeker and Escobar (1998), table 8.1, shock absorbers: mu 10.23, sigma 0.3164."""
    found = fitted(fit(shock_absorbers(), WEIBULL))
    assert found.mu == pytest.approx(10.23, abs=5e-3)
    assert found.sigma == pytest.approx(0.3164, abs=5e-5)


def test_published_fit_of_lives_between_inspections() -> None:
    """Nelson (1982): Weibull shape 1.485, characteristic life 71.7 months."""
    found = fitted(fit(turbine(), WEIBULL))
    assert 1.0 / found.sigma == pytest.approx(1.485, abs=5e-4)
    assert np.exp(found.mu) == pytest.approx(71.69, abs=5e-3)


def test_b10_bounds_are_where_the_profile_of_a_likelihood_written_out_by_hand_drops() -> None:
    """Profile over B10 and the shape of S = exp(ln 0.9 (t / B10)^shape), in plain numpy, shock absorbers."""
    words = SHOCK.split()
    time = np.array([float(word.rstrip("F")) for word in words])
    failed = np.array([word.endswith("F") for word in words])

    def profile(b10: float) -> float:
        def against(shape: float) -> float:
            hazard = -np.log(0.9) * (time / b10) ** shape
            return float(hazard.sum() - np.log(hazard[failed] * shape / time[failed]).sum())

        return -float(minimize_scalar(against, bounds=(0.3, 15.0), method="bounded", options={"xatol": 1e-10}).fun)

    best = minimize_scalar(lambda b10: -profile(b10), bounds=(5e3, 3e4), method="bounded", options={"xatol": 1e-6})
    level = -float(best.fun) - 0.5 * chi2.ppf(0.95, 1)
    found = fitted(fit(shock_absorbers(), WEIBULL)).quantile_bounds(0.1)
    expected = (best.x, *(brentq(lambda b10: profile(b10) - level, *ends) for ends in ((2e3, best.x), (best.x, 6e4))))
    assert (found.value, found.low, found.high) == pytest.approx(expected, rel=1e-5)


def test_likelihood_of_mixed_censoring_by_numerical_integration_of_the_density() -> None:
    """Interval, early and open lives of a lognormal: masses of the density summed on a fine grid."""
    found = lives(np.array([0.0, 3.0, 5.0, 7.0]), np.array([2.0, 4.0, np.inf, 7.0]))
    mu, sigma = 1.4, 0.6
    edges = np.exp(np.linspace(-6.0, 9.0, 2_000_001))
    t = 0.5 * (edges[1:] + edges[:-1])
    density = np.exp(-0.5 * ((np.log(t) - mu) / sigma) ** 2) / (t * sigma * np.sqrt(2.0 * np.pi))
    mass = density * np.diff(edges)
    masses = [mass[t < 2.0].sum(), mass[(t > 3.0) & (t < 4.0)].sum(), mass[t > 5.0].sum(), np.interp(7.0, t, density)]
    from etextile.life.fit import log_likelihood

    assert log_likelihood(found, LOGNORMAL, mu, sigma) == pytest.approx(np.log(masses).sum(), abs=2e-5)


@pytest.mark.slow
def test_bounds_keep_their_promise() -> None:
    """Of 200 samples of 12 lives, 37 % censored by time, about 95 % of the B10 intervals hold the true B10."""
    rng = np.random.default_rng(4)
    true = (-np.log(0.9)) ** (1.0 / 2.0)
    held = 0
    for _ in range(200):
        time = rng.weibull(2.0, 12)
        low = np.minimum(time, 1.0)
        bounds = fitted(fit(lives(low, np.where(time > 1.0, np.inf, time)), WEIBULL)).quantile_bounds(0.1)
        held += bounds.low <= true <= bounds.high
    assert 180 <= held <= 198


def test_share_failed_by_a_required_life_inverts_the_quantile() -> None:
    found = fitted(fit(turbine(), WEIBULL))
    b10 = found.quantile_bounds(0.1)
    assert found.failed(b10.value) == pytest.approx(0.1)
    assert found.failed_bounds(b10.low).high == pytest.approx(0.1, abs=1e-6)
    assert found.failed_bounds(b10.high).low == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize("family", FAMILIES.values(), ids=lambda family: family.name)
def test_no_fit_where_the_lives_do_not_bound_the_likelihood(family: object) -> None:
    same = lives(np.full(4, 100.0), np.full(4, 100.0))
    inspection = lives(np.full(4, 100.0), np.full(4, 200.0))
    whole = lives(np.full(4, 100.0), np.full(4, np.inf))
    assert all(isinstance(fit(found, family), str) for found in (same, inspection, whole))  # type: ignore[arg-type]


def test_product_limit_by_hand() -> None:
    """Deaths at 1 and 3 of 4 with one withdrawn at 2: 3/4, then 3/4 x 1/2."""
    found = survival(lives(np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.0, np.inf, 3.0, np.inf])))
    assert not isinstance(found, str)
    assert dict(zip(found.cycles, found.survival, strict=True))[1.0] == pytest.approx(0.75)
    assert dict(zip(found.cycles, found.survival, strict=True))[3.0] == pytest.approx(0.375)


def test_between_common_inspections_the_curve_is_the_share_seen_whole() -> None:
    found = survival(turbine())
    assert not isinstance(found, str)
    assert found.cycles == pytest.approx(INSPECTED[1:])
    assert found.survival == pytest.approx(1.0 - np.cumsum(CRACKED)[:-1] / 167.0, abs=1e-4)


def test_without_the_extra_the_fits_are_there_and_the_curve_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "lifelines", None)
    found = et.life(write(tmp_path, "1,5,8\n2,6,9\n3,9,\n"), None)
    assert found.data["areas"][0]["b10"]["value"] > 0.0
    assert "etextile[life]" in found.data["areas"][0]["curve"]
    assert any("etextile[life]" in note for note in found.data["notes"])


def test_an_event_is_confirmed_by_readings_in_a_row() -> None:
    rule = EventRule(limit_ratio=2.0, confirm=2)
    cycle = np.arange(7.0) * 1000.0
    spike = np.array([5.0, 5.1, 11.0, 5.3, 12.0, np.inf, 13.0])
    assert rule.life(cycle, spike) == (3000.0, 4000.0, False)
    assert rule.life(cycle[:5], spike[:5]) == (3000.0, np.inf, True)
    assert EventRule(limit_ohm=10.5, confirm=1).life(cycle, spike) == (1000.0, 2000.0, False)


def write(folder: Path, rows: str, header: str = "specimen,cycles_low,cycles_high") -> Path:
    path = folder / "life.csv"
    path.write_text(f"{header}\n{rows}", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("1,a,12000,1e4,failed,", "life.csv:2: cycles_high: below cycles_low (got 10000 < 12000)"),
        ("1,a,x,3,,", "life.csv:2: cycles_low: no number of cycles (got 'x'), write one of 0 or more"),
        ("1,a,1_000,,,", "life.csv:2: cycles_low: no number of cycles (got '1_000')"),
        ("1,a,-5,,,", "life.csv:2: cycles_low: no number of cycles (got '-5')"),
        ("1,a,5,,failed,", "life.csv:2: cycles_high: empty although the specimen failed"),
        ("1,a,5,8,censored,", "life.csv:2: event: 'censored' although it failed between 5 and 8 cycles"),
        ("1,a,5,8,maybe,", "life.csv:2: event: unknown event (got 'maybe'), write failed or censored"),
        ("1,a,5,8,,\n1,a,6,8,,", "life.csv:3: specimen: specimen '1' of area 'a' stands in line 2 already"),
        ("1,a,0,0,,", "life.csv:2: cycles_high: failed before the first cycle"),
    ],
)
def test_what_is_wrong_is_named_with_line_column_value_and_remedy(tmp_path: Path, rows: str, said: str) -> None:
    with pytest.raises(et.BadInput) as caught:
        read_lives(write(tmp_path, f"{rows}\n", "specimen,area,cycles_low,cycles_high,event,mode"))
    assert said in str(caught.value)


def test_a_file_with_semicolons_and_decimal_commas_is_read(tmp_path: Path) -> None:
    path = write(tmp_path, "a;5,5;8\nb;6;\nc;7;7\n", "specimen;cycles_low;cycles_high")
    found = read_lives(path)
    assert found.low.tolist() == [5.5, 6.0, 7.0]
    assert found.high.tolist() == [8.0, np.inf, 7.0]


def test_an_exact_life_needs_one_number_and_an_early_one_its_upper_end(tmp_path: Path) -> None:
    path = write(tmp_path, "a,500,,exact\nb,,300,left\nc,900,,right\n", "specimen,cycles_low,cycles_high,event")
    found = read_lives(path)
    assert found.low.tolist() == [500.0, 0.0, 900.0]
    assert found.high.tolist() == [500.0, 300.0, np.inf]


def test_rows_of_words_at_both_ends_are_data(tmp_path: Path) -> None:
    path = write(tmp_path, "left,5000,\nmiddle,6000,7000\nright,9000,\n")
    assert read_lives(path).specimen == ("left", "middle", "right")


def test_one_mode_is_judged_with_the_others_as_lives_that_go_on(tmp_path: Path) -> None:
    path = write(tmp_path, "1,5,8,open\n2,6,9,clamp\n3,9,,\n", "specimen,cycles_low,cycles_high,mode")
    found = read_lives(path).by_mode("open")
    assert found.high.tolist() == [8.0, np.inf, np.inf]
    with pytest.raises(et.BadInput, match="no failure of mode 'tear', there are clamp, open"):
        et.life(path, None, mode="tear")


def test_without_failures_the_binomial_bound_is_given(tmp_path: Path) -> None:
    found = et.life(write(tmp_path, "1,5000,\n2,5000,\n3,6000,\n"), None).data["areas"][0]
    assert found["without_failures"]["p_below_high"] == pytest.approx(1.0 - 0.05 ** (1 / 3))
    assert found["without_failures"]["cycles"] == 5000.0


@pytest.mark.slow
def test_the_verb_writes_json_and_picture_and_says_what_is_not_agreed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "1,a,12000,15000\n2,a,8000,10000\n3,a,15000,18000\n4,a,30000,\n1,b,9000,9000\n2,b,30000,\n3,b,20000,22000\n"
    path = write(tmp_path, rows, "specimen,area,cycles_low,cycles_high")
    terms = tmp_path / "agreed.yaml"
    terms.write_text("conditioning: 20 C, 65 % RH\nrequired_cycles: 5000\n", encoding="utf-8")
    folder = tmp_path / "out"
    assert main(["life", str(path), "-o", str(folder), "--agreed", str(terms)]) == 0
    text = capsys.readouterr().out
    data = json.loads((folder / "life.json").read_text(encoding="utf-8"))
    assert data["required_cycles"] == 5000.0
    assert data["critical_area"] == min(data["areas"], key=lambda row: row["b10"]["value"])["area"]
    assert (folder / "life.png").read_bytes().startswith(b"\x89PNG")
    assert "20 C, 65 % RH" in text
    assert "not given" in text
    assert max(map(len, text.splitlines())) <= 80
    assert main(["life", str(path), "-o", str(folder)]) == 2
    assert "--force" in capsys.readouterr().err
