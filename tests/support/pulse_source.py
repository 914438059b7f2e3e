"""A device with signals for the scope: a pulse of 1 ms in each minute, a state, a level and a ramp.

devices:
  source: {kind: "pulse_source:PulseSource"}
"""

from collections.abc import Callable, Mapping
from math import sin, tau
from typing import Final

from pydantic import Field

from fieldrig.clock import MS, Clock, S
from fieldrig.device import Device, Point
from fieldrig.settings import Settings

STATES: Final = ("waiting", "high")


class PulseSourceSettings(Settings):
    period_ms: int = Field(60_000, ge=2, description="time between two pulses")
    sines: int = Field(0, ge=0, description="further signals, s000 and so on")


class PulseSource(Device):
    about = "signals for tests of the scope"

    def __init__(self, clock: Clock, settings: PulseSourceSettings) -> None:
        self._clock, self._settings = clock, settings
        self._is_high = False
        self.pulses = 0

    def start(self) -> None:
        self._begin_ns = self._clock.now_ns()
        self._next_ns = self._begin_ns + self._settings.period_ms * MS
        self._clock.call_at(self._next_ns, self._rise)

    def _rise(self) -> None:
        self._is_high = True
        self.pulses += 1
        self._clock.call_at(self._next_ns + MS, self._fall)
        self._changed()

    def _fall(self) -> None:
        self._is_high = False
        self._next_ns += self._settings.period_ms * MS
        self._clock.call_at(self._next_ns, self._rise)
        self._changed()

    def _changed(self) -> None:
        if self.look is not None:
            self.look()

    def points(self) -> Mapping[str, Point]:
        return self._points if hasattr(self, "_points") else self._make_points()

    def _make_points(self) -> Mapping[str, Point]:
        self._points = {
            "pulse": Point(lambda: self._is_high, about="1 ms long"),
            "state": Point(lambda: STATES[self._is_high], states=STATES),
            "word": Point(lambda: STATES[self._is_high], about="the same without saying which texts there are"),
            "pulses": Point(lambda: self.pulses, about="number so far"),
            "level": Point(lambda: sin(tau * self._seconds()), unit="m"),
            "ramp": Point(lambda: self._seconds() % 1, unit="V"),
        }
        for place in range(self._settings.sines):
            self._points[f"s{place:03}"] = Point(self._sine(place), unit="V")
        return self._points

    def _sine(self, place: int) -> Callable[[], float]:
        return lambda: sin(tau * self._seconds() * (0.1 + place * 0.02)) * (1 + place % 7)

    def _seconds(self) -> float:
        return (self._clock.now_ns() - self._begin_ns) / S
