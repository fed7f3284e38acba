"""YAML as editors, other programs and attackers write it: what is read, and the one message for what is not."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from etextile.errors import BadInput
from etextile.units import to_number
from loadcases.reader import load_case


SOON_S = 2.5
"""Seconds of processor, most of them for loading the library of units; what has no bound took 5 to 17."""
HEAD = "schema_version: 1\nextends: punch\n"
LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]\n" for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
REFUSED: dict[str, tuple[str | bytes, str]] = {
    "tab in the indentation": (f"{HEAD}fabric:\n\tcoarsening: 40\n", "4:1: a tab in the indentation"),
    "tab behind a value": (f"{HEAD}title: x\t\n", "3:9: a tab (got 'title: x'), write spaces"),
    "merge key": (f"{HEAD}motion:\n  <<: {{total: 20}}\n", "4:3: motion.<<: merge keys are not part of YAML 1.2"),
    "unknown alias": (f"{HEAD}motion: {{total: *nope}}\n", "3:17: not YAML: found undefined alias 'nope'"),
    "alias of itself": (f"{HEAD}title: &a [*a]\n", "3:8: title.0: this alias holds itself"),
    "billion laughs": (LAUGHS + HEAD, "too much nested data"),
    "key twice": (f"{HEAD}motion: {{total: 20, total: 30}}\n", "3:21: motion.total: this key stands twice"),
    "decimal comma": (f"{HEAD}motion: {{total: '0,5 mm'}}\n", "decimal comma (got '0,5 mm'), write a point: '0.5 mm'"),
    "thousands or decimals": (f"{HEAD}motion: {{total: '1,000 mm'}}\n", "write '1000 mm' or '1.000 mm'"),
    "comma in braces": (f"{HEAD}motion: {{total: 9,5 mm}}\n", "5 mm: unknown key"),
    "on": (f"{HEAD}contact: {{friction: on}}\n", "3:21: contact.friction: not a friction (got 'on')"),
    "date": (f"{HEAD}motion: {{total: 2026-01-01}}\n", "motion.total: not a number followed by a unit"),
    "underscore": (f"{HEAD}motion: {{steps: 1_0}}\n", "3:17: motion.steps: underscores in a number (got '1_0')"),
    "underscore and unit": (f"{HEAD}motion: {{total: 1_0 mm}}\n", "motion.total: underscores in a number"),
    "digits of another script": (f"{HEAD}motion: {{total: ٢٠ mm}}\n", "motion.total: digits of another script"),
    "unit of a typing error": (f"{HEAD}motion: {{total: 20 mmm}}\n", "motion.total: unknown unit (got '20 mmm')"),
    "two documents": (f"{HEAD}---\ntitle: b\n", "3:1: more than one YAML document"),
    "UTF-16": (HEAD.encode("utf-16"), "1: saved as UTF-16 or UTF-32"),
    "UTF-16 without a mark": (HEAD.encode("utf-16-le"), "1: saved as UTF-16 or UTF-32"),
    "Latin-1": (f"{HEAD}title: Prüfung\n".encode("latin-1"), "3:10: not UTF-8 text (got byte 0xfc)"),
    "NUL": (f"{HEAD}title: a\0b\n", "3:9: a character that no text file holds (U+0000)"),
    "bell": (f"{HEAD}title: a\x07b\n", "3:9: a character that no text file holds (U+0007)"),
    "object of Python": (f"{HEAD}title: !!python/object:os.system x\n", "python/object:os.system is not allowed"),
    "tag of its own": (f"{HEAD}title: !foo x\n", "3:8: title: the tag !foo is not allowed"),
    "tag that does not fit": (f"{HEAD}motion: {{steps: !!int abc}}\n", "yaml.org,2002:int does not fit (got 'abc')"),
    "no number with a tag": (f"{HEAD}motion: {{total: !!float abc}}\n", "yaml.org,2002:float does not fit"),
    "no truth with a tag": (f"{HEAD}title: !!bool abc\n", "yaml.org,2002:bool does not fit"),
    "list as a key": (f"{HEAD}? [a, b]\n: 2\n", "3:3: a list or mapping cannot be a key"),
    "key without end": (f"{HEAD}{'k' * 5000}: 1\n", "not YAML: a key of more than 1024 characters"),
    "key with a mark that has no width": (f"{HEAD}mo\u200btion: {{}}\n", r"3:1: mo\u200btion: unknown key"),
    "digits without end": (f"{HEAD}motion: {{steps: {'9' * 4300}}}\n", "3:17: motion.steps: a number of 4300 digits"),
    "brackets without end": (f"{HEAD}title: {'[' * 5000}\n", "nested too deeply"),
    "values without end": (HEAD + "".join(f"x{i}: 1\n" for i in range(60_000)), "at most 20000 are read"),
    "bytes without end": (f"{HEAD}# {'x' * 1_000_000}", "bytes are too many for such a file"),
    "page": ("<!DOCTYPE html><html>404</html>", "1: this is a web page (HTML)"),
    "pointer": ("version https://git-lfs.github.com/spec/v1\noid sha256:00\n", "1: this is a pointer of Git LFS"),
    "archive": (b"PK\x03\x04" + b"x" * 300, "1: this is a zip archive"),
    "words of a merge": (f"{HEAD}<<<<<<< HEAD\ntitle: a\n=======\n", "not YAML"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_a_file_is_refused_in_time_with_its_place_and_the_remedy(tmp_path: Path, kind: str) -> None:
    content, message = REFUSED[kind]
    path = tmp_path / "case.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    start = time.process_time()
    with pytest.raises(BadInput, match=r"case\.yaml") as caught:
        load_case(path)
    assert time.process_time() - start < SOON_S
    assert any(message in str(problem) for problem in caught.value.problems), caught.value


READ = {
    "mark of the order of bytes": f"\ufeff{HEAD}title: x\n",
    "line ends of Windows": f"{HEAD}title: x\n".replace("\n", "\r\n"),
    "JSON": '{\n\t"schema_version": 1, "extends": "punch", "title": "x"}',
    "version": f"%YAML 1.2\n---\n{HEAD}title: x\n",
    "tag of a text": f"{HEAD}title: !!str x\n",
    "anchor": f"{HEAD}title: &a x\n",
}


@pytest.mark.parametrize("kind", READ)
def test_other_ways_to_write_the_same_are_read(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "case.yaml"
    path.write_bytes(READ[kind].encode())
    assert load_case(path).case.title == "x"


def test_many_unknown_keys_are_told_in_time(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(HEAD + "".join(f"x{i}: 1\n" for i in range(1000)))
    start = time.process_time()
    with pytest.raises(BadInput):
        load_case(path)
    assert time.process_time() - start < SOON_S


def test_a_number_is_written_in_ascii_digits_with_a_point() -> None:
    assert to_number("1e-3", "mm") == 1e-3
    for text in ("1_000 mm", "٢ mm", "2\u00b2 mm", "1,000,000 mm", "1.000,5 mm", "0x10 mm", "--2 mm"):
        with pytest.raises(ValueError, match="got"):
            to_number(text, "mm")
