"""Reliability of conductive wires in woven electronic textiles: lattice model, contact, solver, diagnosis.

import etextile as et

case = et.load("punch", {"motion.total": "25 mm"})
run = et.run(case, "out/punch")
run.loops, run.report["verdict"], run.failure_map("map.png")

What stands here is all a user needs; it is loaded when it is first used, so that the import costs nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from etextile.contact.body import Body, Distance
    from etextile.contact.own import implicit_body
    from etextile.effects.base import Card, Effect, Example, Parameter, Signature
    from etextile.errors import BadInput, NoEquilibrium
    from etextile.studies.advice import advise
    from etextile.studies.calibrate.study import calibrate
    from etextile.studies.cases import build, load
    from etextile.studies.diagnose.compare import compare
    from etextile.studies.diagnose.run import diagnose
    from etextile.studies.ensemble.designs import compare_designs
    from etextile.studies.ensemble.run import ensemble
    from etextile.studies.identify.study import identify
    from etextile.studies.inspect import inspect
    from etextile.studies.inspect_folder import inspect_folder
    from etextile.studies.layout import layout
    from etextile.studies.life import life
    from etextile.studies.run.outcome import Run
    from etextile.studies.run.outcome import open_run as open
    from etextile.studies.run.run import run
    from etextile.studies.sizing import size_loops
    from etextile.text.summary import summary
    from wires.damage import Criterion, bundle_damage
    from wires.damage import CriterionParameter as CriterionParameter

_PLACES = {
    "load": "etextile.studies.cases:load",
    "build": "etextile.studies.cases:build",
    "run": "etextile.studies.run.run:run",
    "open": "etextile.studies.run.outcome:open_run",
    "advise": "etextile.studies.advice:advise",
    "inspect": "etextile.studies.inspect:inspect",
    "inspect_folder": "etextile.studies.inspect_folder:inspect_folder",
    "identify": "etextile.studies.identify.study:identify",
    "calibrate": "etextile.studies.calibrate.study:calibrate",
    "compare": "etextile.studies.diagnose.compare:compare",
    "diagnose": "etextile.studies.diagnose.run:diagnose",
    "ensemble": "etextile.studies.ensemble.run:ensemble",
    "compare_designs": "etextile.studies.ensemble.designs:compare_designs",
    "size_loops": "etextile.studies.sizing:size_loops",
    "layout": "etextile.studies.layout:layout",
    "life": "etextile.studies.life:life",
    "summary": "etextile.text.summary:summary",
    "Run": "etextile.studies.run.outcome:Run",
    "Effect": "etextile.effects.base:Effect",
    "Card": "etextile.effects.base:Card",
    "Parameter": "etextile.effects.base:Parameter",
    "Example": "etextile.effects.base:Example",
    "Signature": "etextile.effects.base:Signature",
    "Criterion": "wires.damage:Criterion",
    "CriterionParameter": "wires.damage:CriterionParameter",
    "bundle_damage": "wires.damage:bundle_damage",
    "Body": "etextile.contact.body:Body",
    "Distance": "etextile.contact.body:Distance",
    "implicit_body": "etextile.contact.own:implicit_body",
    "BadInput": "etextile.errors:BadInput",
    "NoEquilibrium": "etextile.errors:NoEquilibrium",
}
"""Public name: module and name of what stands behind it."""

__all__ = [
    "BadInput",
    "Body",
    "Card",
    "Criterion",
    "CriterionParameter",
    "Distance",
    "Effect",
    "Example",
    "NoEquilibrium",
    "Parameter",
    "Run",
    "Signature",
    "advise",
    "build",
    "bundle_damage",
    "calibrate",
    "compare",
    "compare_designs",
    "diagnose",
    "ensemble",
    "identify",
    "implicit_body",
    "inspect",
    "inspect_folder",
    "layout",
    "life",
    "load",
    "open",
    "run",
    "size_loops",
    "summary",
]


class _Door(ModuleType):
    """Keeps `etextile.identify` and its like functions: packages of these names would take their place."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _PLACES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


def __getattr__(name: str) -> Any:
    """Load a public name when it is first asked for."""
    if name not in _PLACES:
        raise AttributeError(f"module 'etextile' has no attribute {name!r}")
    from etextile.collisions import require_own_packages

    require_own_packages()
    module, _, own = _PLACES[name].partition(":")
    found = getattr(import_module(module), own)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, "__doc__", "__file__", "__path__"]


sys.modules[__name__].__class__ = _Door
