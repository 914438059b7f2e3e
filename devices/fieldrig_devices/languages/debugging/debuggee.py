"""The side of a device that the debugging service sees: its program, its threads, and its values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, Protocol

from fieldrig.device import Value


class ProgramState(Enum):
    NONE = "none"
    """There is no program."""
    HELD = "held"
    """Stopped before its first instruction, or between two cycles."""
    RUNNING = "running"
    PAUSED = "paused"
    """At a breakpoint, after a step, or paused from outside; it can continue."""
    ENDED = "ended"
    FAILED = "failed"
    """Stopped by a run-time fault."""


class Step(Enum):
    INTO = "into"
    OVER = "over"
    OUT = "out"


class Reset(Enum):
    """How far a reset goes; a language with one kind of reset treats them alike."""

    WARM = "warm"
    """Retained variables keep their values."""
    COLD = "cold"
    """All variables have their start values."""
    ORIGIN = "origin"
    """The program is deleted as well."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A place in the program: the routine, and the source line of its next instruction."""

    routine: str
    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.routine} ({self.file}:{self.line})"


class At(NamedTuple):
    """The next instruction of a thread, or the one that it has just done."""

    file: str
    line: int
    depth: int
    """The number of callers."""
    is_beginning: bool
    """True if it is the first instruction of its line, where a breakpoint stops."""


Looks = tuple[Callable[[int], None], Callable[[int], None]]
"""Two calls with the number of a thread: in front of each of its instructions, and behind it."""


@dataclass(frozen=True, slots=True)
class ThreadView:
    """A task, or a program that runs by itself."""

    number: int
    name: str
    state: ProgramState
    about: str = ""
    """Why it has stopped, such as the text of a fault."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A value of the program, or a group of values that has children."""

    path: str
    """Its name from the root; a child of `a.b` is `a.b.c` or `a.b[3]`."""
    name: str
    type: str
    value: Value | None = None
    """None for a group."""
    is_writable: bool = False
    is_forced: bool = False
    about: str = ""
    text: str = ""
    """The value as the language writes it, such as T#5s; empty if truth values, numbers and texts say it all."""


class Evaluating(Protocol):
    def evaluate(self, text: str, thread: int | None = None, frame: int = 0) -> Variable: ...


def evaluated(debuggee: Evaluating, text: str) -> Callable[[], Value | None]:
    """Return a function for the value of an expression; None where there is none at present."""

    def read() -> Value | None:
        try:
            return debuggee.evaluate(text).value
        except ValueError:
            return None

    return read


class Debuggee(Protocol):
    """A device with a program.  Methods raise ValueError, saying what was expected, for what is not possible now."""

    language: str
    """The name of the language, such as "ARP BASIC" or "IEC 61131-3"."""
    on_stop: Callable[[], None]
    """Called when a thread stops at a breakpoint, after a step, or because of a fault; set by the service."""
    on_load: Callable[[], None]
    """Called when another program has been loaded, or the present one has been changed; set by the service."""

    @property
    def state(self) -> ProgramState: ...

    @property
    def files(self) -> Mapping[str, str]:
        """The source texts by file name."""

    @property
    def progress(self) -> str:
        """The work in progress, such as compiling, with a percentage; empty if there is none."""

    @property
    def problem(self) -> str:
        """Why the last program was refused, with every mistake on a line; empty if it was loaded."""

    def threads(self) -> Sequence[ThreadView]: ...

    def stack(self, thread: int) -> Sequence[Frame]:
        """The place of a thread, then those of its callers, innermost first."""

    def break_at(self, places: Mapping[str, set[int]]) -> Mapping[str, set[int]]:
        """Set the breakpoints of all files; return those lines that have an instruction to stop at."""

    def goes_on(self, file: str, first: int, last: int) -> bool:
        """Return True if the statement that begins in the line `first` goes on in the line `last`."""

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def reset(self, kind: Reset) -> None: ...

    def look_on(self, looks: Looks | None) -> None:
        """Have every instruction looked at, in the thread and at the instant in which it runs; None ends it.

        A look may halt the thread.  Everything else is the same with looks and without.
        """

    def at(self, thread: int) -> At | None:
        """Return where a thread is; None between two of its cycles."""

    def halt(self, thread: int) -> bool:
        """Stop a thread in front of its next instruction, as at a breakpoint; false if it has none."""

    def pause(self) -> None:
        """Pause all threads; `on_stop` is not called, as the one who pauses knows."""

    def go_on(self) -> None:
        """Continue from a pause."""

    def step(self, thread: int, kind: Step) -> None:
        """Run to the next source line; `on_stop` is called when it is reached."""

    def variables(self, path: str) -> Sequence[Variable]:
        """Return the children of a group; the roots for an empty path.  ValueError for an unknown path.

        `@1:2` is the group of the variables of frame 2 of thread 1, if the language has such variables.
        """

    def evaluate(self, text: str, thread: int | None = None, frame: int = 0) -> Variable:
        """Return a variable, or the value of an expression in the scope of a frame of a thread, 0 for the innermost."""

    def reader(self, text: str) -> Callable[[], Value | None]:
        """Return a fast function for the value of `evaluate(text)`; None where there is none, as after a download."""

    def write(self, path: str, value: Value) -> None:
        """Write a variable.  A text may be a literal of the language, as people type it: `T#5s`, `16#FF`, `TRUE`."""

    def force(self, path: str, value: Value | None) -> None:
        """Hold a variable at a value, as in `write`, until it is released with None."""

    def forced(self) -> Sequence[Variable]:
        """Return the variables that are forced."""

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        """Load a program, as an online change if `is_online`.

        The compiler may need time, which `progress` reports; a program that does not compile leaves the present one,
        and `problem` says why.
        """
