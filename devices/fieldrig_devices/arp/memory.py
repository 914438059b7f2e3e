"""The card's flash: parameters, the program, and sections that other parts keep.

Source: manual 2.1, 2.3, 5; digest chapter 10 (E03, W04).  One JSON text, so that a person can read it, with a CRC over
all in its last line.  What can't be read for whatever reason is E03; nothing is written over it until somebody saves
something, which writes all of it anew.
"""

import json
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from fieldrig.store import Store
from fieldrig_devices.arp.parameters import PARAMETERS, Parameters, defaults

_VERSION: Final = 1


class MemoryFaultError(Exception):
    """The memory can't be read or written: E03."""


@dataclass
class Content:
    parameters: list[list[int]] = field(default_factory=lambda: [defaults(group) for group in range(len(PARAMETERS))])
    parameters_mark: str = ""
    """Of the values in the rig file that were put into `parameters` last."""
    program: str = ""
    """The object file; empty: none."""
    program_mark: str = ""
    """Of the file that was put into `program` last."""
    sections: dict[str, bytes] = field(default_factory=dict)


class Memory:
    def __init__(self, store: Store) -> None:
        self._store = store
        self.content = Content()

    def read(self) -> bool:
        """Take `content` from the store; False, with `content` as it was, if nothing was ever saved there.

        MemoryFaultError if it can't be read, or is damaged.
        """
        try:
            data = self._store.load()
            if data is None:
                return False
            self.content = _decode(data)
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as cause:
            raise MemoryFaultError(f"what is stored can't be used: {cause}") from cause
        return True

    def write(self) -> None:
        """Keep `content`.  MemoryFaultError if the store can't."""
        try:
            self._store.save(_encode(self.content))
        except OSError as cause:
            raise MemoryFaultError(f"the store can't be written: {cause}") from cause

    def section(self, name: str, on_fault: Callable[[], None]) -> Store:
        """A part of the memory for a part of the card, which sees it as a store of its own."""
        return _Section(self, name, on_fault)


class _Section:
    def __init__(self, memory: Memory, name: str, on_fault: Callable[[], None]) -> None:
        self._memory, self._name, self._on_fault = memory, name, on_fault

    def load(self) -> bytes | None:
        return self._memory.content.sections.get(self._name)

    def save(self, data: bytes) -> None:
        content = self._memory.content
        before, content.sections = content.sections, {**content.sections, self._name: data}
        try:
            self._memory.write()
        except MemoryFaultError as cause:
            content.sections = before
            self._on_fault()
            raise OSError(str(cause)) from cause

    def buffered_ram(self, size: int) -> memoryview:
        raise NotImplementedError("the card's RAM holds its variables")


def _encode(content: Content) -> bytes:
    body = json.dumps(
        {
            "version": _VERSION,
            "parameters": [table[1:] for table in content.parameters],
            "parameters_mark": content.parameters_mark,
            "program": content.program,
            "program_mark": content.program_mark,
            "sections": {name: data.hex() for name, data in sorted(content.sections.items())},
        }
    ).encode()
    return body + f"\nCRC {zlib.crc32(body):08X}\n".encode()


def _decode(data: bytes) -> Content:
    """ValueError and the like for anything that `_encode` doesn't write."""
    body, _, check = data.rpartition(b"\nCRC ")
    if check.rstrip() != f"{zlib.crc32(body):08X}".encode():
        raise ValueError("the CRC is missing or wrong")
    fields: Any = json.loads(body)
    if fields["version"] != _VERSION:
        raise ValueError(f"it is of version {fields['version']}")
    tables = fields["parameters"]
    if len(tables) != len(PARAMETERS):
        raise ValueError(f"there are {len(tables)} groups of parameters")
    program = str(fields["program"])
    program.encode()  # JSON can hold what no text file can
    return Content(
        parameters=[_table(group, values) for group, values in enumerate(tables)],
        parameters_mark=str(fields["parameters_mark"]),
        program=program,
        program_mark=str(fields["program_mark"]),
        sections={str(name): bytes.fromhex(text) for name, text in fields["sections"].items()},
    )


def _table(group: int, values: Any) -> list[int]:
    if len(values) != len(PARAMETERS[group]):
        raise ValueError(f"group {group} has {len(values)} parameters")
    for number, raw in enumerate(values, 1):
        if type(raw) is not int or not Parameters.takes(group, number, raw):
            raise ValueError(f"parameter {number} of group {group} can't be {raw!r}")
    return [0, *values]
