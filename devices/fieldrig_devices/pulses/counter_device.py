"""A counter module: counts the pulses of wires, with preset and an output that switches at a value.

It shows at any instant what was sent, what it counted, and what it missed.  The output switches at the instant of the
pulse that takes the count to the compare value.
"""

from collections.abc import Iterator, Mapping
from typing import Literal, Self

from pydantic import Field, model_validator

from fieldrig.clock import Alarm, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.link import Link
from fieldrig.points.checks import whole_in
from fieldrig.settings import Claim, Settings
from fieldrig_bus.wires import Signal
from fieldrig_devices.pulses.counter import Counter, IncrementalInput, Input


class CounterSettings(Settings):
    mode: Literal["direction", "up_down", "incremental"] = Field(
        default="direction",
        description="a counts and b is the direction of single edges; or a up and b down; or both an encoder",
    )
    a_wire: str = Field(description="input")
    b_wire: str | None = Field(default=None, description="input")
    multiplication: Literal[1, 2, 4] = Field(default=4, description="counted edges of a period of an encoder")
    preset: int = Field(default=0, ge=-(2**31), lt=2**31, description="value at the start and after a reset")
    reset_wire: str | None = Field(default=None, description="input: a rising edge loads the preset")
    compare: int | None = Field(default=None, ge=-(2**31), lt=2**31, description="the output is on from this value on")
    compare_wire: str | None = Field(default=None, description="output of compare; default: NAME.reached")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.mode == "up_down" and self.b_wire is None:
            raise ValueError("b_wire: expected with the mode up_down")
        if self.a_wire == self.b_wire:
            raise ValueError("b_wire: expected another wire than a_wire")
        if self.compare is not None and self.mode != "direction":
            raise ValueError("compare: expected only with the mode direction")
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        if self.compare is not None:
            yield Claim("wires", "wire", self.compare_wire or f"{device}.reached", ("compare_wire",))


class CounterModule(Device):
    """A counter module as a device of a rig."""

    about = "a counter of pulses on wires: up, down, encoder, preset and compare output"
    no_faults = "its inputs and its output are wires, and faults of their bus break them"

    def __init__(self, clock: Clock, name: str, settings: CounterSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._counter = self._new()
        self._output_wire = settings.compare_wire or f"{name}.reached"
        self._is_reached: bool | None = None
        self._is_reset = False
        self._timer = Alarm(self._clock)
        self._inputs: dict[str, Input] = {settings.a_wire: "a"}
        if settings.b_wire is not None:
            self._inputs[settings.b_wire] = "b"
        names = [*self._inputs, *([] if settings.reset_wire is None else [settings.reset_wire])]
        wires.on_receive(self._on_signal, names)

    def start(self) -> None:
        self._counter = self._new()
        self._look()

    def points(self) -> Mapping[str, Point]:
        points = {"value": Point(self._value, self._write_value, "", "the count; written, it goes on from there")}
        counter = self._counter
        if isinstance(counter, Counter):
            points |= {
                "frequency": Point(lambda: self._pulses().speed_at(self._clock.now_ns()), None, "Hz", "of segments"),
                "missed": Point(lambda: self._pulses().missed, None, "pulse", "sent, but not counted"),
                "surplus": Point(lambda: self._pulses().surplus, None, "pulse", "counted, but not sent"),
                "restarts": Point(lambda: self._pulses().restarts, None, "", "senders that started again"),
            }
        if self._settings.compare is not None:
            points["reached"] = Point(lambda: bool(self._is_reached), None, "", "the output")
        return points

    def _new(self) -> Counter | IncrementalInput:
        settings, now_ns = self._settings, self._clock.now_ns()
        counter: Counter | IncrementalInput
        if settings.mode == "incremental":
            counter = IncrementalInput(now_ns, settings.multiplication)
        else:
            counter = Counter(settings.mode, now_ns)
        counter.load(settings.preset, now_ns)
        return counter

    def _pulses(self) -> Counter:
        assert isinstance(self._counter, Counter)
        return self._counter

    def _value(self) -> int:
        return self._counter.value_at(self._clock.now_ns())

    def _write_value(self, value: Value) -> None:
        self._counter.load(whole_in(value, -(2**31), 2**31 - 1), self._clock.now_ns())
        self._look()

    def _on_signal(self, signal: Signal) -> None:
        now_ns = self._clock.now_ns()
        which = self._inputs.get(signal.name)
        if which is not None:
            self._counter.receive(which, signal, now_ns)
        else:
            if signal.value and not self._is_reset:
                self._counter.load(self._settings.preset, now_ns)
            self._is_reset = bool(signal.value)
        self._look()

    def _look(self) -> None:
        """Switch the output, and wait for the pulse that switches it next."""
        compare = self._settings.compare
        if compare is None or not isinstance(self._counter, Counter):
            return
        is_reached = self._value() >= compare
        if is_reached is not self._is_reached:
            self._is_reached = is_reached
            self._wires.send(Signal(self._output_wire, is_reached))
        now_ns = self._clock.now_ns()
        when_ns = self._counter.reaches_ns(compare - 1 if is_reached else compare, now_ns)
        self._timer.at(None if when_ns is None or when_ns <= now_ns else when_ns, self._look)
