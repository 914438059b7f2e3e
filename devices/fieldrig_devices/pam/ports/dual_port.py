"""The part of the PAM's end of a DualPort that VME and Simatic have in common (chapters 13 and 14)."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Final

from fieldrig_devices.pam.language.ports import PortPlan
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.variables import IsActive, PortItem, PortStatus, items_of
from fieldrig_devices.pam.runtime.item import Kernel


class Watchdog:
    """The supervision of the master, which serves a watchdog in the memory (PAMS-081, PAMS-093)."""

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


MASTER_READY: Final = "MASTER_READY_TIMEOUT"
MASTER_CONFIGURATION: Final = "MASTER_CONFIGURATION_TIMEOUT"


class DualPortState(Enum):
    """The states of both; configuring is VME's alone, and waiting for the host Simatic's."""

    PRESET = "preset"
    SYNC = "synchronising"
    CONFIG_IN = "configuring inputs"
    CONFIG_OUT = "configuring outputs"
    INIT = "initialising"
    WAIT_START = "waiting for START"
    WAIT_HOST = "waiting for the host"
    RUN = "running"
    RUN_NO_MASTER = "running without a master"
    RUN_ALONE = "running without its DualPort"
    FATAL = "fatal error"


_RUNNING: Final = frozenset({DualPortState.RUN, DualPortState.RUN_NO_MASTER, DualPortState.RUN_ALONE})


class DualPort(ABC):
    def __init__(self, plan: PortPlan, kernel: Kernel, is_active: IsActive, options: PortOptions) -> None:
        self._kernel, self._options = kernel, options
        self.status = PortStatus("DualPort", plan, kernel)
        self.items: Mapping[str, Sequence[PortItem]] = items_of(plan.variables, kernel, is_active, self._push)
        self.state = DualPortState.PRESET
        self.may_run = False
        """True when the application runs, or may begin to."""
        self._watchdog = Watchdog(self.status, kernel, options, self._take_watchdog)
        self._deadline_ns: int | None = None
        self._now_ns = 0

    @property
    def state_text(self) -> str:
        return self.state.value

    def enter(self, state: DualPortState, timeout: str = "") -> None:
        """Change the state; `timeout` is the parameter of the object that limits it."""
        self.state, self.may_run = state, state in _RUNNING
        self._wait(timeout)

    def fail(self) -> None:
        """Stop for a fatal error; only `begin` leads on."""
        self.enter(DualPortState.FATAL)

    def give(self) -> None:  # noqa: B027  an RS422 line has something to do here, a memory has not
        """Do nothing: a change of an output is written when it happens."""

    def _wait(self, timeout: str) -> None:
        """Wait for the master as long as this parameter says, from now on; without a parameter, forever."""
        duration_ns = self.status.duration_ns(timeout)
        self._deadline_ns = None if duration_ns is None else self._now_ns + duration_ns

    def _fail_if_late(self) -> None:
        """Stop if the master has not done its part of the start-up in time."""
        if self._deadline_ns is not None and self._now_ns >= self._deadline_ns:
            self.fail()
            self._kernel.report("07..F020")

    def _look_for_master(self) -> None:
        """Look at the watchdog, and run on without the master, or with it again."""
        if self._watchdog.look(self._now_ns):
            self.enter(DualPortState.RUN_NO_MASTER if self._watchdog.is_lost else DualPortState.RUN)

    @abstractmethod
    def _push(self, item: PortItem) -> None:
        """Tell the master that a program has changed an output."""

    @abstractmethod
    def _take_watchdog(self) -> bool:
        """Return whether the master has served the watchdog, and give it back to the master."""
