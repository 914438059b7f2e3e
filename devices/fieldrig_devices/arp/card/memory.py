"""The card's flash: parameters, the program, and sections for other parts.

Source: manual 2.1, 2.3, 5; digest chapter 10 (E03, W04).  The content is one readable JSON text.  If neither the newest
nor the previous version is usable, the card reports E03; nothing overwrites them until a value is saved, which writes
the complete content.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from fieldrig.outside.untrusted import field as field_of
from fieldrig.outside.untrusted import read_json, typed
from fieldrig.storage import store_format
from fieldrig.storage.store import Part, Store, StoreError, restore
from fieldrig_devices.arp.parameters import PARAMETERS, Parameters, defaults

_VERSION: Final = 1


class MemoryFaultError(Exception):
    """The memory cannot be read or written: E03."""

    def __init__(self, what: str, errno: int | None = None) -> None:
        super().__init__(what)
        self.errno = errno


@dataclass
class Content:
    parameters: list[list[int]] = field(default_factory=lambda: [defaults(group) for group in range(len(PARAMETERS))])
    parameters_mark: str = ""
    """Checksum of the values from the rig file that were last put into `parameters`."""
    program: str = ""
    """The object file; empty if there is none."""
    program_mark: str = ""
    """Checksum of the file that was last put into `program`."""
    sections: dict[str, bytes] = field(default_factory=dict)


class Memory:
    def __init__(self, store: Store) -> None:
        self._store = store
        self.content = Content()
        self.answers: Callable[[], bool] = lambda: True
        """Returns whether the memory answers, which a fault can prevent."""

    def read(self) -> bool:
        """Read `content` from the store.  False, with `content` unchanged, if nothing was ever saved.

        Raises MemoryFaultError if no version of it is usable.
        """
        self._look_whether_it_answers()
        restored = restore(self._store, _decode)
        if restored.content is None and restored.is_damaged:
            raise MemoryFaultError("the stored data are damaged")
        if restored.content is not None:
            self.content = restored.content
        return restored.content is not None

    def write(self) -> None:
        """Save `content`.  Raises MemoryFaultError if the store fails."""
        self._look_whether_it_answers()
        try:
            self._store.save(_encode(self.content))
        except StoreError as cause:
            raise MemoryFaultError(f"the store cannot be written: {cause.strerror}", cause.errno) from cause

    def _look_whether_it_answers(self) -> None:
        if not self.answers():
            raise MemoryFaultError("the memory does not answer")

    def section(self, name: str, on_fault: Callable[[], None]) -> Store:
        """Return a section of the memory as a store for a part of the card."""
        return _Section(self, name, on_fault)


class _Section(Part):
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
            raise StoreError(cause.errno, str(cause)) from cause

    def buffered_ram(self, size: int) -> memoryview:
        raise NotImplementedError("the card's RAM holds its variables")


def _encode(content: Content) -> bytes:
    return json.dumps(
        {
            "version": _VERSION,
            "parameters": [table[1:] for table in content.parameters],
            "parameters_mark": content.parameters_mark,
            "program": content.program,
            "program_mark": content.program_mark,
            "sections": {name: data.hex() for name, data in sorted(content.sections.items())},
        }
    ).encode()


def _decode(data: bytes) -> Content:
    """Decode the output of `_encode`.  Raises ValueError for any other data."""
    fields = read_json(data, store_format.LONGEST)
    if (version := field_of(fields, "version", int)) != _VERSION:
        raise ValueError(f"it has version {version}, expected {_VERSION}")
    tables = field_of(fields, "parameters", list)
    if len(tables) != len(PARAMETERS):
        raise ValueError(f"there are {len(tables)} groups of parameters, expected {len(PARAMETERS)}")
    return Content(
        parameters=[_table(group, values) for group, values in enumerate(tables)],
        parameters_mark=field_of(fields, "parameters_mark", str),
        program=field_of(fields, "program", str),
        program_mark=field_of(fields, "program_mark", str),
        sections={
            name: bytes.fromhex(typed(text, str, name)) for name, text in field_of(fields, "sections", dict).items()
        },
    )


def _table(group: int, values: Any) -> list[int]:
    if len(typed(values, list, f"group {group}")) != len(PARAMETERS[group]):
        raise ValueError(f"group {group} has {len(values)} parameters, expected {len(PARAMETERS[group])}")
    for number, raw in enumerate(values, 1):
        if type(raw) is not int or not Parameters.takes(group, number, raw):
            raise ValueError(f"parameter {number} of group {group} cannot be {raw!r}")
    return [0, *values]
