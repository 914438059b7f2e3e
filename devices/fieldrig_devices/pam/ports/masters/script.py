"""Scripts of masters, and what runs them."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Final, Protocol, TypeVar

T = TypeVar("T")

POLL_NS: Final = 10_000_000
"""Pause between two looks at a word that the PAM is expected to change."""


@dataclass(frozen=True, slots=True)
class Read:
    word: int
    count: int = 1


@dataclass(frozen=True, slots=True)
class Write:
    word: int
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Pause:
    duration_ns: int = POLL_NS


Access = Read | Write | Pause
Script = Generator[Access, Sequence[int], T]
"""Gets the words that a Read asked for; what it gets for others has no meaning."""


class MasterError(Exception):
    """The PAM does not answer, or answers something else than the master expects."""


class Words(Protocol):
    """A way to the memory, such as a `Memory` or a client of Modbus."""

    def read(self, word: int, count: int) -> Sequence[int]: ...

    def write(self, word: int, values: Sequence[int]) -> None: ...


def carry_out(script: Script[T], words: Words, pause: Callable[[float], None]) -> T:
    """Run a script to its end and return its result.  `pause` waits for a number of seconds, as `time.sleep` does."""
    cells: Sequence[int] = ()
    while True:
        try:
            access = script.send(cells) if cells else next(script)
        except StopIteration as end:
            result: T = end.value
            return result
        cells = ()
        match access:
            case Read(word=word, count=count):
                cells = words.read(word, count)
            case Write(word=word, values=values):
                words.write(word, values)
            case Pause(duration_ns=duration_ns):
                pause(duration_ns / 1e9)


def read(word: int) -> Script[int]:
    """Read one word."""
    (value,) = yield Read(word)
    return value


def wait_for(word: int, is_fine: Callable[[int], bool], what: str, patience_ns: int) -> Script[int]:
    """Read a word until it is as expected, and return it.  MasterError if it takes too long."""
    for _ in range(max(1, patience_ns // POLL_NS)):
        value = yield from read(word)
        if is_fine(value):
            return value
        yield Pause()
    raise MasterError(f"{what} has not come within {patience_ns // 1_000_000} ms")
