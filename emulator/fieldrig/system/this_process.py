"""Facts about this process (memory, age, CPU time), and its signal handlers."""

import asyncio
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

_PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096


def facts() -> dict[str, float | None]:
    """Return the facts for `status`.

    `memory_mb` counts shared pages; `own_mb` is what would be free without this process.
    """
    own = own_bytes()
    return {**brief_facts(), "own_mb": None if own is None else round(own / 1e6, 1)}


def brief_facts() -> dict[str, float | None]:
    """Return the facts that cost nothing: the system looks at every page of memory for `own_mb`, which takes 2 to 6 ms.

    A page in a browser asks twice a second, and a cycle of 4 ms has no room for more.
    """
    return {
        "pid": os.getpid(),
        "uptime_s": round(age_s(), 3),
        "cpu_s": round(time.process_time(), 3),
        "memory_mb": round(resident_bytes() / 1e6, 1),
    }


def resident_bytes() -> int:
    """Return the memory in RAM, including shared pages; 0 where the system does not provide it."""
    try:
        return int(Path("/proc/self/statm").read_bytes().split()[1]) * _PAGE
    except OSError:
        return _peak_bytes()


def own_bytes(process: int | None = None) -> int | None:
    """Return the memory that would be free without a process, or without this one; None if the system does not say."""
    try:
        lines = Path(f"/proc/{process or 'self'}/smaps_rollup").read_bytes().splitlines()
    except OSError:
        return None
    return 1024 * sum(int(line.split()[1]) for line in lines if line.startswith(b"Private_"))


def usable_cores() -> int:
    """Return the number of cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def age_s() -> float:
    """Return the time since the process was started, or its CPU time where the system does not provide that."""
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            ticks = int(Path("/proc/self/stat").read_bytes().rpartition(b")")[2].split()[19])
            return time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    return time.process_time()


def on_signals(names: Sequence[str], action: Callable[[], None]) -> None:
    """Call `action` in the running loop.

    Signals that the system lacks, or that the user ignores (nohup), are left out.
    """
    loop = asyncio.get_running_loop()
    for name in names:
        number = getattr(signal, name, None)
        before = None if number is None else signal.getsignal(number)
        if number is None or before is signal.SIG_IGN:
            continue
        try:
            loop.add_signal_handler(number, action)
        except NotImplementedError:  # Windows
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(action))
        if isinstance(before, _Interrupt) and before.has_come:
            loop.call_soon(action)


def interrupt_on_signals(names: Sequence[str]) -> None:
    """Treat the signals like Ctrl-C until a loop handles them, so that every `finally` runs."""
    for name in names:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _Interrupt())


def exit_on_signals(names: Sequence[str]) -> None:
    """End this process by SystemExit, with the exit code of a shell, so that every `finally` runs."""

    def leave(number: int, _frame: object) -> None:
        raise SystemExit(128 + number)

    for name in names:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, leave)


class _Interrupt:
    """An interrupt that is also kept for `on_signals`, as Python drops exceptions inside a fork hook or a `__del__`."""

    def __init__(self) -> None:
        self.has_come = False

    def __call__(self, _number: int, _frame: object) -> None:
        self.has_come = True
        raise KeyboardInterrupt


def _peak_bytes() -> int:
    """Return the peak of the memory, which is all that is available without /proc."""
    if sys.platform != "win32":
        with suppress(ImportError):
            import resource

            peak: int = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            return peak if sys.platform == "darwin" else peak * 1024
    return 0
