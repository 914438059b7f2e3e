"""Long work of a device, such as compiling a program, beside the running device.

A device reacts and takes no time, so it hands work that takes longer than a few milliseconds to its `background`, and
gets the result as an event of its own.  The function is pure: it can be imported by its name, it takes one argument
and a function to report its progress to, and argument and result can be pickled.

    def squares(upto: int, report: Report) -> list[int]: ...

    background.run(squares, 1_000_000, self._on_done, self._on_progress, virtual_ns=20 * MS)

In real time the function runs in a process of its own with a lower priority (`background_process`).  A process that
ends too early is a `Failure`, and so is an exception.  In virtual time the function runs at once, and the result
arrives after `virtual_ns`, with the reports at equal distances before it, so every run is the same; an exception is
raised there, as it is a fault in our code.

The result becomes an object in the process of the device, which stops for as long as that takes.  Large parts of it
should therefore be a `Bulk`: its bytes are transferred piece by piece, and the device decodes them when it needs them.
"""

import pickle
from collections.abc import Callable
from functools import partial
from typing import Any, Final, NamedTuple, Protocol, TypeVar

from fieldrig.clock import Clock, Timer

A = TypeVar("A")
A_contra = TypeVar("A_contra", contravariant=True)
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)

Report = Callable[[str, int, int], None]
"""Called by the function with what it is doing, and how many steps of how many are done."""

PROTOCOL: Final = 5
"""The first protocol of pickle that leaves large parts out of the pickled bytes."""
_PARTS: Final = 100
"""Greatest number of reports for each thing that a function does."""


class Function(Protocol[A_contra, R_co]):
    def __call__(self, argument: A_contra, report: Report, /) -> R_co: ...


class Failure(NamedTuple):
    """The answer instead of a result if the worker process has failed."""

    why: str


class Bulk:
    """Bytes that are transferred without being copied or decoded in the process of the device."""

    __slots__ = ("data",)

    def __init__(self, data: bytes | bytearray | memoryview) -> None:
        self.data = data

    def __reduce_ex__(self, _protocol: Any) -> tuple[Any, ...]:
        return Bulk, (pickle.PickleBuffer(self.data),)


def packed(value: object) -> Bulk:
    """Return an object as bytes, for a part of a result that the device may not need at once, or at all."""
    return Bulk(pickle.dumps(value, PROTOCOL))


def unpacked(bulk: Bulk) -> Any:
    """Return the object of `packed`.  Only for bytes of our own worker process."""
    return pickle.loads(bulk.data)


class Job(Protocol):
    """Work that was handed over."""

    def cancel(self) -> None:
        """End the work, if it is not done; nothing of it arrives any more."""


class Background(Protocol):
    """Work that takes longer than a reaction may, beside the device."""

    def run(
        self,
        function: Function[A, R],
        argument: A,
        on_done: Callable[[R | Failure], None],
        on_progress: Report | None = None,
        *,
        virtual_ns: int,
    ) -> Job:
        """Run `function(argument, report)` beside the device, and call `on_done` with its result.

        `virtual_ns` is the time that it takes in virtual time.  `on_progress` is called with some of the reports, with
        the last one before `on_done`.
        """


class Coarse:
    """Passes on those reports that differ from the last one by a hundredth, or begin something else."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._last: tuple[str, int] | None = None

    def __call__(self, what: str, done: int, steps: int) -> None:
        mark = what, done * _PARTS // max(steps, 1)
        if mark != self._last:
            self._last = mark
            self._report(what, done, steps)


class VirtualBackground:
    """The background of a device under virtual time, and in tests of a device alone."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock

    def run(
        self,
        function: Function[A, R],
        argument: A,
        on_done: Callable[[R | Failure], None],
        on_progress: Report | None = None,
        *,
        virtual_ns: int,
    ) -> Job:
        reports: list[tuple[str, int, int]] = []
        result = function(_copy(argument), Coarse(lambda *report: reports.append(report)))
        clock, now_ns, timers = self._clock, self._clock.now_ns(), list[Timer]()
        for number, report in enumerate(reports if on_progress is not None else (), 1):
            when_ns = now_ns + number * virtual_ns // (len(reports) + 1)
            timers.append(clock.call_at(when_ns, partial(on_progress or _ignore, *report)))
        timers.append(clock.call_at(now_ns + virtual_ns, partial(on_done, _copy(result))))
        return _VirtualJob(timers)


class _VirtualJob:
    def __init__(self, timers: list[Timer]) -> None:
        self._timers = timers

    def cancel(self) -> None:
        for timer in self._timers:
            timer.cancel()


def _copy(value: R) -> R:
    """Return what another process would see of the value."""
    copy: R = pickle.loads(pickle.dumps(value, PROTOCOL))
    return copy


def _ignore(what: str, done: int, steps: int) -> None:
    """Drop a report that the device did not ask for."""
