"""The hardware of a node: terminals, LEDs, display and analog output, and the faults that come from it."""

from typing import Any, Final

from fieldrig.clock import MS, Clock
from fieldrig.faults.injected import InjectedFaults
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.smart_io.addresses import group_of, place_of
from fieldrig_devices.smart_io.display import Display
from fieldrig_devices.smart_io.faults import BrokenWire, DamagedFrames, FullFifo, Overtemperature, ShortCircuit
from fieldrig_devices.smart_io.lamp import Lamp
from fieldrig_devices.smart_io.settings import SmartIoSettings
from fieldrig_devices.smart_io.terminals import Terminals
from fieldrig_devices.smart_io.troubles import (
    NODE,
    NODE_BITS,
    OUTPUT,
    FaultCode,
    Key,
    Troubles,
    heat_sink_bit,
    output_detail,
)

Injected = InjectedFaults[Any]

BLINK_NS: Final = 1_000 * MS
"""Period of blinking, on for one half; the manual says that it is fixed (11.1)."""


class Board:
    """The hardware of one node."""

    def __init__(
        self, clock: Clock, settings: SmartIoSettings, terminals: Terminals, troubles: Troubles, faults: Injected
    ) -> None:
        self._settings, self._faults = settings, faults
        self.terminals, self.troubles = terminals, troubles
        self.modules = frozenset(settings.modules)
        self.has_display = settings.keyboard == "006.7012"
        self.display = Display(clock, BLINK_NS // 2, settings.readings.font)
        self.lamps = {number: Lamp(clock, terminals, f"led{number}", BLINK_NS // 2) for number in settings.leds}
        self.millivolts = 0
        """Value of the analog output."""
        self._present: dict[Key, int] = {}
        """The faults of the hardware as they were at the last look."""
        terminals.on_short = self.look

    def has_key(self, number: int) -> bool:
        return number in self._settings.keys

    def put_analog(self, millivolts: int) -> None:
        if millivolts != self.millivolts:
            self.millivolts = millivolts
            self.terminals.drive_analog("analog1", millivolts)

    def apply_faults(self) -> None:
        """Let the injected faults that are on at present have their effect."""
        broken = frozenset(f"in{fault.address}" for fault in self._faults.active(BrokenWire))
        shorted = frozenset(f"out{fault.address}" for fault in self._faults.active(ShortCircuit))
        full = self._faults.first(FullFifo)
        self.display.held_fifo = 0 if full is None else full.number
        self.terminals.fail(broken, shorted)
        self.look()

    def look(self) -> None:
        """Report the faults of the hardware that have begun or ended."""
        there = self._there()
        for key, bits in there.items():
            if key not in self._present:
                self.troubles.begin(key[0], key[1:], bits)
        for key in self._present:
            if key not in there:
                self.troubles.end(key[0], key[1:])
        self._present = there

    def _there(self) -> dict[Key, int]:
        keys: dict[Key, int] = {}
        for terminal in self.terminals.shorts():
            address = int(terminal.removeprefix("out"))
            keys[OUTPUT, output_detail(place_of(address)[0], group_of(address)), int(FaultCode.SHORT_CIRCUIT)] = 0
        for hot in self._faults.active(Overtemperature):
            if hot.module is None:
                keys[NODE, int(FaultCode.AMBIENT), 0] = NODE_BITS[FaultCode.AMBIENT]
            else:
                keys[OUTPUT, output_detail(hot.module, 0), int(FaultCode.HEAT_SINK)] = heat_sink_bit(hot.module)
        damaged = {frames.of for frames in self._faults.active(DamagedFrames)}
        if "crc" in damaged or self.display.ring is RingFault.CRC:
            keys[NODE, int(FaultCode.CRC), 0] = NODE_BITS[FaultCode.CRC]
        if "type" in damaged:
            keys[NODE, int(FaultCode.FRAME_TYPE), 0] = NODE_BITS[FaultCode.FRAME_TYPE]
        for full in self._faults.active(FullFifo):
            keys[NODE, int(FaultCode.FIFO), full.number] = NODE_BITS[FaultCode.FIFO]
        return keys
