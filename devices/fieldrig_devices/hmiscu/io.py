"""The terminals of the controller, and the process image of the task MAST.

Source: manual 2315-2320 (SCU-095): MAST copies the inputs before it runs, and writes the outputs after it.  The
library manual assigns no addresses and no ranges; ours:

    %IX0.n   DIn, n below 16      %QX0.n   DQn
    %IX1.n   FIn                  %QX1.n   FQn, unless a channel has it (SCU-075)
    %IW2..   AIn, 0 to 4095       %QW2..   AQn, 0 to 4095
    %IW4..   TIn, 0.1 of its unit
"""

import struct
from collections.abc import Callable, Iterator
from functools import partial
from typing import Final, NamedTuple

from fieldrig.clock import Clock
from fieldrig.device import Point, Value
from fieldrig.link import Link
from fieldrig.points.checks import number_in, truth_in, whole_in
from fieldrig_bus.wires import Signal
from fieldrig_devices.hmiscu.models import Kind
from fieldrig_devices.hmiscu.settings import INPUTS, MOST_RAW, AnalogWire, HmiscuSettings
from fieldrig_devices.iec.layout import AREA_SIZE

FIRST_WORDS: Final = {"DI": 0, "FI": 1, "AI": 2, "TI": 4, "DQ": 0, "FQ": 1, "AQ": 2}
"""The word of the first terminal by the prefix of its name; digital terminals share it as bits."""
PER_DEGREE: Final = 10
_LOWEST, _HIGHEST = -0x8000, 0x7FFF
_WORD: Final = struct.Struct("<h")


class Place(NamedTuple):
    """The place of a terminal in its area; `bit` is -1 for a word."""

    byte: int
    bit: int


def place_of(terminal: str) -> Place:
    prefix, number = terminal[:2], int(terminal[2:])
    word = FIRST_WORDS[prefix]
    if prefix in ("AI", "TI", "AQ"):
        return Place(2 * (word + number), -1)
    return Place(2 * word + number // 8, number % 8)


class Terminals:
    """All terminals of one controller."""

    def __init__(self, clock: Clock, settings: HmiscuSettings, wires: Link[Signal] | None) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self.inputs, self.outputs = bytearray(AREA_SIZE), bytearray(AREA_SIZE)
        self._kinds = settings.kinds
        self._signals: dict[str, Signal] = {}
        """The last signal of each input."""
        self._shown: dict[str, int] = {}
        """The raw values of outputs as they are on the terminals."""
        self.on_input: Callable[[str], None] = lambda terminal: None
        """Called with the terminal after each signal for an input."""
        self._by_wire: dict[str, list[str]] = {}
        for terminal in settings.terminals:
            if self._kinds[terminal] in INPUTS:
                self._by_wire.setdefault(settings.wire_of(terminal), []).append(terminal)
        self._outputs = [
            terminal
            for terminal, kind in self._kinds.items()
            if kind not in INPUTS and terminal not in settings.dedicated
        ]
        if wires is not None and self._by_wire:
            wires.on_receive(self._on_signal, sorted(self._by_wire))

    def start(self) -> None:
        """Switch the outputs off, as at power-on."""
        self._shown.clear()
        self.fall()

    # ---- the process image

    def take(self) -> None:
        """Copy all inputs into the image."""
        for terminal in self._signals:
            _put(self.inputs, place_of(terminal), self.raw(terminal))

    def give(self) -> None:
        """Write the image to the outputs."""
        for terminal in self._outputs:
            self._give(terminal)

    def _give(self, terminal: str) -> None:
        raw = _get(self.outputs, place_of(terminal))
        if self._shown.get(terminal) != raw:
            self._shown[terminal] = raw
            self._send(terminal, raw)

    def fall(self) -> None:
        """Switch all outputs off, because the controller has left RUN."""
        for terminal in self._outputs:
            _put(self.outputs, place_of(terminal), 0)
        self.give()

    def _send(self, terminal: str, raw: int) -> None:
        wire = self._settings.terminals.get(terminal)
        if self._wires is None or wire is None:
            return
        if isinstance(wire, AnalogWire):
            value = wire.low + (wire.high - wire.low) * min(max(raw, 0), MOST_RAW) / MOST_RAW
            self._wires.send(Signal(wire.wire, value, wire.unit))
        else:
            self._wires.send(Signal(wire, bool(raw)))

    # ---- inputs

    def _on_signal(self, signal: Signal) -> None:
        for terminal in self._by_wire[signal.name]:
            self._signals[terminal] = signal
            self.on_input(terminal)

    def level(self, terminal: str) -> bool:
        """The present level of a digital input."""
        return bool(self.raw(terminal))

    def raw(self, terminal: str) -> int:
        """The present raw value of an input."""
        signal = self._signals.get(terminal)
        if signal is None:
            return 0
        value, kind = signal.at(self._clock.now_ns()), self._kinds[terminal]
        if kind == "digital input":
            return int(bool(value))
        if kind == "temperature input":
            return min(max(round(value * PER_DEGREE), _LOWEST), _HIGHEST)
        wire = self._settings.terminals.get(terminal)
        low, high = (wire.low, wire.high) if isinstance(wire, AnalogWire) else (0.0, float(MOST_RAW))
        return min(max(round((value - low) / (high - low) * MOST_RAW), 0), MOST_RAW)

    # ---- points

    def points(self) -> Iterator[tuple[str, Point]]:
        """A point for each terminal; inputs without a wire can be set."""
        for terminal, kind in self._kinds.items():
            if terminal in self._settings.dedicated:
                continue
            is_input = kind in INPUTS
            wire = self._settings.wire_of(terminal)
            about = f"{kind}, wire {wire}" if wire else kind
            read = partial(self._read, terminal, kind)
            if not is_input:
                yield terminal, Point(read, partial(self._set_output, terminal, kind), about=about)
            else:
                yield terminal, Point(read, None if wire else partial(self._set_input, terminal, kind), about=about)

    def _read(self, terminal: str, kind: Kind) -> Value:
        raw = self.raw(terminal) if kind in INPUTS else self._shown.get(terminal, 0)
        return bool(raw) if kind.startswith("digital") else raw

    def _set_input(self, terminal: str, kind: Kind, value: Value) -> None:
        """Set an input that has no wire: a level, a raw value, or a temperature in 0.1 of its unit."""
        if kind == "digital input":
            signal = Signal(terminal, truth_in(value))
        elif kind == "temperature input":
            signal = Signal(terminal, whole_in(value, _LOWEST, _HIGHEST) / PER_DEGREE)
        else:
            signal = Signal(terminal, float(number_in(value, 0, MOST_RAW)))
        self._signals[terminal] = signal
        self.on_input(terminal)

    def _set_output(self, terminal: str, kind: Kind, value: Value) -> None:
        """Set an output in the image.  One that a program writes refuses it before."""
        raw = int(truth_in(value)) if kind == "digital output" else whole_in(value, 0, MOST_RAW)
        _put(self.outputs, place_of(terminal), raw)
        self._give(terminal)  # at once, so that who sets it reads it


def _put(area: bytearray, place: Place, raw: int) -> None:
    if place.bit < 0:
        _WORD.pack_into(area, place.byte, raw)
    else:
        area[place.byte] = area[place.byte] & ~(1 << place.bit) | bool(raw) << place.bit


def _get(area: bytearray, place: Place) -> int:
    if place.bit < 0:
        word: int = _WORD.unpack_from(area, place.byte)[0]
        return word
    return area[place.byte] >> place.bit & 1
