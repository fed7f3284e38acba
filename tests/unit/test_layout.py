"""The table of stored arrays: complete, unambiguous, and strict about names."""

import numpy as np
import pytest

from etextile.errors import EtextileError
from etextile.results import layout
from etextile.results.store import clip


TABLES = {
    "point": layout.POINT_ARRAYS,
    "cell": layout.CELL_ARRAYS,
    "label": layout.CELL_LABELS,
    "lattice": layout.LATTICE,
    "body": layout.BODY,
    "wires": layout.WIRES,
    "histories": layout.HISTORIES,
    "increments": layout.INCREMENTS,
}


@pytest.mark.parametrize("group", TABLES)
def test_every_array_is_described_once_and_has_a_number_type(group: str) -> None:
    names = layout.names(TABLES[group])
    assert len(set(names)) == len(names)
    for entry in TABLES[group]:
        assert entry.description
        np.dtype(entry.dtype)
        assert layout.quantity(group, entry.name) is entry


def test_names_that_carry_a_unit_agree_with_the_unit_column() -> None:
    suffixes = {"_mm": "mm", "_N": "N", "_s": "s"}
    for table in TABLES.values():
        for entry in table:
            for suffix, unit in suffixes.items():
                if entry.name.endswith(suffix):
                    assert entry.unit == unit, entry.name


def test_point_and_cell_arrays_have_different_names_because_they_are_asked_for_by_name_alone() -> None:
    assert not set(layout.names(layout.POINT_ARRAYS)) & set(layout.names(layout.CELL_ARRAYS))


def test_an_unknown_name_is_answered_with_the_nearest_known_one() -> None:
    with pytest.raises(EtextileError, match="did you mean 'plastic_strain'"):
        layout.quantity("cell", "plastic_strian")


def test_long_sentences_are_cut_at_a_character() -> None:
    stored = clip("x" + "\N{GREEK SMALL LETTER EPSILON}" * layout.TEXT_BYTES)
    assert len(stored) <= layout.TEXT_BYTES
    assert set(stored.decode()[1:]) == {"\N{GREEK SMALL LETTER EPSILON}"}
