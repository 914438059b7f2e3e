"""The terminals of a single drive: inputs from wires and from switches at the load, and outputs on wires."""

from collections.abc import Callable
from math import inf

from fieldrig.link import Link
from fieldrig_bus.wires import Signal
from fieldrig_devices.cia402.motor import Captured
from fieldrig_devices.cia402.single.settings import FIRST_FREE, INPUTS, Cia402DriveSettings
from fieldrig_devices.plants.switches import Switch


class Inputs:
    """The digital inputs as in 60FDh, and the digital outputs."""

    def __init__(self, settings: Cia402DriveSettings, name: str, wires: Link[Signal] | None) -> None:
        self._wires, self._output_wires = wires, settings.output_wires
        named = {settings.wire_for(name, what): bit for what, bit in INPUTS.items()}
        self.bits = named | {wire: bit for bit, wire in enumerate(settings.input_wires, FIRST_FREE)}
        """Bits in 60FDh by wire."""
        self._switches = [
            (1 << INPUTS[what], Switch("", cam.low, cam.high, cam.every or inf))
            for what, cam in settings.switches.items()
        ]
        self._levels = 0
        self._outputs = 0
        self.captured: dict[int, Captured] = {}
        """The last edge of each input that is on a wire, by its bit."""

    def take(self, signal: Signal, capture: Callable[[], Captured]) -> None:
        """Take a new level of a wire; `capture` returns position and instant of an edge."""
        bit = self.bits[signal.name]
        levels = self._levels & ~(1 << bit) | bool(signal.value) << bit
        if levels != self._levels:
            self._levels = levels
            self.captured[bit] = capture()

    def set(self, bit: int, is_on: bool) -> None:
        """Set an input as its wire would."""
        self._levels = self._levels & ~(1 << bit) | is_on << bit

    def level(self, bit: int) -> bool:
        return bool(self._levels >> bit & 1)

    def word(self, position: float) -> int:
        """The inputs as in 60FDh, with the load at this position in rad."""
        word = self._levels
        for bit, switch in self._switches:
            if switch.is_closed(position):
                word |= bit
        return word

    def show_outputs(self, outputs: int) -> None:
        """Drive the outputs; the first one is bit 0."""
        changed, self._outputs = outputs ^ self._outputs, outputs
        if self._wires is not None:
            for place, wire in enumerate(self._output_wires):
                if changed >> place & 1:
                    self._wires.send(Signal(wire, bool(outputs >> place & 1)))
