"""The boot: its events in time, and the clock of the time stamps.

Source: PacDrive manual 4093-4110, 4317-4337 (digest PD-040 to PD-045): 8002 at 1 ms, reports of drives around 14 ms,
8004 and 8005 at 92 ms, 8003 at 57 or 98 ms.  With two bytes of the service channel per cycle, a ring cannot come up
that fast; our reading is that the clock starts when the ring is up or has failed.  A setting starts it at power-on.
"""

from collections.abc import Callable

from fieldrig.clock import MS, Clock, Timer
from fieldrig_devices.max4.settings import BootTimes


class Boot:
    """The boot of one controller."""

    def __init__(
        self,
        clock: Clock,
        times: BootTimes,
        *,
        on_started: Callable[[], None],
        on_program: Callable[[], None],
        on_finished: Callable[[], None],
    ) -> None:
        """`on_program` is called when autostart is due."""
        self._clock, self._times = clock, times
        self._on_started, self._on_program, self._on_finished = on_started, on_program, on_finished
        self._zero_ns: int | None = None
        self._held: list[Callable[[], None]] = []
        self._timers: list[Timer] = []
        self._is_open = False
        """True once reports of drives are let through."""
        self._has_autostart = False
        self.is_finished = False

    def now_ms(self) -> int:
        """Timer1 in milliseconds; 0 until the clock has started."""
        return 0 if self._zero_ns is None else (self._clock.now_ns() - self._zero_ns) // MS

    def begin(self) -> None:
        """Start a boot, after power-on or a system reset."""
        self.end()

    def go(self, *, has_autostart: bool) -> None:
        """Go on when it is known whether there is a program to start."""
        self._has_autostart = has_autostart
        if self._times.clock_starts == "power_on":
            self._start_clock()

    def end(self) -> None:
        """Cancel the boot and stop the clock, at power-off or before a reset."""
        for timer in self._timers:
            timer.cancel()
        self._timers.clear()
        self._held.clear()
        self._zero_ns = None
        self._is_open = self.is_finished = False

    def settle(self) -> None:
        """Start the clock, because the ring is up or has failed."""
        if self._zero_ns is None:
            self._start_clock()

    def when_heard(self, action: Callable[[], None]) -> None:
        """Call `action` now, or at the point of the boot at which reports of drives are let through."""
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
