"""The paper's six X-rayed sites A to F: what its text says, and what a criterion makes of the strains it gives.

The text names no places, so the sites do not test a simulation but a criterion: from the warp strain that the authors
computed at a site (a number, or bounds where only a bound is left) to whether filaments are broken there. What the
bounds do not decide is called undecided.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from etextile.types import Array
from etextile.vocabulary import PARTIAL, STATES
from loadcases import catalogue
from loadcases.schema_numbers import PositiveLength, Quantity, Strict, Version
from loadcases.validate import validated
from loadcases.yaml_text import read_document
from wires.coupon import stretched
from wires.observed import HIT, ObservedPlace


FILE = catalogue.ROOT / "data" / "paper_sites" / "sites.yaml"
MISS, UNDECIDED = "miss", "undecided"
Strain = Annotated[float, Quantity(at_least=0.0)]


class Bounds(Strict):
    """Bounds of an engineering strain; equal for a number."""

    low: Strain = Field(description="Lower bound.")
    high: Strain = Field(description="Upper bound.")


class Site(Strict):
    """One X-rayed place."""

    observed: Literal["intact", "plastic", "partial", "open"] = Field(description="State that was seen.")
    strain: Bounds = Field(description="Warp strain that the authors computed there.")
    text: str = Field(min_length=1, description="What the text says, shortened.")


class Order(Strict):
    """Sites with more damage than others."""

    more: tuple[str, ...] = Field(min_length=1, description="Sites with more damage.")
    less: tuple[str, ...] = Field(min_length=1, description="Sites with less.")
    text: str = Field(min_length=1, description="What the text says, shortened.")


class Sites(Strict):
    """All sites, with their source and with what is not known of them."""

    schema_version: Version
    title: str = Field(description="One line.")
    source: str = Field(description="Where the statements are from.")
    displacement: PositiveLength = Field(description="Travel of the punch, mm.")
    missing: str = Field(description="What the text does not say.")
    sites: dict[str, Site] = Field(description="Sites by letter.")
    orders: tuple[Order, ...] = Field(description="Which sites are damaged more than others.")


@dataclass(frozen=True)
class SiteVerdict:
    """A site by its name, and what a criterion predicts there for the lower and the upper bound of its strain."""

    name: str
    low: ObservedPlace
    high: ObservedPlace

    @property
    def outcome(self) -> str:
        """That of both bounds, `undecided` where they differ."""
        return self.low.outcome if self.low.outcome == self.high.outcome else UNDECIDED


@dataclass(frozen=True)
class SitesVerdict:
    """All sites, the outcome of each statement about more and less damage, least and greatest Brier score."""

    sites: tuple[SiteVerdict, ...]
    orders: tuple[str, ...]
    brier: tuple[float, float]

    def count(self, outcome: str) -> int:
        """Return the number of sites with an outcome."""
        return sum(site.outcome == outcome for site in self.sites)


def load_sites() -> Sites:
    """Return the shipped sites."""
    document, _ = read_document(FILE)
    return validated(document, Sites)


def judge_sites(sites: Sites, criterion: str, *, parameters: Mapping[str, float] | None = None) -> SitesVerdict:
    """Return what a criterion predicts at the sites and where that agrees with what was seen there.

    The Brier score is that of `a filament is broken`, each site taken at the bound where it is less and greater.
    """
    low, high = (_at_bound(sites, name, criterion, parameters) for name in ("low", "high"))
    names = list(sites.sites)
    shares = {name: (low[1][k], high[1][k]) for k, name in enumerate(names)}
    errors = [sorted(_error(place) for place in pair) for pair in zip(low[0], high[0], strict=True)]
    return SitesVerdict(
        tuple(SiteVerdict(name, low[0][k], high[0][k]) for k, name in enumerate(names)),
        tuple(_order(order, shares) for order in sites.orders),
        (float(np.mean([pair[0] for pair in errors])), float(np.mean([pair[1] for pair in errors]))),
    )


def _at_bound(
    sites: Sites, bound: str, criterion: str, parameters: Mapping[str, float] | None
) -> tuple[list[ObservedPlace], Array]:
    """Return the predictions and the shares of broken filaments (n,) for a bound of the strains."""
    strain = np.array([getattr(site.strain, bound) for site in sites.sites.values()])
    damage = stretched(strain, criterion, parameters=parameters)
    places = [
        ObservedPlace(
            name=name,
            observed=site.observed,
            predicted=STATES[damage.loop_state[k]],
            strain=float(strain[k]),
            failure_probability=float(damage.failure_probability[k]),
            open_probability=float(damage.open_probability[k]),
        )
        for k, (name, site) in enumerate(sites.sites.items())
    ]
    return places, damage.loop_broken


def _error(place: ObservedPlace) -> float:
    """Return the squared error of the probability that a filament is broken."""
    return (place.failure_probability - (STATES.index(place.observed) >= PARTIAL)) ** 2


def _order(order: Order, shares: Mapping[str, tuple[float, float]]) -> str:
    """Return whether the shares (least, greatest) of all pairs agree with a statement; one that cannot is a miss."""
    pairs = [(shares[more], shares[less]) for more in order.more for less in order.less]
    if any(more[1] <= less[0] for more, less in pairs):
        return MISS
    return HIT if all(more[0] > less[1] for more, less in pairs) else UNDECIDED
