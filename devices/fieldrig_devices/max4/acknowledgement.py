"""Acknowledging diagnoses, which the manual calls to quit: of the controller, of an axis, and of its drive.

Source: PacDrive manual 4163-4196, 5344-5355 (digest PD-091 to PD-098, PD-130 to PD-141).  A diagnosis whose cause is
still present stays.  The diagnoses of a drive are reset in the drive first (S-0-0099), which takes many cycles.
"""

from collections.abc import Callable, Iterable

from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import Pending
from fieldrig_devices.max4.reports import SUB_UNIT, Reports
from fieldrig_devices.max4.ring.drive_end import RingDrive
from fieldrig_devices.max4.ring.real_time_bus import RealTimeBus
from fieldrig_devices.sercos import standard_idns as std


class Acknowledgement:
    """Acknowledges diagnoses of one controller; `bus` returns its ring, or None while it has no ring."""

    def __init__(self, reports: Reports, bus: Callable[[], RealTimeBus | None]) -> None:
        self._reports, self._bus = reports, bus

    def of_all(self, axes: Iterable[Axis]) -> None:
        """Acknowledge the diagnoses of the controller and of `axes`, and bring up a ring that is down."""
        bus, axes = self._bus(), tuple(axes)
        if bus is not None:
            bus.quit()
        for axis in axes:
            axis.quit_errors()
        stations = {f"{axis.ring_address}.{SUB_UNIT}" for axis in axes}
        self._reports.diagnosis.quit(
            lambda pending: pending.ext.split(" ")[0] not in stations and not self._is_ring_failing(pending)
        )

    def of_axis(self, axis: Axis, done: Callable[[bool], None] | None) -> None:
        """Acknowledge the diagnoses of an axis, then call `done` with true if no error is left."""
        drive, station = axis.drive, f"{axis.ring_address}.{SUB_UNIT} "

        def on_reset(is_good: bool) -> None:
            axis.diagnosis.quit(lambda pending: not self._is_present(axis, pending))
            self._reports.diagnosis.quit(
                lambda pending: pending.ext.startswith(station) and not self._is_present(axis, pending)
            )
            if done is not None:
                done(is_good and not axis.is_in_error)

        if drive is None:
            on_reset(True)
        else:
            drive.command(std.RESET_CLASS_1, on_reset)

    def _is_present(self, axis: Axis, pending: Pending) -> bool:
        """True if the cause of a diagnosis of the axis is still present."""
        drive, code_of = axis.drive, self._reports.code_of
        if isinstance(drive, RingDrive):
            is_refused = drive.is_refused and pending.code == code_of(Code.VERSION)
            return is_refused or bool(drive.code and code_of(drive.code) == pending.code)
        return self._is_ring_failing(pending)

    def _is_ring_failing(self, pending: Pending) -> bool:
        """True if the diagnosis is of the ring, and its cause is still present."""
        bus = self._bus()
        return bus is not None and bus.is_still_wrong(pending.code)
