"""The card's own terminals: I101 to I108, O101 to O104, load cells, analog inputs and outputs, encoders.

Source: manual 3.1; digest chapter 9.  Each terminal has a wire, `NAME.I101` unless `signals` says otherwise.  A wire
that somebody drives is what an input reads; until then it reads what a person or the settings put there.  Inputs are
sampled once a control loop, so what is shorter than that may be missed.
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
_LARGEST_COUNT: Final = 1e15  # beyond it a float no longer counts one by one

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
        """`names` are the wires by terminal, `tables` the card's I and O."""
        self._clock, self._wires, self._names = clock, wires, names
        self._inputs, self._outputs = tables
        self._analog_inputs, self._analog_outputs = analog
        self._latch_1, self._latch_2 = latch_inputs
        self._levels = [0] * len(DIGITAL_INPUTS)
        self._present: dict[str, Number] = dict.fromkeys(DIGITAL_INPUTS, False) | dict.fromkeys(ANALOG_INPUTS, 0.0)
        self._driven: set[str] = set()
        self._refused: set[str] = set()
        self._encoders: list[Signal | None] = [None, None, None]
        self._told_bits: list[int] = []
        self._told_volts = [math.nan, math.nan, math.nan]
        self.counts: list[int | None] = [None, None, None]
        """Of the encoders, by axis, as sampled; None: nobody has said yet."""
        self.latches = [0, 0, 0]
        """Levels of the latch inputs, by axis, as sampled."""
        self._terminals: dict[str, list[str]] = {}
        """Inputs by wire: several may feel the same one, as both counters that of one encoder."""
        for terminal in INPUTS:
            self._terminals.setdefault(names[terminal], []).append(terminal)
        if wires is not None:
            wires.on_receive(self._on_signal, tuple(self._terminals))

    @property
    def is_enabled(self) -> bool:
        """The level of I108, as it is now."""
        return bool(self._levels[ENABLE - 101])

    # ---- inputs

    def present(self, terminal: str) -> Number:
        """The value at an input at this instant, between two samples too; 0 for an encoder without a signal."""
        axis = ENCODERS.get(terminal)
        if axis is None:
            return self._present[terminal]
        counts = self._counted(axis, self._clock.now_ns())
        return (self.counts[axis] or 0) if counts is None else counts

    def _counted(self, axis: int, now_ns: int) -> int | None:
        """What the encoder of an axis has counted by `now_ns`; None without a signal, or beyond what it can count."""
        signal = self._encoders[axis]
        position = None if signal is None else signal.at(now_ns)
        return floor(position) if position is not None and -_LARGEST_COUNT < position < _LARGEST_COUNT else None

    def put(self, terminal: str, value: Number) -> None:
        """Feel `value`.  ValueError if a wire drives this input, or for what it can't feel."""
        if terminal in self._driven:
            raise ValueError(f"the wire {self._names[terminal]} drives {terminal}")
        if not feels(terminal, value):
            raise ValueError(f"{terminal} takes {'true or false' if terminal in DIGITAL_INPUTS else 'a number'}")
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
            log.warning("%s is in %r, %s in %r; not taken", signal.name, signal.unit, terminal, UNITS[terminal])

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
        """Once a control loop."""
        inputs, latches, counts = self._inputs, self.latches, self.counts
        inputs[101:109] = self._levels
        latches[1], latches[2] = inputs[self._latch_1], inputs[self._latch_2]
        for axis in (1, 2):
            position = self._counted(axis, now_ns)
            if position is not None:
                counts[axis] = position

    # ---- outputs

    def tell(self) -> None:
        """Once a control loop: the outputs that have changed; each at first."""
        if self._wires is None:
            return
        bits = self._outputs[101:105]
        if bits != self._told_bits:
            self._tell_bits(bits)
        volts = self._analog_outputs.volts
        told = self._told_volts
        for channel in (1, 2):
            volt = volts(channel)
            if volt != told[channel]:
                told[channel] = volt
                self._wires.send(Signal(self._names[f"dac{channel}"], volt, "V"))

    def _tell_bits(self, bits: list[int]) -> None:
        assert self._wires is not None
        told = self._told_bits or [-1] * len(bits)
        self._told_bits = bits
        for (terminal, number), was in zip(DIGITAL_OUTPUTS.items(), told, strict=True):
            bit = bits[number - 101]
            if bit != was:
                self._wires.send(Signal(self._names[terminal], bool(bit)))


def wire_names(card: str, signals: Mapping[str, str]) -> dict[str, str]:
    return {terminal: signals.get(terminal, f"{card}.{terminal}") for terminal in TERMINALS}


def feels(terminal: str, value: Number) -> bool:
    """Whether an input can feel that."""
    if terminal in DIGITAL_INPUTS:
        return value in (0, 1)
    return terminal in INPUTS and not isinstance(value, bool) and abs(value) < _LARGEST_COUNT


def _is_finite(signal: Signal) -> bool:
    if isinstance(signal, Motion) and not (math.isfinite(signal.speed) and math.isfinite(signal.acceleration)):
        return False
    return math.isfinite(signal.value)
