"""From the wires section of a case to wires in a model: layout, copper law, bond, and their share of the coupon."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.results.wire_layout import ALONG_WARP, LAID
from etextile.types import IntArray
from loadcases.build_paths import Construction, construction, drawn_wires
from loadcases.schema_bond import Slipping
from loadcases.schema_paths import Net
from loadcases.schema_wires import Wires
from loadcases.wire_material import load_wire_material
from wires.layout import Portion, WireLayout, lay_out


if TYPE_CHECKING:
    from etextile.lattice.weave import Weave
    from etextile.laws.powerlaw import PowerLaw
    from etextile.mechanics.model import Model
    from loadcases.fabric import Fabric
    from loadcases.schema import Case
    from wires.embed import EmbeddedWires
    from wires.embed_slip import WeaveHold
    from wires.lands import Lands
    from wires.share import WireShare


def wire_layout(case: Case, fabric: Fabric) -> WireLayout | None:
    """Return where wires and loops lie, None without wires; raises BadInput for nets that do not lie on them."""
    wires = case.wires
    if wires is None:
        return None
    if wires.drawn:
        layout = drawn_wires(case).layout
    else:
        if wires.components or wires.joined:
            key = "wires.components" if wires.components else "wires.joined"
            raise BadInput.of("parts and joints need drawn wires, give wires.paths or wires.layout", key=key)
        layout = _comb(case, wires, fabric)
    if case.worn and (wires.components or wires.joined):
        raise BadInput.of("parts and joints are modelled on flat pieces, leave them away", key="wires.components")
    if case.worn and not layout.straight:
        raise BadInput.of("wires of a worn piece follow the warp, give along: warp and at", key="wires.paths")
    problems = [problem for index, net in enumerate(wires.nets) for problem in _misplaced(net, index, layout)]
    if problems:
        raise BadInput(problems)
    return layout


def portion_of(case: Case) -> Portion:
    """Return the part of the wires that is modelled: half of a worn piece is one side of it."""
    portion = case.fabric.portion
    return "side" if case.worn and portion == "half" else portion


def _comb(case: Case, wires: Wires, fabric: Fabric) -> WireLayout:
    """Return the regular wires and loops of a case."""
    loops = wires.loops
    return lay_out(
        length_mm=case.pattern[0],
        width_mm=case.pattern[1],
        portion=portion_of(case),
        wire_spacing_mm=wires.every_warp_yarns / fabric.warp_density,
        first_offset_mm=wires.first_offset,
        loop_spacing_mm=None if loops is None else loops.spacing,
        loop_length_mm=1.0 if loops is None else loops.length,
        loop_slack=0.0 if loops is None else loops.slack,
        loop_offset_mm=0.0 if loops is None else loops.offset,
        loop_rigid_mm=0.0 if loops is None else loops.component,
        edge_margin_mm=1.0 / fabric.warp_density,
    )


def _misplaced(net: Net, index: int, layout: WireLayout) -> list[Problem]:
    """Return what is wrong with the place of a net given by numbers."""
    if net.wire is None:
        return []
    if net.wire >= layout.n_wires:
        known = f"the modelled part has wires 0 to {layout.n_wires - 1}" if layout.n_wires else "there are no wires"
        return [Problem(f"no such wire (got {net.wire}), {known}", key=f"wires.nets.{index}.wire")]
    count = int(np.count_nonzero(layout.loop_wire == net.wire))
    known = f"wire {net.wire} has loops 0 to {count - 1} in the modelled part" if count else "it has no loops"
    return [
        Problem(f"no such loop (got {loop}), {known}", key=f"wires.nets.{index}.{key}")
        for key, loop in (("from_loop", net.from_loop), ("to_loop", net.to_loop))
        if loop is not None and loop >= count
    ]


def copper(wires: Wires | Construction) -> PowerLaw:
    """Return the law of the filaments' metal."""
    from etextile.laws.powerlaw import PowerLaw

    metal = load_wire_material(wires.material)
    return PowerLaw(metal.E.value, metal.sigma_y0.value, metal.H.value, metal.n.value, e0=metal.e0.value)


def wire_area(wires: Wires | Construction) -> float:
    """Return the metal's cross-section of a wire, mm2."""
    return float(wires.filaments * np.pi / 4.0 * wires.filament_diameter**2)


def share_of_wires(case: Case, fabric: Fabric, weave: Weave, warp: PowerLaw) -> WireShare | None:
    """Return the warp law without the wires that the coupons contained, None where they contained none."""
    from wires.share import wire_stress, without_wires

    wires = case.wires
    if wires is None or not wires.coupons_contain_wires:
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


def constructions_of(case: Case, layout: WireLayout) -> tuple[Construction, ...]:
    """Return the construction of each wire of the modelled part."""
    wires = case.wires
    if wires is None:
        return ()
    return drawn_wires(case).constructions if wires.drawn else (construction(wires, None),) * layout.n_wires


def with_wires(
    model: Model, case: Case, layout: WireLayout, *, laws: Sequence[PowerLaw], weave: Weave
) -> tuple[Model, EmbeddedWires]:
    """Return the model with the wires of a case, bonded as they say, and the record of where they are."""
    from wires.embed import Strand, bonded, with_strands

    wires = case.wires
    if wires is None:
        raise ValueError("the case has no wires")
    held = drawn_wires(case).held if wires.drawn else None
    lands = lands_of(case)
    strands: list[Strand] = []
    for made, numbers in _groups(constructions_of(case, layout), layout):
        rigid = layout.loop_rigid_mm[np.isin(layout.loop_wire, numbers)].any()
        law, area = copper(made), wire_area(made)
        if made.bond == "perfect" and not rigid:
            strands.append(bonded(model, layout, numbers, law, area_mm2=area, crimp=made.crimp, lands=lands))
            continue
        from wires.embed_slip import sliding

        channel = _channel(made.bond, int(layout.kind[numbers[0]]), laws, weave)
        model, strand = sliding(
            model, layout, numbers, law, area_mm2=area, crimp=made.crimp, channel=channel, held=held, lands=lands
        )
        strands.append(strand)
    return with_strands(model, layout, strands, lands=lands)


def lands_of(case: Case) -> Lands | None:
    """Return the rigid lands of a case, None where it has none."""
    if case.wires is None or not case.wires.drawn:
        return None
    from wires.lands import Lands

    found = Lands.of(drawn_wires(case).parts)
    return found if len(found.low) else None


def _groups(made: Sequence[Construction], layout: WireLayout) -> Iterator[tuple[Construction, IntArray]]:
    """Yield the wires that are alike: of one construction and, where the yarns' tension grips them, of one kind."""
    groups: dict[tuple[Construction, int], list[int]] = {}
    for wire, item in enumerate(made):
        gripped = isinstance(item.bond, Slipping) and item.bond.tension_factor > 0.0
        groups.setdefault((item, int(layout.kind[wire]) if gripped else -1), []).append(wire)
    for (item, _), numbers in groups.items():
        yield item, np.array(numbers, dtype=np.int64)


def _channel(bond: object, kind: int, laws: Sequence[PowerLaw], weave: Weave) -> WeaveHold:
    """Return how the weave holds wires of a kind; the crossing yarns' tension per mm is their force over the cell."""
    from wires.embed_slip import WeaveHold

    if not isinstance(bond, Slipping):
        return WeaveHold(held=True)
    if kind == LAID:
        return WeaveHold(bond.line_friction)
    crossing, cell = (laws[1], weave.cell_warp) if kind == ALONG_WARP else (laws[0], weave.cell_weft)
    strain = np.linspace(0.0, 1.0, 201)
    tension = crossing.loading_curve(strain) * weave.truss_area / cell
    return WeaveHold(bond.line_friction, bond.tension_factor, strain, np.maximum.accumulate(tension))
