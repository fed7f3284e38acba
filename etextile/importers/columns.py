"""Which column of a file is which quantity, and by what it is multiplied to be in the unit that is wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from etextile.errors import nearest
from etextile.importers.labels import Label, factor, label_of, means, split_name
from etextile.importers.options import Source
from etextile.importers.sheet import Sheet, bad


@dataclass(frozen=True)
class Column:
    """One quantity: index of its column, factor to the wanted unit, and where it comes from ('' when plain)."""

    name: str
    index: int
    factor: float = 1.0
    words: str = ""


def offers(sheet: Sheet, name: str) -> bool:
    """Tell whether the file seems to hold a quantity (`force_N`); more than one candidate counts."""
    return bool(_stated(sheet, name)) or bool(_candidates(_head(sheet), name))


def is_stated(sheet: Sheet, name: str) -> bool:
    """Tell whether a person said which column a quantity is."""
    return _stated(sheet, name) is not None


def find_columns(sheet: Sheet, required: Sequence[str], *, texts: Sequence[str] = ()) -> list[Column]:
    """Return the columns of the quantities `required`; raises BadInput for missing, double and unclear ones."""
    head = _head(sheet)
    if not head:
        wanted = ",".join(required)
        message = f"no header: the first line must name the columns {wanted}"
        if len(sheet.body) <= len(sheet.body[0].cells) and not any(row.cells[0][:1].isdigit() for row in sheet.body):
            raise bad(sheet, "the names stand at the start of the lines: turn the table", line=sheet.body[0].line)
        remedy = "or say them: --columns displacement_mm,force_N, or columns: in measured.yaml"
        raise bad(sheet, f"{message} ({remedy})", line=sheet.body[0].line)
    twice = [label.text for label in head if label.text and sum(other == label for other in head) > 1]
    wanted_twice = [text for text in twice if any(_fits(label_of(text), name) for name in required)]
    if wanted_twice:
        raise bad(sheet, f"column {wanted_twice[0]!r} is given twice", line=_line(sheet))
    missing = [name for name in required if not _stated(sheet, name) and not _candidates(head, name)]
    if missing:
        raise _missing(sheet, head, missing, required)
    _one_specimen(sheet, head, [name for name in required if not _stated(sheet, name)])
    return [_column(sheet, head, name, text=name in texts) for name in required]


def _one_specimen(sheet: Sheet, head: Sequence[Label], names: Sequence[str]) -> None:
    """Raise BadInput where several columns have the same names: the curves of several specimens side by side."""
    found = {name: _candidates(head, name) for name in names}
    several = {name: at for name, at in found.items() if len({head[i].text for i in at}) == 1 < len(at)}
    counts = {len(at) for at in several.values()}
    if len(several) < 2 or len(counts) > 1:
        return
    ways = [",".join(f"{name}={at[k] + 1}" for name, at in several.items()) for k in range(min(2, *counts))]
    message = f"columns of {counts.pop()} specimens side by side; say which: --columns {' or '.join(ways)}"
    raise bad(sheet, f"{message} (columns: in measured.yaml)", line=_line(sheet), key=next(iter(several)))


def _head(sheet: Sheet) -> tuple[Label, ...]:
    """Return the names of the columns: those a person said in their order, else those of the file."""
    names = sheet.options.names
    if not names:
        return sheet.head
    if sheet.body and len(names) != len(sheet.body[0].cells):
        count = len(sheet.body[0].cells)
        message = f"{count} columns, but columns: names {len(names)} ({','.join(str(name) for name in names)})"
        raise bad(sheet, f"{message}; name all in their order, null for one to leave out", line=sheet.body[0].line)
    said = tuple(label_of(name or "") for name in names)
    for own, told in zip(sheet.head, said, strict=False):
        if told.text and own.text != told.text and own.text in [label.text for label in said]:
            message = f"a header ({','.join(label.text for label in sheet.head)}) that contradicts the columns said"
            message += f" ({','.join(label.text for label in said)}): leave the declaration of columns out"
            raise bad(sheet, message, line=sheet.head_line)
    return said


def _stated(sheet: Sheet, name: str) -> tuple[str, Source] | None:
    """Return the key and source a person gave for a quantity; the key may carry another unit (`force_kN`)."""
    quantity = split_name(name)[0]
    for key, source in sheet.options.sources.items():
        if key in (name, quantity) or split_name(key)[0] == quantity:
            return key, source
    return None


def _fits(label: Label, name: str) -> bool:
    """Tell whether a column carries a quantity's own name, in any unit that converts."""
    quantity, unit = split_name(name)
    if label.text == name:
        return True
    same = label.name.lower() == quantity.lower()
    return same and label.unit is not None and factor(label.unit, unit or "") is not None


def _candidates(head: Sequence[Label], name: str) -> list[int]:
    """Return the columns that may be a quantity: of its own name, else of its words in another language."""
    quantity, unit = split_name(name)
    exact = [i for i, label in enumerate(head) if label.text == name]
    own = exact or [i for i, label in enumerate(head) if _fits(label, name)]
    if own:
        return own
    called = [i for i, label in enumerate(head) if means(label.name, quantity)]
    return [i for i in called if (head[i].unit is None and unit) or factor(head[i].unit or "", unit or "") is not None]


def _column(sheet: Sheet, head: Sequence[Label], name: str, *, text: bool) -> Column:
    """Return one column; raises BadInput where several may be meant and where the unit is not known."""
    unit = split_name(name)[1] or ""
    stated = _stated(sheet, name)
    if stated is not None:
        return _from_source(sheet, head, name, *stated)
    found = _candidates(head, name)
    if len(found) > 1:
        several = " and ".join(head[i].shown for i in found)
        heading = head[found[0]].text
        alike = sum(label.text == heading for label in head) > 1
        first = str(found[0] + 1) if alike else repr(heading)
        if alike:
            several = f"columns {' and '.join(str(i + 1) for i in found)} ({head[found[0]].name!r})"
        message = f"{several} may both be {name}; say which: columns: {{{name}: {first}}} in measured.yaml"
        raise bad(sheet, f"{message} (--columns {name}={first})", line=_line(sheet), key=name)
    label = head[found[0]]
    if text or label.text == name:
        if sheet.units_line is not None and label.unit is not None and not text:
            own = factor(label.unit, unit)
            if own != 1.0:
                message = f"the name says {unit or 'a plain number'}, the units row {label.unit!r}"
                raise bad(sheet, f"{message}; say which: columns: {{{name}: ...}}", line=sheet.units_line, key=name)
        return Column(name, found[0])
    if found[0] in sheet.wrong_units:
        line, said = sheet.wrong_units[found[0]]
        raise bad(sheet, said, line=line, key=name)
    if label.unit is None:
        message = f"column {label.name!r} has no unit, so it cannot become {name}; say it: "
        message += f"columns: {{{name}: {{column: {label.text!r}, unit: {unit or '%'}}}}}"
        raise bad(sheet, message, line=_line(sheet), key=name)
    return Column(name, found[0], factor(label.unit, unit) or 1.0, f"{name} from {label.shown}")


def _from_source(sheet: Sheet, head: Sequence[Label], name: str, key: str, source: Source) -> Column:
    """Return the column a person named, by its name or its number."""
    unit = split_name(name)[1] or ""
    index = _index(sheet, head, key, source.column)
    label = head[index]
    of_key = split_name(key)[1]
    own = source.unit if source.unit is not None else label.unit
    if source.unit is None and of_key not in (None, unit):
        if label.unit is not None and factor(label.unit, of_key or "") != 1.0:
            message = f"columns: says {of_key}, the file {label.unit!r} for {label.name!r}"
            raise bad(sheet, f"{message}; write {{column: {label.name!r}, unit: ...}}", line=_line(sheet), key=key)
        own = of_key
    scale = 1.0 if own is None else factor(own, unit)
    if scale is None:
        wrong = f"{own!r} is no unit of {name}"
        raise bad(sheet, f"{wrong} (column {label.name!r})", line=_line(sheet), key=key)
    where = label.name or f"column {index + 1}"
    return Column(name, index, scale, f"{name} from {where!r}" + (f" in {own or 'plain numbers'}" if own else ""))


def _index(sheet: Sheet, head: Sequence[Label], key: str, column: str | int) -> int:
    """Return the index of a column given by name or by number from 1."""
    if isinstance(column, int):
        if not 1 <= column <= sheet.width:
            raise bad(sheet, f"there is no column {column}, the file has {sheet.width}", line=_line(sheet), key=key)
        return column - 1
    wanted = " ".join(column.split())
    for same in (
        lambda label: label.text == wanted or label.name == wanted,
        lambda label: wanted.lower() in (label.text.lower(), label.name.lower()),
    ):
        found = [i for i, label in enumerate(head) if same(label)]
        if len(found) == 1:
            return found[0]
        if found:
            message = (
                f"{len(found)} columns are called {column!r}; give the number: {', '.join(str(i + 1) for i in found)}"
            )
            raise bad(sheet, message, line=_line(sheet), key=key)
    names = [label.text for label in head]
    said = f"no column {column!r} (got {','.join(names)}){nearest(column, names)}"
    raise bad(sheet, said, line=_line(sheet), key=key)


def _missing(sheet: Sheet, head: Sequence[Label], missing: Sequence[str], required: Sequence[str]) -> Exception:
    """Return the error for columns that are not there, with the likely one and how to name it."""
    plural = "columns" if len(missing) > 1 else "column"
    texts = [label.text for label in head]
    found = ",".join(texts)
    near = nearest(missing[0], [name for name in texts if name not in required]).rpartition("mean ")[2].strip("?")
    hint = f"; rename or convert {near}" if near else "; columns: says which is which" if len(texts) > 1 else ""
    message = (
        f"missing {plural} {', '.join(map(repr, missing))} (got {found[:200]}), expected {','.join(required)}{hint}"
    )
    if sheet.block:
        message += (
            f"; lines {sheet.block[0].line} to {sheet.block[-1].line} were taken for a block before the table "
            "(skip_rows says where it begins)"
        )
    return bad(sheet, message, line=_line(sheet))


def _line(sheet: Sheet) -> int:
    """Return the line of the names, or of the first row."""
    return sheet.head_line or (sheet.body[0].line if sheet.body else 1)
