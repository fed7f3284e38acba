"""The summary of an identification as text: parameters with intervals, the paper's values beside them, what to know."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from etextile.identify.result import DIRECTION_OF, Estimate, IdentifiedFabric, IdentifiedFamily
from etextile.text.refine import refinement_text


if TYPE_CHECKING:
    from etextile.studies.identify.found import Identification

WIDTH = 80
_UNITS = {"E": "MPa", "H": "MPa", "n": ""}


def identification_text(found: Identification) -> str:
    """Return what `identify` found, with what refinement found, readable at 80 columns."""
    text = summary(found.identified, title=found.title, base=found.base)
    return f"{text}\n{refinement_text(found)}" if found.refinement is not None else text


def summary(fabric: IdentifiedFabric, *, title: str, base: str) -> str:
    """Return the summary, readable at 80 columns."""
    lines = [title, f"{fabric.procedure} procedure; weave from {base}", ""]
    for item in fabric.families.values():
        lines += [*_family(item), ""]
    missing = [family for family in DIRECTION_OF if family not in fabric.families]
    if missing:
        lines += _wrapped(f"not measured, taken from {base}: {', '.join(missing)}", "")
    return "\n".join(lines).rstrip() + "\n"


def _family(item: IdentifiedFamily) -> list[str]:
    """Return the block of one family."""
    fit = item.fit
    count = len(fit.specimens)
    peak = max(float(specimen.segments.stress.max()) for specimen in fit.specimens)
    low, high = fit.strain_range
    lines = [
        f"{item.family} ({count} {DIRECTION_OF[item.family]} specimen{'s' if count > 1 else ''}):"
        f" strain {low:.3g} to {high:.3g}, residual {fit.residual:.2g} MPa, {fit.residual / peak:.1%} of peak",
        f"  {'':9}{'value':>9} {'std':>7}   {'95 % interval':<18} " + ("paper's procedure" if item.paper else ""),
    ]
    paper = item.paper.law if item.paper else None
    for name, estimate in item.estimates.items():
        given = paper is None or estimate.std is None
        beside = _beside(estimate.value, None if given else getattr(paper, name))
        lines.append(_row(name, estimate, beside))
    lines.append(f"  {'sigma_y0':9}{_number(item.law.sigma_y0):>9}   MPa, fixed")
    lines += _wrapped(_correlations(item), "  ")
    if fit.modulus_source:
        lines += _wrapped(f"E is {fit.modulus_source}", "  ! ")
    for note in fit.notes:
        lines += _wrapped(note, "  - ")
    return lines


def _beside(value: float, paper: float | None) -> str:
    """Return the paper's value and how far it is from the one beside it."""
    return "" if paper is None else f"{_number(paper)} ({paper / value - 1.0:+.0%})"


def _row(name: str, estimate: Estimate, beside: str) -> str:
    """Return the line of one parameter."""
    label = f"{name} {_UNITS[name]}".strip()
    if estimate.std is None or estimate.low is None or estimate.high is None:
        return f"  {label:9}{_number(estimate.value):>9} {'-':>7}   {'unidentified':<18} {beside}".rstrip()
    interval = f"{_number(estimate.low)} to {_number(estimate.high)}"
    return f"  {label:9}{_number(estimate.value):>9} {_number(estimate.std, 2):>7}   {interval:<18} {beside}".rstrip()


def _correlations(item: IdentifiedFamily) -> str:
    """Return the correlations between the parameters in words."""
    covariance = item.fit.covariance
    deviation = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    matrix = covariance / deviation[:, None] / deviation[None, :]
    pairs = [("E-H", matrix[0, 1]), ("E-n", matrix[0, 2])] if item.modulus_identified else []
    return "correlation " + ", ".join(f"{name} {value:+.2f}" for name, value in [*pairs, ("H-n", matrix[1, 2])])


def _number(value: float, digits: int = 4) -> str:
    """Return a number with some significant digits, with an exponent from a million on."""
    rounded = float(f"{value:.{digits}g}")
    if abs(rounded) >= 1e6:
        return f"{rounded:.{digits - 1}e}".replace("e+0", "e")
    return f"{rounded:.0f}" if abs(rounded) >= 10 ** (digits - 1) else f"{rounded:g}"


def _wrapped(text: str, indent: str) -> list[str]:
    """Return text wrapped to the width, later lines indented as far as the first."""
    return textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=" " * len(indent))
