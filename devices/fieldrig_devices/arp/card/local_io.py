"""The card's own terminals: I101 to I108, O101 to O104, load cells, analog inputs and outputs, encoders.

Source: manual 3.1; digest chapter 9.  Each terminal has a wire, `NAME.I101` unless `signals` names another.  An input
reads the wire if a device drives it; until then it reads the value from a user or the settings.  Inputs are sampled
once per control loop, so shorter pulses may be missed.
"""

import logging
import math
from collections.abc import Mapping
from math import floor
from typing import Final

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.arp.signals.analog_inputs import AnalogInputs
from fieldrig_devices.arp.signals.analog_outputs import AnalogOutputs

log = logging.getLogger(__name__)

ENABLE: Final = 108
DIGITAL_INPUTS: Final = {f"I{number}": number for number in range(101, 109)}
DIGITAL_OUTPUTS: Final = {f"O{number}": number for number in range(101, 105)}
ANALOG_INPUTS: Final = {f"adc{channel}": channel for channel in range(1, 7)}
ANALOG_OUTPUTS: Final = {f"dac{channel}": channel for channel in (1, 2)}
ENCODERS: Final = {f"encoder{axis}": axis for axis in (1, 2)}
INPUTS: Final = (*DIGITAL_INPUTS, *ANALOG_INPUTS, *ENCODERS)
OUTPUTS: Final = (*DIGITAL_OUTPUTS, *ANALOG_OUTPUTS)
TERMINALS: Final = (*INPUTS, *OUTPUTS)
UNITS: Final = dict.fromkeys((*ANALOG_INPUTS, *ANALOG_OUTPUTS), "V") | dict.fromkeys(ENCODERS, "count")
_LARGEST_COUNT: Final = 1e15  # a float beyond it cannot represent every integer

Number = bool | int | float


class LocalIo:
    def __init__(
        self,
        clock: Clock,
        wires: Link[Signal] | None,
        names: Mapping[str, str],
        tables: tuple[list[int], list[int]],
        analog: tuple[AnalogInputs, AnalogOutputs],
        latch_inputs: tuple[int, int],
    ) -> None:
        """`names` are the wires by terminal, and `tables` are the card's I and O."""
        self._clock, self._wires, self._names = clock, wires, names
        self._inputs, self._outputs = tables
        self._analog_inputs, self._analog_outputs = analog
        self._latch_1, self._latch_2 = latch_inputs
        self._levels = [0] * len(DIGITAL_INPUTS)
        self._present: dict[str, Number] = dict.fromkeys(DIGITAL_INPUTS, False) | dict.fromkeys(ANALOG_INPUTS, 0.0)
        self._driven: set[str] = set()
        self._refused: set[str] = set()
        self._encoders: list[Signal | None] = [None, None, None]
        self._sent_bits: list[int] = []
        self._sent_volts = [math.nan, math.nan, math.nan]
        self.counts: list[int | None] = [None, None, None]
        """Encoder counts by axis, as sampled; None before the first signal."""
        self.latches = [0, 0, 0]
        """Levels of the latch inputs, by axis, as sampled."""
        self._terminals: dict[str, list[str]] = {}
        """Inputs by wire; several inputs may share a wire, as both counters of one encoder do."""
        for terminal in INPUTS:
            self._terminals.setdefault(names[terminal], []).append(terminal)
        if wires is not None:
            wires.on_receive(self._on_signal, tuple(self._terminals))

    @property
    def is_enabled(self) -> bool:
        """Present level of I108."""
        return bool(self._levels[ENABLE - 101])

    # ---- inputs

    def present(self, terminal: str) -> Number:
        """Present value at an input, even between two samples; 0 for an encoder without a signal."""
        axis = ENCODERS.get(terminal)
        if axis is None:
            return self._present[terminal]
        counts = self._counted(axis, self._clock.now_ns())
        return (self.counts[axis] or 0) if counts is None else counts

    def _counted(self, axis: int, now_ns: int) -> int | None:
        """Count of an axis' encoder at `now_ns`, or None without a signal or beyond the range of the encoder."""
        signal = self._encoders[axis]
        position = None if signal is None else signal.at(now_ns)
        return floor(position) if position is not None and -_LARGEST_COUNT < position < _LARGEST_COUNT else None

    def put(self, terminal: str, value: Number) -> None:
        """Set the value at an input.  Raises ValueError if a wire drives the input, or for an invalid value."""
        if terminal in self._driven:
            raise ValueError(f"the wire {self._names[terminal]} drives {terminal}")
        if not accepts(terminal, value):
            expected = "true or false" if terminal in DIGITAL_INPUTS else "a number"
            raise ValueError(f"{terminal} cannot be {value!r}; expected {expected}")
        self._take(terminal, Signal("", value))

    def _on_signal(self, signal: Signal) -> None:
        if not _is_finite(signal):
            return
        for terminal in self._terminals.get(signal.name, ()):
            if terminal not in DIGITAL_INPUTS and signal.unit != UNITS[terminal]:
                self._refuse(terminal, signal)
            else:
                self._driven.add(terminal)
                self._take(terminal, signal)

    def _refuse(self, terminal: str, signal: Signal) -> None:
        if terminal not in self._refused:
            self._refused.add(terminal)
            log.warning(
                "%s has the unit %r, but %s has %r; the signal is ignored",
                signal.name,
                signal.unit,
                terminal,
                UNITS[terminal],
            )

    def _take(self, terminal: str, signal: Signal) -> None:
        axis = ENCODERS.get(terminal)
        if axis is not None:
            self._encoders[axis] = signal
        elif terminal in DIGITAL_INPUTS:
            self._present[terminal] = bool(signal.value)
            self._levels[DIGITAL_INPUTS[terminal] - 101] = int(bool(signal.value))
        else:
            self._present[terminal] = float(signal.value)
            self._analog_inputs.take(ANALOG_INPUTS[terminal], float(signal.value))

    def sample(self, now_ns: int) -> None:
        """Sample all inputs, once per control loop."""
        inputs, latches, counts = self._inputs, self.latches, self.counts
        inputs[101:109] = self._levels
        latches[1], latches[2] = inputs[self._latch_1], inputs[self._latch_2]
        for axis in (1, 2):
            position = self._counted(axis, now_ns)
            if position is not None:
                counts[axis] = position

    # ---- outputs

    def send_changes(self) -> None:
        """Send the outputs that have changed, once per control loop; the first call sends all of them."""
        if self._wires is None:
            return
        bits = self._outputs[101:105]
        if bits != self._sent_bits:
            self._send_bits(bits)
        volts = self._analog_outputs.volts
        sent = self._sent_volts
        for channel in (1, 2):
            volt = volts(channel)
            if volt != sent[channel]:
                sent[channel] = volt
                self._wires.send(Signal(self._names[f"dac{channel}"], volt, "V"))

    def _send_bits(self, bits: list[int]) -> None:
        assert self._wires is not None
        sent = self._sent_bits or [-1] * len(bits)
        self._sent_bits = bits
        for (terminal, number), was in zip(DIGITAL_OUTPUTS.items(), sent, strict=True):
            bit = bits[number - 101]
            if bit != was:
                self._wires.send(Signal(self._names[terminal], bool(bit)))


def wire_names(card: str, signals: Mapping[str, str]) -> dict[str, str]:
    return {terminal: signals.get(terminal, f"{card}.{terminal}") for terminal in TERMINALS}


def accepts(terminal: str, value: Number) -> bool:
    """True if the input can take the value."""
    if terminal in DIGITAL_INPUTS:
        return value in (0, 1)
    return terminal in INPUTS and not isinstance(value, bool) and abs(value) < _LARGEST_COUNT


def _is_finite(signal: Signal) -> bool:
    if isinstance(signal, Motion) and not (math.isfinite(signal.speed) and math.isfinite(signal.acceleration)):
        return False
    return math.isfinite(signal.value)
