"""Signals by their names, `PART/KEY`, and what is known of each: a point of a device, or a wire of a bus."""

from collections.abc import Callable, Sequence
from enum import StrEnum
from typing import Any, ClassVar, Final, Literal, NamedTuple, Protocol

from fieldrig.device import Value
from fieldrig.errors import ArgumentError, ControlError
from fieldrig.outside.untrusted import MalformedError, field, items, shown

CYCLE: Final = "cycle"
CHANGE: Final = "change"
Rhythm = Literal["cycle", "change"] | int
"""When signals are sampled: in each cycle of their device, at each change, or once in a period of nanoseconds."""

NO_RECORDING: Final = "has no recording"
"""Begins, after the name of the process, the refusal of a question about a recording that is not there any more."""
NAN: Final = float("nan")
OWN_PERIOD_NS: Final = 1_000_000
"""Period of the samples of a device without a cycle of its own, where the cycle is asked for."""
REST_NS: Final = 100_000_000
"""Period of the samples of a device whose cycle rests, such as a drive without its ring."""

End = Callable[[], None]
"""Ends what has begun.  Calling it twice does no harm."""


OnCycle = Callable[[int, int], None]


class Sort(StrEnum):
    """The sort of the values of a column."""

    NUMBER = "number"
    TRUTH = "truth"
    TEXT = "text"
    """Each value is the place of its text in `Column.states`."""


class Column(NamedTuple):
    """One recorded signal."""

    name: str
    """`PART/KEY`."""
    kind: Sort
    unit: str
    states: list[str]
    """The texts of a `TEXT`, by their values.  The list grows when the signal has a text that it never had before."""
    is_held: bool = False
    """True if there is a sample for each change, so that each value holds until the next one."""
    is_open: bool = False
    """True for a text of which the part does not say which ones there are: others may come."""


class Described(NamedTuple):
    """A signal as its part describes it."""

    value: Value
    """The present value; NaN if there is none."""
    unit: str = ""
    states: Sequence[str] = ()

    @property
    def is_whole(self) -> bool:
        """True for a whole number, which may grow beyond what a float has."""
        return type(self.value) is int

    @property
    def sort(self) -> Sort:
        if self.states or isinstance(self.value, str):
            return Sort.TEXT
        return Sort.TRUTH if isinstance(self.value, bool) else Sort.NUMBER


class RecordedPart(Protocol):
    """A device or a bus whose signals can be recorded."""

    is_bus: ClassVar[bool]
    """True for a bus: where the cycle is asked for, its signals are recorded at their changes."""

    def describe(self, keys: Sequence[str]) -> list[Described]:
        """ControlError for a key that it does not have."""

    def reader(self, keys: Sequence[str]) -> Callable[[], Sequence[Value]]:
        """Return a function that reads these signals at the present instant; NaN stands for those without a value."""

    def on_cycle(self, action: OnCycle) -> End | None:
        """Call `action(instant, cycles missed before it)` at the end of each cycle.  None if the part has no cycle."""

    def on_change(self, keys: Sequence[str], action: Callable[[int, int, Value], None]) -> End:
        """Call `action(instant, place in keys, value)` at each change of one of these signals."""

    def close(self) -> None:
        """Read nothing any more."""


class Source(Protocol):
    """The devices and buses of one process."""

    on_rows: Callable[[], None]
    """Set by the recordings: called after the rows of a cycle were taken, when there is time until the next one."""

    def part(self, name: str) -> RecordedPart:
        """ControlError, with the nearest name, if there is no such part."""

    def now_ns(self) -> int: ...

    def every(self, period_ns: int, action: Callable[[int, int], None]) -> End:
        """Call `action(instant, ticks missed before it)` at each multiple of the period from now on."""


def split_signal(name: str) -> tuple[str, str]:
    """Return part and key of a signal.  ControlError for a name without a slash."""
    part, _, key = name.partition("/")
    if not part or not key:
        raise ControlError(f"{shown(name)} is not a signal", "expected DEVICE/KEY or BUS/WIRE, such as tank/level")
    return part, key


def wish_of(signals: Any, rhythm: Any) -> tuple[list[str], Rhythm]:
    """Return the names and the rhythm that a test wants to record.  ArgumentError for anything else."""
    names = [signals] if isinstance(signals, str) else list(signals) if isinstance(signals, Sequence) else []
    if not names or not all(isinstance(name, str) for name in names):
        raise ArgumentError(f"record cannot take {shown(signals)}", 'expected names, such as ["tank/level"]')
    if rhythm not in (CYCLE, CHANGE) and (type(rhythm) is not int or rhythm <= 0):
        expected = f'expected "{CYCLE}", "{CHANGE}" or a period, such as 10 * MS'
        raise ArgumentError(f"record cannot have the rhythm {shown(rhythm)}", expected)
    return names, rhythm


def rhythm_of(value: Any, shortest_ns: int, longest_ns: int) -> Rhythm:
    """Return a rhythm that came from outside.  MalformedError for anything else."""
    if value in (CYCLE, CHANGE):
        return CYCLE if value == CYCLE else CHANGE
    if type(value) is int and shortest_ns <= value <= longest_ns:
        return value
    expected = f'"{CYCLE}", "{CHANGE}" or a period of {shortest_ns} to {longest_ns} ns'
    raise MalformedError(f"rhythm: expected {expected}, found {shown(value)}")


def column_of(data: Any) -> Column:
    """Return a column from an answer.  MalformedError for anything else."""
    sort = field(data, "kind", str)
    if sort not in list(Sort):
        raise MalformedError(f"kind: {shown(sort)}")
    states = items(field(data, "states", list), str, 1 << 16, "states")
    is_held = field(data, "is_held", bool)
    is_open = field(data, "is_open", bool)
    return Column(field(data, "name", str), Sort(sort), field(data, "unit", str), states, is_held, is_open)
