"""The supervision of the master of a DualPort, which serves a watchdog in its memory (PAMS-081, PAMS-093)."""

from collections.abc import Callable

from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.variables import PortStatus
from fieldrig_devices.pam.runtime.item import Kernel


class Watchdog:
    def __init__(self, status: PortStatus, kernel: Kernel, options: PortOptions, take: Callable[[], bool]) -> None:
        """`take` says whether the master has served the watchdog, and gives it back to the master."""
        self._status, self._kernel, self._take = status, kernel, take
        self._resumes = options.lost_master == "resumes"
        self._heard_ns = 0
        self.is_lost = False
        """True while the application runs without its master."""

    def begin(self, now_ns: int) -> None:
        self._heard_ns, self.is_lost = now_ns, False

    def look(self, now_ns: int) -> bool:
        """Return True if the master was lost or found in this moment."""
        if self.is_lost and not self._resumes:
            return False
        if self._take():
            self._heard_ns = now_ns
            return self._change(False)
        limit_ns = self._status.duration_ns("MASTER_INACTIVITY_TIMEOUT")
        return limit_ns is not None and now_ns - self._heard_ns > limit_ns and self._change(True)

    def _change(self, is_lost: bool) -> bool:
        if is_lost is self.is_lost:
            return False
        self.is_lost = is_lost
        self._status.set_error(is_lost)
        if is_lost:
            self._kernel.report("07..E01E")
        return True
