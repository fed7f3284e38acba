"""What sizing found, in sentences: the same on the terminal and on the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from wires.wording import probability


def sentences(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield what was found in words; first what withholds it."""
    if data["verdict"]["withheld"]:
        yield data["verdict"]["sentence"]
    per = {"garment": "of the garment", "net": "of the worst net", "loop": "of the worst loop or woven piece"}[
        data["per"]
    ]
    per = "of the worst wire" if data.get("whole_wires") else per
    everywhere = data["slack_for_all"]
    yield f"As it is, the probability {per} is {probability(data['probability_now'])}."
    if data["crimp"] > data["crimp_now"]:
        ends = dict.fromkeys(f"{100 * data[key]:.1f}" for key in ("crimp_now", "crimp_now_most") if key in data)
        now = " to ".join(ends)
        yield (
            f"Slack alone does not do: the wire in the weave breaks too, it needs a crimp of "
            f"{100 * data['crimp']:.1f} % (now {now} %)."
        )
    if everywhere is None:
        yield "No slack up to 50 % is enough for all loops."
        return
    with_crimp = " with that crimp" if data["crimp"] > data["crimp_now"] else ""
    yield f"A slack of {100 * everywhere:.1f} % in every loop{with_crimp} is enough."
    found = data["verified"]
    if found is None:
        return
    garment = found["garment"]
    loops_alone = found["largest_woven_probability"] is None
    judged = (
        "loops alone judged, the criterion knows no wire in the weave" if loops_alone else "every piece of wire judged"
    )
    yield (
        f"Run again with that, {judged}: the probability {per} is {probability(found['probability'])} "
        f"({probability(found['low'])} to {probability(found['high'])} for what is not known of the coupons), "
        f"{_against(found)}."
    )
    if garment is None:
        return
    yield (
        f"Some filament of the garment breaks with {probability(garment['value'])} ({probability(garment['low'])} to "
        f"{probability(garment['high'])} for what is not known of the coupons)."
    )


def _against(found: Mapping[str, Any]) -> str:
    """Say how a verified probability and its interval stand to the target."""
    if found["surely_met"]:
        return "within the target by the whole interval"
    return "within the target by its value and NOT by the whole interval" if found["met"] else "ABOVE the target"
