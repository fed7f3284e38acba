"""Nets of a case as the report asks for them: by numbers of a wire and its loops, or by names of wires and parts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from etextile.results.wire_layout import WireLayout
from etextile.types import Array
from loadcases.build_paths import Drawn, drawn_wires
from loadcases.build_wires import constructions_of, wire_area
from loadcases.schema_paths import Net
from loadcases.wire_material import load_wire_material
from wires import resistance
from wires.circuit import Circuit, Node


if TYPE_CHECKING:
    from loadcases.schema import Case


def _numbered(net: Net) -> resistance.Net | None:
    if net.wire is None or net.from_loop is None or net.to_loop is None:
        return None
    return resistance.Net(net.name, net.wire, net.from_loop, net.to_loop)


def numbered_nets(case: Case) -> list[resistance.Net]:
    """Return the nets of a case that are given by numbers."""
    return [] if case.wires is None else [net for net in map(_numbered, case.wires.nets) if net is not None]


def circuits_of(case: Case) -> list[Circuit]:
    """Return the nets of a case that are given by names, with their nodes on the wires."""
    if case.wires is None or not case.wires.drawn:
        return []
    drawn = drawn_wires(case)
    return [_circuit(net, drawn) for net in case.wires.nets if net.wire is None]


def _circuit(net: Net, drawn: Drawn) -> Circuit:
    parts = {name: node for node, name in enumerate(net.parts)}
    nodes = [
        Node(item.wire, item.along_mm, parts[drawn.parts[item.part].name])
        for item in drawn.terminals
        if item.wire in net.wires and drawn.parts[item.part].name in parts
    ]
    for count, joint in enumerate(drawn.joints):
        if set(joint.wires) <= set(net.wires):
            sides = zip(joint.wires, joint.along_mm, strict=True)
            nodes += [Node(wire, along, len(parts) + count) for wire, along in sides]
    return Circuit(net.name, net.wires, net.parts, tuple(nodes), tuple(parts.values()), drawn.images)


def ohm_per_mm(case: Case, layout: WireLayout) -> Array:
    """Return the resistance (W,) of a mm of unstretched wire, rho / (N A)."""
    made = constructions_of(case, layout)
    resistivity = [load_wire_material(item.material).resistivity.value for item in made]
    return np.array([1e-3 * rho / wire_area(item) for rho, item in zip(resistivity, made, strict=True)])
