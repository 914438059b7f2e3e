"""The alarms of the system, `signal.alarm` and `signal.setitimer`, which come in real time, and so too late or never.

A member cannot set one, and cannot wait for a signal, which would be a wait in real time.  The tools around a test can,
such as pytest-timeout, which ends a test that hangs.
"""

import signal
import sys
from collections.abc import Callable
from functools import wraps
from typing import Any, Final

from fieldrig.master_time.active import seeing_scheduler
from fieldrig.master_time.swaps import is_of_tool
from fieldrig.master_time.threads import refused

ALARM: Final = "an alarm of the system comes in real time; threading.Timer is in virtual time"

WAIT: Final = "a wait for a signal is in real time; threading.Event and signal.signal work in virtual time"
WAITS: Final = ("pause", "sigwait", "sigwaitinfo", "sigtimedwait")


def alarm_swaps() -> list[tuple[Any, Any]]:
    """Return the calls with their stand-ins, where the system has them."""
    if sys.platform != "win32" and hasattr(signal, "setitimer"):
        real_alarm, real_timer = signal.alarm, signal.setitimer

        def alarm(seconds: int) -> int:
            if seconds:
                _check()
            return real_alarm(seconds)

        def setitimer(which: int, seconds: float, interval: float = 0.0) -> tuple[float, float]:
            if seconds and which == signal.ITIMER_REAL:
                _check()
            return real_timer(which, seconds, interval)

        waits = [getattr(signal, name) for name in WAITS if hasattr(signal, name)]
        return [(real_alarm, alarm), (real_timer, setitimer), *((real, _wait(real)) for real in waits)]
    return []


def _wait(real: Callable[..., Any]) -> Callable[..., Any]:
    """Return the stand-in of a call that waits for a signal."""

    @wraps(real)
    def wait(*args: Any) -> Any:
        _check(WAIT)
        return real(*args)

    return wait


def _check(what: str = ALARM) -> None:
    """VirtualTimeError if the caller of a stand-in is a member, and none of the tools around a test."""
    scheduler = seeing_scheduler()
    if scheduler is not None and not is_of_tool(sys._getframe(2).f_globals.get("__name__", "")):
        raise refused(scheduler, what)
