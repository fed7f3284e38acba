"""Files that are something else than their name says, named for what they are."""

from __future__ import annotations


ANNEX = "a pointer of git-annex that stands for the file; fetch it with `git annex get`"
SIGNATURES = (
    (b"version https://git-lfs", "a pointer of Git LFS that stands for the file; fetch it with `git lfs pull`"),
    (b"PK\x03\x04", "a zip archive or an Excel workbook; unpack it, or save the sheet as CSV text"),
    (b"\xd0\xcf\x11\xe0", "an old Office file (xls, doc); save the sheet as CSV text"),
    (b"%PDF", "a PDF document; export the numbers themselves"),
    (b"\x1f\x8b", "compressed (gzip); unpack it"),
    (b"BZh", "compressed (bzip2); unpack it"),
    (b"\xfd7zXZ", "compressed (xz); unpack it"),
    (b"7z\xbc\xaf", "a 7z archive; unpack it"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"\x89HDF", "an HDF5 file; export the numbers as CSV text"),
    (b"MATLAB 5.0", "a MATLAB file; export the numbers as CSV text"),
    (b"{\\rtf", "a rich text document; save it as plain text"),
    (b"/annex/objects/", ANNEX),
    (b"[InternetShortcut]", "a shortcut to a web address that stands for the file; download the file itself"),
)
PAGES = (b"<!doctype html", b"<html", b"<head", b"<body", b"<table", b"<title", b"<script")
XML = b"<?xml"


def what_it_is(head: bytes) -> str:
    """Return what a file is whose first kilobyte is `head`, with what to do; '' for none of the known kinds."""
    start = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    for signature, words in SIGNATURES:
        if start.startswith(signature):
            return words
    small = start[:600].lower()
    if small.startswith(b"../") and b".git/annex/objects/" in small:
        return ANNEX
    while small.startswith(b"<!--") and b"-->" in small:
        small = small.partition(b"-->")[2].lstrip()
    if small.startswith(b"<svg") or (small.startswith(XML) and b"<svg" in small):
        return "a drawing (SVG)"
    if small.startswith(PAGES) or (small.startswith(XML) and b"<html" in small):
        return "a web page (HTML), perhaps an error page saved by a download; download the file itself"
    if small.startswith((b'{"', b"{'", b'[{"', b"[[")) or small[:1] + small[1:].lstrip()[:1] == b'{"':
        return "a JSON document; export the numbers as CSV text"
    if small.startswith(XML):
        return "an XML document; export the numbers as text"
    return ""
