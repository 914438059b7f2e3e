"""The part of programs that the host implements: native functions and blocks, parameters of objects, and waiting."""

from collections.abc import Callable
from functools import partial
from typing import Any, Final

from fieldrig_devices.iec import memory_functions
from fieldrig_devices.iec.cell_bytes import BY_NUMBER
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.host import Host, NativeBlock, NativeFunction, Pending, Results
from fieldrig_devices.iec.layout import STRING_KIND, WIDE_STRING_KIND, storage
from fieldrig_devices.iec.lower.names import BEGIN, NATIVE
from fieldrig_devices.iec.memory import Memory, limiter
from fieldrig_devices.iec.program import Pou, Variable
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import StringType, Value
from fieldrig_devices.languages.faults import RunError

Waiting = tuple[Pending | None, Callable[[Results], None]]


def ignore(results: Results) -> None:
    """Store nothing."""


NOTHING: Waiting = (None, ignore)
_LIMITS: Final = {number: limiter(kind) for number, kind in BY_NUMBER.items()} | {
    STRING_KIND: limiter(StringType(255)),
    WIDE_STRING_KIND: limiter(StringType(255, is_wide=True)),
}
"""The limiter of a parameter by the number of its type."""


class Natives:
    def __init__(self, host: Host, memory: Memory, compiled: Compiled) -> None:
        self._host, self._memory = host, memory
        self._functions: dict[str, NativeFunction | NativeBlock] = {**memory_functions.natives(memory)}
        for library in host.libraries:
            self._functions |= {**library.functions, **library.blocks}
        self._pous = [compiled.program.pous[name] for name in compiled.code.natives]
        self.wake: Pending | None = None
        """The answer that the running thread waits for; the thread keeps it while others run."""
        self._store: Callable[[Results], None] = ignore

    def forget(self) -> None:
        """Tell all native blocks that their instances begin again."""
        for native in self._functions.values():
            if isinstance(native, NativeBlock):
                native.forget()

    def names(self) -> dict[str, Any]:
        names: dict[str, Any] = {
            "parameter": self._parameter,
            "set_parameter": self._set_parameter,
            "begin_read": lambda address: self._begin(self._host.read_slowly, address),
            "begin_write": lambda address, value: self._begin(self._host.write_slowly, address, value),
            "is_waiting": lambda: self.is_waiting,
            "taken": self._taken,
            "finish": self._finish,
        }
        for number, pou in enumerate(self._pous):
            names[NATIVE.format(number)] = names[BEGIN.format(number)] = self._caller(pou)
        return names

    # ---- calls

    def _caller(self, pou: Pou) -> Callable[[int], None]:
        """Return a function that calls a native POU with its arguments at an address, and stores what it returns."""
        known = self._functions.get(pou.name.lower())
        if known is None:
            return lambda base: _missing(pou.name)
        inputs = [
            variable for variable in pou.variables.values() if variable.section in (Section.INPUT, Section.IN_OUT)
        ]
        outputs = [variable for variable in pou.variables.values() if variable.section is Section.OUTPUT]
        if pou.result is not None:
            outputs = [pou.result, *(variable for variable in outputs if variable is not pou.result)]
        places = [(variable.offset, _cells_of(variable)) for variable in inputs]
        stores = [(variable.offset, limiter(variable.type)) for variable in outputs]
        is_block, cells = isinstance(known, NativeBlock), self._memory.cells

        def store(base: int, results: Results) -> None:
            for (offset, limit), value in zip(stores, results, strict=False):
                cells[base + offset] = limit(value)

        def call(base: int) -> None:
            arguments = [
                cells[base + offset] if size is None else tuple(cells[base + offset : base + offset + size])
                for offset, size in places
            ]
            answer = _asked(known.run, base, *arguments) if is_block else _asked(known.run, *arguments)
            if isinstance(answer, Pending):
                self.wake, self._store = answer, partial(store, base)
            else:
                self.wake = None
                store(base, answer)

        return call

    # ---- waiting

    def _begin(self, ask: Callable[..., Pending], *arguments: Value) -> None:
        self.wake, self._store = _accessed(ask, *arguments), ignore

    @property
    def waiting(self) -> Waiting:
        """The answer that the running thread waits for, and its use; a thread sets it again before it goes on."""
        return self.wake, self._store

    @waiting.setter
    def waiting(self, waiting: Waiting) -> None:
        self.wake, self._store = waiting

    @property
    def is_waiting(self) -> bool:
        return self.wake is not None and not self.wake.is_done

    def _taken(self, number: int) -> Value:
        """Return the value of a parameter that has been read slowly."""
        pending, self.wake = self.wake, None
        if pending is None or not pending.values:
            raise RunError("native", "the parameter could not be read")
        return _LIMITS[number](pending.values[0])

    def _finish(self) -> None:
        """Store the results of a slow call."""
        pending, self.wake = self.wake, None
        if pending is not None:
            self._store(pending.values)

    # ---- parameters

    def _parameter(self, address: int, number: int) -> Value:
        return _LIMITS[number](_accessed(self._host.read, address))

    def _set_parameter(self, address: int, value: Value) -> None:
        _accessed(self._host.write, address, value)


def _cells_of(variable: Variable) -> int | None:
    """Return the number of cells of an argument that is a structure or an array.

    None for a value, and for a VAR_IN_OUT, whose argument is the address.
    """
    if variable.is_reference or storage(variable.type) is not None:
        return None
    return variable.type.size


def _asked(ask: Callable[..., Any], *arguments: Any) -> Any:
    """Call the host; what it refuses is a fault of the program."""
    try:
        return ask(*arguments)
    except ValueError as cause:
        raise RunError("native", str(cause)) from cause


def _accessed(ask: Callable[..., Any], *arguments: Any) -> Any:
    """Access a parameter by the address that the program has computed from its object."""
    try:
        return _asked(ask, *arguments)
    except KeyError as cause:
        raise RunError("pointer", "a reference to no object of the control configuration") from cause


def _missing(name: str) -> None:
    raise RunError("native", f"{name} is not implemented on this controller")
