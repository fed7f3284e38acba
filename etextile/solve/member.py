"""A contribution within an iterate: what the step needs of it, whether its elements bear in one sense only or not.

The step treats all members alike. A plain one hands on its own gradient and tangent; a `Paired` one bears forces of
its pairs of stretch and slack (`barrier`) instead, once `Linearised` towards a target.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from etextile.mechanics.onesided import OneSided
from etextile.mechanics.protocol import Contribution, Response
from etextile.solve.barrier import LinearSet, Pair, Target
from etextile.solve.system import States, System, Trial
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Step:
    """A step (P, 3) mm; `length` is the share of it that is taken."""

    nodes: Array
    length: float


@dataclass(frozen=True)
class Member:
    """A contribution, the state it starts from and its response at the trial; `places` of its tangent's values."""

    part: Contribution
    state: Any
    response: Response
    places: IntArray

    @property
    def pair(self) -> Pair | None:
        """The pairs of one-sided elements, if it has any."""
        return None

    @property
    def side(self) -> OneSided | None:
        """The one-sided elements at the trial."""
        return self.part.one_sided(self.response, self.state)

    def centred(self, mu: float) -> Member:
        """Return it with pairs about F s = mu (N mm), where its elements are one-sided."""
        side = self.side
        return self if side is None else Paired.of(self, Pair.centred(side, mu))

    def tightened(self) -> Any:
        """Return the stricter state that its contribution asks for at this trial, else its own."""
        return self.part.tightened(self.response, self.state)

    def again(self, new: Member) -> Member:
        """Return the member at the same positions from a stricter state."""
        return new

    def linearised(self, *, exact: bool) -> Member:
        """Return it linearised, aiming at zero."""
        return self

    def add_tangent(self, rows: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent to the values of the pattern."""
        self.response.add_tangent(rows, self.places, values, exact=exact, damping=damping)

    def add_gradient(self, gradient: Array) -> None:
        """Add the gradient to `gradient` (P, 3)."""
        self.response.add_gradient(gradient)

    def add_skew(self, step: Array, load: Array) -> bool:
        """Add what the tangent leaves out, times `step` (P, 3), to `load`; return whether there is any."""
        return False

    def aimed(self, guess: Step, tolerance: float) -> Member:
        """Return it aiming where the predictor `guess` says that it gets to."""
        return self

    def moved(self, new: Member, step: Step) -> Member:
        """Return the member `new` of the next trial with what this one carries over."""
        return new

    def cut(self, new: Member, chosen: IntArray) -> Member:
        """Return the member `new` of a subdomain with what `chosen` elements of this one carry over."""
        return new

    def put_back(self, new: Member, own: Member | None, chosen: IntArray) -> Member:
        """Return the member `new` of the whole with the elements `chosen` as they are in the subdomain's `own`."""
        return new


@dataclass(frozen=True)
class Paired(Member):
    """A member whose one-sided elements carry force and slack as pairs."""

    pairs: Pair

    @classmethod
    def of(cls, member: Member, pairs: Pair) -> Paired:
        """Return a member with pairs."""
        return cls(member.part, member.state, member.response, member.places, pairs)

    @property
    def pair(self) -> Pair:
        """The pairs of one-sided elements."""
        return self.pairs

    def again(self, new: Member) -> Member:
        """Return the member from a stricter state, its pairs centred again where the state is another."""
        side = None if new.state is self.state else new.side
        return Paired.of(new, self.pairs if side is None else Pair.centred(side, self.pairs.product))

    def linearised(self, *, exact: bool) -> Linearised:
        """Return it linearised, aiming at zero."""
        line = LinearSet.of(self.pairs, exact=exact)
        return Linearised(
            self.part, self.state, self.response, self.places, self.pairs, line, Target.zero(len(line.force))
        )

    def cut(self, new: Member, chosen: IntArray) -> Member:
        """Return the member of a subdomain with the pairs of the elements `chosen`."""
        side = new.side
        if side is None:
            return new
        own = (self.pairs.stretch[chosen], self.pairs.slack[chosen])
        return Paired.of(new, Pair(side, *own, *side.bear(own[0])))

    def put_back(self, new: Member, own: Member | None, chosen: IntArray) -> Member:
        """Return the member of the whole with the pairs of the subdomain in place of its own.

        What the subdomain does not touch is borne anew: sets that hang together keep what their law gave last.
        """
        side, found, mine = new.side, None if own is None else own.pair, self.pairs
        if side is None:
            return new
        if found is None:
            return Paired.of(new, Pair(side, mine.stretch, mine.slack, *side.bear(mine.stretch)))
        values = [value.copy() for value in (mine.stretch, mine.slack, mine.force, mine.slope)]
        for value, other in zip(values, (found.stretch, found.slack, found.force, found.slope), strict=True):
            value[chosen] = other
        return Paired.of(new, Pair(side, *values))


@dataclass(frozen=True)
class Linearised(Paired):
    """A paired member linearised at its trial, with what its pairs aim at."""

    line: LinearSet
    target: Target

    def add_tangent(self, rows: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent of geometry and pairs."""
        line, side = self.line, self.pairs.side
        side.add_tangent(line.force, line.along, rows, self.places, values, exact=exact, damping=damping)

    def add_gradient(self, gradient: Array) -> None:
        """Add the gradient with the forces that lead to the target."""
        self.pairs.side.add_gradient(self.line.borne(self.target), gradient)

    def add_skew(self, step: Array, load: Array) -> bool:
        """Add friction that follows the normal force."""
        return self.pairs.side.add_skew(self.line.along, step, load)

    def change(self, step: Step) -> tuple[Array, Array]:
        """Return the changes of stretches and slacks (n,) along the whole step."""
        return self.line.change(self.pairs.side.rate(step.nodes), self.target)

    def aimed(self, guess: Step, tolerance: float) -> Linearised:
        """Return it aiming at products that fall as fast as the predictor allows, with the turn along it."""
        side = self.pairs.side
        floor = (0.1 * tolerance) ** 2 / float(side.stiffness.sum())
        rate = side.rate(guess.nodes)
        aim = self.line.aim(self.line.change(rate, self.target), guess.length, floor)
        return replace(self, target=Target(aim, side.bulge(guess.length * guess.nodes, guess.length * rate)))

    def moved(self, new: Member, step: Step) -> Member:
        """Return the member of the next trial, every element on its own within its bounds."""
        side = new.side
        if side is None:
            return new
        side.follow(self.pairs.side, step.length * step.nodes)
        return Paired.of(new, self.pairs.moved(side, self.change(step), step.length))


def members_of(system: System, trial: Trial, states: States) -> tuple[Member, ...]:
    """Return the contributions of a system at a trial, without pairs."""
    rows = zip(system.model.contributions, states, trial.responses, system.pattern.pairs, strict=True)
    return tuple(Member(*row) for row in rows)
