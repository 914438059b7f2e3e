"""The source texts of the programs in a card, for the debugging service.

A card keeps an object: canonical text without comments, with every name replaced.  The text that people wrote is known
only for a program that the rig file names or that came through the debugging service; its object tells whether it is
the one in the card.  The names that EQU defines are found by compiling it, beside the card.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from fieldrig.loop.background import Report
from fieldrig.text.source_text import decoded
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.language.files import encode, system_of
from fieldrig_devices.arp.language.loading import NS_PER_OCTET, Unusable
from fieldrig_devices.arp.language.printer import argument_text
from fieldrig_devices.languages.mistakes import CompileError

_HEAD: Final = re.compile(rb"ARP OBJECT \d+ SYSTEM (\d\d) NAME ([A-Za-z0-9_-]+)")


@dataclass(frozen=True, slots=True)
class SourceText:
    """A source file; `equs` are the meanings of its names, once they are known."""

    name: str
    text: str
    equs: dict[str, str] = field(default_factory=dict)

    @property
    def stem(self) -> str:
        return Path(self.name).stem

    @property
    def duration_ns(self) -> int:
        """Virtual time that compiling takes."""
        return NS_PER_OCTET * len(self.text)


@dataclass(frozen=True, slots=True)
class Prepared:
    """The result of a compilation: the object file, and the meanings of the names."""

    data: bytes
    equs: dict[str, str]


def prepare(argument: tuple[SourceText, int], report: Report) -> Prepared | Unusable:
    """Compile a source for the card with this number, in a process beside it."""
    source, number = argument
    report("compiling", 0, 1)
    try:
        compiled = compile_text(source.text)
    except CompileError as wrong:
        lines = [f"{source.name}:{mistake}" for mistake in wrong.mistakes if not mistake.is_note]
        return Unusable("\n".join(lines))
    equs = {name: argument_text(meaning) for name, meaning in compiled.symbols.equs.items()}
    return Prepared(encode(compiled, source.stem, number), equs)


def of_file(path: Path | None) -> SourceText | None:
    """The source that a rig file names; None for an object."""
    if path is None or system_of(path) is None:
        return None
    return SourceText(path.name, decoded(path.read_bytes()))


def of_object(data: bytes) -> SourceText:
    """The text of an object, each line at its number in the source."""
    head = _HEAD.match(data)
    name = f"{head[2].decode()}.D{head[1].decode()}" if head is not None else "program"
    lines: dict[int, str] = {}
    for line in data.decode(errors="replace").splitlines()[1:-1]:
        number, _, text = line.partition(" ")
        lines[int(number)] = text
    text = "\n".join(lines.get(number, "") for number in range(1, max(lines, default=0) + 1))
    return SourceText(name, f"{text}\n")
