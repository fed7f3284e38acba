"""From the wires section of a case to wires in a model: layout, copper law, bond, and their share of the coupon."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from etextile.errors import BadInput, Problem
from loadcases.schema_wires import Net, Slipping, Wires
from loadcases.wire_material import load_wire_material
from wires.layout import WireLayout, lay_out


if TYPE_CHECKING:
    from etextile.lattice.weave import Weave
    from etextile.laws.powerlaw import PowerLaw
    from etextile.mechanics.model import Model
    from loadcases.fabric import Fabric
    from loadcases.schema import Case
    from wires.embed import EmbeddedWires
    from wires.embed_slip import Channel
    from wires.share import WireShare


def wire_layout(case: Case, fabric: Fabric) -> WireLayout | None:
    """Return where wires and loops lie, None without wires; raises BadInput for nets that do not lie on them."""
    wires = case.wires
    if wires is None:
        return None
    loops = wires.loops
    layout = lay_out(
        length_mm=case.fabric.size[0],
        width_mm=case.fabric.size[1],
        portion=case.fabric.portion,
        wire_spacing_mm=wires.every_warp_yarns / fabric.warp_density,
        first_offset_mm=wires.first_offset,
        loop_spacing_mm=None if loops is None else loops.spacing,
        loop_length_mm=1.0 if loops is None else loops.length,
        loop_slack=0.0 if loops is None else loops.slack,
        loop_offset_mm=0.0 if loops is None else loops.offset,
        loop_rigid_mm=0.0 if loops is None else loops.component,
        edge_margin_mm=1.0 / fabric.warp_density,
    )
    problems = [problem for index, net in enumerate(wires.nets) for problem in _misplaced(net, index, layout)]
    if problems:
        raise BadInput(problems)
    return layout


def _misplaced(net: Net, index: int, layout: WireLayout) -> list[Problem]:
    """Return what is wrong with the place of a net."""
    if net.wire >= layout.n_wires:
        known = f"the modelled part has wires 0 to {layout.n_wires - 1}" if layout.n_wires else "there are no wires"
        return [Problem(f"no such wire (got {net.wire}), {known}", key=f"wires.nets.{index}.wire")]
    count = int(np.count_nonzero(layout.loop_wire == net.wire))
    known = f"wire {net.wire} has loops 0 to {count - 1} in the modelled part" if count else "it has no loops"
    return [
        Problem(f"no such loop (got {loop}), {known}", key=f"wires.nets.{index}.{key}")
        for key, loop in (("from_loop", net.from_loop), ("to_loop", net.to_loop))
        if loop >= count
    ]


def copper(wires: Wires) -> PowerLaw:
    """Return the law of the filaments' metal."""
    from etextile.laws.powerlaw import PowerLaw

    metal = load_wire_material(wires.material)
    return PowerLaw(metal.E.value, metal.sigma_y0.value, metal.H.value, metal.n.value, e0=metal.e0.value)


def wire_area(wires: Wires) -> float:
    """Return the metal's cross-section of a wire, mm2."""
    return float(wires.filaments * np.pi / 4.0 * wires.filament_diameter**2)


def share_of_wires(case: Case, fabric: Fabric, weave: Weave, warp: PowerLaw) -> WireShare | None:
    """Return the warp law without the wires that the coupons contained, None for a case without wires."""
    from wires.share import wire_stress, without_wires

    wires = case.wires
    if wires is None:
        return None
    loops = wires.loops
    low, high = fabric.warp.strain_range
    strain = np.linspace(max(low, 1e-3), high, 120)
    stress = wire_stress(
        strain,
        copper(wires),
        area_mm2=wire_area(wires),
        spacing_mm=wires.every_warp_yarns / fabric.warp_density,
        thickness_mm=fabric.thickness,
        crimp=wires.crimp,
        slack=0.0 if loops is None else loops.slack,
        free_share=0.0 if loops is None else loops.length / loops.spacing,
        rigid_share=0.0 if loops is None else loops.component / loops.length,
    )
    return without_wires(warp, weave, stress, strain)


def with_wires(
    model: Model, case: Case, layout: WireLayout, *, weft: PowerLaw, weave: Weave
) -> tuple[Model, EmbeddedWires]:
    """Return the model with the wires of a case, bonded as it says, and the record of where they are."""
    wires = case.wires
    if wires is None:
        raise ValueError("the case has no wires")
    if wires.bond == "perfect" and not layout.loop_rigid_mm.any():
        from wires.embed import embed

        return embed(model, layout, copper(wires), area_mm2=wire_area(wires), crimp=wires.crimp)
    from wires.embed_slip import embed_sliding

    return embed_sliding(
        model,
        layout,
        copper(wires),
        area_mm2=wire_area(wires),
        crimp=wires.crimp,
        channel=_channel(wires, weft, weave),
    )


def _channel(wires: Wires, weft: PowerLaw, weave: Weave) -> Channel:
    """Return how the weave holds the wires; the weft's tension per mm of warp is its force over the cell's length."""
    from wires.embed_slip import Channel

    bond = wires.bond
    if not isinstance(bond, Slipping):
        return Channel(held=True)
    strain = np.linspace(0.0, 1.0, 201)
    tension = weft.loading_curve(strain) * weave.truss_area / weave.cell_warp
    return Channel(bond.line_friction, bond.tension_factor, strain, np.maximum.accumulate(tension))
