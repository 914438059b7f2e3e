"""A pulse generator, as on a laboratory bench: a pulse train or PWM on a wire, set by its points.

Left out: ramps up to a frequency; a train has one rate.
"""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Literal

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.device import Device, Point, Value
from fieldrig.link import Link
from fieldrig.points.checks import number_in, truth_in, whole_in
from fieldrig.settings import Claim, Settings
from fieldrig_bus.signals.codec import check_sent
from fieldrig_bus.signals.pulse_train import FASTEST_HZ, STEEPEST_HZ_PER_S
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal
from fieldrig_devices.pulses.output import EdgePlayer, Mode, PulseOutput

MOST_PULSES = 2**53
"""Largest count: JSON of the points has all digits up to this."""


class GeneratorSettings(Settings):
    waveform: Literal["pulses", "pwm"] = Field(default="pulses", description="what the output gives")
    output: Mode = Field(default="segments", description="one message for a segment, or one for each edge")
    frequency: float = Field(default=1000.0, gt=0, le=FASTEST_HZ, description="Hz, until its point is written")
    duty: float = Field(default=50.0, ge=0, le=100, description="% of PWM, until its point is written")
    run: bool = Field(default=False, description="the output is on from the start")
    wire: str | None = Field(default=None, description="output; default: NAME.pulse or NAME.pwm")
    direction_wire: str | None = Field(default=None, description="output: digital, true is forwards; default: none")

    def wire_of(self, device: str) -> str:
        return self.wire or f"{device}.{'pwm' if self.waveform == 'pwm' else 'pulse'}"

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("wires", "wire", self.wire_of(device), ("wire",))
        if self.direction_wire is not None:
            yield Claim("wires", "wire", self.direction_wire, ("direction_wire",))


class Generator(Device):
    """A pulse generator as a device of a rig."""

    about = "a pulse generator: a pulse train or PWM on a wire, set by its points"
    no_faults = "its output is a wire, and faults of its bus break it"

    def __init__(self, clock: Clock, name: str, settings: GeneratorSettings, wires: Link[Signal]) -> None:
        self._clock, self._wires, self._is_pwm = clock, wires, settings.waveform == "pwm"
        wire = settings.wire_of(name)
        self._output = PulseOutput(clock, wires, wire, settings.output, settings.direction_wire)
        self._player = EdgePlayer(clock, wires, wire) if self._is_pwm and settings.output == "edges" else None
        self._pwm = Pwm(wire, 0)
        self._frequency = Fraction(settings.frequency)
        self._rate = Fraction(0)
        self._duty: int | float = settings.duty
        self._count = 0
        self._direction = 1
        self._is_on = settings.run

    def start(self) -> None:
        if not self._is_pwm:
            self._output.start()
        self._begin()

    def points(self) -> Mapping[str, Point]:
        now_ns, output = self._clock.now_ns, self._output
        common = {
            "run": Point(self._is_running, self._write_run, "", "write true to begin; false ends at once"),
            "frequency": Point(lambda: float(self._frequency), self._write_frequency, "Hz", "at the beginning"),
            "level": Point(self._level, None, "", "of the output"),
        }
        if self._is_pwm:
            return common | {"duty": Point(lambda: self._duty, self._write_duty, "%")}
        return common | {
            "rate": Point(lambda: float(self._rate), self._write_rate, "Hz/s", "of the next train, which has a count"),
            "count": Point(lambda: self._count, self._write_count, "pulse", "of the next train; 0: without end"),
            "direction": Point(lambda: self._direction, self._write_direction, "", "of the next train: 1 or -1"),
            "sent": Point(lambda: output.train.sent_at(now_ns()), None, "pulse", "in both directions"),
            "position": Point(lambda: output.train.at(now_ns()), None, "pulse", "forwards less backwards"),
        }

    def _is_running(self) -> bool:
        end_ns = self._output.train.end_ns
        return self._is_on and (self._is_pwm or end_ns is None or end_ns > self._clock.now_ns())

    def _level(self) -> bool:
        return (self._pwm if self._is_pwm else self._output.train).level_at(self._clock.now_ns())

    def _begin(self) -> None:
        if self._is_pwm:
            duty = self._duty if self._is_on else 0
            self._pwm = Pwm(self._pwm.name, duty, "%", self._clock.now_ns(), self._frequency)
            if self._player is None:
                self._wires.send(self._pwm)
            else:
                self._player.play(self._pwm)
        elif self._is_on:
            self._output.send(self._frequency, self._rate, self._count or None, direction=self._direction)

    def _write_run(self, value: Value) -> None:
        is_on = truth_in(value)
        if is_on and not self._is_pwm:
            check_sent(self._output.train.then(0, self._frequency, self._rate, self._count or None))
        was_on, self._is_on = self._is_running(), is_on
        if is_on or (was_on and self._is_pwm):
            self._begin()
        elif was_on:
            self._output.send()

    def _write_frequency(self, value: Value) -> None:
        self._frequency = Fraction(number_in(value, 0.001, FASTEST_HZ, "Hz")).limit_denominator(10**6)
        if self._is_pwm:
            self._begin()

    def _write_duty(self, value: Value) -> None:
        self._duty = number_in(value, 0, 100, "%")
        self._begin()

    def _write_rate(self, value: Value) -> None:
        rate = number_in(value, -STEEPEST_HZ_PER_S, STEEPEST_HZ_PER_S, "Hz/s")
        self._rate = Fraction(rate).limit_denominator(10**6)

    def _write_count(self, value: Value) -> None:
        self._count = whole_in(value, 0, MOST_PULSES, "pulses")

    def _write_direction(self, value: Value) -> None:
        direction = whole_in(value, -1, 1)
        if not direction:
            raise ValueError("expected 1 or -1, got 0")
        self._direction = direction
