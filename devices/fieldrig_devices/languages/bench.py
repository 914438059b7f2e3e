"""A program of a language with a debugger, under test in Python: its values are those that a debugger sees."""

from abc import abstractmethod
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

from fieldrig.clock import MS
from fieldrig.errors import ArgumentError
from fieldrig.programs import ProgramBench
from fieldrig.text.nearest import closest

MOST_VALUES: Final = 4
"""Values of a variable in a message, the last of them."""


class WatchedBench(ProgramBench):
    """Reads and writes by the words of a debugger.  A class of a language says where these go."""

    def __init__(self) -> None:
        self._read: dict[str, deque[tuple[int, Any]]] = {}
        """The values that a test has read since the program was loaded, each behind its instant, by variables."""

    @abstractmethod
    def _value(self, path: str) -> Any:
        """Return the value of a variable.  ValueError, saying what was expected, if there is none."""

    @abstractmethod
    def _write(self, path: str, value: Any) -> None: ...

    @abstractmethod
    def _force(self, path: str, value: Any) -> None:
        """Force a variable; None releases it."""

    def get(self, path: str) -> Any:
        with _refusals():
            value = self._value(path)
        values = self._read.setdefault(path, deque(maxlen=MOST_VALUES))
        if not values or values[-1][1] != value:
            values.append((self.now_ns, value))
        return value

    def set(self, path: str, value: Any) -> None:
        with _refusals():
            self._write(path, value)

    def force(self, path: str, value: Any) -> None:
        with _refusals():
            self._force(path, value)

    def release(self, path: str) -> None:
        with _refusals():
            self._force(path, None)

    def reset(self) -> None:
        self._read.clear()

    def _told_of_values(self) -> Iterator[str]:
        for path, values in self._read.items():
            *before, now = (f"{value!r} at {at_ns / MS:g} ms" for at_ns, value in values)
            yield f"{path} = {now}" + (f"; before {', '.join(before)}" if before else "")


def check_options(options: Mapping[str, Any], known: tuple[str, ...] = ()) -> None:
    """ArgumentError for an option that a language does not have."""
    for name in options:
        if name not in known:
            raise ArgumentError(f"program has no option {name!r} in this language", closest(name, known))


@contextmanager
def _refusals() -> Iterator[None]:
    """Turn what a debugger refuses into an error of the call."""
    try:
        yield
    except ArgumentError:
        raise
    except ValueError as wrong:
        what, _, remedy = str(wrong).partition("\n")
        raise ArgumentError(what, remedy) from wrong
