"""A loaded program: its memory, its code, and the values of its variables.

    runtime = Runtime(compile_project(files, host), host)
    thread = runtime.thread(pou, task_number=0)
    thread.start()
    thread.run(250_000)        what is left of the nanoseconds

Memory starts as `layout` says (PD-051 to PD-056): a cold start gives all variables their start values, a warm start all
but the retained ones.  An online change keeps the values of all variables that have the same name and type as before.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any, Final, Protocol
from weakref import WeakSet

from fieldrig.coverage import collecting
from fieldrig.coverage.marks import HIT
from fieldrig_devices.iec.carrying import Carrier
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.exceptions import number_of
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.images import Images
from fieldrig_devices.iec.layout import AREA_SIZE, AREAS, INSIDE, STACK_SIZE, Layout, storage
from fieldrig_devices.iec.library.intrinsics import IMPLEMENTATIONS
from fieldrig_devices.iec.lower.names import rules_of
from fieldrig_devices.iec.memory import Memory
from fieldrig_devices.iec.natives import Natives
from fieldrig_devices.iec.program import Link, Located, Pou, Variable
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.thread import Start, Thread
from fieldrig_devices.iec.types import Value
from fieldrig_devices.iec.values import NoTargetError, Values, checked
from fieldrig_devices.languages.resumable import Code

__all__ = ["Runtime", "Start", "Thread"]


MOST_FORCED: Final = 1_000
"""Variables that can be forced at the same time, because all of them are written twice in each cycle."""
_WRONG_KIND: Final = (TypeError, AttributeError)
"""Raised for a value of another type where a pointer or a VAR_IN_OUT refers to a variable of a call that has ended."""


class Fresh(Protocol):
    """Makes a program as it was."""

    def __call__(self, parts: Sequence[range] | None = None) -> None: ...


class Runtime:
    def __init__(self, compiled: Compiled, host: Host, stack_size: int = STACK_SIZE) -> None:
        """`stack_size` is the size of the stack of each thread, in bytes."""
        self._host, self._stack_size = host, stack_size
        self._images = Images()
        self.markers = bytearray(AREA_SIZE)
        """The area %M."""
        self._areas = {"I": host.inputs, "Q": host.outputs, "M": self.markers}
        self._memory = Memory(host, self._areas, self._images, compiled.layout.end)
        self.memory = self._memory.cells
        self._values = Values(self._memory, self._areas, host)
        self._forced: dict[str, tuple[Symbol, Value]] = {}
        self._stops: dict[str, set[int]] = {}
        self.is_preparing = False
        """True while another process prepares the code for breakpoints; until then the program does not stop there."""
        self.threads: WeakSet[Thread] = WeakSet()
        self._use(compiled)
        self.initialise(Start.COLD)

    def __del__(self) -> None:
        if hasattr(self, "code"):  # it was built to its end
            self.code.close()

    def _use(self, compiled: Compiled) -> None:
        self.compiled, self.symbols = compiled, compiled.symbols
        self.is_preparing = False
        lowered = compiled.code
        self._memory.grow(compiled.layout.end)
        self._memory.use_forms(lowered.forms)
        self.natives = Natives(self._host, self._memory, compiled)
        names: dict[str, Any] = {
            **IMPLEMENTATIONS,
            **self._memory.names(),
            **self.natives.names(),
            **{f"image_{number}": cells for number, cells in enumerate(lowered.constants)},
            "now_ms": self._host.now_ms,
        }
        marked = lowered.marked
        if marked.hits:
            collecting.use(marked)
            names[HIT] = marked.hits
        faults = _WRONG_KIND if lowered.keeps_stack_addresses else ()
        self.code = Code(
            lowered.routines,
            names,
            self._stack_size,
            rules_of(len(lowered.constants), has_marks=bool(marked.hits)),
            faults,
            partial(_catch, self._memory.cells),
        )
        self._links = [linked for link in compiled.program.links for linked in self._linked(link)]
        self.routines: Mapping[str, int] = self.code.numbers

    @property
    def contents(self) -> Memory:
        """The memory with the kinds of its cells, for native functions that follow addresses."""
        return self._memory

    # ---- starting

    def initialise(self, kind: Start) -> None:
        """Give variables their start values; a warm start leaves retained ones as they are."""
        kept = self._retained() if kind is Start.WARM else []
        values = [self.read(symbol) for symbol in kept]
        self._memory.free_all()
        for variable in self.compiled.program.globals.values():
            if variable.location is None:
                self._initialise(variable)
        self._initialise_areas()
        for symbol, value in zip(kept, values, strict=True):
            self._values.put(symbol, value)
        self.give_markers()
        self.natives.forget()

    def fresh(self) -> Fresh:
        """Return a function that makes everything as it is now, much faster than `initialise`; for tests.

        It may be given the addresses of the variables that can have changed.  It needs the code that is loaded now, and
        no thread within a cycle.
        """
        memory, areas = self._memory.kept(), {letter: bytes(area) for letter, area in self._areas.items()}

        def again(parts: Sequence[range] | None = None) -> None:
            self._memory.restore(memory, parts)
            for letter, area in areas.items():
                self._areas[letter][:] = area
            self._forced.clear()
            self.natives.forget()

        return again

    def _initialise_areas(self) -> None:
        """Clear the markers, and write the start values of variables with an address, wherever they are declared."""
        self.markers[:] = bytes(len(self.markers))
        program = self.compiled.program
        located = [
            *program.globals.values(),
            *(own for pou in program.pous.values() for own in pou.variables.values()),
        ]
        for variable in located:
            if variable.location is None:
                continue
            cells = self._images.variable(variable)
            if variable.initial is not None or any(cells):
                self._initialise_located(variable, variable.location, cells)

    def _initialise_located(self, variable: Variable, where: Located, cells: Sequence[Value]) -> None:
        if storage(variable.type) is not None:
            self._values.put_area(Symbol(variable.name, variable.name, variable.type, location=where), cells[0])
            return
        for offset, number in enumerate(self._images.kinds(variable.type)):
            if number != INSIDE[0]:
                self._memory.poke(AREAS[where.area] + where.byte + offset, number, cells[offset])

    def _initialise(self, variable: Variable) -> None:
        cells = self._images.variable(variable)
        self._memory.put_image(variable.offset, cells, self._images.kinds(variable.type))

    def restart(self, variable: Variable, base: int) -> None:
        """Give a variable of the instance at an address its start value."""
        self._memory.put_image(
            base + variable.offset, self._images.variable(variable), self._images.kinds(variable.type)
        )

    def thread(self, pou: Pou, task_number: int = 0) -> Thread:
        """Return a thread that runs a program with the stack of a task."""
        thread = Thread(self, pou.name, task_number)
        self.threads.add(thread)
        return thread

    # ---- values

    def find(self, path: str) -> Symbol:
        """Return the symbol with a path; ValueError if there is none."""
        symbol = self.symbols.find(path)
        if symbol is None:
            raise ValueError(f"expected the path of a variable, got {path!r}")
        return symbol

    def read(self, symbol: Symbol) -> Value:
        """Return the value of a symbol; ValueError for a group, and for a VAR_IN_OUT that has not been given."""
        return self._values.read(symbol)

    def write(self, symbol: Symbol, value: Value) -> None:
        """Set a variable; ValueError if it cannot have this value."""
        if not symbol.is_writable:
            raise ValueError(f"{symbol.path} is a constant; expected a variable")
        self._values.put(symbol, checked(value, symbol))

    def force(self, symbol: Symbol, value: Value | None) -> None:
        """Hold a variable at a value: it is written at the start and at the end of each cycle.  None releases it.

        ValueError if it cannot have the value, and for more than MOST_FORCED variables.
        """
        if value is None:
            self._forced.pop(symbol.path.lower(), None)
            return
        if len(self._forced) >= MOST_FORCED and symbol.path.lower() not in self._forced:
            raise ValueError(f"{MOST_FORCED} variables are forced already: expected a release first")
        self.write(symbol, value)
        self._forced[symbol.path.lower()] = (symbol, checked(value, symbol))

    @property
    def forced(self) -> Mapping[str, Value]:
        """The values of forced variables by path."""
        return {symbol.path: value for symbol, value in self._forced.values()}

    def write_forced(self) -> None:
        """Write all forced values; threads call this at both ends of a cycle."""
        for symbol, value in self._forced.values():
            with suppress(NoTargetError):
                self._values.put(symbol, value)

    def _retained(self) -> list[Symbol]:
        return [symbol for symbol in self.symbols.values() if symbol.is_retain and len(symbol.steps) == 1]

    # ---- variables whose instances have different addresses

    def take_inputs(self, pou: str) -> None:
        """Copy %I and %M to the variables that are linked to them, at the start of a cycle of a program."""
        for root, symbol, outside in self._links:
            if root in ("", pou.lower()) and outside.location is not None and outside.location.area != "Q":
                self._values.put(symbol, self._values.read_area(outside))

    def give_outputs(self, pou: str) -> None:
        """Copy the variables that are linked to %Q and %M there, at the end of a cycle of a program."""
        for root, symbol, outside in self._links:
            if root not in ("", pou.lower()) or outside.location is None or outside.location.area == "I":
                continue
            value = self.read(symbol)
            if value != self._values.read_area(outside):
                self._values.put_area(outside, value)

    def give_markers(self) -> None:
        """Copy the variables that are linked to %M there, as they have their start values, or retained ones."""
        for _, symbol, outside in self._links:
            if outside.location is not None and outside.location.area == "M":
                self._values.put_area(outside, self.read(symbol))

    def _linked(self, link: Link) -> Iterator[tuple[str, Symbol, Symbol]]:
        """Yield for each value of a link the program that exchanges it, empty for all programs, and both ends."""
        symbol = self.find(link.path)
        program, root = self.compiled.program, link.path.partition(".")[0].lower()
        root = root if program.dialect.key(root) in program.pous else ""
        outside = replace(symbol, location=link.where)
        for inner, outer in zip(self.symbols.values(symbol), self.symbols.values(outside), strict=True):
            yield root, inner, outer

    # ---- online change

    def change(self, compiled: Compiled) -> None:
        """Go on with another program, compiled with the present layout as `previous`, between two cycles.

        Variables of the same name and type keep their values.  Threads of programs that are no longer there stay ended.
        """
        kept = self._kept(compiled.layout)
        old, old_code, carrier = self.compiled, self.code, Carrier()
        self._use(compiled)
        for name, variable in compiled.program.globals.items():
            if variable.location is None and _has_moved(name, old.layout, compiled.layout):
                self._initialise(variable)
                if name in kept:
                    cells, kinds = kept[name]
                    runs = carrier.runs(old.program.globals[name].type, variable.type)
                    self._memory.put_runs(variable.offset, runs, cells, kinds)
        self._clear_references(old.layout, carrier)
        for thread in self.threads:
            thread.reload()
        old_code.close()
        self._forced = {
            path: (symbol, value)
            for path, (old_symbol, value) in self._forced.items()
            if (symbol := self.symbols.find(path)) is not None and str(symbol.type) == str(old_symbol.type)
        }
        if self.has_breakpoints:
            self.break_at(self._stops)

    def _clear_references(self, old: Layout, carrier: Carrier) -> None:
        """Clear each VAR_IN_OUT whose variable is gone or has another place; the next call gives it again."""
        new = self.compiled.layout
        gone = [
            range(slot.address, slot.address + slot.size)
            for name, slot in old.slots.items()
            if name not in new.slots or _has_moved(name, new, old)
        ]
        if not gone:
            return
        for name, slot in new.slots.items():
            for offset in carrier.references(self.compiled.program.globals[name].type):
                if any(self.memory[slot.address + offset] in cells for cells in gone):
                    self.memory[slot.address + offset] = 0

    def _kept(self, new: Layout) -> dict[str, tuple[Sequence[Value], bytes]]:
        """Return the cells, and their kinds, of the variables that get another place."""
        slots = self.compiled.layout.slots
        return {
            name: self._memory.image(slot.address, slot.size)
            for name, slot in slots.items()
            if name in new.slots and _has_moved(name, new, self.compiled.layout)
        }

    # ---- debugging

    def break_at(self, places: Mapping[str, set[int]]) -> dict[str, set[int]]:
        """Set the breakpoints of all files; return the lines that have an instruction, by file."""
        self._stops = {file: set(lines) for file, lines in places.items()}
        stops: dict[str, set[int]] = {file: set() for file in places}
        for name, number in self.code.numbers.items():
            file = self.compiled.code.files[name]
            lines = self.code.stop_in(number, self._stops.get(file, set()))
            if lines:
                stops[file] |= lines
        self.watch()
        return stops

    def watch(self) -> None:
        """Let the threads stop at the breakpoints, unless these are being prepared."""
        is_watched = not self.is_preparing and any(map(any, self.code.stops))
        for thread in self.threads:
            thread.is_watched = is_watched

    @property
    def has_breakpoints(self) -> bool:
        return any(self._stops.values())


def _catch(cells: list[Value], fault: BaseException, cell: int) -> bool:
    """Put the number of a fault into a cell for __CATCH; false for one that no program can catch."""
    number = number_of(fault)
    if number is not None:
        cells[cell] = number
    return number is not None


def _has_moved(name: str, first: Layout, second: Layout) -> bool:
    """True if a variable has no place or another place in the first layout."""
    slot = first.slots.get(name)
    other = second.slots[name]
    return slot is None or (slot.address, slot.form) != (other.address, other.form)
