"""The files of an ARP program: NAME.I01 is compiled to .D01, .E01, .M01, .O01 and .S01.

Source: manual 5.2.  The two digits are the system's communication address, so that no program reaches the wrong card.
WinAxis' formats are not published; these are ours:

    .D  object in ASCII: the program in canonical form, each name replaced by its meaning, each line with its number in
        the source, and a CRC over everything.  A card loads it by compiling it again, so no object has to be trusted
    .O  the same object, compressed, with a header
    .E  mistakes and notes, one per line: LINE:COLUMN: what is wrong; expected ...
    .M  routines and labels with their lines
    .S  names and their meanings
"""

import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fieldrig.loop.background import Report
from fieldrig_devices.arp.language.compiler import Compiled, compile_lines
from fieldrig_devices.arp.language.printer import argument_text, routine_lines
from fieldrig_devices.languages.mistakes import CompileError

HIGHEST_SYSTEM: Final = 99  # two digits
LONGEST_OBJECT_LINE: Final = 4_000
LARGEST_OBJECT: Final = 1_000_000  # bytes
BINARY: Final = struct.Struct(">4sBBII")  # "ARPO", version, system, length and CRC of the text
_VERSION: Final = 1
_HEAD: Final = re.compile(r"ARP OBJECT (\d+) SYSTEM (\d\d) NAME ([A-Za-z0-9_-]+)", re.ASCII)
_LINE: Final = re.compile(r"(\d{1,7}) (.+)", re.ASCII)


class ObjectError(Exception):
    """A file that is not an object, or is damaged."""


@dataclass(frozen=True, slots=True)
class ArpObject:
    name: str
    system: int
    compiled: Compiled


def encode(compiled: Compiled, name: str, system: int) -> bytes:
    """Encode the object file, .Dnn."""
    head = f"ARP OBJECT {_VERSION} SYSTEM {system:02} NAME {re.sub('[^A-Za-z0-9_-]', '_', name) or '_'}"
    lines = [f"{number} {text}" for routine in compiled.program.routines for number, text in routine_lines(routine)]
    body = "".join(f"{line}\n" for line in [head, *lines]).encode()
    return body + f"CRC {zlib.crc32(body):08X}\n".encode()


def decode(data: bytes, report: Report = lambda _what, _done, _steps: None) -> ArpObject:
    """Decode an object file.  Raises ObjectError, which says what is wrong, if the data are not an object.

    `report` is called with the number of lines that have been read.
    """
    if len(data) > LARGEST_OBJECT:
        raise ObjectError(f"{len(data)} bytes are more than an object may have")
    body, mark, check = data.rpartition(b"CRC ")
    if not mark or check.rstrip() != f"{zlib.crc32(body):08X}".encode():
        raise ObjectError("the CRC is missing or wrong: the object is damaged")
    try:
        head, *lines = body.decode("utf-8").split("\n")[:-1] or [""]
    except UnicodeDecodeError as cause:
        raise ObjectError("the object is no text") from cause
    match = _HEAD.fullmatch(head)
    if match is None or int(match[1]) != _VERSION:
        raise ObjectError(f"this is no object of version {_VERSION}: {head[:60]!r}")
    try:
        return ArpObject(match[3], int(match[2]), compile_lines(_numbered(lines, report), LONGEST_OBJECT_LINE))
    except CompileError as cause:
        raise ObjectError(f"the object holds no program: {cause.mistakes[0]}") from cause


def _numbered(lines: list[str], report: Report) -> Iterator[tuple[int, str]]:
    for index, line in enumerate(lines):
        report("reading", index, len(lines))
        match = _LINE.fullmatch(line)
        if match is None:
            raise ObjectError(f"a line of the object has no number: {line[:60]!r}")
        yield int(match[1]), match[2]
    report("checking", 0, 1)


def binary(text: bytes, system: int) -> bytes:
    """Encode the binary object, .Onn, from the ASCII object."""
    return BINARY.pack(b"ARPO", _VERSION, system, len(text), zlib.crc32(text)) + zlib.compress(text, 9)


def map_text(compiled: Compiled) -> str:
    rows = []
    for routine in compiled.program.routines:
        role = "interrupt" if routine.is_interrupt else "main" if routine.name == compiled.main else "subprogram"
        rows.append(f"{routine.number:>5} {routine.end_number:>5}  {role:<10}  {routine.name}")
        rows += (
            f"{line.number:>5}        label       {line.label}" for line in routine.lines if line.label is not None
        )
    return "".join(f"{row}\n" for row in rows)


def symbols_text(compiled: Compiled) -> str:
    symbols = compiled.symbols
    rows = {name: argument_text(meaning) for name, meaning in symbols.equs.items()}
    rows |= {name: f"label of {routine}" for name, routine in symbols.labels.items()}
    rows |= dict.fromkeys(symbols.routines, "routine")
    return "".join(f"{name:<20} {rows[name]}\n" for name in sorted(rows))


def outputs(compiled: Compiled, name: str, system: int) -> dict[str, bytes]:
    """Files that a successful compilation writes, by their letter."""
    text = encode(compiled, name, system)
    notes = "".join(f"{note}\n" for note in compiled.notes)
    return {
        "D": text,
        "E": f"{notes}0 mistakes\n".encode(),
        "M": map_text(compiled).encode(),
        "O": binary(text, system),
        "S": symbols_text(compiled).encode(),
    }


def failed(wrong: CompileError) -> dict[str, bytes]:
    """Files that a failed compilation writes, by their letter."""
    count = sum(not mistake.is_note for mistake in wrong.mistakes)
    return {"E": f"{wrong}\n{count} mistake{'s' if count > 1 else ''}\n".encode()}


def system_of(path: Path) -> int | None:
    """System address in the name of a source file, NAME.Inn, or None if the name has no address."""
    match = re.fullmatch(r"\.I(\d\d)", path.suffix, re.IGNORECASE | re.ASCII)
    return int(match[1]) if match is not None else None
