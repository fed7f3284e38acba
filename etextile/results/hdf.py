"""HDF5 with all room laid out in advance, so that a kill at any moment leaves a file that opens.

HDF5 has no journal: a process killed while it rearranges the file's inner structure leaves a file nobody can read. Here
the structure is complete before the first increment is computed: arrays are contiguous and allocated for the expected
number of entries (a sparse file, space is taken as entries are written), and appending only fills in bytes that nothing
points at yet. The counters, written last and at one go, make an entry part of the file (`etextile.results.vtkhdf`).
"""

from __future__ import annotations

import math
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from etextile.errors import EtextileError
from etextile.results import integrity
from etextile.results.layout import StoredQuantity


STEPS = "steps"
INCREMENTS = "increments"


def annotate(dataset: h5py.Dataset, quantity: StoredQuantity) -> None:
    """Attach unit and description to a dataset."""
    dataset.attrs["unit"] = quantity.unit
    dataset.attrs["description"] = quantity.description


def store(group: h5py.Group, quantity: StoredQuantity, values: ArrayLike) -> None:
    """Write an array that does not change over the run."""
    dataset = group.create_dataset(quantity.name, data=np.asarray(values, dtype=quantity.dtype))
    annotate(dataset, quantity)
    integrity.seal(dataset)


def reserve(group: h5py.Group, quantity: StoredQuantity, entries: int, *, per: str, block: int = 1) -> None:
    """Allocate room for `entries` entries of `block` rows each; `per` names the counter the entries follow."""
    dataset = allocate(group, quantity.name, (entries * block, *quantity.shape), quantity.dtype)
    annotate(dataset, quantity)
    dataset.attrs["per"] = per
    dataset.attrs["block"] = block


def allocate(group: h5py.Group, name: str, shape: tuple[int, ...], dtype: str) -> h5py.Dataset:
    """Create a contiguous dataset whose space in the file is fixed now and written never (holes read as zero)."""
    plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plan.set_layout(h5py.h5d.CONTIGUOUS)
    plan.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    plan.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
    kind = h5py.h5t.py_create(np.dtype(dtype), logical=True)
    return h5py.Dataset(h5py.h5d.create(group.id, name.encode(), kind, space, plan))


class Track:
    """Room reserved for the entries of one array, written through HDF5's low-level interface.

    An increment of a small model takes a millisecond; h5py's own indexing would double that.
    """

    def __init__(self, dataset: h5py.Dataset) -> None:
        self._id = dataset.id
        self._shape = (int(dataset.attrs["block"]), *dataset.shape[1:])
        self._dtype = dataset.dtype
        self._memory = h5py.h5s.create_simple(self._shape)
        self._file = dataset.id.get_space()
        self._rest = (0,) * (len(self._shape) - 1)

    def write(self, entry: int, values: ArrayLike) -> NDArray[Any]:
        """Write entry number `entry` and return it as stored; values of another shape raise EtextileError."""
        array = np.ascontiguousarray(np.asarray(values, dtype=self._dtype))
        if array.size != math.prod(self._shape):
            name = h5py.h5i.get_name(self._id).decode()
            raise EtextileError(f"{name}: got an array of shape {array.shape}, expected {self._shape}")
        if array.size:
            self._file.select_hyperslab((entry * self._shape[0], *self._rest), self._shape)
            self._id.write(self._memory, self._file, array.reshape(self._shape))
        return array


def tracks(group: h5py.Group) -> dict[str, Track]:
    """Return the reserved datasets of a group by name."""
    return {name: Track(item) for name, item in group.items() if "per" in item.attrs}


def copy_enlarged(old: h5py.Group, new: h5py.Group, capacities: dict[str, tuple[int, int]]) -> None:
    """Copy a tree, giving counted datasets room for more entries; `capacities` maps counter to (used, new room)."""
    new.attrs.update(old.attrs)
    for name, item in old.items():
        if isinstance(item, h5py.Group):
            if name not in ("Steps", "times"):
                copy_enlarged(item, new.create_group(name), capacities)
        elif "per" not in item.attrs:
            old.copy(item, new, name)
        else:
            used, room = capacities[item.attrs["per"]]
            block = int(item.attrs["block"])
            target = allocate(new, name, (room * block, *item.shape[1:]), item.dtype)
            target.attrs.update(item.attrs)
            target[: used * block] = item[: used * block]
