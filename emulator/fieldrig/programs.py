"""Programs under test in Python: `program("pid.st")` is a program alone, on a clock that the test moves.

    plc = program("pid.st")
    pid = plc.block("PID")
    pid(setpoint=50.0, PT=T("2s"))
    plc.advance(10 * MS)
    assert pid.output > 0

The kernel knows no language: each is an entry point "fieldrig.programs", a module that is a `Language`.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, Final, Protocol, TypeVar

from fieldrig.clock import MS, S
from fieldrig.errors import ArgumentError, UnmetError, UsageError
from fieldrig.outside.untrusted import shown
from fieldrig.text import durations
from fieldrig.text.nearest import nearest_file

GROUP = "fieldrig.programs"
LOOK_NS = 1 * MS
"""The time between two looks at a condition."""

MOST_EVENTS = 5
"""Events in a message, the last of them."""

R = TypeVar("R")


_UNITS_NS: Final = {**durations.UNITS_NS, "d": 86_400 * S, "h": 3_600 * S, "m": 60 * S}
_PART: Final = re.compile(r"([0-9]+(?:\.[0-9]+)?)(ns|us|ms|min|[dhms])")


def T(duration: str) -> int:  # noqa: N802  the prefix of a time in the language
    """Return a duration in nanoseconds: `T("1.5s")`, `T("10ms")`, and as in the language `T("T#1h30m")`.

    The units are d, h, m (or min), s, ms, us and ns.  ArgumentError for anything else.
    """
    text = re.sub(r"^(?:l?t|l?time)#|_", "", duration.lower()) if isinstance(duration, str) else ""
    parts = _PART.findall(text)
    if not parts or "".join(number + unit for number, unit in parts) != text:
        raise ArgumentError(f"{shown(duration)} is not a duration", 'expected one such as T("10ms") or T("1h30m")')
    return sum(round(Fraction(number) * _UNITS_NS[unit]) for number, unit in parts)


class ProgramBench(ABC):
    """A program alone, at time 0, with start values in all variables.

    `bench["Main.level"]` reads and writes a variable by its path.  Times are whole nanoseconds, dates those of Python,
    values of enumerations their names, structures dicts, arrays lists.
    """

    @property
    @abstractmethod
    def now_ns(self) -> int:
        """The instant, in virtual time since the program was loaded."""

    @abstractmethod
    def get(self, path: str) -> Any:
        """Return the value of a variable.  ArgumentError, with the nearest name, for an unknown one."""

    @abstractmethod
    def set(self, path: str, value: Any) -> None:
        """Write a variable.  ArgumentError, saying what was expected, for a value that it cannot have."""

    @abstractmethod
    def force(self, path: str, value: Any) -> None:
        """Hold a variable at a value, whatever the program writes."""

    @abstractmethod
    def release(self, path: str) -> None:
        """End the force of a variable."""

    @abstractmethod
    def start(self) -> None:
        """Start the tasks of the program; they run while time passes."""

    @abstractmethod
    def stop(self) -> None:
        """Hold the tasks where they are."""

    @abstractmethod
    def reset(self) -> None:
        """Begin again: time 0, start values, no forces, and tasks that have not been started."""

    @abstractmethod
    def advance(self, duration_ns: int) -> None:
        """Let time pass, such as `10 * MS`.  RigError if the program is suspended by a fault meanwhile."""

    @property
    @abstractmethod
    def events(self) -> Sequence[str]:
        """Faults and messages of the program so far, in whole sentences."""

    def block(self, name: str, **init: Any) -> Any:
        """Return a new instance of a function block, or a program, to be called with its inputs.

        `init` are the arguments of its FB_init.
        """
        raise ArgumentError(f"there is no block {shown(name)}", "only programs of IEC 61131-3 have blocks")

    def function(self, name: str) -> Callable[..., Any]:
        """Return a function, to be called with its inputs."""
        raise ArgumentError(f"there is no function {shown(name)}", "only programs of IEC 61131-3 have functions")

    def mock(self, name: str, call: Callable[..., Any] | None = None, *, returns: Any = None) -> Any:
        """Call `call` instead of a function with its inputs, or of a block with its instance; it counts the calls."""
        raise ArgumentError(f"{shown(name)} cannot be mocked", "only programs of IEC 61131-3 have functions and blocks")

    def __getitem__(self, path: str) -> Any:
        return self.get(path)

    def __setitem__(self, path: str, value: Any) -> None:
        self.set(path, value)

    def next_ns(self) -> int | None:
        """Return the next instant at which something happens in the program; None if it is not known."""
        return None

    def _watch(self, look: Callable[[], bool], during: int) -> None:
        """Let time pass, and call `look()` now, at each instant at which something happens, and at the end.

        It ends when `look()` is false.
        """
        end_ns = self.now_ns + checked_duration(during)
        while look() and self.now_ns < end_ns:
            look_ns, next_ns = self.now_ns + LOOK_NS, self.next_ns()
            until_ns = min(end_ns, look_ns if next_ns is None else max(min(next_ns, look_ns), self.now_ns + 1))
            self.advance(until_ns - self.now_ns)

    def until(self, condition: Callable[[], R], within: int) -> R:
        """Let time pass until `condition()` is true, and return its value.

        It is called at each instant at which something happens, and once in a millisecond.  UnmetError, with the last
        changes, if it is not true in time.
        """
        met: list[R] = []
        checked_condition(condition)

        def look() -> bool:
            value = condition()
            if value:
                met.append(value)
            return not value

        self._watch(look, within)
        if not met:
            raise UnmetError(f"the condition did not hold within {within / MS:g} ms", self.told())
        return met[0]

    def stays(self, condition: Callable[[], object], during: int, until: Callable[[], object] | None = None) -> None:
        """Let time pass, or until `until()` is true, in which `condition()` has to stay true.

        UnmetError at the first instant at which it is not true, and if `until()` does not become true in time.
        """
        is_over: list[bool] = []
        checked_condition(condition)
        checked_condition(until or condition)

        def look() -> bool:
            if until is not None and until():
                is_over.append(True)
            elif not condition():
                raise UnmetError(f"the condition no longer held at {self.now_ns / MS:g} ms", self.told())
            return not is_over

        self._watch(look, during)
        if until is not None and not is_over:
            raise UnmetError(f"the end did not come within {during / MS:g} ms", self.told())

    def never(self, condition: Callable[[], object], during: int) -> None:
        """Let time pass, at no instant of which `condition()` may be true.  UnmetError if it is."""
        checked_condition(condition)

        def look() -> bool:
            if condition():
                raise UnmetError(f"the condition held at {self.now_ns / MS:g} ms", self.told())
            return True

        self._watch(look, during)

    def values(self, path: str) -> Any:
        """Return a strategy of hypothesis with all values that a variable can have."""
        raise ArgumentError(
            f"{shown(path)} has no type here", "give a strategy, such as hypothesis.strategies.booleans()"
        )

    def for_all(
        self,
        inputs: Mapping[str, Any] | Sequence[str] | None = None,
        *,
        always: Callable[[], object] | None = None,
        never: Callable[[], object] | None = None,
        block: Any = None,
        every: int = 10 * MS,
        steps: int = 20,
        examples: int = 100,
        seed: int | None = None,
    ) -> None:
        """Try random inputs over time, and judge that a condition is always true, or never, whatever they are.

        `inputs` are paths of variables, or a dict with their strategies of hypothesis; a strategy that is None, or not
        given, has all values of the variable's type.  They change while the tasks run, at multiples of `every`
        nanoseconds.  With `block`, an instance, they are its inputs, by default all of them, and it is called once in
        this time.  At most `steps` changes follow one another, in `examples` runs, each from a program as it is when it
        is loaded.  Without `seed` they are the same each time.

        UnmetError, with the shortest sequence, if the condition does not hold or a fault ends the program.
        """
        from fieldrig.properties import Step, explore

        holds = _property(always, never)
        checked_duration(every)

        def look() -> bool:
            if not holds():
                what = "did not hold" if never is None else "held"
                raise UnmetError(f"the condition {what} at {self.now_ns / MS:g} ms", self.told())
            return True

        def play(sequence: Sequence[Step]) -> None:
            self._begin_again(with_tasks=block is None)
            for step in sequence:
                self._play(block, step.changes, step.cycles, every, look)

        self._begin_again(with_tasks=block is None)
        explore(play, self._strategies(inputs, block), steps, examples, seed)

    def _begin_again(self, *, with_tasks: bool) -> None:
        """Begin at the time 0 with start values; instances that the test has stay valid."""
        self.reset()
        if with_tasks:
            self.start()

    def _play(self, block: Any, changes: Mapping[str, Any], cycles: int, every: int, look: Callable[[], bool]) -> None:
        """Let the program run for some cycles with changed inputs."""
        if block is None:
            for path, value in changes.items():
                self.set(path, value)
            self._watch(look, cycles * every)
            return
        for number in range(cycles):
            block(**(changes if number == 0 else {}))
            look()
            self.advance(every)

    def _strategies(self, inputs: Mapping[str, Any] | Sequence[str] | None, block: Any) -> dict[str, Any]:
        """Return a strategy for each input."""
        names = self._inputs_of(block) if inputs is None else inputs
        if isinstance(names, str) or not names:
            raise ArgumentError(f"inputs cannot be {shown(inputs)}", 'expected names, such as ["start", "stop"]')
        given = names if isinstance(names, Mapping) else dict.fromkeys(names)
        return {name: self._values_of(block, name) if one is None else one for name, one in given.items()}

    def _inputs_of(self, block: Any) -> Sequence[str]:
        """Return the names of the inputs of an instance."""
        return ()

    def _values_of(self, block: Any, name: str) -> Any:
        """Return the strategy of an input of an instance, or of a variable if there is none."""
        return self.values(name)

    def told(self) -> str:
        """Return what happened lately, for a person whose test has failed: what the test has read, and events."""
        return "\n".join([*self._told_of_values(), *self.events[-MOST_EVENTS:]])

    def _told_of_values(self) -> Iterable[str]:
        """Return a line for each variable that the test has read, with its last values."""
        return ()


class Language(Protocol):
    """A module that can load the programs of a language."""

    def takes(self, path: Path) -> bool:
        """True for a file, or a folder, with a program of this language."""

    def load(self, paths: list[Path], options: Mapping[str, Any]) -> ProgramBench: ...


def program(*files: str | Path, **options: Any) -> ProgramBench:
    """Load a program to test it: source files, or folders with them.

    Options of IEC 61131-3 are `dialect="edition-3"` and `resource`.  ConfigError with every mistake of the program.
    """
    if not files:
        raise ArgumentError("program needs a file", 'expected program("pid.st")')
    paths = [_path(file) for file in files]
    return _language_of(paths[0]).load(paths, options)


def _property(always: Callable[[], object] | None, never: Callable[[], object] | None) -> Callable[[], bool]:
    """Return whether a property holds now.  ArgumentError unless just one of the two is given."""
    if callable(always) and never is None:
        return lambda: bool(always())
    if callable(never) and always is None:
        return lambda: not never()
    raise ArgumentError("a property is one condition", "expected for_all(..., never=lambda: lift.motor and lift.brake)")


def checked_duration(duration_ns: int) -> int:
    """Return a duration.  ArgumentError for anything but whole nanoseconds from 0 on."""
    if type(duration_ns) is not int or duration_ns < 0:
        raise ArgumentError(f"time cannot pass for {shown(duration_ns)}", "expected nanoseconds, such as 10 * MS")
    return duration_ns


def checked_condition(condition: object) -> None:
    """ArgumentError for what is no function."""
    if not callable(condition):
        raise ArgumentError(
            f"a condition cannot be {shown(condition)}", "expected a function, such as lambda: lift.motor"
        )


def _path(file: str | Path) -> Path:
    if not isinstance(file, str | Path):
        raise ArgumentError(f"a program cannot be {shown(file)}", 'expected the name of a file, such as "pid.st"')
    path = Path(file)
    if not path.exists():
        remedy = nearest_file(path) or f"expected a source file; the folder is {Path.cwd()}"
        raise UsageError(f"there is no {path}", remedy)
    return path


def _language_of(path: Path) -> Language:
    """Return the language of a file.  UsageError if no package takes it."""
    known = sorted(entry_points(group=GROUP), key=lambda entry: entry.name)
    for entry in known:
        language: Language = entry.load()
        if language.takes(path):
            return language
    names = ", ".join(entry.name for entry in known) or "none"
    raise UsageError(f"{path} is in no known language", f"expected a program for one of: {names}")
