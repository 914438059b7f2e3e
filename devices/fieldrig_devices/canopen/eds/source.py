"""An EDS or DCF file line by line, without corrections or losses, for the checks and the writer.

Source: CiA 306-1 4.2 and 4.3.
"""

import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

NUMBER = re.compile(r"[+-]?0x[0-9a-f]+|[+-]?\d+", re.IGNORECASE)
OBJECT = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?", re.IGNORECASE)
NODE_ID = "$NODEID"


class Entry(NamedTuple):
    line: int
    key: str
    value: str


class Section:
    """One section.  `entries` has the first entry of each key, by key in lower case."""

    def __init__(self, name: str, line: int) -> None:
        self.name, self.line = name, line
        self.entries: dict[str, Entry] = {}
        self.repeated: list[Entry] = []

    @property
    def every(self) -> list[Entry]:
        """All entries; where a key is repeated, the later entry comes last."""
        return [*self.entries.values(), *self.repeated]

    def add(self, entry: Entry) -> None:
        if entry.key.lower() in self.entries:
            self.repeated.append(entry)
        else:
            self.entries[entry.key.lower()] = entry

    def get(self, key: str) -> str:
        """Return the value of a key, or "" if it is missing."""
        entry = self.entries.get(key.lower())
        return "" if entry is None else entry.value

    def number(self, key: str) -> int | None:
        """Return the number at a key, or None if there is none."""
        try:
            return parse_number(self.get(key))
        except ValueError:
            return None

    def line_of(self, key: str) -> int:
        entry = self.entries.get(key.lower())
        return self.line if entry is None else entry.line


class EdsSource:
    """The sections of a file.  `sections` has the first of each name, in lower case; `strays` are unreadable lines."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines = decode(path.read_bytes()).splitlines()
        self.sections: dict[str, Section] = {}
        self.repeated: list[Section] = []
        self.every: list[Section] = []
        """All sections in the order of the file."""
        self.strays: list[tuple[int, str]] = []
        section: Section | None = None
        for number, raw in enumerate(self.lines, start=1):
            text = raw.strip()
            if not text or text.startswith(";"):
                continue
            if text.startswith("["):
                text = _without_comment(text)
            if text.startswith("[") and text.endswith("]"):
                section = self._open(Section(text[1:-1].strip(), number))
            elif "=" in text and section is not None:
                key, _, value = text.partition("=")
                section.add(Entry(number, key.strip(), _without_comment(value)))
            else:
                self.strays.append((number, text))

    def _open(self, section: Section) -> Section:
        self.every.append(section)
        if section.name.lower() in self.sections:
            self.repeated.append(section)
        else:
            self.sections[section.name.lower()] = section
        return section

    def get(self, name: str) -> Section | None:
        return self.sections.get(name.lower())

    def objects(self) -> Iterator[tuple[int, int | None, Section]]:
        """Yield index, sub-index (None for the object itself) and section, in the order of the file."""
        for section in self.sections.values():
            match = OBJECT.fullmatch(section.name)
            if match is not None:
                yield int(match[1], 16), None if match[2] is None else int(match[2], 16), section


def _without_comment(value: str) -> str:
    return re.split(r"\s;", value, maxsplit=1)[0].strip()


def parse_number(text: str) -> int:
    """Parse a number: decimal, hex with 0x, or octal with a leading 0 (CiA 306-1 4.2).  Raises ValueError otherwise.

    Some makers of drives write limits such as -0x80000000, so hex may have a sign as well.
    """
    text = text.strip()
    if not NUMBER.fullmatch(text):
        raise ValueError(f"{text!r} is not a number")
    digits = text.lstrip("+-")
    if digits.startswith("0") and digits.isdigit() and digits.strip("0"):
        return int(digits, 8) * (-1 if text.startswith("-") else 1)
    return int(text, 16 if digits[:2].lower() == "0x" else 10)


def decode(data: bytes) -> str:
    """Return the text in the encoding that its first bytes or its letters show."""
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def evaluate(text: str, node_id: int) -> int:
    """Evaluate a number that may contain `$NODEID`.  Raises ValueError for anything else."""
    total = 0
    for part in text.split("+"):
        part = part.strip()
        total += node_id if part.upper() == NODE_ID else parse_number(part)
    return total


def has_node_id(text: str) -> bool:
    return NODE_ID in text.upper()
