"""Hidden mechanisms for the independent solver, in other functional forms than the product's library.

`form` "other" writes each law differently (smooth where the library is sharp, saturating where it is linear, varying
where it is constant) and moves the mount of a clamp in one piece; "same" follows the library's own formula where that
differs; "piece" is "same" but for the mount.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from solver import DIAGONAL, MID, PATTERNS, WARP, WEFT, Ball, General, Lattice, Law, Part, Result, Trusses, march


@dataclass
class Truth:
    """What is hidden: effects with parameters (library names and units), the fabric's laws, the lattice, the form.

    And the test: punch radius, speed, how far it goes and, if at all, how far back.
    """

    effects: dict = field(default_factory=dict)
    cause: str = ""
    laws: tuple = MID
    cells: tuple = (20, 35)
    form: str = "other"
    total: float = 40.0
    steps: int = 24
    radius: float = 15.0
    speed: float = 1.0
    back: float | None = None


def simulate(truth):
    """Return the clean result of a truth: recorded displacement, force and positions."""
    PATTERNS.clear()
    lattice = Lattice.quarter(*truth.cells)
    own = truth.effects
    laws = tuple(_law(number, k, truth) for k, number in enumerate(truth.laws))
    fixed = np.zeros_like(lattice.points, dtype=bool)
    fixed[lattice.line("clamp")] = True
    fixed[lattice.line("x0"), 0] = True
    fixed[lattice.line("y0"), 1] = True
    trusses = Trusses(lattice, laws, carry=_carry(own, truth.form))
    if "clamp_slip" in own:
        trusses = FedTrusses(trusses, lattice, slipping(**own["clamp_slip"], form=truth.form))
    ball = Ball(
        lattice,
        radius=truth.radius + own.get("geometry", {}).get("radius", 0.0),
        friction=own.get("punch_friction", {}).get("mu", 0.0),
    )
    parts = [trusses, ball]
    points = lattice.points
    if "clamp_slip" in own:
        points = np.concatenate([points, np.zeros((len(trusses.jaw), 3))])
        fixed = np.concatenate([fixed, np.tile([False, True, True], (len(trusses.jaw), 1))])
    if "pretension" in own:
        ends = lattice.points[lattice.trusses[:, 1]] - lattice.points[lattice.trusses[:, 0]]
        ends[:, 0] /= 1.0 + own["pretension"]["strain"]
        ends[:, 1] /= 1.0 + own["pretension"].get("across", 0.0) * own["pretension"]["strain"]
        trusses.rest = np.linalg.norm(ends, axis=1)
    if "rotational_shear" in own:
        share = own["rotational_shear"]["share"]
        trusses.area[lattice.family == DIAGONAL] *= 1.0 - share
        parts.append(CellSprings(lattice, virtual_diagonals(lattice, laws[DIAGONAL], share, truth.form)))
    if "shear_locking" in own:
        parts.append(CellSprings(lattice, locking(lattice, **own["shear_locking"], form=truth.form)))
    if "bending_stiffness" in own:
        parts += bending(lattice, own["bending_stiffness"]["D"])
    if "clamp_compliance" in own:
        fixed[np.flatnonzero(lattice.line("clamp")), 0] = False
        hold = compliant(**own["clamp_compliance"], form=truth.form)
        if truth.form == "same":
            parts.append(ClampLine(lattice, hold))
        else:
            parts.append(RigidJaw(lattice, hold, number=len(points)))
            points = np.concatenate([points, [[lattice.half[0], 0.0, 0.0]]])
            fixed = np.concatenate([fixed, [[False, True, True]]])
    if "yarn_sliding" in own:
        points, fixed, parts = split_families(lattice, fixed, parts, own["yarn_sliding"], truth.form)
    crimp = None
    if "crimp_interchange" in own:
        crimp = interchange_hook(trusses, lattice, 1.5 * own["crimp_interchange"]["coefficient"])
    _uneven(trusses, lattice, truth.cause)
    hooks = [hook for hook in (_rate_hook(trusses, own, truth), _tear_hook(trusses, lattice, truth.cause)) if hook]

    def before_step(x, states, travel):
        for part in parts:
            if hasattr(part, "prepare"):
                part.prepare(x)
        for hook in hooks:
            hook(travel)
        if crimp is not None:
            crimp(travel, x)

    spare = 3.0 if "datum_offset" in own or "machine_compliance" in own else 0.0
    travels = np.linspace(0.0, truth.total + spare, truth.steps + 1 + (2 if spare else 0))[1:]
    if truth.back is not None:
        step = travels[1] - travels[0]
        ways = max(int(np.ceil(2 * (truth.total - truth.back) / step)), 6)
        travels = np.concatenate([travels, np.linspace(travels[-1], truth.back, ways + 1)[1:]])
    force, positions, worst = march(points, fixed, parts, ball, travels, before_step=before_step)
    recorded = travels + own.get("datum_offset", {}).get("offset", 0.0)
    compliance = own.get("machine_compliance", {}).get("compliance", 0.0)
    if truth.form == "other":
        recorded = recorded + compliance * force * (1.0 + 0.15 * np.tanh(force / 800.0))
    else:
        recorded = recorded + compliance * force
    recorded = recorded + np.where((truth.cause == "crosshead_jump") & (travels > 24.0), 0.6, 0.0)
    seen = positions[:, : len(lattice.points)]
    if truth.cause == "camera_scale":
        seen = lattice.points + 1.05 * (seen - lattice.points)
    return Result(recorded, _instrument(force, recorded, truth.cause), seen, lattice, worst)


def _instrument(force, recorded, cause):
    """Causes that no library holds and that sit in the force record."""
    if cause == "load_cell_drift":
        return force + 0.035 * force.max() * np.sin(0.5 * np.pi * recorded / recorded.max()) ** 2
    if cause == "slip_stick":
        phase = np.mod(recorded - 20.0, 7.0) / 7.0
        return force * np.where(recorded > 20.0, 1.0 - 0.07 * phase, 1.0)
    if cause == "amplifier":
        return force * (1.0 + 0.06 * np.sin(2.0 * np.pi * force / 1500.0))
    return force


def _law(numbers, family, truth):
    """Return the law of a family with what acts on laws: tail, damage, a weft that differs from its coupons."""
    own, form = truth.effects, truth.form
    E, yield0, H, n = numbers
    if truth.cause == "other_weft" and family == WEFT:
        H, E = 0.72 * H, 0.72 * E
    plain = Law(E, yield0, H, n)
    change = damage = None
    if family != DIAGONAL and "yarn_tail" in own:
        factor, start = own["yarn_tail"]["slope_change"], _plastic(plain, own["yarn_tail"]["onset"])
        width = 0.02 if form == "other" else 1e-4

        def change(p, stress):
            rise = np.gradient(stress, p) * (1.0 + factor * 0.5 * (1.0 + np.tanh((p - start) / width)))
            return np.concatenate([[0.0], np.cumsum(0.5 * (rise[1:] + rise[:-1]) * np.diff(p))])

    if family != DIAGONAL and "yarn_damage" in own:
        rate, onset = own["yarn_damage"]["rate"], _plastic(plain, own["yarn_damage"]["onset"])

        def damage(p):
            if form == "same":
                return 1.0 - np.exp(-rate * np.maximum(p - onset, 0.0))
            past = rate * 0.01 * np.logaddexp(0.0, (p - onset) / 0.01)
            return past / (1.0 + past)

    return Law(E, yield0, H, n, change=change, damage=damage)


def _plastic(law, strain):
    return float(np.interp(np.log1p(strain), law.total, law.p))


def _carry(own, form):
    """Compressed trusses follow a share of their mirrored loading curve; the other form saturates."""
    if "compression_carry" not in own:
        return None
    ratio = own["compression_carry"]["ratio"]

    def carry(strain, law):
        p = np.interp(-strain, law.total, law.p)
        s = np.interp(p, law.p, law.undamaged)
        t = law.E * np.interp(p, law.p, law.slope) / (law.E + np.interp(p, law.p, law.slope))
        soft = 1.0 / (1.0 - strain / 0.4) if form == "other" else np.ones_like(strain)
        return np.where(strain < 0, -ratio * s * soft, 0.0), np.where(strain < 0, ratio * t * soft**2, 0.0)

    return carry


def _rate_hook(trusses, own, truth):
    """Scale all laws with the strain rate: of a straight yarn over the punch then, or the mean of the test."""
    if "rate_dependence" not in own:
        return None
    per_decade = own["rate_dependence"]["per_decade"]

    def hook(travel):
        slope = max(travel, 2.0) / 50.0
        rate = slope / np.hypot(1.0, slope) / 50.0 if truth.form == "other" else (np.sqrt(2.0) - 1.0) / 50.0
        rate = rate * truth.speed
        trusses.factor[:] = 1.0 + per_decade * np.log10(rate / 1.67e-3)

    return hook


def _uneven(trusses, lattice, cause):
    """Fabric that is not alike everywhere: a selvedge of stiffer warp yarns, or a band of softer ones."""
    y = lattice.points[lattice.trusses].mean(axis=1)[:, 1]
    warp = trusses.family == WARP
    if cause == "selvedge":
        trusses.area[warp & (y > 44.0)] *= 2.5
    if cause == "soft_band":
        trusses.area[warp & (y < 6.0)] *= 0.65


def _tear_hook(trusses, lattice, cause):
    """Tear a row of weft yarns beside the punch from 18 mm on."""
    if cause != "torn_row":
        return None
    middle = lattice.points[lattice.trusses].mean(axis=1)
    row = (trusses.family == WARP) & (middle[:, 1] > 6.0) & (middle[:, 1] < 11.0)

    def hook(travel):
        trusses.factor[row] = 1.0 - 0.9 * np.clip((travel - 18.0) / 3.0, 0.0, 1.0)

    return hook


class CellSprings:
    """Moments on the shear angle between the mean warp and weft vectors of a cell; `moment` gives (M, dM/dgamma)."""

    along = np.array([-0.5, 0.5, 0.5, -0.5])
    across = np.array([-0.5, -0.5, 0.5, 0.5])

    def __init__(self, lattice, moment):
        self.nodes, self.moment = lattice.cells, moment

    def start(self):
        return None

    def __call__(self, x, travel, state):
        p = x[self.nodes]
        a, b = np.einsum("k,nkc->nc", self.along, p), np.einsum("k,nkc->nc", self.across, p)
        la, lb = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)
        ua, ub = a / la[:, None], b / lb[:, None]
        sine = np.clip(np.einsum("ij,ij->i", ua, ub), -0.999, 0.999)
        gamma = np.arcsin(sine)
        moment, stiffness = self.moment(np.abs(gamma))
        cosine = np.sqrt(1.0 - sine**2)[:, None]
        ga = (ub - sine[:, None] * ua) / (la[:, None] * cosine)
        gb = (ua - sine[:, None] * ub) / (lb[:, None] * cosine)
        slope = self.along[None, :, None] * ga[:, None, :] + self.across[None, :, None] * gb[:, None, :]
        gradient = (np.sign(gamma) * moment)[:, None, None] * slope
        tangent = stiffness[:, None, None, None, None] * slope[:, :, :, None, None] * slope[:, None, None, :, :]
        return General(self.nodes, gradient, tangent), None


def virtual_diagonals(lattice, law, share, form):
    """Moment of a cell whose diagonals follow the angle alone; the other form has no plastic history."""
    hx, hy = lattice.points[:, 0].max() / lattice.nx, lattice.points[:, 1].max() / lattice.ny
    length = np.hypot(hx, hy)
    area = hx * hy * np.hypot(0.2849, 0.1603) * 0.0155 / (0.2849 * 0.1603) / length
    angles = np.linspace(0.0, 1.55, 2000)
    long = np.sqrt(hx**2 + hy**2 + 2 * hx * hy * np.sin(angles))
    p = np.interp(np.log(long / length), law.total, law.p)
    moments = share * area * np.interp(p, law.p, law.undamaged) * np.exp(-p) * hx * hy * np.cos(angles) / long
    if form == "other":
        # a little more at small angles, a little less at large ones: friction at the crossings, then easier turning
        moments = moments * (1.08 - 0.16 * angles)
    slopes = np.maximum(np.gradient(moments, angles), 0.0)
    return lambda gamma: (np.interp(gamma, angles, moments), np.interp(gamma, angles, slopes))


def locking(lattice, *, stiffness, angle, form):
    """Moment beyond the locking angle: linear, or growing smoothly."""
    hx, hy = lattice.points[:, 0].max() / lattice.nx, lattice.points[:, 1].max() / lattice.ny
    k, start = stiffness * hx * hy, np.radians(angle)
    if form == "same":
        return lambda gamma: (k * np.maximum(gamma - start, 0.0), np.where(gamma > start, k, 0.0))
    width = np.radians(1.0)

    def smooth(gamma):
        t = (gamma - start) / width
        return k * width * (np.logaddexp(0.0, t) - np.logaddexp(0.0, -start / width)), k / (1.0 + np.exp(-t))

    return smooth


def bending(lattice, D):
    """Bending of the yarn lines: linear in the second difference across the line's own direction."""
    number = np.arange((lattice.nx + 1) * (lattice.ny + 1)).reshape(lattice.nx + 1, lattice.ny + 1)
    hx, hy = lattice.points[:, 0].max() / lattice.nx, lattice.points[:, 1].max() / lattice.ny
    parts = []
    for lines, step, across in ((number, hx, hy), (number.T, hy, hx)):
        nodes = np.stack([lines[:-2].ravel(), lines[1:-1].ravel(), lines[2:].ravel()], axis=1)
        wide = np.full(lines.shape[1], across)
        wide[[0, -1]] /= 2
        parts.append(Bending(nodes, np.tile(D * wide / step**3, lines.shape[0] - 2), mirror=None))
        first = np.stack([lines[1], lines[0]], axis=1)
        parts.append(Bending(first, D * wide / step**3 / 2, mirror=0 if step == hx and lines is number else 1))
    return parts


class Bending:
    """k |second difference across the line|^2 / 2 on triples of nodes, or pairs at a symmetry plane (mirror axis)."""

    def __init__(self, nodes, stiffness, *, mirror):
        self.nodes, self.k, self.mirror = nodes, stiffness, mirror

    def start(self):
        return None

    def __call__(self, x, travel, state):
        p = x[self.nodes]
        if self.mirror is None:
            weights = np.array([1.0, -2.0, 1.0])
            second = p[:, 0] - 2 * p[:, 1] + p[:, 2]
            along = p[:, 2] - p[:, 0]
        else:
            weights = np.array([2.0, -2.0])
            second = 2 * (p[:, 0] - p[:, 1])
            along = np.zeros_like(second)
            along[:, self.mirror] = 1.0
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        plane = np.eye(3) - along[:, :, None] * along[:, None, :]
        across = np.einsum("nij,nj->ni", plane, second)
        gradient = self.k[:, None, None] * weights[None, :, None] * across[:, None, :]
        pair = self.k[:, None, None] * weights[None, :, None] * weights[None, None, :]
        return General(self.nodes, gradient, pair[:, :, None, :, None] * plane[:, None, :, None, :]), None


def interchange_hook(trusses, lattice, coefficient):
    """Shorten yarns by a share of the stretch of those they cross, as it was at the end of the step before.

    Unlike the library's this is no energy: the crossing yarns shorten each other without pushing back.
    """
    count = len(lattice.points)
    ends = lattice.trusses
    degree = [np.maximum(np.bincount(ends[lattice.family == k].ravel(), minlength=count), 1) for k in (WARP, WEFT)]
    rest = trusses.rest.copy()

    def hook(travel, x):
        stretch = np.linalg.norm(x[ends[:, 1]] - x[ends[:, 0]], axis=1) / rest - 1.0
        taut = np.maximum(stretch, 0.0)
        for k in (WARP, WEFT):
            crossing = np.flatnonzero(lattice.family == 1 - k)
            at_node = np.zeros(count)
            for side in (0, 1):
                np.add.at(at_node, ends[crossing, side], taut[crossing])
            at_node /= degree[1 - k]
            own = np.flatnonzero(lattice.family == k)
            trusses.rest[own] = rest[own] / (1.0 + coefficient * at_node[ends[own]].mean(axis=1))

    return hook


class FedTrusses(Trusses):
    """The lattice whose clamp feeds fabric past a jaw edge that stands still: unknown lengths u of fabric are fed in.

    The nodes of the edge stay where they are. Every truss that crosses the edge gets longer: one that reached hx along
    the pull and dy across is made of hypot(hx + u, dy) of fabric, all of it at one strain. The tension that those
    trusses bring to a node of the edge, per width, is what the clamp holds at its feed. The feeds are first components
    of extra points; no energy stands behind the balance of feeds, and the tangent is a symmetric neighbour of the true.
    """

    def __init__(self, plain, lattice, law):
        self.__dict__.update(vars(plain))
        self.law = law
        self.jaw = np.flatnonzero(lattice.line("clamp"))
        self.width = lattice.share[self.jaw] * 2 * lattice.half[1] / lattice.ny
        held = np.isin(lattice.trusses, self.jaw)
        self.fed = np.flatnonzero(held.sum(axis=1) == 1)
        ends = lattice.trusses[self.fed]
        self.at = np.searchsorted(self.jaw, ends[held[self.fed]])
        self.reach = np.abs(lattice.points[ends[:, 1]] - lattice.points[ends[:, 0]])
        self.first = len(lattice.points)

    def __call__(self, x, travel, p_old):
        fed, feed = self.fed, x[self.first : self.first + len(self.jaw), 0]
        along = self.reach[:, 0] + feed[self.at]
        self.rest[fed] = np.maximum(np.hypot(along, self.reach[:, 1]), 1e-6)
        part, p = super().__call__(x, travel, p_old)
        share = along / self.rest[fed]
        hold, slope = self.law(feed)
        pull = np.bincount(self.at, part.force[fed] * share, minlength=len(feed))
        stretch = part.force[fed] / np.maximum(part.across[fed], 1e-12) / self.rest[fed]
        return Feeding(part, self, self.width * hold - pull, self.width * slope, share * np.sqrt(stretch)), p


@dataclass
class Feeding:
    """Trusses at a trial and the balance of the feeds: out of balance (J,), slope of the hold, share of each truss."""

    part: Part
    trusses: FedTrusses
    balance: np.ndarray
    slope: np.ndarray
    share: np.ndarray

    def add(self, gradient, entries):
        self.part.add(gradient, entries)
        own, part = self.trusses, self.part
        gradient[own.first : own.first + len(own.jaw), 0] += self.balance
        stiff = np.maximum(part.along[own.fed], 0.0)
        point = own.first + own.at
        first = np.array([[1.0, 0.0, 0.0]])
        a, b = part.nodes[own.fed].T
        cross = (stiff * self.share)[:, None, None] * part.unit[own.fed][:, :, None] * first[:, None, :]
        for node, sign in ((a, 1), (b, -1)):
            entries.append((node, point, sign * cross))
            entries.append((point, node, sign * np.swapaxes(cross, 1, 2)))
        corner = first[:, :, None] * first[:, None, :]
        entries.append((point, point, (stiff * self.share**2)[:, None, None] * corner))
        jaw = own.first + np.arange(len(own.jaw))
        entries.append((jaw, jaw, self.slope[:, None, None] * corner))


class ClampLine:
    """The clamp line gives way node by node, as in the library: pull per width over the slip L/2 - x, its slope."""

    def __init__(self, lattice, law):
        self.nodes = np.flatnonzero(lattice.line("clamp"))
        self.edge = lattice.half[0]
        self.width = lattice.share[self.nodes] * 2 * lattice.half[1] / lattice.ny
        self.law = law

    def start(self):
        return None

    def __call__(self, x, travel, state):
        slip = self.edge - x[self.nodes, 0]
        pull, slope = self.law(slip)
        gradient = np.zeros((len(self.nodes), 1, 3))
        gradient[:, 0, 0] = -self.width * pull
        tangent = np.zeros((len(self.nodes), 1, 3, 1, 3))
        tangent[:, 0, 0, 0, 0] = self.width * slope
        return General(self.nodes[:, None], gradient, tangent), None


class RigidJaw:
    """A mount that gives, as the bar that a jaw is: it moves inwards in one piece, by what its whole pull takes.

    One unknown, the place of the bar, stands for the whole clamp (`number`: its point, whose first component is free);
    the edge of the fabric is bound to it by ties that give by some thousandths of a millimetre. Pull per width as a
    function of the slip (and its slope) is that of the bar over the width of the piece.
    """

    tie = 2e4

    def __init__(self, lattice, law, *, number):
        edge = np.flatnonzero(lattice.line("clamp"))
        self.nodes = np.stack([edge, np.full(len(edge), number)], axis=1)
        self.bar = np.array([[number]])
        self.edge, self.law = lattice.half[0], law
        self.width = lattice.share[edge] * 2 * lattice.half[1] / lattice.ny

    def start(self):
        return None

    def __call__(self, x, travel, state):
        pull, slope = self.law(self.edge - x[self.bar[:, 0], 0])
        return Jaw(self, x, self.width.sum() * pull, self.width.sum() * slope), None


@dataclass
class Jaw:
    """A bar at a trial: places (N, 3) of all points, pull in N and stiffness of its mount in N/mm, both (1,)."""

    jaw: RigidJaw
    x: np.ndarray
    pull: np.ndarray
    stiffness: np.ndarray

    def add(self, gradient, entries):
        own = self.jaw
        a, b = own.nodes.T
        tie = own.tie * own.width
        held = tie * (self.x[a, 0] - self.x[b, 0])
        gradient[a, 0] += held
        gradient[own.bar[0, 0], 0] -= held.sum() + self.pull[0]
        corner = np.zeros((1, 3, 3))
        corner[0, 0, 0] = 1.0
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            entries.append((i, j, sign * tie[:, None, None] * corner))
        entries.append((own.bar[:, 0], own.bar[:, 0], self.stiffness[:, None, None] * corner))


def slipping(*, limit, hardening=0.0, form):
    """Hold of a clamp at a feed: limited tension, sharp (over 2 um), or giving way over 0.03 mm."""
    reach = 0.03 if form == "other" else 0.002

    def law(slip):
        t = np.tanh(slip / reach)
        return limit * t + hardening * slip, limit / reach * (1.0 - t**2) + hardening + 1e-3

    return law


def compliant(*, compliance, form):
    """Pull of an elastic clamp, linear or (form "other") stiffening a little as it closes."""
    k = 1.0 / compliance

    def law(slip):
        if form != "other":
            return k * slip, np.full_like(slip, k)
        return k * slip * (0.9 + 0.5 * np.abs(slip)), k * (0.9 + np.abs(slip))

    return law


def split_families(lattice, fixed, parts, numbers, form):
    """Give the weft its own nodes, tied to the warp's at every crossing by a grip that slides beyond a limit."""
    count = len(lattice.points)
    trusses = parts[0]
    nodes = lattice.trusses.copy()
    nodes[lattice.family == WEFT] += count
    trusses.nodes = nodes
    grip = Crossings(lattice, numbers["limit"], form)
    return np.concatenate([lattice.points, lattice.points]), np.concatenate([fixed, fixed]), [*parts, grip]


class Crossings:
    """Grip between warp and weft nodes: stiff across the fabric, limited within it (limit in N per mm2 of fabric).

    An elastic offset slips at the limit; what is left of it is carried from step to step, with the path of the slip.
    The other form gives earlier and hardens along the path, as crossings do that bed in: 0.75 of the limit at first.
    """

    bedding = 0.2

    def __init__(self, lattice, limit, form):
        count = len(lattice.points)
        self.nodes = np.stack([np.arange(count), np.arange(count) + count], axis=1)
        self.area = lattice.share * lattice.half[0] / lattice.nx * lattice.half[1] / lattice.ny
        self.limit = limit * self.area
        self.soft = 0.25 if form == "other" else 0.0
        self.grip = self.limit / (0.05 if form == "other" else 0.01)
        self.shape = (lattice.nx + 1, lattice.ny + 1)
        self.normal = np.tile([0.0, 0.0, 1.0], (count, 1))
        self.stiff = 300.0 * self.area

    def start(self):
        nothing = np.zeros((len(self.nodes), 3))
        return nothing, nothing, np.zeros(len(self.nodes))

    def prepare(self, x):
        surface = x[: len(self.normal)].reshape(*self.shape, 3)
        normal = np.cross(np.gradient(surface, axis=0), np.gradient(surface, axis=1)).reshape(-1, 3)
        self.normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def __call__(self, x, travel, state):
        before, elastic, path = state
        apart = x[self.nodes[:, 1]] - x[self.nodes[:, 0]]
        elastic = elastic + apart - before
        across = np.einsum("ij,ij->i", elastic, self.normal)
        along = elastic - across[:, None] * self.normal
        size = np.linalg.norm(along, axis=1)
        hold = self.limit * (1.0 - self.soft * np.exp(-path / self.bedding))
        kept = np.minimum(1.0, hold / np.maximum(self.grip * size, 1e-12))
        slipped = (1.0 - kept) * size
        force = (kept * self.grip)[:, None] * along + (self.stiff * across)[:, None] * self.normal
        way = along / np.maximum(size, 1e-12)[:, None]
        normal = self.normal[:, :, None] * self.normal[:, None, :]
        plane = np.eye(3) - normal
        slips = (kept < 1.0)[:, None, None]
        plane = plane - 0.999 * np.where(slips, way[:, :, None] * way[:, None, :], 0.0)
        block = (kept * self.grip)[:, None, None] * plane + self.stiff[:, None, None] * normal
        sign = np.array([-1.0, 1.0])
        gradient = sign[None, :, None] * force[:, None, :]
        pair = sign[:, None] * sign[None, :]
        tangent = pair[None, :, None, :, None] * block[:, None, :, None, :]
        left = across[:, None] * self.normal + kept[:, None] * along
        return General(self.nodes, gradient, tangent), (apart, left, path + slipped)
