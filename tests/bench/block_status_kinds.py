"""A device for the benchmark of block status: it compares the end of each move with the status that reports it."""

import time

from fieldrig.device import Device, Point
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Signal

MOST = 10_000


class StatusWatchSettings(Settings):
    pulses: str
    """Wire of the pulses."""
    status: str
    """Wire that is true while the block reports Done."""


class StatusWatch(Device):
    """Notes how late the status arrives after the exact end of the pulses, in nanoseconds.

    It reads the clock of the host, because a device's own clock gives the instant at which an event was due.
    """

    def __init__(self, settings: StatusWatchSettings, wires: Link[Signal]) -> None:
        self._settings = settings
        self._end_ns = 0
        self.late_ns: list[int] = []
        wires.on_receive(self._on_signal, [settings.pulses, settings.status])

    def _on_signal(self, signal: Signal) -> None:
        if isinstance(signal, PulseTrain):
            end_ns = signal.end_ns
            if end_ns is not None and end_ns > signal.start_ns:
                self._end_ns = end_ns
        elif signal.name == self._settings.status and signal.value and self._end_ns and len(self.late_ns) < MOST:
            self.late_ns.append(time.monotonic_ns() - self._end_ns)

    def points(self) -> dict[str, Point]:
        return {"late_ns": Point(lambda: " ".join(map(str, self.late_ns)))}
