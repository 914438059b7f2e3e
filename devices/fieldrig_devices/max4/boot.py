"""The boot: what happens when, and the clock that time stamps count by.

Source: PacDrive manual 4093-4110, 4317-4337 (digest PD-040 to PD-045): 8002 at 1 ms, what drives report around 14 ms,
8004 and 8005 at 92 ms, 8003 at 57 or 98 ms.  A ring comes up in no such time, with two bytes of the service channel a
cycle; so, as our reading, the clock starts when the ring has come up or was given up.  A setting starts it at power-on.
"""

from collections.abc import Callable

from fieldrig.clock import MS, Clock, Timer
from fieldrig_devices.max4.settings import BootTimes


class Boot:
    def __init__(
        self,
        clock: Clock,
        times: BootTimes,
        *,
        on_started: Callable[[], None],
        on_program: Callable[[], None],
        on_finished: Callable[[], None],
    ) -> None:
        """`on_program`: autostart is due."""
        self._clock, self._times = clock, times
        self._on_started, self._on_program, self._on_finished = on_started, on_program, on_finished
        self._zero_ns: int | None = None
        self._held: list[Callable[[], None]] = []
        self._timers: list[Timer] = []
        self._is_open = False
        """Drives are heard."""
        self._has_autostart = False
        self.is_finished = False

    @property
    def now_ms(self) -> int:
        """Timer1; 0 until the clock has started."""
        return 0 if self._zero_ns is None else (self._clock.now_ns() - self._zero_ns) // MS

    def begin(self, *, has_autostart: bool) -> None:
        """Power-on or system reset."""
        self.end()
        self._has_autostart = has_autostart
        if self._times.clock_starts == "power_on":
            self._start_clock()

    def end(self) -> None:
        """Power-off: nothing happens any more."""
        for timer in self._timers:
            timer.cancel()
        self._timers.clear()
        self._held.clear()
        self._zero_ns = None
        self._is_open = self.is_finished = False

    def settle(self) -> None:
        """The ring is up, or given up."""
        if self._zero_ns is None:
            self._start_clock()

    def when_heard(self, action: Callable[[], None]) -> None:
        """Now, or when drives are heard in the course of the boot."""
        if self._is_open:
            action()
        else:
            self._held.append(action)

    def _start_clock(self) -> None:
        self._zero_ns = self._clock.now_ns()
        times = self._times
        self._at(times.started_ms, self._on_started)
        self._at(times.drives_ms, self._on_drives)
        if self._has_autostart:
            self._at(times.program_ms, self._on_program)
        self._at(times.finished_autostart_ms if self._has_autostart else times.finished_ms, self._finish)

    def _at(self, ms: int, action: Callable[[], None]) -> None:
        assert self._zero_ns is not None
        self._timers.append(self._clock.call_at(self._zero_ns + ms * MS, action))

    def _on_drives(self) -> None:
        self._is_open = True
        held, self._held = self._held, []
        for action in held:
            action()

    def _finish(self) -> None:
        self.is_finished = True
        self._on_finished()
