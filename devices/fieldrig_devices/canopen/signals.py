"""Signals of a node: objects connected to wires, so that a master's writes move the machine and its reads show it."""

import logging
import math
import re
from collections.abc import Mapping
from typing import Annotated, Final, Literal, NamedTuple

from pydantic import Field

from fieldrig.clock import MS, Clock
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.datatypes import Boolean, Integer, Real, Value
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service
from fieldrig_devices.canopen.terminals import Terminal, Terminals
from fieldrig_devices.canopen.variable import Access, Variable

log = logging.getLogger(__name__)

SAMPLE_NS: Final = MS

SIGNAL_KEY = re.compile(r"(?P<key>[0-9A-Fa-f]{4}:[0-9A-Fa-f]{2})(?:\.(?P<bit>\d+))?")


class SignalSettings(Settings):
    """The wire of one object or bit: signal = raw value * scale + offset."""

    wire: Annotated[str, Field(min_length=1, description="name of the wire")]
    unit: Annotated[str, Field(description="unit of the signal (SI or %); empty accepts any unit")] = ""
    scale: Annotated[float, Field(description="change of the signal per count of the object")] = 1.0
    offset: Annotated[float, Field(description="value of the signal at a raw value of 0")] = 0.0
    direction: Annotated[
        Literal["in", "out"] | None,
        Field(description="in: wire to object; out: object to wire; null: as the object's access says"),
    ] = None


class Binding(NamedTuple):
    """The settings of a signal with the variable that its key names; `bit` counts from 0, None is the whole object."""

    variable: Variable
    bit: int | None
    settings: SignalSettings
    is_output: bool


def bind(dictionary: Dictionary, signals: Mapping[str, str | SignalSettings]) -> list[Binding]:
    """The bindings of `signals`.  Raises ValueError, with the key and what was expected, for a key that doesn't fit."""
    return [
        _bind(dictionary, key, SignalSettings(wire=signal) if isinstance(signal, str) else signal)
        for key, signal in signals.items()
    ]


def _bind(dictionary: Dictionary, key: str, settings: SignalSettings) -> Binding:
    match = SIGNAL_KEY.fullmatch(key)
    if match is None:
        raise ValueError(
            f"{key!r} is not an object or a bit: expected '6200:01', or '6200:01.3' for its bit 3, in quotes"
        )
    variable = dictionary.by_key(match["key"])
    bit = None if match["bit"] is None else int(match["bit"])
    if not isinstance(variable.type, Boolean | Integer | Real):
        raise ValueError(f"{key} is {variable.type.name}; expected an object that holds a number")
    if bit is not None and not isinstance(variable.type, Integer):
        raise ValueError(f"{variable.type.name} has no bits; expected {match['key']}")
    if bit is not None and isinstance(variable.type, Integer) and bit >= variable.type.bits:
        raise ValueError(f"{variable.type.name} has no bit {bit}; expected 0 to {variable.type.bits - 1}")
    if settings.scale == 0 or not math.isfinite(settings.scale) or not math.isfinite(settings.offset):
        raise ValueError(f"scale {settings.scale}, offset {settings.offset}: expected a finite scale other than 0")
    return Binding(variable, bit, settings, _is_output(variable, settings))


def _is_output(variable: Variable, settings: SignalSettings) -> bool:
    if settings.direction is not None:
        return settings.direction == "out"
    return variable.access in (Access.RW, Access.WO, Access.RWW)


class WireSignals(Service):
    """Sends the signals of outputs at the start and on change, and puts the signals of inputs into their objects.

    A wire that carries a `Motion` is sampled every `SAMPLE_NS`, so that event-driven PDOs follow it.  A read of the
    object returns the value at the instant of reading.
    """

    def __init__(self, clock: Clock, wires: Link[Signal], bindings: list[Binding], terminals: Terminals) -> None:
        self._clock, self._wires = clock, wires
        self._is_sampling = False
        self._outputs: list[_Output] = []
        self._inputs: dict[str, list[_Input]] = {}
        for binding in bindings:
            terminal = terminals.get(binding.variable, binding.variable)
            if binding.is_output:
                self._outputs.append(_Output(wires, binding, terminal))
            else:
                self._inputs.setdefault(binding.settings.wire, []).append(_Input(clock, binding, terminal))

    def start(self) -> None:
        self._wires.on_receive(self._on_signal, sorted(self._inputs))

    def reset(self, scope: Reset) -> None:
        for output in self._outputs:
            output.show()

    def _on_signal(self, signal: Signal) -> None:
        for wired in self._inputs.get(signal.name, ()):
            wired.take(signal)
        self._keep_sampling()

    def _keep_sampling(self) -> None:
        is_moving = any(wired.is_moving for inputs in self._inputs.values() for wired in inputs)
        if is_moving and not self._is_sampling:
            self._clock.call_at(self._clock.now_ns() + SAMPLE_NS, self._on_sample)
        self._is_sampling = is_moving or self._is_sampling

    def _on_sample(self) -> None:
        self._is_sampling = False
        for inputs in self._inputs.values():
            for wired in inputs:
                wired.sample()
        self._keep_sampling()


class _Output:
    def __init__(self, wires: Link[Signal], binding: Binding, terminal: Terminal) -> None:
        self._wires, self._bit, self._settings, self._terminal = wires, binding.bit, binding.settings, terminal
        self._last: Value | None = None
        terminal.watchers.append(self.show)

    def show(self) -> None:
        value = self._signal_value()
        if value != self._last and math.isfinite(value):  # a wire carries no NaN; it keeps its last value
            self._last = value
            self._wires.send(Signal(self._settings.wire, value, self._settings.unit))

    def _signal_value(self) -> bool | int | float:
        raw = self._terminal.value
        assert not isinstance(raw, str), "only numbers have signals"
        if self._bit is not None:
            return bool(int(raw) >> self._bit & 1)
        if self._settings.scale == 1 and self._settings.offset == 0:
            return raw
        return raw * self._settings.scale + self._settings.offset


class _Input:
    def __init__(self, clock: Clock, binding: Binding, terminal: Terminal) -> None:
        self._clock = clock
        self._variable, self._bit, self._settings, self._terminal = (
            binding.variable,
            binding.bit,
            binding.settings,
            terminal,
        )
        self._moving: Signal | None = None
        self._is_warned = False

    @property
    def is_moving(self) -> bool:
        return self._moving is not None

    def take(self, signal: Signal) -> None:
        if self._settings.unit and signal.unit != self._settings.unit:
            self._warn(signal)
        elif math.isfinite(signal.value):
            self._moving = signal if signal.is_moving else None
            if self._terminal is self._variable and self._bit is None:
                self._variable.live = None if self._moving is None else self._live
            self._terminal.put(self._raw(signal.at(self._clock.now_ns())))

    def sample(self) -> None:
        if self._moving is not None:
            self._terminal.put(self._present(self._moving))

    def _live(self) -> bytes:
        assert self._moving is not None, "only a signal in motion is followed"
        return self._variable.type.encode(self._present(self._moving))

    def _present(self, signal: Signal) -> Value:
        return self._raw(signal.at(self._clock.now_ns()))

    def _raw(self, value: float) -> Value:
        if self._bit is not None:
            return self._with_bit(bool(value))
        variable = self._variable
        if isinstance(variable.type, Boolean):
            return bool(value)
        return variable.nearest((value - self._settings.offset) / self._settings.scale)

    def _with_bit(self, is_set: bool) -> int:
        """The object's raw value with the bit set or cleared; the sign bit is no exception."""
        integer = self._variable.type
        present = self._terminal.value
        assert isinstance(integer, Integer)
        assert self._bit is not None
        assert not isinstance(present, str)
        raw = int(present) & ~(1 << self._bit) | is_set << self._bit
        raw &= (1 << integer.bits) - 1
        return raw - (1 << integer.bits) if raw > integer.high else raw

    def _warn(self, signal: Signal) -> None:
        if not self._is_warned:
            self._is_warned = True
            log.warning(
                "%s: the signal is in %r, but the rig file expects %r: the value is ignored",
                signal.name,
                signal.unit,
                self._settings.unit,
            )
