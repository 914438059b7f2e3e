"""The cycles of the controller over its boots: the ring drives the real-time process, or else the clock.

Source: PacDrive manual 6967-6969 (digest PD-084); the process also runs while the ring is down.
"""

from collections.abc import Callable, Iterator

from fieldrig.clock import MS, Clock
from fieldrig.device import Point, Value
from fieldrig.link import Link
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.boot import Boot
from fieldrig_devices.max4.configuration.version import version_of
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import MAX4
from fieldrig_devices.max4.reports import Reports
from fieldrig_devices.max4.ring.real_time_bus import RealTimeBus, RingState
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.system import System


class Cycles:
    """The ring and the real-time process of one controller (`real_time_bus.Host`)."""

    def __init__(
        self, clock: Clock, ring: Link[RingMessage] | None, settings: Max4Settings, boot: Boot, reports: Reports
    ) -> None:
        self._clock, self._ring, self._settings = clock, ring, settings
        self._boot, self._reports = boot, reports
        self._actions: list[Callable[[], None]] = []
        self._system: System | None = None
        """The system of the last boot."""
        self._is_on = self._is_ticking = False
        self.end_of_cycle: Callable[[], None] | None = None
        """Called after each cycle of the real-time process, if it is set."""
        self.bus: RealTimeBus | None = None
        """The ring, or None if the controller has no ring or no drives."""

    def add(self, action: Callable[[], None]) -> None:
        """Call `action` in every cycle, between actual values and set values."""
        self._actions.append(action)

    # ---- boot and end

    def begin(self, system: System) -> None:
        """Run the process of this system, and bring its ring up."""
        self._system, self._is_on = system, True
        system.process.actions = self._actions
        self._tick_if_idle()
        if self._ring is None or not system.drives:
            self.bus = None
            self._boot.settle()
            return
        settings = self._settings
        self.bus = RealTimeBus(
            self._clock,
            self._ring,
            self,
            system.drives,
            system.drive_parameters,
            cycle_ns=system.cycle_ns,
            wait_ns=settings.boot.ring_wait_ms * MS,
            version=version_of(settings.version),
            leave_out_missing=settings.missing_drive == "leave_out",
        )
        self.bus.bring_up()

    def end(self) -> None:
        """Stop the ring and the axes, at power-off or before another boot."""
        self.stop()
        if self._system is not None:
            for simulated in self._system.process.simulated:
                simulated.stop()
        self._is_on = False

    def stop(self) -> None:
        """Stop the ring."""
        if self.bus is not None:
            self.bus.stop()

    def _tick_if_idle(self) -> None:
        """Run the process by the clock while there is no ring to drive it."""
        # A tick that is under way is kept over a boot: a second one would double the cycles.
        if not self._is_ticking and self._system is not None:
            self._is_ticking = True
            self._clock.call_at(self._clock.now_ns() + self._system.cycle_ns, self._on_tick)

    def _on_tick(self) -> None:
        self._is_ticking = False
        is_ring_there = self.bus is not None and self.bus.state in (RingState.READING, RingState.UP)
        if self._is_on and self._system is not None and not is_ring_there:
            self._tick_if_idle()
            self._run(self._system)

    # ---- for the ring (`real_time_bus.Host`)

    def report_ring(self, code: Code, ext: str = "") -> None:
        self._boot.when_heard(lambda: self._reports.report(code, MAX4, ext))

    def report_axis(self, code: int, axis: Axis, ext: str = "", *, is_logged: bool = True) -> None:
        self._boot.when_heard(lambda: self._reports.report_axis(code, axis, ext, is_logged=is_logged))

    def on_ring_settled(self) -> None:
        self._boot.settle()

    def on_ring_cycle(self) -> None:
        system, bus = self._system, self.bus
        assert system is not None
        assert bus is not None
        process = system.process
        if process.drives is not bus.present:
            process.lay_out(bus.present)
        self._run(system)

    def _run(self, system: System) -> None:
        system.process.run()
        if self.end_of_cycle is not None:
            self.end_of_cycle()

    def on_ring_lost(self) -> None:
        if self._system is not None:
            self._system.process.lay_out(())
        self._tick_if_idle()

    def quit_axes(self) -> None:
        for axis in self._system.axes.values() if self._system is not None else ():
            if axis.is_operating:
                axis.quit_errors()

    # ---- for the axes

    def on_code(self, axis: Axis, code: int) -> None:
        """Report a code of a drive, unless it is pending here; a drive shows only its most severe code."""
        shown = self._reports.code_of(code)
        if all(pending.code != shown for pending in axis.diagnosis.pending):
            self.report_axis(code, axis)

    def at_errors(self, address: int) -> int:
        """The number of ATs of a drive that did not arrive."""
        return self.bus.at_errors(address) if self.bus is not None else 0

    # ---- points

    def points(self) -> Iterator[tuple[str, Point]]:
        yield "led.bus", Point(self._led)
        yield "ring.state", Point(lambda: self.bus.state.name.lower() if self.bus is not None else "off")
        yield "ring.phase", Point(lambda: self.bus.phase if self.bus is not None else 0)
        yield "ring.open", Point(lambda: self.bus is not None and self.bus.is_open)
        yield "cycles", Point(self._count, about="cycles of the real-time process since the boot")
        yield "missed_cycles", Point(lambda: self.bus.missed_cycles if self.bus is not None else 0)

    def _count(self) -> Value:
        return 0 if self._system is None else self._system.process.cycles

    def _led(self) -> Value:
        if self.bus is None or self.bus.state in (RingState.OFF, RingState.DOWN):
            return "off"
        return "on" if self.bus.state is RingState.UP else "flashing"
