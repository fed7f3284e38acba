"""The table of the shipped effects, made from their cards: `{effects}`."""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from etextile.effects.base import Card, Parameter
from etextile.effects.registry import EFFECTS


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("effects", EffectsDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


class EffectsDirective(SphinxDirective):
    """One row per effect: id, mechanism, parameters with their ranges, what it is confused with."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        lines = ["| effect | mechanism | parameters | confused with |", "|---|---|---|---|"]
        lines += [_row(EFFECTS[name].card) for name in sorted(EFFECTS)]
        return self.parse_text_to_nodes("\n".join(lines))


def _row(card: Card) -> str:
    parameters = "; ".join(_parameter(item) for item in card.parameters)
    rivals = ", ".join(f"`{name}`" for name in card.confused_with) or "–"
    return f"| `{card.id}` | {card.mechanism} | {parameters} | {rivals} |".replace("\n", " ")


def _parameter(item: Parameter) -> str:
    return f"`{item.name}` {item.low:g} to {item.high:g} {item.unit}".rstrip()
