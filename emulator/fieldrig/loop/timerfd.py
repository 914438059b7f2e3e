"""Linux timerfd by ctypes: a descriptor that becomes readable at an absolute instant of CLOCK_MONOTONIC.

asyncio's own timers are rounded up to milliseconds by epoll; a timerfd is late by some tens of microseconds.
(Python 3.13 has `os.timerfd_create`; 3.11 has not.)
"""

import ctypes
import os
import sys
from typing import Final

CLOCK_MONOTONIC: Final = 1
TFD_NONBLOCK: Final = os.O_NONBLOCK if hasattr(os, "O_NONBLOCK") else 0
TFD_CLOEXEC: Final = getattr(os, "O_CLOEXEC", 0)
TFD_TIMER_ABSTIME: Final = 1


class _Timespec(ctypes.Structure):
    _fields_ = (("tv_sec", ctypes.c_long), ("tv_nsec", ctypes.c_long))


class _Itimerspec(ctypes.Structure):
    _fields_ = (("it_interval", _Timespec), ("it_value", _Timespec))


class TimerFd:
    """One timer.  OSError where the kernel has none; ask `is_available` first."""

    def __init__(self) -> None:
        self._libc = ctypes.CDLL(None, use_errno=True)
        self.fd: int = self._libc.timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)
        if self.fd < 0:
            raise OSError(ctypes.get_errno(), "timerfd_create")
        self._spec = _Itimerspec()
        self._spec_pointer = ctypes.byref(self._spec)
        self._settime = self._libc.timerfd_settime

    def arm(self, when_ns: int) -> None:
        """Become readable at `when_ns` of `time.monotonic_ns()`, or at once if that is in the past."""
        value = self._spec.it_value
        value.tv_sec, value.tv_nsec = divmod(max(when_ns, 1), 1_000_000_000)
        self._settime(self.fd, TFD_TIMER_ABSTIME, self._spec_pointer, None)

    def clear(self) -> None:
        """Acknowledge an expiry, so that the descriptor is no longer readable."""
        try:
            os.read(self.fd, 8)
        except BlockingIOError:  # re-armed between readiness and this read
            return

    def close(self) -> None:
        os.close(self.fd)


def is_available() -> bool:
    return sys.platform == "linux"
