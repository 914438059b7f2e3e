"""A host at the Simatic S5 DualPort: start-up, and values by name (sections 12.2 to 12.4)."""

from collections.abc import Mapping, Sequence
from typing import Final

from fieldrig_devices.pam.language.ports import PortPlan, PortVariable
from fieldrig_devices.pam.ports.masters.definitions import each_item
from fieldrig_devices.pam.ports.masters.script import Read, Script, Write, read, wait_for
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.simatic.cells import EVEN_BYTE, INDEX_SHIFTS, Place, bit_place, item_place
from fieldrig_devices.pam.runtime.item import Value

PAM_TIMEOUT_NS: Final = 200_000_000
"""Time after which a PAM that leaves WATCH_DOG at FFh is dead (PAMS-093)."""
CYCLE_NS: Final = 10_000_000
"""Cycle of the PLC's program, in which it serves the watchdog."""
MOST_ENTRIES: Final = 128


class S5Master:
    def __init__(self, plan: PortPlan, options: PortOptions | None = None, patience_ns: int = 5_000_000_000) -> None:
        """`plan` is the DUAL_PORT of the application; `patience_ns` limits each wait for the PAM."""
        self._patience_ns = patience_ns
        self._shift = INDEX_SHIFTS[(options or PortOptions()).fifo_index_byte]
        self._variables = {variable.name: variable for variable in plan.variables}
        self._pam_ready, self._dualport_ready, self._host_ready = (
            bit_place(*plan.numbers(name)) for name in ("PAM_READY", "DUALPORT_READY", "HOST_READY")
        )
        self._watch_dog = plan.numbers("WATCH_DOG")[0] // 2
        self._fifos = {
            name: [plan.numbers(f"{name}_{part}")[0] // 2 for part in ("START", "HEAD", "TAIL")]
            for name in ("FIFO_IN", "FIFO_OUT")
        }
        self._cells: dict[int, list[tuple[Place, PortVariable, int]]] = {}
        for variable in plan.outputs:
            for index in range(variable.number):
                place = item_place(variable, index)
                self._cells.setdefault(place.cell, []).append((place, variable, index))
        self._missed = 0
        self.values: dict[str, list[Value]] = {
            variable.name: [False if variable.kind == "FLAG_VAR" else 0] * variable.number
            for variable in plan.variables
        }
        """The last values of all variables, by name and item."""

    def start_up(self, initial: Mapping[str, Value | Sequence[Value]] | None = None) -> Script[None]:
        """Bring the PAM to its application.  Inputs without an initial value begin with 0."""
        self._missed = 0
        yield from self._set(self._pam_ready, False)
        for _ in range(2):
            yield from self._wait(self._pam_ready, "PAM_READY")
            yield from self._set(self._pam_ready, False)
        given = initial or {}
        for variable in self._variables.values():
            if variable.is_input:
                for _, index, value in each_item(variable, given.get(variable.name, 0)):
                    yield from self._store(variable, index, value)
        yield from self._set(self._host_ready, True)
        yield from self._wait(self._dualport_ready, "DUALPORT_READY")

    def put(self, name: str, value: Value, index: int = 0) -> Script[bool]:
        """Change an input, and announce a word.  Return False if the FIFO has no room for that now."""
        variable = self._variables[name]
        yield from self._store(variable, index, value)
        if variable.kind == "FLAG_VAR":
            return True
        start, head_cell, tail_cell = self._fifos["FIFO_IN"]
        head = yield from self._index(head_cell)
        tail = yield from self._index(tail_cell)
        following = _following(head, start, head_cell)
        if following == tail:
            return False
        yield Write(start + head // 2, (item_place(variable, index).address,))
        yield Write(head_cell, (following << self._shift,))
        return True

    def take(self) -> Script[list[tuple[str, int, Value]]]:
        """Read the output FIFO and the cells in it; return the changes as name, item and value."""
        start, head_cell, tail_cell = self._fifos["FIFO_OUT"]
        head = yield from self._index(head_cell)
        tail = yield from self._index(tail_cell)
        changes: list[tuple[str, int, Value]] = []
        while head != tail:
            address = yield from read(start + tail // 2)
            tail = _following(tail, start, head_cell)
            yield Write(tail_cell, (tail << self._shift,))
            word = yield from read(address // 2)
            for place, variable, index in self._cells.get(address // 2, ()):
                value: Value = bool(word & place.mask) if variable.kind == "FLAG_VAR" else _signed(word)
                if value != self.values[variable.name][index]:
                    self.values[variable.name][index] = value
                    changes.append((variable.name, index, value))
        return changes

    def watch(self) -> Script[bool]:
        """Serve the watchdog; call it once per cycle of the PLC.  Return False if the PAM is dead."""
        value = yield from read(self._watch_dog)
        if value & EVEN_BYTE:
            self._missed += 1
        else:
            self._missed = 0
            yield Write(self._watch_dog, (value | EVEN_BYTE,))
        return self._missed * CYCLE_NS <= PAM_TIMEOUT_NS

    def _index(self, cell: int) -> Script[int]:
        """Read HEAD or TAIL."""
        return (yield from read(cell)) >> self._shift & EVEN_BYTE

    def _store(self, variable: PortVariable, index: int, value: Value) -> Script[None]:
        place = item_place(variable, index)
        if variable.kind == "FLAG_VAR":
            yield from self._set(place, bool(value))
        else:
            yield Write(place.cell, (int(value) & 0xFFFF,))
        self.values[variable.name][index] = value

    def _set(self, place: Place, value: bool) -> Script[None]:
        (word,) = yield Read(place.cell)
        yield Write(place.cell, (word | place.mask if value else word & ~place.mask,))

    def _wait(self, place: Place, what: str) -> Script[None]:
        yield from wait_for(place.cell, lambda word: bool(word & place.mask), what, self._patience_ns)


def _following(index: int, start: int, head: int) -> int:
    return index + 2 if index + 2 < 2 * (head - start) else 0


def _signed(word: int) -> int:
    return word - 0x1_0000 if word & 0x8000 else word
