"""Usual ranges are priors, not walls: a leader that stands at the end of one has it opened, once.

A card's range says what is likely beforehand; `Parameter.limits` says what can be at all. A punch of 11 mm where the
case has 15 is unlikely and possible: the parameter would sit at its usual end and the gap stay unexplained. So the
range of a leading hypothesis is continued beyond the end it leans on, its table gets nodes there, and everything is
judged again. The uniform prior over the longer range costs what it should. What then still leans on an end is
disqualified.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.diagnose.decide.finalists import ends
from etextile.diagnose.decide.verdict import Finalist
from etextile.diagnose.infer.finer_table import depends, on_finer_lattice
from etextile.diagnose.infer.full_table import tables_on
from etextile.diagnose.infer.lattice_doubt import undetermined
from etextile.diagnose.predict.run_tables import Candidate
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.predict.table import EffectTable, ParameterAxis, ParameterGrid
from etextile.diagnose.setting import Prepared
from etextile.effects.base import Parameter
from etextile.errors import BadInput


REACH, FACTOR = 3.0, 10.0
"""How far a range is opened: times its distance from the neutral value, or times its end on a logarithmic scale."""
BETWEEN = (0.25, 0.6, 1.0)
"""Shares of the new stretch at which the effect is simulated."""


@dataclass(frozen=True)
class Opened:
    """A range that was opened: effect, the parameter as it was and as it is searched now."""

    effect: str
    usual: Parameter
    now: Parameter

    @property
    def words(self) -> str:
        """What was done, for people."""
        unit = f" {self.usual.unit}" if self.usual.unit else ""
        return (
            f"{self.effect}: the leading explanation stood at the end of the usual range of {self.usual.name} "
            f"({self.usual.low:g} to {self.usual.high:g}{unit}), which was opened once, to {self.now.low:g} to "
            f"{self.now.high:g}{unit}"
        )


def to_open(finalists: Sequence[Finalist], tables: Mapping[str, EffectTable]) -> tuple[Opened, ...]:
    """Return the ranges of the likeliest hypothesis that go on beyond the end it stands at."""
    leader = max(finalists, key=lambda item: item.alone, default=None)
    if leader is None or not leader.at_bound:
        return ()
    found = []
    for table, axis, end in ends(leader.contender, tables):
        wider = beyond(axis.parameter, end)
        if wider is not None:
            found.append(Opened(table.id, axis.parameter, wider))
    return tuple(found)


def beyond(item: Parameter, end: float) -> Parameter | None:
    """Return a parameter whose range goes on beyond `end`, a value; None where its physical limit is.

    Three times as far from the neutral value, ten times as far on a logarithmic scale, and no farther than its limits.
    """
    least, most = item.limits if item.limits is not None else (item.low, item.high)
    zero = item.neutral if item.neutral is not None else item.default or 0.0
    upper = abs(end - item.high) <= abs(end - item.low)
    value = item.high if upper else item.low
    if item.scale == "log":
        far = value * FACTOR if upper else value / FACTOR
    else:
        far = zero + REACH * (value - zero)
        far = (
            far
            if (far > value) == upper and far != value
            else value + (1.0 if upper else -1.0) * (item.high - item.low)
        )
    far = min(far, most) if upper else max(far, least)
    if far == value or (far > value) != upper:
        return None
    return replace(item, high=far) if upper else replace(item, low=far)


def widened_axis(axis: ParameterAxis, wider: Parameter) -> ParameterAxis:
    """Return an axis with the longer range of `wider` and nodes on what was added; nodes of before stay."""
    old, new = axis.bounds, replace(axis, parameter=wider)
    low, high = new.bounds
    added = [old[1] + share * (high - old[1]) for share in BETWEEN if high > old[1]]
    added += [old[0] + share * (low - old[0]) for share in BETWEEN if low < old[0]]
    nodes = np.array(sorted({*axis.nodes.tolist(), *added}))
    neutral = None if axis.neutral is None else int(np.searchsorted(nodes, axis.nodes[axis.neutral]))
    return replace(axis, parameter=wider, nodes=nodes, neutral=neutral)


def widened_grid(grid: ParameterGrid, wider: Sequence[Parameter]) -> ParameterGrid:
    """Return a grid whose axes of these parameters go on to their new ends."""
    named = {item.name: item for item in wider}
    card = replace(grid.card, parameters=tuple(named.get(item.name, item) for item in grid.card.parameters))
    axes = [widened_axis(a, named[a.parameter.name]) if a.parameter.name in named else a for a in grid.axes]
    return ParameterGrid(card, tuple(axes))


def reopened(
    ready: Prepared, wider: Sequence[Opened], candidates: Sequence[Candidate], runner: Runner
) -> Prepared | None:
    """Return the prepared tables with those of opened effects over their longer ranges.

    None where the effect cannot be built there (a punch of no radius).
    """
    tables, known = dict(ready.tables), {item.card.id: item for item in candidates}
    plans = dict(ready.plans)
    for name in dict.fromkeys(item.effect for item in wider):
        plans[name] = widened_grid(plans[name], [item.now for item in wider if item.effect == name])
        try:
            table = tables_on(ready, {name: plans[name]}, candidates, runner)[name]
        except BadInput:
            return None
        table = replace(table, doubt=tables[name].doubt, loose=undetermined(ready.bench.points, plans[name].card))
        tables[name] = on_finer_lattice(ready, known[name], table, runner) if depends(table) else table
    return replace(ready, tables=tables, plans=plans)
