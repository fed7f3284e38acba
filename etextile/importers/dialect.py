"""The dialect of a column file: mark between columns, decimal mark, quotes; found by which reading makes numbers.

Every reading is tried on lines from the whole file. The one under which most cells are numbers is taken; where two make
the same number of different numbers the person is asked, with both readings and the option that decides.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.importers.numerals import SPREADSHEET, is_number, value_of
from etextile.importers.options import WHITESPACE, Options


NAMES = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", WHITESPACE: "spaces"}
DECIMAL_NAMES = {".": "decimal point", ",": "decimal comma"}
SAMPLE = 400
MAX_CELL = 10_000
MAX_SPAN = 5
"""Lines that one quoted cell, the name of a column, may run over."""
FORMULA = re.compile(r"(^|[,;\t|])=(?=\")")
"""What spreadsheets put before a quoted cell that shall stay text."""
COMMENTED = re.compile(r"\s*(?:%|//|!)+\s")
"""Marks of comments that Matlab and others write before the names of columns; only above the table."""
SEPARATOR = re.compile(r"\s*[\"']?sep=(.)[\"']?\s*", re.IGNORECASE)


@dataclass(frozen=True)
class FileRow:
    """Cells of one row and the line (from 1) it stands in."""

    line: int
    cells: list[str]


@dataclass(frozen=True)
class Dialect:
    """How cells are told apart and read; `quote` is the mark around cells, '' when there is none."""

    delimiter: str
    decimal: str
    quote: str = ""

    @property
    def words(self) -> str:
        """The dialect in words."""
        return f"{NAMES[self.delimiter]}, {DECIMAL_NAMES[self.decimal]}"


@dataclass(frozen=True)
class FileLines:
    """Numbered lines of a file without blank ones and comments; the delimiter of a `sep=` line, the last comment."""

    numbers: list[int]
    texts: list[str]
    separator: str = ""
    comment: tuple[int, str] | None = None


def lines_of(text: str, *, skip: int, file: str) -> FileLines:
    """Split a text into lines; `skip` of them are passed over. Raises BadInput for an empty file and endless cells."""
    every = re.split(r"\r\n|\r|\n", text)
    numbers: list[int] = []
    texts: list[str] = []
    separator, comment = "", None
    for number, line in enumerate(every, start=1):
        if number <= skip or not line or line.isspace() or line == "\x1a":
            continue
        is_comment = line.lstrip().startswith("#") or (not texts and COMMENTED.match(line))
        if is_comment and not SPREADSHEET.match(line.lstrip()):
            comment = (number, line.lstrip(" \t#%!/")) if not texts else comment
            continue
        if not texts and (match := SEPARATOR.fullmatch(line)):
            separator = match[1]
            continue
        numbers.append(number)
        texts.append(line)
    if not texts:
        message = "empty file: a header line and rows of numbers are expected"
        if skip:
            message = f"nothing is left after {skip} lines: lower skip_rows"
        raise BadInput.of(message, file=file, line=1)
    longest = max(range(len(texts)), key=lambda i: len(texts[i]))
    if len(texts[longest]) > 20 * MAX_CELL:
        message = f"a line of {len(texts[longest])} characters: no table of numbers"
        raise BadInput.of(message, file=file, line=numbers[longest])
    return FileLines(numbers, texts, separator, comment)


def split_rows(lines: FileLines, dialect: Dialect, file: str) -> list[FileRow]:
    """Return the rows of stripped cells; raises BadInput for a quote that is not closed and a cell without end."""
    if not dialect.quote:
        mark = None if dialect.delimiter == WHITESPACE else dialect.delimiter
        return [
            FileRow(number, [cell.strip() for cell in text.split(mark)])
            for number, text in zip(lines.numbers, lines.texts, strict=True)
        ]
    rows = []
    texts = [FORMULA.sub(r"\1", text) + "\n" for text in lines.texts]
    if dialect.delimiter == WHITESPACE:
        texts = [" ".join(text.split()) + "\n" for text in texts]
    reader = csv.reader(texts, delimiter=dialect.delimiter, quotechar=dialect.quote, skipinitialspace=True)
    before = 0
    try:
        for cells in reader:
            number, spans, before = lines.numbers[before], reader.line_num - before, reader.line_num
            if spans > MAX_SPAN:
                raise BadInput.of(f"a quote that is not closed within {MAX_SPAN} lines", file=file, line=number)
            if any(len(cell) > MAX_CELL for cell in cells):
                message = f"a cell of more than {MAX_CELL} characters, or a quote that is not closed"
                raise BadInput.of(message, file=file, line=number)
            rows.append(FileRow(number, [" ".join(cell.split()) for cell in cells]))
    except csv.Error as error:
        message = f"a cell of more than 131072 characters, or a quote that is not closed ({error})"
        raise BadInput.of(message, file=file, line=lines.numbers[min(before, len(texts) - 1)]) from None
    return rows


def find_dialect(lines: FileLines, options: Options, file: str) -> Dialect:
    """Return the dialect; raises BadInput that names both when two readings make different numbers."""
    delimiters = [options.delimiter or lines.separator or ""]
    if delimiters == [""]:
        delimiters = [mark for mark in NAMES if mark != WHITESPACE]
        delimiters = [mark for mark in delimiters if any(mark in line for line in lines.texts)] + [WHITESPACE]
    decimals = [options.decimal] if options.decimal else [".", ","]
    quote = _quote(lines)
    tried = [Dialect(delimiter, decimal, quote) for delimiter in delimiters for decimal in decimals]
    sample = _sample(lines)
    best = _best(tried, sample, file)
    if not best and lines.separator and not options.delimiter:
        raise _contradicted(lines, options, file)
    if len(best) > 1 and len(sample.texts) < len(lines.texts):
        best = _best(best, lines, file)
    if not best:
        return tried[0]
    return _decided(best, lines, file)


def _contradicted(lines: FileLines, options: Options, file: str) -> BadInput:
    """Return the error for a `sep=` line under which no line holds numbers."""
    mark = lines.separator
    message = f"the file says sep={mark} but its lines are not divided by that; say by what: delimiter: ',' in "
    try:
        other = find_dialect(replace(lines, separator=""), options, file).delimiter
    except BadInput:
        other = ","
    message = message.replace("','", repr(other))
    return BadInput.of(f"{message}measured.yaml (--delimiter)", file=file, line=lines.numbers[0], key="delimiter")


def _quote(lines: FileLines) -> str:
    """Return the mark around cells: the double quote, or the single one when rows begin with it."""
    if any('"' in line for line in lines.texts):
        return '"'
    return "'" if any(re.match(r"\s*'[^']*'\s*(?:[,;\t|]|$)", line) for line in lines.texts) else ""


def _sample(lines: FileLines) -> FileLines:
    """Return some hundred lines from everywhere in the file, all when there are no more."""
    count = len(lines.texts)
    if count <= SAMPLE:
        return lines
    chosen = np.unique(np.linspace(0, count - 1, SAMPLE).astype(int)).tolist()
    return replace(lines, numbers=[lines.numbers[i] for i in chosen], texts=[lines.texts[i] for i in chosen])


def _best(tried: Sequence[Dialect], lines: FileLines, file: str) -> list[Dialect]:
    """Return the dialects under which most cells are numbers."""
    scores = [_score(dialect, lines, file) for dialect in tried]
    top = max(scores)
    return [] if top <= 0.0 else [item for item, score in zip(tried, scores, strict=True) if score > top - 1e-9]


def _score(dialect: Dialect, lines: FileLines, file: str) -> float:
    """Return how many rows hold numbers: each row of the usual width counts by its share of numbers."""
    try:
        rows = split_rows(lines, dialect, file)
    except BadInput:
        return 0.0
    shares: Counter[int] = Counter()
    total = dict.fromkeys({len(row.cells) for row in rows}, 0.0)
    for row in rows:
        filled = [cell for cell in row.cells if cell]
        share = sum(is_number(cell, dialect.decimal) for cell in filled) / max(len(filled), 1)
        if share > 0.0:
            shares[len(row.cells)] += 1
            total[len(row.cells)] += share
    wide = {width: count for width, count in shares.items() if width > 1}
    return max((total[width] for width in wide), default=0.0)


def _decided(best: list[Dialect], lines: FileLines, file: str) -> Dialect:
    """Return the one of several dialects that read the same numbers, or the only one whose names fit; else ask."""
    tables = {dialect: split_rows(lines, dialect, file) for dialect in best}
    if len(best) > 1:
        fitting = [dialect for dialect in best if _names_fit(tables[dialect], dialect.decimal)]
        best = fitting or best
    # A comma cannot stand between columns and mark decimals in one line unless cells are quoted.
    if {item.delimiter for item in best} == {","} and not best[0].quote:
        return best[0]
    for other in best[1:]:
        row = _difference(tables[best[0]], tables[other], best[0].decimal, other.decimal)
        if row is not None:
            raise _question(best[0], other, row, tables, lines, file)
    return best[0]


def _names_fit(rows: Sequence[FileRow], decimal: str) -> bool:
    """Tell whether the last line of words has as many cells as the rows of numbers below it."""
    width = Counter(len(row.cells) for row in rows).most_common(1)[0][0]
    for row in rows:
        if len(row.cells) == width and all(is_number(cell, decimal) or not cell for cell in row.cells):
            return False
        if len(row.cells) == width and len(row.cells) > 1:
            return True
    return False


def _difference(one: Sequence[FileRow], two: Sequence[FileRow], first: str, second: str) -> int | None:
    """Return the first row of the table that two readings read to different numbers; blocks around it do not count."""
    widths = [_usual_width(rows, decimal) for rows, decimal in ((one, first), (two, second))]
    for i, (a, b) in enumerate(zip(one, two, strict=False)):
        if [len(a.cells), len(b.cells)] != widths:
            continue
        left = [value_of(cell, first) for cell in a.cells if cell]
        right = [value_of(cell, second) for cell in b.cells if cell]
        if any(value is not None for value in (*left, *right)) and repr(left) != repr(right):
            return i
    return None


def _usual_width(rows: Sequence[FileRow], decimal: str) -> int:
    """Return the number of cells of most rows that hold a number."""
    widths = Counter(len(row.cells) for row in rows if any(is_number(cell, decimal) for cell in row.cells))
    return widths.most_common(1)[0][0] if widths else 0


def _question(
    one: Dialect, two: Dialect, row: int, tables: dict[Dialect, list[FileRow]], lines: FileLines, file: str
) -> BadInput:
    """Return the question: both readings with the numbers they give, and the option that decides."""

    def reads(dialect: Dialect) -> str:
        values = [value_of(cell, dialect.decimal) for cell in tables[dialect][row].cells if cell]
        return f"{dialect.words} gives {' and '.join(f'{value:.12g}' for value in values[:4] if value is not None)}"

    which = "decimal" if one.delimiter == two.delimiter else "delimiter"
    ways = [f"{which}: {getattr(item, which)!r}" for item in (one, two)]
    message = (
        f"two readings are possible: {reads(one)}; {reads(two)}. Say which: {' or '.join(ways)} in measured.yaml "
        f"(--{which} on the command line)"
    )
    return BadInput.of(message, file=file, line=tables[one][row].line, key=which)
