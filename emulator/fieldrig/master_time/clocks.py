"""The clocks of the standard library, which show virtual time to a master.

`time.time` begins at a fixed date, so a date in a message is the same in each run.  The monotonic clocks begin at
1000 s, because some programs take 0 for "never".
"""

import datetime
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, Final, Self

from fieldrig.clock import S
from fieldrig.master_time.active import seeing_scheduler, waiting_scheduler
from fieldrig.master_time.scheduler import Place

EPOCH_NS: Final = 946_684_800 * S
"""2000-01-01 00:00:00 UTC."""
MONOTONIC_NS: Final = 1000 * S
SHIFTS_NS: Final = {
    "time": EPOCH_NS,
    "monotonic": MONOTONIC_NS,
    "perf_counter": MONOTONIC_NS,
}
"""The readings of the clocks at the instant 0 of the rig."""
CLOCK_IDS: Final = {
    getattr(time, name): shift_ns
    for name, shift_ns in {
        "CLOCK_REALTIME": EPOCH_NS,
        "CLOCK_MONOTONIC": MONOTONIC_NS,
        "CLOCK_MONOTONIC_RAW": MONOTONIC_NS,
        "CLOCK_BOOTTIME": MONOTONIC_NS,
    }.items()
    if hasattr(time, name)
}
CLOCK_METHODS: Final = ("now", "today", "utcnow")
_IS_HEAP_TYPE, _IS_IMMUTABLE = 1 << 9, 1 << 8
"""The marks of a class that was made at run time, and of one that takes no attributes (`Py_TPFLAGS_...`)."""
BROKEN_DOWN: Final = ("localtime", "gmtime", "ctime")
_real_time_s, _real_sleep = time.time, time.sleep
_DateTime, _Date = datetime.datetime, datetime.date  # the names in the module lead to the stand-ins during the block


def virtual_ns(shift_ns: int) -> int | None:
    """Return a virtual clock, after counting the look at it; None for a caller in real time."""
    scheduler = seeing_scheduler()
    if scheduler is None:
        return None
    if scheduler.place is Place.MEMBER:
        scheduler.count_read()
    return scheduler.rig.now_ns + shift_ns


class ClockStandIn:
    """One clock; its methods are no functions, so that they stay what they are as attributes of a class."""

    def __init__(self, real: Callable[..., Any], shift_ns: int) -> None:
        self._real, self._shift_ns = real, shift_ns

    def seconds(self) -> float:
        now_ns = virtual_ns(self._shift_ns)
        return float(self._real()) if now_ns is None else now_ns / S

    def nanoseconds(self) -> int:
        now_ns = virtual_ns(self._shift_ns)
        return int(self._real()) if now_ns is None else now_ns

    def of_id(self, clock: int) -> float:
        now_ns = virtual_ns(CLOCK_IDS[clock]) if clock in CLOCK_IDS else None
        return float(self._real(clock)) if now_ns is None else now_ns / S

    def of_id_ns(self, clock: int) -> int:
        now_ns = virtual_ns(CLOCK_IDS[clock]) if clock in CLOCK_IDS else None
        return int(self._real(clock)) if now_ns is None else now_ns

    def broken_down(self, seconds: float | None = None) -> Any:
        return self._real(_now_s() if seconds is None else seconds)

    def text(self, *moment: Any) -> str:
        """`asctime`."""
        return str(self._real(*(moment or (time.localtime(),))))

    def format(self, form: str, *moment: Any) -> str:
        """`strftime`."""
        return str(self._real(form, *(moment or (time.localtime(),))))

    def sleep(self, seconds: float) -> None:
        scheduler = waiting_scheduler()
        if scheduler is None:
            self._real(seconds)
        elif seconds < 0:
            raise ValueError("sleep length must be non-negative")
        elif seconds == 0:
            scheduler.count_read()
            scheduler.give_way()
        else:
            scheduler.wait(scheduler.until(seconds))


def _now_s() -> float:
    now_ns = virtual_ns(EPOCH_NS)
    return _real_time_s() if now_ns is None else now_ns / S


class _KindOfDate(type):
    """Dates of the real class are dates, also for code that asks while the stand-in has its name."""

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, cls.__mro__[1])

    def __subclasscheck__(cls, subclass: type) -> bool:
        return issubclass(subclass, cls.__mro__[1])


class DateTimeStandIn(datetime.datetime, metaclass=_KindOfDate):
    """`datetime.datetime`, which makes dates of the real class, so that none outlives the block."""

    def __new__(cls, *args: Any, **options: Any) -> Self:
        kind: Any = _DateTime if cls is DateTimeStandIn else cls
        made: Self = _DateTime.__new__(kind, *args, **options)
        return made

    @classmethod
    def now(cls, tz: datetime.tzinfo | None = None) -> Any:
        return _real_kind(cls).fromtimestamp(_now_s(), tz)

    @classmethod
    def today(cls) -> Any:
        return _real_kind(cls).fromtimestamp(_now_s())

    @classmethod
    def utcnow(cls) -> Any:
        return _real_kind(cls).fromtimestamp(_now_s(), datetime.UTC).replace(tzinfo=None)


class DateStandIn(datetime.date, metaclass=_KindOfDate):
    """`datetime.date`, in the same way."""

    def __new__(cls, *args: Any, **options: Any) -> Self:
        kind: Any = _Date if cls is DateStandIn else cls
        made: Self = _Date.__new__(kind, *args, **options)
        return made

    @classmethod
    def today(cls) -> Any:
        return _real_kind(cls).fromtimestamp(_now_s())


def _real_kind(kind: type) -> Any:
    """Return the real class for a stand-in; a class that is derived from one stays."""
    if kind is DateTimeStandIn:
        return _DateTime
    return _Date if kind is DateStandIn else kind


def dates_of_subclasses() -> Iterator[tuple[type, str, Any]]:
    """Yield the classes that are derived from the real dates, each with the name and stand-in of a method from them.

    Such a class reads the clock in C.  Those of extension modules cannot be changed, and one that calls the method of
    the real class by `super()` shows real time.
    """
    for real, stand_in in ((_Date, DateStandIn), (_DateTime, DateTimeStandIn)):
        methods = {name: each for name, each in vars(stand_in).items() if name in CLOCK_METHODS}
        for kind in real.__subclasses__():
            is_fixed = kind.__flags__ & (_IS_HEAP_TYPE | _IS_IMMUTABLE) != _IS_HEAP_TYPE
            if kind in (_DateTime, DateTimeStandIn, DateStandIn) or is_fixed:
                continue
            yield from ((kind, name, method) for name, method in methods.items() if name not in vars(kind))


def with_real_dates(load: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method that loads a module in C, and shows it the real dates.

    Such a module may derive a class of its own from one of them, as those of pandas do, and cannot from a stand-in.
    """

    def method(*arguments: Any) -> Any:
        shown = datetime.datetime, datetime.date
        stand_in: Any = datetime
        stand_in.datetime, stand_in.date = _DateTime, _Date
        try:
            return load(*arguments)
        finally:
            stand_in.datetime, stand_in.date = shown

    return method


def clock_swaps() -> list[tuple[Any, Any]]:
    """Return the real calls and classes, each with its stand-in."""
    swaps: list[tuple[Any, Any]] = [(_real_sleep, ClockStandIn(_real_sleep, 0).sleep)]
    for name, shift_ns in SHIFTS_NS.items():
        real, real_ns = getattr(time, name), getattr(time, name + "_ns")
        swaps.append((real, ClockStandIn(real, shift_ns).seconds))
        swaps.append((real_ns, ClockStandIn(real_ns, shift_ns).nanoseconds))
    for name in BROKEN_DOWN:
        real = getattr(time, name)
        swaps.append((real, ClockStandIn(real, 0).broken_down))
    swaps += [
        (time.asctime, ClockStandIn(time.asctime, 0).text),
        (time.strftime, ClockStandIn(time.strftime, 0).format),
        (_DateTime, DateTimeStandIn),
        (_Date, DateStandIn),
    ]
    if sys.platform != "win32" and hasattr(time, "clock_gettime"):
        swaps.append((time.clock_gettime, ClockStandIn(time.clock_gettime, 0).of_id))
        swaps.append((time.clock_gettime_ns, ClockStandIn(time.clock_gettime_ns, 0).of_id_ns))
    return swaps
