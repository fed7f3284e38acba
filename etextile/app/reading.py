"""Options that say how a measured file is to be read, the same for every verb that reads one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from etextile.errors import BadInput


if TYPE_CHECKING:
    from etextile.identify.curves import CouponSize
    from etextile.importers.options import Options


def _option(text: str) -> Parameter:
    """Return an option with its help."""
    return Parameter(show_default=False, allow_leading_hyphen=True, help=text)


def _size_option(what: str) -> Parameter:
    """Return the option for one dimension of the coupons."""
    return Parameter(show_default=False, help=f"{what} of the coupons (mm), for files of force and displacement.")


Width = Annotated[str | None, _size_option("Width")]
Thickness = Annotated[str | None, _size_option("Thickness")]
GaugeLength = Annotated[str | None, _size_option("Gauge length")]
MachineStiffness = Annotated[
    str | None,
    Parameter(
        show_default=False,
        help="Stiffness of frame, load cell and grips (N/mm): what they give is taken off the displacement.",
    ),
]


@dataclass(frozen=True)
class Said:
    """What the command line says of a file; what is left out is found in the file, or asked for."""

    columns: Annotated[
        str | None,
        _option("Names of all columns in order, displacement_mm,force_N, or which is which: force_kN=Load,strain=3."),
    ] = None
    delimiter: Annotated[str | None, _option("Mark between columns: comma, semicolon, tab, bar or space.")] = None
    decimal: Annotated[str | None, _option("Decimal mark: point or comma.")] = None
    encoding: Annotated[str | None, _option("Encoding of the files, such as utf-16 or latin-1.")] = None
    skip_rows: Annotated[int | None, _option("Lines to pass over before the names of the columns.")] = None
    sign: Annotated[str | None, _option("-1 where compression counts positive; or by quantity: force=-1.")] = None
    zero: Annotated[
        str | None, _option("What is taken off displacement or strain: first (reading) or a number; or force=2.")
    ] = None

    def options(self) -> Options:
        """Return the options of the reader; raises BadInput with everything that is wrong in them."""
        from etextile.importers.options import Options, column_map, decimal_of, delimiter_of, encoding_of

        problems: list[BadInput] = []

        def read(key: str, reader: Callable[[Any], Any], text: Any) -> Any:
            try:
                return None if text is None else reader(text)
            except ValueError as error:
                problems.append(BadInput.of(str(error), key=key))
                return None

        names, sources = read("--columns", column_map, self.columns) or ((), {})
        options = Options(
            delimiter=read("--delimiter", delimiter_of, self.delimiter),
            decimal=read("--decimal", decimal_of, self.decimal),
            encoding=read("--encoding", encoding_of, self.encoding),
            skip_rows=read("--skip-rows", _count, self.skip_rows),
            names=names,
            sources=sources,
            sign=read("--sign", _signs, self.sign) or {},
            zero=read("--zero", _zeros, self.zero) or {},
        )
        if problems:
            raise BadInput([problem for error in problems for problem in error.problems])
        return options


NOTHING = Said()


def _count(value: int) -> int:
    """Return a number of lines; raises ValueError below zero."""
    if value < 0:
        raise ValueError(f"out of range (got {value}), must be 0 or more")
    return value


def _pairs(text: str) -> dict[str, str]:
    """Return quantity to text; '' stands for all quantities."""
    if "=" not in text:
        return {"": text.strip()}
    pairs = [part.partition("=") for part in text.split(",")]
    return {name.strip(): value.strip() for name, _, value in pairs}


def _signs(text: str) -> dict[str, int]:
    """Return the sign by quantity; raises ValueError for anything but 1 and -1."""
    signs = {"1": 1, "+1": 1, "-1": -1, "-": -1, "+": 1}
    found = _pairs(text)
    wrong = next((value for value in found.values() if value not in signs), None)
    if wrong is not None:
        raise ValueError(f"not a sign (got {wrong!r}), must be 1 or -1")
    return {name: signs[value] for name, value in found.items()}


def _zeros(text: str) -> dict[str, float | str]:
    """Return what is taken off by quantity: `first` or a number; raises ValueError for anything else."""
    from etextile.importers.options import FIRST

    found: dict[str, float | str] = {}
    for name, value in _pairs(text).items():
        try:
            found[name] = value if value == FIRST else float(value)
        except ValueError:
            raise ValueError(f"not a zero (got {value!r}), must be first or a number") from None
    return found


def coupon_size(
    *, width: str | None, thickness: str | None, gauge_length: str | None, machine_stiffness: str | None = None
) -> CouponSize | None:
    """Return the size of the coupons from options with units, or None when there are none."""
    from etextile.identify.curves import CouponSize
    from etextile.units import to_number

    given = {"--width": width, "--thickness": thickness, "--gauge-length": gauge_length}
    if not any(given.values()) and machine_stiffness is None:
        return None
    missing = [name for name, text in given.items() if text is None]
    if missing:
        raise BadInput.of(f"width, thickness and gauge length belong together, {', '.join(missing)} is missing")
    values = []
    for name, text, unit in (
        *((name, text, "mm") for name, text in given.items()),
        ("--machine-stiffness", machine_stiffness, "N/mm"),
    ):
        if text is None:
            continue
        try:
            values.append(to_number(text, unit))
        except ValueError as error:
            raise BadInput.of(str(error), key=name) from error
        if values[-1] <= 0.0:
            raise BadInput.of(f"out of range (got {text}), must be above 0 {unit}", key=name)
    return CouponSize(*values)
