"""What `etextile list` shows: one function per kind, short by default, every number with its source when verbose."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from etextile.errors import BadInput, nearest
from etextile.text.columns import Columns


if TYPE_CHECKING:
    from etextile.effects.base import Card, Parameter
    from loadcases.fabric import Fabric, Family
    from loadcases.measured import Measured
    from wires.observed import ObservedPlace


def listings(kinds: Sequence[str], *, verbose: bool) -> Iterator[Columns]:
    """Yield the tables of the given kinds, of all when none is given; raises BadInput for an unknown kind."""
    for kind in kinds:
        if kind not in KINDS:
            raise BadInput.of(f"nothing to list (got {kind!r}), known are {', '.join(KINDS)}{nearest(kind, KINDS)}")
    for kind in kinds or KINDS:
        yield from KINDS[kind](verbose)


def cases(verbose: bool) -> Iterator[Columns]:
    """Yield the shipped cases."""
    from loadcases import catalogue
    from loadcases.reader import load_case

    loaded = {name: load_case(name) for name in catalogue.names("case")}
    if not verbose:
        yield Columns("cases", ("name", "title"), [(name, item.case.title) for name, item in loaded.items()])
        return
    rows = [(name, item.case.description, str(item.path)) for name, item in loaded.items()]
    yield Columns("cases", ("name", "description", "file"), rows)


def fabrics(verbose: bool) -> Iterator[Columns]:
    """Yield the shipped fabrics; verbose: geometry and the law of each family with its origin."""
    from loadcases import catalogue
    from loadcases.fabric import load_fabric

    loaded = {name: load_fabric(name) for name in catalogue.names("fabric")}
    yield Columns("fabrics", ("name", "title"), [(name, item.title) for name, item in loaded.items()])
    if not verbose:
        return
    geometry = ("name", "cell, mm", "thickness, mm", "truss area, mm2", "warp, weft yarns per mm", "source")
    yield Columns("fabric geometry", geometry, [(name, *_geometry(item)) for name, item in loaded.items()])
    columns = ("name", "family", "E, MPa", "sigma_y0, MPa", "H, MPa", "n", "strains", "origin")
    rows = [
        (name, family, *_law(getattr(item, family)))
        for name, item in loaded.items()
        for family in ("warp", "weft", "diagonal")
    ]
    yield Columns("fabric laws", columns, rows)


def _geometry(fabric: Fabric) -> tuple[str, ...]:
    """Return the geometry of a fabric as text."""
    warp, weft = fabric.cell
    densities = f"{fabric.warp_density:g}, {fabric.weft_density:g}"
    return (f"{warp:g} x {weft:g}", f"{fabric.thickness:g}", f"{fabric.truss_area:g}", densities, fabric.source)


def _law(family: Family) -> tuple[str, ...]:
    """Return the law of a truss family as text, with where it comes from."""
    low, high = family.strain_range
    origin = f"{'estimated: ' if family.estimated else ''}{family.source}".removesuffix(": ")
    numbers = (family.E, family.sigma_y0, family.H, family.n)
    return (*(_number(item) for item in numbers), f"{low:g} to {high:g}", origin)


def _number(item: Measured) -> str:
    """Return a number with its standard deviation, if it has one."""
    return f"{item.value:g}" if item.std is None else f"{item.value:g} +- {item.std:.2g}"


def wires(verbose: bool) -> Iterator[Columns]:
    """Yield the shipped wire materials; verbose: every number with its source."""
    from loadcases import catalogue
    from loadcases.describe import wire_defaults
    from loadcases.wire_material import NUMBERS, load_wire_material

    loaded = {name: load_wire_material(name) for name in catalogue.names("wire material")}
    yield Columns("wires", ("name", "title"), [(name, item.title) for name, item in loaded.items()])
    if not verbose:
        return
    rows = []
    for name, material in loaded.items():
        for key, unit in NUMBERS.items():
            item: Measured = getattr(material, key)
            rows.append((name, key, _number(item), unit, item.source or "estimated"))
    yield Columns("wire numbers", ("name", "number", "value", "unit", "source"), rows)
    defaults = [(f"{key.section}.{key.name}", key.default, key.origin, key.meaning) for key in wire_defaults()]
    yield Columns("defaults of the case file", ("key", "default", "source", "meaning"), defaults)
    yield _criteria_numbers()


def bodies(verbose: bool) -> Iterator[Columns]:
    """Yield the body types; verbose: their keys, defaults and what they mean."""
    from loadcases.describe import body_keys, body_types

    yield Columns("bodies", ("type", "shape"), list(body_types().items()))
    if verbose:
        rows = [(key.section, key.name, key.default, key.meaning) for key in body_keys()]
        yield Columns("body keys", ("type", "key", "default", "meaning"), rows)


def effects(verbose: bool) -> Iterator[Columns]:
    """Yield the effects of the library and of installed packages; verbose: the card of each."""
    from etextile.effects.registry import EFFECTS

    cards = [item.card for item in EFFECTS.values()]
    if not verbose:
        rows = [(card.id, card.mechanism, ", ".join(item.name for item in card.parameters)) for card in cards]
        yield Columns("effects", ("id", "mechanism", "parameters"), rows)
    for card in cards if verbose else ():
        yield Columns(f"effect {card.id}", ("mechanism", card.mechanism), list(_card_rows(card)))


def _card_rows(card: Card) -> Iterator[tuple[str, str]]:
    """Yield what a card says, line by line."""
    for parameter in card.parameters:
        yield f"parameter {parameter.name}", _parameter_text(parameter)
    for item in card.signature:
        sign = {1: "rises", -1: "falls", 0: "changes"}[item.sign]
        since = f" from {item.onset_mm:g} mm" if item.onset_mm else ""
        yield f"in {item.channel}", f"{sign}{since}: {item.words}"
    given = ", ".join(f"{name} {value:g}" for name, value in card.example.parameters.items())
    for name, unit, numbers in (("force", "%", card.example.force_percent), ("edge", "mm", card.example.edge_mm)):
        if numbers:
            text = " / ".join(f"{number:+g}" for number in numbers)
            yield f"example, {name}", f"{text} {unit} at 10 / 20 / 25 / 30 / 40 mm with {given}"
    others = {"confused with": ", ".join(card.confused_with), "told apart by": card.separate}
    units = {"strain_field": ""}
    loose = (
        f"{item.quantity} in {item.channel} by up to {item.size:g} {units.get(item.channel, 'mm')}".rstrip()
        for item in card.undetermined
    )
    others |= {"leaves open": ", ".join(loose), "limits": card.limits, "literature": card.literature}
    yield from ((name, text) for name, text in others.items() if text)


def _parameter_text(item: Parameter) -> str:
    """Return range, neutral value and meaning of an effect's parameter."""
    without = f"default {item.default:g}" if item.neutral is None and item.default is not None else ""
    without = f"{item.neutral:g} is none" if item.neutral is not None else without
    details = ", ".join(part for part in (f"{item.low:g} to {item.high:g} {item.unit}".rstrip(), without) if part)
    return f"{item.meaning} ({details})"


def criteria(verbose: bool) -> Iterator[Columns]:
    """Yield the failure criteria; verbose: their parameters with source."""
    from wires.failure import CRITERIA

    rows = [(name, item.summary) for name, item in CRITERIA.items()]
    yield Columns("criteria", ("name", "decides by"), rows)
    if verbose:
        yield _criteria_numbers()


def _criteria_numbers() -> Columns:
    """Return the parameters of the failure criteria with source."""
    from wires.failure import CRITERIA

    numbers = [
        (name, item.name, f"{item.default:g}", item.unit, f"{item.origin}: {item.source}")
        for name, criterion in CRITERIA.items()
        for item in criterion.parameters
    ]
    return Columns("criteria parameters", ("criterion", "parameter", "default", "unit", "source"), numbers)


def scatter(_: bool) -> Iterator[Columns]:
    """Yield what differs from specimen to specimen in an ensemble, with the default standard deviations."""
    from loadcases.describe import scatter_defaults

    rows = [(f"scatter.{key.name}", key.default, key.origin, key.meaning) for key in scatter_defaults()]
    yield Columns("scatter", ("key", "default", "source", "meaning"), rows)


def arcs(verbose: bool) -> Iterator[Columns]:
    """Yield the arcs of joints that a case can name as its history; verbose: with their sources."""
    from loadcases.arcs import ARCS

    rows = [
        (name, " - ".join(f"{angle:g}" for angle in arc.angle_deg), arc.description, *([arc.source] if verbose else []))
        for name, arc in ARCS.items()
    ]
    yield Columns("arcs", ("name", "deg", "of", *(["source"] if verbose else [])), rows)


def sites(verbose: bool) -> Iterator[Columns]:
    """Yield the paper's X-rayed sites with hits and misses of the default criterion; verbose: of all, and the text."""
    from loadcases.sites import judge_sites, load_sites
    from wires.failure import CRITERIA, DEFAULT_CRITERION

    known = load_sites()
    columns = ("site", "observed", "strain", "predicted", "P(broken)", "outcome")
    for name in CRITERIA if verbose else (DEFAULT_CRITERION,):
        found = judge_sites(known, name)
        title = f"sites by {name}" if verbose else "sites"
        rows = [_site_row(site.name, site.low, site.high, site.outcome) for site in found.sites]
        rows += [
            (" ".join(order.more), "more damage", f"than at {' '.join(order.less)}", "", "", outcome)
            for order, outcome in zip(known.orders, found.orders, strict=True)
        ]
        score = " to ".join(f"{value:.3f}" for value in found.brier)
        rows.append(
            ("all", "", "", "", "", f"{found.count('hit')} of {len(found.sites)} sites hit, Brier score {score}")
        )
        yield Columns(title, columns, rows)
    if verbose:
        said = [*((name, site.text) for name, site in known.sites.items()), ("missing", known.missing)]
        yield Columns("sites, the text", ("site", "says"), [*said, ("source", known.source)])


def _site_row(name: str, low: ObservedPlace, high: ObservedPlace, outcome: str) -> tuple[str, ...]:
    """Return a site with what is predicted for the bounds of its strain."""
    from wires.wording import probability

    strain = f"{100 * low.strain:g} %" if low.strain == high.strain else f"above {100 * low.strain:g} %"
    states = " to ".join(dict.fromkeys((low.predicted, high.predicted)))
    chances = dict.fromkeys(probability(place.failure_probability) for place in (low, high))
    return (name, low.observed, strain, states, " to ".join(chances), outcome)


def solvers(verbose: bool) -> Iterator[Columns]:
    """Yield the linear solvers and whether they can be used here."""
    from etextile.solve.linear import LINEAR_SOLVERS

    rows = [("auto", "yes", "band for small lattices, then pardiso where it is installed, else superlu")]
    for name, solver in LINEAR_SOLVERS.items():
        usable = name != "pardiso" or find_spec("pypardiso") is not None
        rows.append((name, "yes" if usable else "not installed", (solver.__doc__ or "").strip().splitlines()[0]))
    yield Columns("solvers", ("name", "usable here", "method"), rows)


KINDS: dict[str, Callable[[bool], Iterator[Columns]]] = {
    "cases": cases,
    "fabrics": fabrics,
    "wires": wires,
    "bodies": bodies,
    "arcs": arcs,
    "effects": effects,
    "criteria": criteria,
    "scatter": scatter,
    "sites": sites,
    "solvers": solvers,
}
"""What can be listed; a further kind is one function and one line here."""
