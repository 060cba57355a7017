"""Reads mission files, and tells other files that end in `.stl` apart from them."""

from __future__ import annotations

from os import PathLike
from typing import Final

from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError, UsageError
from stlc.inputs import STANDARD, InputError, TooLargeError, read_input
from stlc.source import Source
from stlc.syntax.errors import NotText, TooLarge
from stlc.syntax.screen import MAX_FILE

_UTF16: Final = (b"\xff\xfe", b"\xfe\xff")
_BOM: Final = b"\xef\xbb\xbf"
_MESH_HEADER: Final = 84  # bytes before the first facet of a binary mesh; 50 bytes a facet
_MESH_ADVICE: Final = "stlc reads missions; a mesh of a site can be given as polygons or as GeoJSON"


def read_source(path: str | PathLike[str]) -> Source:
    """The text of a mission file, its name as given; `-` is standard input.

    Raises UsageError if the file can't be opened, MissionError if it isn't UTF-8 text of a
    reasonable size.
    """
    name = "<stdin>" if str(path) == STANDARD else str(path)
    try:
        data = read_input(path, 4 * MAX_FILE)
    except TooLargeError as error:
        span = Source(name, "").span(0, 0)
        mistake = TooLarge(span=span, what="the file", size=error.size, limit=MAX_FILE)
        raise MissionError([mistake]) from None
    except InputError as error:
        raise UsageError(f"cannot read `{name}`: {error}") from None
    return decode(name, data)


def decode(name: str, data: bytes) -> Source:
    """The bytes of a mission file as text. Raises MissionError if they are no UTF-8 text."""
    mistake = _mesh(name, data) or _encoding(name, data)
    if mistake is not None:
        raise MissionError([mistake])
    return Source(name, data.removeprefix(_BOM).decode("utf-8"))


def _mesh(name: str, data: bytes) -> Diagnostic | None:
    """The mistake of a three-dimensional mesh, ASCII or binary, under a mission's name."""
    head = data[:2000].lstrip().lower()
    ascii_mesh = head.startswith(b"solid") and (b"facet" in head or b"endsolid" in head)
    facets = int.from_bytes(data[80:84], "little")
    binary_mesh = len(data) >= _MESH_HEADER and len(data) == _MESH_HEADER + 50 * facets
    if not ascii_mesh and not (binary_mesh and b"\0" in data[:_MESH_HEADER]):
        return None
    source = Source(name, data[:80].split(b"\n")[0].decode("latin-1"))
    span = source.span(0, min(5, len(source.text)))
    reason = "it is a three-dimensional mesh (stereolithography)"
    return NotText(span=span, name=name, reason=reason, advice=_MESH_ADVICE)


def _encoding(name: str, data: bytes) -> Diagnostic | None:
    """The mistake of bytes that aren't UTF-8, at the first of them."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        start = error.start
    else:
        return None
    text = data.decode("utf-8", errors="replace")
    place = len(data[:start].decode("utf-8"))
    advice = "save it as UTF-8"
    if data.startswith(_UTF16):
        advice = "it looks like UTF-16: save it as UTF-8"
    elif b"\0" in data[:2000]:
        advice = "it looks like a binary file"
    span = Source(name, text).span(place, place + 1)
    reason = f"byte {start + 1} (0x{data[start]:02x}) is not UTF-8"
    return NotText(span=span, name=name, reason=reason, advice=advice)
