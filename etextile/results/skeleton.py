"""The inner structure of a result file, laid out before anything is computed.

What never changes (the case, the piece, the body, the wires) is written here; what grows gets its room. The store then
only fills in numbers.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import h5py
import numpy as np
from numpy.typing import ArrayLike

from etextile.contact.skinning import DUAL
from etextile.errors import EtextileError
from etextile.results import hdf, integrity, layout, vtkhdf
from etextile.results.layout import BodySurface, CaseRecord, StoredQuantity, UndeformedGrid


def build(
    file: h5py.File,
    grid: UndeformedGrid,
    case: CaseRecord,
    steps: int,
    wires: Mapping[str, ArrayLike],
    body: BodySurface | None,
    restart: Mapping[str, ArrayLike],
) -> None:
    """Lay out everything but the increments in an empty file, with room for `steps` output steps."""
    room = max(int(steps), 1)
    extra = file.create_group("etextile")
    _build_record(extra, case)
    _build_piece(extra, grid, body)
    extra.attrs[f"room_{hdf.STEPS}"] = room
    extra.attrs[f"room_{hdf.INCREMENTS}"] = increments = 256 + 8 * room
    group = extra.create_group("increments")
    for entry in layout.INCREMENTS:
        hdf.reserve(group, entry, increments, per=hdf.INCREMENTS)
    _build_wires(extra, wires, room)
    for slot in ("0", "1") if restart else ():
        target = extra.create_group(f"restart/{slot}")
        for name, values in restart.items():
            array = np.asarray(values)
            hdf.allocate(target, name, array.shape, array.dtype.str)
    _build_grid(file.create_group("VTKHDF"), grid, room)
    vtkhdf.lay_out_steps(file, room)
    _build_checks(file, extra, room, increments)


def _build_record(extra: h5py.Group, case: CaseRecord) -> None:
    extra.attrs["format"] = layout.FORMAT
    extra.attrs["version"] = np.array(layout.VERSION, dtype=np.int64)
    extra.attrs["completed"] = np.int8(0)
    extra.attrs["case_sha256"] = hashlib.sha256(case.text.encode()).hexdigest()
    extra.attrs["source"] = case.source
    extra.attrs["seed"] = np.int64(case.seed)
    extra.attrs["travel_unit"] = case.travel_unit
    extra.attrs["created"] = case.created
    extra["case"] = case.text
    extra["case_effective"] = case.effective
    extra.attrs["case_effective_sha256"] = case.sha256
    extra.create_dataset(
        "overrides", data=list(case.overrides), shape=(len(case.overrides),), dtype=h5py.string_dtype()
    )
    extra.create_dataset("ending", data=np.zeros(1, dtype=f"S{layout.TEXT_BYTES}"))
    extra.create_group("versions").attrs.update(dict(case.versions))
    extra.attrs[integrity.CHECK] = np.uint32(integrity.record_crc(extra))


def _build_checks(file: h5py.File, extra: h5py.Group, room: int, increments: int) -> None:
    """Give every array that grows a place for the checksums of its entries, and the counters a journal."""
    group = extra.create_group("checks")
    places = [file["VTKHDF/Points"], *file["VTKHDF/PointData"].values(), *file["VTKHDF/CellData"].values()]
    places += list(extra["histories"].values()) if "histories" in extra else []
    for dataset in places:
        if dataset.attrs.get("per") == hdf.STEPS:
            check = StoredQuantity(integrity.name_of(dataset), "", "checksum of the step (CRC-32)", "uint32")
            hdf.reserve(group, check, room, per=hdf.STEPS)
    row = StoredQuantity(integrity.ROW, "", "checksum of the row of the table of increments (CRC-32)", "uint32")
    hdf.reserve(group, row, increments, per=hdf.INCREMENTS)
    state = StoredQuantity("state", "", "checksum of each restart state and the increments before it", "int64", (2,))
    hdf.annotate(group.create_dataset("state", data=np.zeros((2, 2), dtype=np.int64)), state)
    vtkhdf.lay_out_journal(group)


def _build_piece(extra: h5py.Group, grid: UndeformedGrid, body: BodySurface | None) -> None:
    held = np.zeros(len(grid.reference)) if grid.clamped is None else grid.clamped
    quads = np.zeros((0, 4)) if grid.quads is None else grid.quads
    piece: dict[str, ArrayLike] = {"reference": grid.reference, "cells": grid.cells, "clamped": held, "quads": quads}
    piece |= {"symmetry": grid.symmetry, "warp_angle": grid.warp_angle_deg}
    _store_all(extra.create_group("lattice"), "lattice", piece)
    if body is not None:
        surface = {"vertices": body.vertices, "faces": body.faces, "direction": body.direction}
        _store_all(extra.create_group("body"), "body", surface)
    if body is not None and body.skin is not None:
        skin, dual = body.skin, np.array([body.skin.kind == DUAL])
        arrays = {"rest": skin.vertices, "weight": skin.weight, "flexion": np.degrees([skin.rest]), "dual": dual}
        _store_all(extra.create_group("skin"), "skin", arrays)


def _build_wires(extra: h5py.Group, wires: Mapping[str, ArrayLike], room: int) -> None:
    if not wires:
        return
    missing = set(layout.names(layout.WIRES)) - set(layout.WIRES_SINCE_1_1) - set(wires)
    if missing:
        raise EtextileError(f"wire arrays missing: {', '.join(sorted(missing))}")
    _store_all(extra.create_group("wires"), "wires", wires)
    loops, elements = np.size(wires["loop_wire"]), np.size(wires["element_wire"])
    group = extra.create_group("histories")
    for entry in layout.HISTORIES:
        hdf.reserve(group, entry, room, per=hdf.STEPS, block=elements if entry.name == "element_strain" else loops)


def _build_grid(root: h5py.Group, grid: UndeformedGrid, room: int) -> None:
    n_points, n_cells = len(grid.reference), len(grid.cells)
    vtkhdf.lay_out_topology(root, grid.cells, n_points)
    points = StoredQuantity("Points", "mm", "positions of the deformed piece", "float32", (3,))
    hdf.reserve(root, points, room, per=hdf.STEPS, block=n_points)
    for name, table, block in (
        ("PointData", layout.POINT_ARRAYS, n_points),
        ("CellData", layout.CELL_ARRAYS, n_cells),
    ):
        group = root.create_group(name)
        for entry in table:
            hdf.reserve(group, entry, room, per=hdf.STEPS, block=block)
    root["Points"][:n_points] = grid.reference
    _store_all(root["CellData"], "label", {"family": grid.family, "wire": grid.wire})


def _store_all(group: h5py.Group, table: str, arrays: Mapping[str, ArrayLike]) -> None:
    for name, values in arrays.items():
        hdf.store(group, layout.quantity(table, name), values)
