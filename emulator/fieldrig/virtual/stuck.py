"""Ends a run in virtual time in which nothing goes on, such as a device that computes without end.

Processor time counts, and not that of the host, so a busy host ends no run.  A run goes on if a millisecond of virtual
time passes now and then; one in which a device calls itself again each nanosecond does not.
Left out: systems without timers of processor time, such as Windows, and calls of C that never return.
"""

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Final

from fieldrig.clock import MS

LIMIT_S: Final = 20.0
"""Processor time without a millisecond of virtual time.  Compiling a large program takes seconds at one instant."""
LOOKS: Final = 4
"""Looks in this time."""


class StuckError(BaseException):
    """Nothing goes on.  It is no Exception, so that no device takes it for an answer."""


@contextmanager
def never_stuck(now_ns: Callable[[], int]) -> Iterator[None]:
    """Raise a StuckError, with the line, in a body in which `now_ns()` stays for `LIMIT_S` of processor time.

    Within itself it does nothing, nor does it outside of the main thread, or beside another user of this timer.
    """
    if sys.platform == "win32" or not _is_free():
        yield
    else:
        seen_ns, looks = now_ns(), 0

        def on_look(_signal: int, frame: FrameType | None) -> None:
            nonlocal seen_ns, looks
            if abs(now_ns() - seen_ns) >= MS:
                seen_ns, looks = now_ns(), 0
                return
            looks += 1
            if looks >= LOOKS:
                raise StuckError(f"it has computed for {LIMIT_S:g} s and no time has passed{_where(frame)}")

        before = signal.signal(signal.SIGVTALRM, on_look)
        signal.setitimer(signal.ITIMER_VIRTUAL, LIMIT_S / LOOKS, LIMIT_S / LOOKS)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            signal.signal(signal.SIGVTALRM, before)


def _is_free() -> bool:
    """True where this thread can have the timer of the process, and nothing else uses it."""
    is_main = threading.current_thread() is threading.main_thread()
    if sys.platform != "win32" and is_main and hasattr(signal, "setitimer"):
        return not signal.getitimer(signal.ITIMER_VIRTUAL)[0]
    return False


def _where(frame: FrameType | None) -> str:
    if frame is None:
        return ""
    return f" ({Path(frame.f_code.co_filename).name}:{frame.f_lineno} in {frame.f_code.co_name})"
