"""Devices for the benchmarks: relays that answer the frame before them in a ring, and a master of drives."""

import struct
from collections.abc import Callable, Mapping

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.can.frame import CanFrame


class RelaySettings(Settings):
    number: int
    of: int


class Relay(Device):
    """Sends its frame when it hears the one before; `of` of them keep a bus busy with as many frames."""

    def __init__(self, settings: RelaySettings, can: Link[CanFrame]) -> None:
        self._can = can
        self._identifier = 0x100 + settings.number
        before = 0x100 + (settings.number - 1) % settings.of
        can.on_receive(self._on_frame, [[before, 0x7FF]])

    def start(self) -> None:
        self._can.send(CanFrame(self._identifier, bytes(8)))

    def _on_frame(self, frame: CanFrame) -> None:
        self._can.send(CanFrame(self._identifier, frame.data))


class CspMasterSettings(Settings):
    first: int
    """Node-ID of the first drive."""
    drives: int


class CspMaster(Device):
    """Leads drives in cyclic synchronous position: a set-point for each in RPDO 3, then the SYNC, once per millisecond.

    A cycle is kept if every drive has answered the SYNC by TPDO 3 before the next one.
    """

    ENABLING = (0x06, 0x07, 0x0F)

    def __init__(self, clock: Clock, settings: CspMasterSettings, can: Link[CanFrame]) -> None:
        self._clock, self._can = clock, can
        self._nodes = range(settings.first, settings.first + settings.drives)
        self.cycles = self.kept = 0
        self._answers = 0
        can.on_receive(self._on_answer, [[0x380 + node, 0x7FF] for node in self._nodes])

    def start(self) -> None:
        self._clock.call_at(self._clock.now_ns() + 500 * MS, self._begin)

    def points(self) -> Mapping[str, Point]:
        return {"cycles": Point(lambda: self.cycles), "kept": Point(lambda: self.kept)}

    def _begin(self) -> None:
        self._can.send(CanFrame(0x000, b"\x01\x00"))
        self._clock.call_at(self._clock.now_ns() + 10 * MS, self._on_cycle)

    def _on_cycle(self) -> None:
        self._clock.call_at(self._clock.now_ns() + MS, self._on_cycle)
        if self.cycles:
            self.kept += self._answers == len(self._nodes)
        self._answers = 0
        word = self.ENABLING[min(self.cycles // 10, 2)]
        place = max(self.cycles - 100, 0) * 1_000
        self.cycles += 1
        data = struct.pack("<Hi", word, place & 0x7FFF_FFFF)
        for node in self._nodes:
            self._can.send(CanFrame(0x400 + node, data))
        self._can.send(CanFrame(0x080, b""))

    def _on_answer(self, frame: CanFrame) -> None:
        self._answers += 1


class CountingSettings(Settings):
    signals: int


class Counting(Device):
    """Values that all change in each cycle of 1 ms, at next to no cost of their own."""

    has_cycle = True

    def __init__(self, clock: Clock, settings: CountingSettings) -> None:
        self._clock = clock
        self.count = 0
        self._points = {f"v{number}": Point(self._reader(number)) for number in range(settings.signals)}

    def _reader(self, number: int) -> Callable[[], float]:
        return lambda: self.count + number

    def start(self) -> None:
        self._clock.call_at(self._clock.now_ns() + MS, self._on_cycle)

    def points(self) -> Mapping[str, Point]:
        return self._points

    def _on_cycle(self) -> None:
        self._clock.call_at(self._clock.now_ns() + MS, self._on_cycle)
        self.count += 1
        if self.end_of_cycle is not None:
            self.end_of_cycle()
