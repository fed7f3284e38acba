"""How a measured file is to be read, as far as a person says so: dialect, encoding, columns, sign and zero in YAML."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import BeforeValidator, Discriminator, Field, Tag, field_validator

from etextile.errors import nearest
from etextile.importers.labels import factor, is_unit, split_name
from etextile.importers.options import FIRST, Options, Source, decimal_of, delimiter_of, encoding_of
from etextile.units import shorten, to_number
from loadcases.schema_numbers import Count, CountOrZero, Strict


ReadingT = TypeVar("ReadingT", bound="Reading")


def _text(value: Any) -> str:
    """Return text as it is; anything else is refused."""
    if not isinstance(value, str):
        raise ValueError(f"not a text (got {shorten(value)})")
    return value


def _direction(value: Any) -> int:
    """Return +1 or -1."""
    if isinstance(value, bool) or value not in (1, -1):
        raise ValueError(f"not a sign (got {shorten(value)}), must be 1 or -1")
    return int(value)


Delimiter = Annotated[str, BeforeValidator(lambda value: delimiter_of(_text(value)))]
Decimal = Annotated[str, BeforeValidator(lambda value: decimal_of(_text(value)))]
Encoding = Annotated[str, BeforeValidator(lambda value: encoding_of(_text(value)))]
Sign = Annotated[Literal[1, -1], BeforeValidator(_direction)]


class ColumnSource(Strict):
    """Where a quantity stands in a file."""

    column: Count | str = Field(description="Name of the column in the file, or its number from 1.")
    unit: str | None = Field(default=None, description="Unit of the column, where the file does not say it.")

    @field_validator("unit")
    @classmethod
    def _known(cls, value: str | None) -> str | None:
        if value is not None and not is_unit(value):
            raise ValueError(f"unknown unit (got {value!r}), such as mm, cm, N, kN, MPa or %")
        return value


def _source_kind(value: Any) -> str:
    """Tell the two forms of a column apart."""
    return "section" if isinstance(value, (dict, ColumnSource)) else "number" if isinstance(value, int) else "name"


AnySource = Annotated[
    Annotated[str, Tag("name")] | Annotated[Count, Tag("number")] | Annotated[ColumnSource, Tag("section")],
    Discriminator(_source_kind),
]


def _map_kind(value: Any) -> str:
    return "map" if isinstance(value, dict) else "list"


Columns = Annotated[
    Annotated[tuple[str | None, ...], Tag("list")] | Annotated[dict[str, AnySource], Tag("map")],
    Discriminator(_map_kind),
]
Signs = Annotated[
    Annotated[Sign, Tag("list")] | Annotated[dict[str, Sign], Tag("map")],
    Discriminator(_map_kind),
]


def _zero(value: Any) -> Any:
    """Return `first`, or what a quantity's unit turns into a number later."""
    if isinstance(value, dict) or value == FIRST:
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(
            f"not a zero (got {shorten(value)}), write first or a number, as in zero: {{displacement: -700}}"
        )
    return value


Zero = Annotated[float | str | dict[str, float | str], BeforeValidator(_zero)]


class Reading(Strict):
    """What may be said of a file; what is left out is found in the file itself, or asked for."""

    QUANTITIES: ClassVar[tuple[str, ...]] = ()

    delimiter: Delimiter | None = Field(default=None, description="Mark between columns: ',', ';', tab, '|' or space.")
    decimal: Decimal | None = Field(default=None, description="Decimal mark: point or comma.")
    encoding: Encoding | None = Field(default=None, description="Encoding, such as utf-8, utf-16, latin-1.")
    skip_rows: CountOrZero | None = Field(default=None, description="Lines to pass over before the names of columns.")
    columns: Columns | None = Field(
        default=None,
        description="Names of all columns in order (null: leave out), or quantity: column, as in "
        "{force_N: Load, displacement_mm: {column: 2, unit: cm}}.",
    )
    sign: Signs | None = Field(
        default=None, description="-1 for quantities counted the other way; for all, or by quantity: {force: -1}."
    )
    zero: Zero | None = Field(
        default=None,
        description="What is taken off displacement and strain: first (the first reading) or a number; or by quantity: "
        "{displacement: first, force: 2 N}.",
    )

    @field_validator("columns", "sign", "zero")
    @classmethod
    def _quantities(cls, value: Any) -> Any:
        if isinstance(value, tuple) and len(value) < 2:
            raise ValueError(f"wrong number of items (got {list(value)!r}), name all columns of the file in order")
        if value in (1, -1) and not {"force_N", "stress_MPa"} & set(cls.QUANTITIES):
            raise ValueError(f"of which quantity? write {{{split_name(cls.QUANTITIES[-1])[0]}: {value}}}")
        stems = {split_name(name)[0]: name for name in cls.QUANTITIES}
        for name in value if isinstance(value, dict) else ():
            stem, unit = split_name(name)
            if stem not in stems:
                known = ", ".join(cls.QUANTITIES)
                raise ValueError(f"unknown quantity (got {name!r}), must be of {known}{nearest(name, cls.QUANTITIES)}")
            if unit is not None and factor(unit, split_name(stems[stem])[1] or "") is None:
                raise ValueError(f"{unit!r} is no unit of {stems[stem]} (got {name!r})")
        return value

    @field_validator("zero")
    @classmethod
    def _zeros(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value if value is None or value == FIRST else to_number(value, "mm")
        units = {split_name(name)[0]: split_name(name)[1] or "" for name in cls.QUANTITIES}
        return {
            name: zero if zero == FIRST else to_number(zero, units[split_name(name)[0]]) for name, zero in value.items()
        }

    def over(self: ReadingT, common: Reading) -> ReadingT:
        """Return this entry with what it leaves out taken from the one for all files."""
        missing = {name: getattr(common, name) for name in Reading.model_fields if getattr(self, name) is None}
        return self.model_copy(update=missing)

    def options(self) -> Options:
        """Return what was said as options of the reader."""
        named = isinstance(self.columns, dict)
        sources = {
            name: Source(item.column, item.unit) if isinstance(item, ColumnSource) else Source(item)
            for name, item in (self.columns.items() if isinstance(self.columns, dict) else ())
        }
        names = () if named or self.columns is None else tuple(self.columns)
        sign = self.sign if isinstance(self.sign, dict) else {} if self.sign is None else {"": self.sign}
        zero = self.zero if isinstance(self.zero, dict) else {} if self.zero is None else {"": self.zero}
        return Options(self.delimiter, self.decimal, self.encoding, self.skip_rows, names, sources, sign, zero)
