"""From the bytes of a file to its text: the encoding found without chance, or what stands in the way.

Numbers are ASCII in every encoding but UTF-16 and UTF-32, so a wrong guess between Latin-1 and its relatives spoils
letters of names and never a value; a unit that was spoiled is refused later.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from etextile.errors import BadInput, nearest
from etextile.importers.foreign import what_it_is


MAX_BYTES = 200_000_000
MARKS = (
    (b"\xff\xfe\x00\x00", "utf-32"),
    (b"\x00\x00\xfe\xff", "utf-32"),
    (b"\xef\xbb\xbf", "utf-8-sig"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
WESTERN = "cp1252"
WORDS = {
    "gb18030": ("位移", "载荷", "荷载", "应变", "应力", "变形", "伸长", "时间", "试验力"),
    "shift_jis": ("変位", "荷重", "試験力", "応力", "時間", "ストローク"),
    "cp949": ("변위", "하중", "시험력", "응력", "변형", "시간"),
    "cp1250": ("iła", "ydłuż", "dkształ"),
    "cp1251": ("перемещ", "Перемещ", "нагруз", "Нагруз", "Усили", "усили", "деформ", "Деформ"),
}
"""Words of tests, each two letters or more of another script: no Western text holds their bytes."""
SHOWN = {"utf-8": "UTF-8", "utf-8-sig": "UTF-8 with byte order mark", "utf-16": "UTF-16", "utf-32": "UTF-32"}


@dataclass(frozen=True)
class Text:
    """Text of a file, its encoding, and how sure that is: `note` is empty for UTF-8."""

    text: str
    encoding: str
    note: str = ""

    @property
    def shown(self) -> str:
        """The encoding as people write it."""
        return SHOWN.get(self.encoding, self.encoding)


def read_text(path: Path, encoding: str | None = None) -> Text:
    """Return the text of a file; raises BadInput for a missing, binary, too large or foreign file."""
    file = str(path)
    data = _bytes(path, file)
    if foreign := what_it_is(data[:1024]):
        raise BadInput.of(f"this is {foreign}", file=file, line=1)
    found = _stated(data, encoding, file) if encoding else _found(data, file)
    found = _without_zeros_at_end(found)
    if "\x00" in found.text:
        line = found.text.count("\n", 0, found.text.index("\x00")) + 1
        raise BadInput.of("not a text file: it holds NUL characters; export it as CSV text", file=file, line=line)
    return found


def _without_zeros_at_end(found: Text) -> Text:
    """Return a text without the zero bytes that a file system leaves behind the end after a loss of power."""
    text = found.text.rstrip("\x00")
    zeros = len(found.text) - len(text)
    if not zeros or not text or "\x00" in text:
        return found
    said = f"{zeros} zero bytes at the end passed over"
    return replace(found, text=text, note=f"{found.note}; {said}" if found.note else said)


def _bytes(path: Path, file: str) -> bytes:
    """Return the content of a regular file."""
    try:
        if path.exists() and not path.is_file():
            kind = "folder" if path.is_dir() else "device or pipe"
            raise BadInput.of(f"this is a {kind}, no file", file=file)
        if path.is_file() and path.stat().st_size > MAX_BYTES:
            raise BadInput.of(f"larger than {MAX_BYTES // 1_000_000} MB: not a measured curve", file=file)
        return path.read_bytes()
    except FileNotFoundError:
        raise BadInput.of(f"no such file{_sibling(path)}", file=file) from None
    except OSError as error:
        raise BadInput.of(f"cannot be read ({error.strerror})", file=file) from None
    except ValueError:
        raise BadInput.of("no name of a file: it holds a NUL character", file=repr(file)) from None


def _sibling(path: Path) -> str:
    """Name the file in the same folder that was probably meant."""
    return nearest(path.name, [other.name for other in path.parent.iterdir()]) if path.parent.is_dir() else ""


def _stated(data: bytes, encoding: str, file: str) -> Text:
    """Decode as the person said; a byte that does not fit is named."""
    try:
        return Text(data.decode(encoding).removeprefix("\ufeff"), encoding)
    except UnicodeError as error:
        at = getattr(error, "start", 0)
        message = f"is not {encoding}: byte {at + 1} (0x{data[at] if at < len(data) else 0:02x}) does not fit"
        raise BadInput.of(f"{message}; say another encoding or none", file=file, line=_line(data, at)) from None


def _found(data: bytes, file: str) -> Text:
    """Find the encoding: byte order mark, UTF-16 by its zero bytes, UTF-8, else Western European by its bytes."""
    marked = next((name for mark, name in MARKS if data.startswith(mark)), None)
    if marked:
        try:
            return Text(data.decode(marked), marked)
        except UnicodeError:
            raise BadInput.of(f"starts as {SHOWN[marked]} but is damaged; export it again", file=file, line=1) from None
    if wide := _wide(data):
        return Text(data.decode(wide), wide, f"no byte order mark, taken as {wide.upper()} by its zero bytes")
    try:
        return Text(data.decode("utf-8"), "utf-8")
    except UnicodeDecodeError as error:
        return _western(data, error.start, file)


def _wide(data: bytes) -> str:
    """Return utf-16-le or -be when every second byte of an even number of them is zero nearly everywhere, else ''."""
    if len(data) < 8 or len(data) % 2:
        return ""
    for start, name in ((1, "utf-16-le"), (0, "utf-16-be")):
        zeros = data[start::2].count(0)
        if zeros > 0.9 * (len(data) // 2) and data[1 - start :: 2].count(0) == 0:
            try:
                data.decode(name)
            except UnicodeDecodeError:
                return ""
            return name
    return ""


def _western(data: bytes, at: int, file: str) -> Text:
    """Decode text that is not UTF-8; what is binary is refused with the first byte that says so."""
    control = next((i for i, byte in enumerate(data) if byte < 32 and byte not in b"\t\n\r\x0b\x0c\x1a"), None)
    if control is not None:
        message = f"not a text file: byte {control + 1} is 0x{data[control]:02x}; export the numbers as CSV text"
        raise BadInput.of(message, file=file, line=_line(data, control))
    name = _by_its_words(data) or WESTERN
    try:
        text = data.decode(name)
    except UnicodeDecodeError:
        name = _guessed(data)
        text = data.decode(name)
    note = f"byte {at + 1} (0x{data[at]:02x}, line {_line(data, at)}) is not UTF-8, letters taken as {name}"
    return Text(text, name, note)


def _by_its_words(data: bytes) -> str:
    """Return the only encoding of another script under which the start of a file has words of testing, else ''."""
    found = [name for name, words in WORDS.items() if any(word.encode(name) in data[:20_000] for word in words)]
    return found[0] if len(found) == 1 else ""


def _guessed(data: bytes) -> str:
    """Return the likeliest encoding of bytes that are neither UTF-8 nor cp1252; latin-1 takes any byte."""
    from charset_normalizer import from_bytes

    found = from_bytes(data[:20_000]).best()
    try:
        if found is not None:
            data.decode(found.encoding)
            return found.encoding
    except UnicodeDecodeError:
        pass
    return "latin-1"


def _line(data: bytes, at: int) -> int:
    """Return the line (from 1) of a byte."""
    return data.count(b"\n", 0, at) + 1
