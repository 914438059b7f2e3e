"""Ties of objects to wires: what a master writes moves the machine, what the machine says a master reads."""

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
from fieldrig_devices.canopen.datatypes import Boolean, Integer, Real, Value, clamp
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service
from fieldrig_devices.canopen.terminals import Terminal, Terminals
from fieldrig_devices.canopen.variable import Access, Variable

log = logging.getLogger(__name__)

SAMPLE_NS: Final = MS

TIE_KEY = re.compile(r"(?P<key>[0-9A-Fa-f]{4}:[0-9A-Fa-f]{2})(?:\.(?P<bit>\d+))?")


class Tie(Settings):
    """One wire at one object or bit: signal = raw value * scale + offset."""

    wire: Annotated[str, Field(min_length=1, description="name of the wire")]
    unit: Annotated[str, Field(description="unit of the signal, SI; empty for a digital one")] = ""
    scale: Annotated[float, Field(description="units of the signal for one of the object")] = 1.0
    offset: Annotated[float, Field(description="the signal at a raw value of 0")] = 0.0
    direction: Annotated[
        Literal["in", "out"] | None,
        Field(description="in: the wire drives the object; out: the object the wire; else by the object's access"),
    ] = None


class Bound(NamedTuple):
    """A tie with the variable that its key names; `bit` counts from 0."""

    variable: Variable
    bit: int | None
    tie: Tie
    is_output: bool


def bind(dictionary: Dictionary, ties: Mapping[str, str | Tie]) -> list[Bound]:
    """ValueError, naming the key and what would be right, for a tie that can't be."""
    return [_bind(dictionary, key, Tie(wire=tie) if isinstance(tie, str) else tie) for key, tie in ties.items()]


def _bind(dictionary: Dictionary, key: str, tie: Tie) -> Bound:
    match = TIE_KEY.fullmatch(key)
    if match is None:
        raise ValueError(
            f"{key!r} is no object or bit: right would be '6200:01', or '6200:01.3' for its bit 3, in quotes"
        )
    variable = dictionary.by_key(match["key"])
    bit = None if match["bit"] is None else int(match["bit"])
    if not isinstance(variable.type, Boolean | Integer | Real):
        raise ValueError(f"{key} is {variable.type.name}; right would be an object that holds a number")
    if bit is not None and not isinstance(variable.type, Integer):
        raise ValueError(f"{variable.type.name} has no bits; right would be {match['key']}")
    if bit is not None and isinstance(variable.type, Integer) and bit >= variable.type.bits:
        raise ValueError(f"{variable.type.name} has no bit {bit}; right would be 0 to {variable.type.bits - 1}")
    if tie.scale == 0 or not math.isfinite(tie.scale) or not math.isfinite(tie.offset):
        raise ValueError(f"scale {tie.scale}, offset {tie.offset}: right would be a scale other than 0")
    return Bound(variable, bit, tie, _is_output(variable, tie))


def _is_output(variable: Variable, tie: Tie) -> bool:
    if tie.direction is not None:
        return tie.direction == "out"
    return variable.access in (Access.RW, Access.WO, Access.RWW)


class Ties(Service):
    """Sends the signals of outputs at the start and when they change; puts those of inputs into their objects.

    A wire that moves by itself is sampled every `SAMPLE_NS`, for the PDOs that tell of changes; a read of the object
    gives its value at that instant.
    """

    def __init__(self, clock: Clock, wires: Link[Signal], bounds: list[Bound], terminals: Terminals) -> None:
        self._clock, self._wires = clock, wires
        self._is_sampling = False
        self._outputs: list[_Output] = []
        self._inputs: dict[str, list[_Input]] = {}
        for bound in bounds:
            terminal = terminals.get(bound.variable, bound.variable)
            if bound.is_output:
                self._outputs.append(_Output(wires, bound, terminal))
            else:
                self._inputs.setdefault(bound.tie.wire, []).append(_Input(clock, bound, terminal))

    def start(self) -> None:
        self._wires.on_receive(self._on_signal, sorted(self._inputs))

    def reset(self, scope: Reset) -> None:
        for output in self._outputs:
            output.show()

    def _on_signal(self, signal: Signal) -> None:
        for one in self._inputs.get(signal.name, ()):
            one.take(signal)
        self._keep_sampling()

    def _keep_sampling(self) -> None:
        is_moving = any(one.is_moving for inputs in self._inputs.values() for one in inputs)
        if is_moving and not self._is_sampling:
            self._clock.call_at(self._clock.now_ns() + SAMPLE_NS, self._on_sample)
        self._is_sampling = is_moving or self._is_sampling

    def _on_sample(self) -> None:
        self._is_sampling = False
        for inputs in self._inputs.values():
            for one in inputs:
                one.sample()
        self._keep_sampling()


class _Output:
    def __init__(self, wires: Link[Signal], bound: Bound, terminal: Terminal) -> None:
        self._wires, self._bit, self._tie, self._terminal = wires, bound.bit, bound.tie, terminal
        self._last: Value | None = None
        terminal.watchers.append(self.show)

    def show(self) -> None:
        value = self._signal_value()
        if value != self._last and math.isfinite(value):  # a wire carries no NaN; it keeps what it had
            self._last = value
            self._wires.send(Signal(self._tie.wire, value, self._tie.unit))

    def _signal_value(self) -> bool | int | float:
        raw = self._terminal.value
        assert not isinstance(raw, str), "only numbers are tied"
        if self._bit is not None:
            return bool(int(raw) >> self._bit & 1)
        if self._tie.scale == 1 and self._tie.offset == 0:
            return raw
        return raw * self._tie.scale + self._tie.offset


class _Input:
    def __init__(self, clock: Clock, bound: Bound, terminal: Terminal) -> None:
        self._clock = clock
        self._variable, self._bit, self._tie, self._terminal = bound.variable, bound.bit, bound.tie, terminal
        self._moving: Signal | None = None
        self._is_warned = False

    @property
    def is_moving(self) -> bool:
        return self._moving is not None

    def take(self, signal: Signal) -> None:
        if self._tie.unit and signal.unit != self._tie.unit:
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
        assert self._moving is not None, "only a signal that moves is followed"
        return self._variable.type.encode(self._present(self._moving))

    def _present(self, signal: Signal) -> Value:
        return self._raw(signal.at(self._clock.now_ns()))

    def _raw(self, value: float) -> Value:
        if self._bit is not None:
            return self._with_bit(bool(value))
        variable = self._variable
        if isinstance(variable.type, Boolean):
            return bool(value)
        wanted = (value - self._tie.offset) / self._tie.scale
        low = variable.type.low if variable.low is None else variable.low
        high = variable.type.high if variable.high is None else variable.high
        limited = clamp(wanted, low, high)
        return round(limited) if isinstance(variable.type, Integer) else limited

    def _with_bit(self, is_set: bool) -> int:
        """The bit among its neighbours; the sign bit is a bit like another."""
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
            log.warning("%s: the wire is in %r, the tie in %r; not taken", signal.name, signal.unit, self._tie.unit)
