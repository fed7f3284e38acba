"""The load path: a generator of converged increments from flat and slack to the end of the motion.

The output displacements are met exactly. An increment that finds no equilibrium is cut in half, again and again up to
the allowed number. So is one that changes more for good than its length allows (`haste`: while a yarn snaps its
neighbours unload, and what they bore until then would be lost), down to a `FINEST` of the motion or to where only the
longer one finds equilibrium. Afterwards increments grow back. A path that cannot go on raises `NoEquilibrium` with what
is known; everything yielded before is converged. The state of an increment is all that a restart needs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Energy as StoredEnergy
from etextile.solve.newton import NewtonOutcome, Settings
from etextile.solve.nonlinear import NONLINEAR_SOLVERS
from etextile.solve.reasons import no_equilibrium
from etextile.solve.system import States, System, Trial
from etextile.types import Array


AFTER_REVERSAL = 0.125
"""First step after the motion turns round, as a share of the way: elastic unloading is steep."""

FINEST = 512
"""An increment is not made shorter than this part of the motion for what it changes for good."""


@dataclass(frozen=True)
class IncrementVerdict:
    """What the solver says of an increment: converged or why not, the work done, and the numbers in N."""

    converged: bool
    reason: str
    iterations: int
    linear_solves: int
    cut_backs: int
    residual_N: float
    tolerance_N: float
    worst_node: int
    sentence: str


@dataclass(frozen=True)
class EnergyBalance:
    """Energies in N mm of the modelled part: external work, stored, plastic, friction, and the contact penalty's.

    `work_doubt` is how far the quadrature of the external work over the increments may be off.
    """

    external: float
    stored: float
    plastic: float
    friction: float
    contact: float
    work_doubt: float = 0.0

    @property
    def gap(self) -> float:
        """External work not found again, N mm."""
        return self.external - (self.stored + self.plastic + self.friction + self.contact)

    @property
    def error(self) -> float:
        """External work not found again, as a share of the external work."""
        return abs(self.gap / self.external) if self.external != 0.0 else 0.0


@dataclass(frozen=True)
class Snapshot:
    """All a path needs to go on: last two positions (P, 3) and travels, states, force, work, step size."""

    x: Array
    travel: float
    x_before: Array
    travel_before: float
    states: States
    force: float = 0.0
    work: float = 0.0
    step: float = np.inf
    force_before: float = 0.0
    force_onward: float = 0.0
    work_doubt: float = 0.0


@dataclass(frozen=True)
class Increment:
    """A converged increment; arrays run over all points (lattice, then wires) and all trusses (lattice, then wires)."""

    index: int
    displacement_mm: float
    positions: Array
    truss_strain: Array
    truss_stress: Array
    truss_plastic_strain: Array
    truss_force: Array
    contact_force: Array
    punch_force_N: float
    clamp_force_N: float
    max_penetration_mm: float
    softening: int
    energy: EnergyBalance
    state: Snapshot
    verdict: IncrementVerdict
    output: bool


def start(model: Model) -> Snapshot:
    """Return the snapshot of the flat, slack, untouched piece, as if a pulled clamp had stretched it evenly before.

    So the first prediction does not put the whole pull into one row of cells, where cells turn over and stay so. A
    piece mounted taut brings along the energy it was mounted with.
    """
    states = tuple(part.initial_state() for part in model.contributions)
    before = model.points - _even_stretch(model)
    began = model.begins
    return Snapshot(model.points, began, before, began - 1.0, states, work=_energy_of_mounting(model))


def _energy_of_mounting(model: Model) -> float:
    """Return the energy (N mm) stored in and lost to trusses whose rest length is below their span when flat."""
    taut = [block for block in model.trusses if np.any(block.rest_length < block.span)]
    found = [block.respond(model.points, 0.0, block.initial_state()).energy() for block in taut]
    return float(sum(energy.stored + energy.plastic for energy in found))


def _even_stretch(model: Model) -> Array:
    """Return the displacement (P, 3) per mm of travel of a piece evenly stretched by its pulled clamp, else zeros."""
    stretch = np.zeros_like(model.points)
    if np.any(model.carried):
        nodes = len(model.lattice.points)
        along = model.lattice.points @ model.direction
        stretch[:nodes] = ((along - along.min()) / np.ptp(along))[:, None] * model.direction
    return stretch


def advance(
    model: Model,
    settings: Settings | None = None,
    *,
    snapshot: Snapshot | None = None,
    first_index: int = 0,
    system: System | None = None,
) -> Iterator[Increment]:
    """Yield converged increments along `model.travel`; raises NoEquilibrium when the path cannot go on.

    `snapshot` goes on from an earlier increment (`first_index` counts its outputs as done). Whoever wants to know where
    the time goes makes the `system` of this model, and reads its counters.
    """
    settings = settings or Settings()
    system = system or System(model, linear=settings.linear)
    now = snapshot or start(model)
    index = first_index
    finest = float(np.ptp(np.append(model.travel, model.begins))) / FINEST
    for target in model.travel[first_index:]:
        solves, hasty = system.counters.linear_solves, None
        least = ShortestSteps(min(abs(target - now.travel), model.longest_step) / 2**settings.max_cut_backs, finest)
        if (target - now.travel) * (now.travel - now.travel_before) < 0.0:
            now = replace(now, step=min(now.step, AFTER_REVERSAL * abs(target - now.travel)))
        while now.travel != target:
            taken = _take(system, now, hasty, target, settings, least)
            now, hasty = taken.now, taken.hasty
            verdict = _verdict(taken.outcome, system.counters.linear_solves - solves, taken.cut_backs)
            yield _increment(model, index, now, taken.outcome.trial, verdict, output=now.travel == target)
            solves = system.counters.linear_solves
        index += 1


@dataclass(frozen=True)
class Taken:
    """An increment that was taken, the snapshot after it, and what lies ahead of it that was refused for its haste."""

    now: Snapshot
    outcome: NewtonOutcome
    cut_backs: int
    hasty: Trial | None


@dataclass(frozen=True)
class ShortestSteps:
    """Steps (mm): none shorter than `cut_back` is tried for want of equilibrium, than `hasty` for its haste."""

    cut_back: float
    hasty: float


def _take(
    system: System, now: Snapshot, hasty: Trial | None, target: float, settings: Settings, least: ShortestSteps
) -> Taken:
    """Return the next increment towards `target`, cut in half as often as it has to be; raises NoEquilibrium."""
    model, cut_backs = system.model, 0
    while True:
        left = target - now.travel
        step = next_step(left, now.step, model.longest_step)
        outcome = _attempt(system, now, now.travel + step if step != left else target, settings)
        haste = _haste(model, now, outcome)
        if not outcome.converged and hasty is not None:
            step, haste = hasty.travel - now.travel, 1.0
            outcome, hasty = _attempt(system, now, hasty.travel, settings, begun=hasty.x), None
        if outcome.converged and (haste <= 1.0 or abs(step) < 2.0 * least.hasty):
            after = _move(model, now, outcome.trial, grown=_grown(now, abs(step), haste))
            return Taken(after, outcome, cut_backs, hasty)
        if outcome.converged:
            hasty = outcome.trial
        elif abs(step) / 2 < 0.99 * least.cut_back:
            raise NoEquilibrium(no_equilibrium(model, outcome, last=now.travel, cut_backs=cut_backs))
        else:
            cut_backs += 1
        now = replace(now, step=abs(step) / 2)


def _grown(before: Snapshot, step: float, haste: float) -> float:
    """Return how long the next step may be after one of `step` (mm): twice as long, but no hastier than allowed."""
    twice = 2.0 * step if np.isfinite(before.step) else np.inf
    return min(twice, step / min(haste, 1.0)) if haste else twice


def _haste(model: Model, now: Snapshot, outcome: NewtonOutcome) -> float:
    """Return what the parts of a model say of the haste of an increment."""
    parts = zip(model.contributions, outcome.trial.responses, now.states, strict=True)
    return max(part.haste(response, state) for part, response, state in parts)


def next_step(left: float, wanted: float, longest: float) -> float:
    """Return the next step towards a target `left` mm away: about as wanted, never longer than `longest`."""
    distance = abs(left)
    step = distance if distance <= 1.5 * wanted else min(wanted, distance / 2)
    parts = np.ceil(distance / longest - 1e-9)
    return float(left if step == distance and parts <= 1 else np.sign(left) * min(step, distance / max(parts, 1.0)))


def _attempt(
    system: System, now: Snapshot, travel: float, settings: Settings, *, begun: Array | None = None
) -> NewtonOutcome:
    """Return the outcome at `travel`, tightening contributions whose own limits (penetration) the answer passes.

    `begun`: positions (P, 3) to start from, else those predicted.
    """
    solve = NONLINEAR_SOLVERS[settings.nonlinear]
    states = now.states
    x = predict(system, now, travel) if begun is None else begun
    outcome = solve(system, x, travel, states, settings)
    if outcome.converged:
        outcome, states = _with_first_touch(system, now, outcome, states, settings)
    for _ in range(6):
        stricter = tuple(
            part.tightened(response, state)
            for part, response, state in zip(system.model.contributions, outcome.trial.responses, states, strict=True)
        )
        if not outcome.converged or all(a is b for a, b in zip(stricter, states, strict=True)):
            break
        states = stricter
        again = solve(system, outcome.trial.x, travel, states, settings)
        outcome = replace(again, iterations=outcome.iterations + again.iterations)
    return outcome


def _with_first_touch(
    system: System, now: Snapshot, outcome: NewtonOutcome, states: States, settings: Settings
) -> tuple[NewtonOutcome, States]:
    """Return outcome and states of the increment solved again where friction acts on what it brought to touch.

    Without equilibrium, or where nothing much was brought to touch, the increment stays as it is.
    """
    trial = outcome.trial
    touched = tuple(
        part.touched(response, state, now.x, now.travel)
        for part, response, state in zip(system.model.contributions, trial.responses, states, strict=True)
    )
    if all(a is b for a, b in zip(touched, states, strict=True)):
        return outcome, states
    again = NONLINEAR_SOLVERS[settings.nonlinear](system, trial.x, trial.travel, touched, settings)
    if not again.converged:
        return outcome, states
    return replace(again, iterations=outcome.iterations + again.iterations), touched


def predict(system: System, now: Snapshot, travel: float) -> Array:
    """Return start positions (P, 3): the last motion continued, prescribed components and contact carried along."""
    model = system.model
    x = now.x
    behind = now.travel - now.travel_before
    if behind * (travel - now.travel) > 0.0:
        x = x + (travel - now.travel) / behind * (now.x - now.x_before)
    held = model.prescribed(travel)
    x = np.where(model.fixed, held, x)
    for part in model.contributions:
        x = part.carried_along(x, travel, now.x, now.travel)
    return np.where(model.fixed, held, x)


def _move(model: Model, before: Snapshot, trial: Trial, *, grown: float) -> Snapshot:
    """Return the snapshot after a converged trial."""
    force = generalised_force(model, trial)
    power = min(part.onset_power for part in model.contributions)
    work, doubt = work_done(before, trial.travel, force, power=power)
    return Snapshot(
        x=trial.x,
        travel=trial.travel,
        x_before=before.x,
        travel_before=before.travel,
        states=trial.states,
        force=force,
        work=before.work + work,
        step=grown,
        force_before=before.force_onward,
        force_onward=generalised_force(model, trial, onward=True),
        work_doubt=before.work_doubt + doubt,
    )


def work_done(before: Snapshot, travel: float, force: float, *, power: float = 2.0) -> tuple[float, float]:
    """Return the external work (N mm) from the last state to `force` (N) at `travel` (mm), and how doubtful it is.

    Exact for a force that runs on a parabola through the last three points; trapezoidal after a reversal and where the
    body touches or leaves. Flat fabric has no force and no stiffness: there the force rises with `power` of the travel.
    The doubt is the difference of the two rules.
    """
    step, last = travel - before.travel, before.travel - before.travel_before
    trapezoid = 0.5 * (before.force_onward + force) * step
    if before.force_onward != before.force:
        return trapezoid, abs((force - before.force_onward) * step / 6.0)
    if before.travel == before.force == before.force_before == 0.0:
        own = force * step / (power + 1.0)
        return own, abs(trapezoid - own)
    if last * step < 0.0 or force == 0.0 or before.force == 0.0:
        return trapezoid, abs((force - before.force) * step / 6.0)
    bend = ((force - before.force) / step - (before.force - before.force_before) / last) / (step + last)
    return trapezoid - bend * step**3 / 6.0, abs(bend * step**3 / 6.0)


def generalised_force(model: Model, trial: Trial, *, onward: bool = False) -> float:
    """Return the force that works on the travel, N: on moved clamps and on the body.

    `onward`: of the motion that begins at this travel, where another ends.
    """
    rate = model.prescribed_rate(trial.travel, onward=onward)
    force = float(np.vdot(trial.gradient[model.fixed], rate[model.fixed]))
    own = (response.force_onward if onward else response.driving_force for response in trial.responses)
    return force + sum(own)


def _increment(
    model: Model, index: int, now: Snapshot, trial: Trial, verdict: IncrementVerdict, *, output: bool
) -> Increment:
    blocks = [fields for fields in (response.fields for response in trial.responses) if fields is not None]
    found = trial.energy()
    contact = np.zeros_like(trial.x)
    for response in trial.responses:
        response.add_contact_force(contact)
    led = model.prescribed_rate(trial.travel) != 0.0
    held = np.where(led, 0.0, np.where(model.fixed, trial.gradient, 0.0))
    for response in trial.responses:
        response.add_support_force(held)
    return Increment(
        index=index,
        displacement_mm=float(now.travel),
        positions=model.all_points(trial.x),
        truss_strain=np.concatenate([block.strain for block in blocks]),
        truss_stress=np.concatenate([block.stress for block in blocks]),
        truss_plastic_strain=np.concatenate([block.plastic for block in blocks]),
        truss_force=np.concatenate([block.force for block in blocks]),
        contact_force=model.on_all_points(contact),
        punch_force_N=_reported_force(now, trial) * model.force_factor,
        clamp_force_N=-float((held @ model.direction).sum()) * model.force_factor,
        max_penetration_mm=max(response.penetration for response in trial.responses),
        softening=sum(response.softening for response in trial.responses),
        energy=_energy(now, found),
        state=now,
        verdict=verdict,
        output=output,
    )


def _reported_force(now: Snapshot, trial: Trial) -> float:
    """Return the force on the travel, or the resultant of the loads where these are what rises."""
    loads = [response.load for response in trial.responses if response.load is not None]
    return sum(loads) if loads else now.force


def _energy(now: Snapshot, found: StoredEnergy) -> EnergyBalance:
    return EnergyBalance(now.work, found.stored, found.plastic, found.friction, found.contact, now.work_doubt)


def _verdict(outcome: NewtonOutcome, solves: int, cut_backs: int) -> IncrementVerdict:
    worst = int(np.argmax(np.abs(outcome.trial.residual).max(axis=1)))
    sentence = f"converged in {outcome.iterations} iterations, residual {outcome.residual:.2g} N"
    if cut_backs:
        sentence += f", after {cut_backs} cut-backs"
    return IncrementVerdict(
        True, "converged", outcome.iterations, solves, cut_backs, outcome.residual, outcome.tolerance, worst, sentence
    )
