"""The side of a controller that its programs see: objects, native functions and blocks, areas of I/O.

A library is IEC source text.  A POU in it whose body is the pragma {native} is implemented by the host under the same
name; everything else in it is compiled like the user's text.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectType, Value


class Pending:
    """The answer of something that takes time, such as a SERCOS parameter or a file.  The calling task waits for it."""

    def __init__(self) -> None:
        self.is_done = False
        self.values: tuple[Value, ...] = ()
        """The result first if there is one, then the outputs in the order of their declaration."""
        self.on_done: Callable[[], None] = lambda: None

    def finish(self, *values: Value) -> None:
        if not self.is_done:
            self.is_done, self.values = True, values
            self.on_done()


Results = tuple[Value, ...]


@dataclass(frozen=True, slots=True)
class NativeFunction:
    """Called with its inputs in the order of declaration; returns the result, then its outputs.

    A slow one returns a Pending instead and holds the calling task up.  Strings are Latin-1, times are in ms.
    """

    run: Callable[..., Results | Pending]
    cost_ns: int = 1_000
    """Processor time of a call."""
    is_slow: bool = False


@dataclass(frozen=True, slots=True)
class NativeBlock:
    """Called with the address of the instance and its inputs in the order of declaration; returns all its outputs.

    What an instance keeps besides its pins, the host keeps by the address.  An online change never moves an instance;
    `forget` says that the instances have begun again.
    """

    run: Callable[..., Results | Pending]
    cost_ns: int = 5_000
    is_slow: bool = False
    forget: Callable[[], None] = lambda: None


@dataclass(frozen=True, slots=True)
class Library:
    """A library: its source text, and the implementations of its native POUs by name in small letters."""

    name: str
    text: str
    functions: Mapping[str, NativeFunction]
    blocks: Mapping[str, NativeBlock]
    required: frozenset[str] = frozenset()
    """The names of inputs that a program must give to an instance of its blocks which it calls."""


class Host(Protocol):
    """The controller as programs see it."""

    @property
    def libraries(self) -> Sequence[Library]:
        """Besides the standard library, which is always there."""

    @property
    def object_types(self) -> Mapping[str, ObjectType]:
        """Kinds of configuration objects by name in small letters."""

    @property
    def objects(self) -> Mapping[str, ConfiguredObject]:
        """Configuration objects by symbolic name in small letters."""

    def read(self, address: int) -> Value:
        """Return the value of the parameter with this logical address.  KeyError if there is none."""

    def write(self, address: int, value: Value) -> None:
        """Set the parameter.  KeyError if there is none; ValueError if it cannot have this value."""

    def read_slowly(self, address: int) -> Pending:
        """Read a parameter through SERCOS (PD-028); KeyError if there is none."""

    def write_slowly(self, address: int, value: Value) -> Pending: ...

    @property
    def inputs(self) -> bytearray:
        """The area %I, of at most 64 kB (PD-314); a read at any instant gives the present value."""

    @property
    def outputs(self) -> bytearray: ...

    def on_output(self, byte: int) -> None:
        """Called after each write into %Q, because the MAx-4 has no process image (PD-070)."""

    def now_ms(self) -> int:
        """Milliseconds since the start of the controller: TIME() and the timers."""
