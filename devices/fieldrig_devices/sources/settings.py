"""Values that live by themselves, as the key `source` describes them: one small language for registers, objects, wires.

source: {kind: sine, low: 225, high: 235, period_ms: 60000}
source: {kind: counter, per_s: 0.5}
source: {kind: replay, file: morning.csv, column: power, time_column: time}
"""

from datetime import datetime
from fractions import Fraction
from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from fieldrig.clock import MS, S
from fieldrig.settings import ConfigFile, Settings, WrongKey, refuse_all
from fieldrig_devices.sources.recording import Recording, read_recording
from fieldrig_devices.sources.shapes import (
    Constant,
    Counter,
    DateAndTime,
    Ramp,
    RandomWalk,
    Replay,
    Sine,
    Source,
    Square,
)

LARGEST: Final = 1e300
LAST_YEAR: Final = 9000
"""A clock runs for up to 146 years, and Python's dates end with the year 9999."""


def _computable(number: float) -> float:
    """Return a number whose sums with others of this size are still numbers."""
    if abs(number) > LARGEST:
        raise ValueError(f"expected at most {LARGEST:g} in either direction, got {number:g}")
    return number


Finite = Annotated[float, Field(allow_inf_nan=False), AfterValidator(_computable)]
Millis = Annotated[float, Field(ge=0.001, le=1e12, allow_inf_nan=False)]
EVERY = Field(
    default=None, ge=1, le=1e12, description="time from one change to the next; default: 100, or a 20th of the period"
)
STEPS: Final = 20
"""The changes of a period that is too short for changes every 100 ms."""


class _Between(Settings):
    """A source with two limits."""

    low: Finite
    high: Finite

    @model_validator(mode="after")
    def _is_ordered(self) -> Self:
        if self.low > self.high:
            what = f"low {self.low:.12g} is above high {self.high:.12g}"
            _refuse(self, ("low", "high"), what, f"expected at most high, which is {self.high:.12g}")
        return self


class ConstantSettings(Settings):
    kind: Literal["constant"]
    value: Finite = Field(description="the value at all times")

    def begin(self, name: str) -> Source:
        return Constant(self.value)


class SineSettings(_Between):
    kind: Literal["sine"]
    period_ms: Millis = Field(description="time of one oscillation")
    phase_deg: Finite = Field(default=0.0, description="angle at power-on; 0 is the middle, rising")
    every_ms: float | None = EVERY

    def begin(self, name: str) -> Source:
        return Sine(self.low, self.high, _ns(self.period_ms), self.phase_deg, _every_ns(self))


class RampSettings(Settings):
    kind: Literal["ramp"]
    first: Finite = Field(description="value at power-on")
    last: Finite = Field(description="value after the period")
    period_ms: Millis = Field(description="time from the first value to the last")
    repeats: bool = Field(default=True, description="begins again; otherwise the last value stays")
    every_ms: float | None = EVERY

    def begin(self, name: str) -> Source:
        return Ramp(self.first, self.last, _ns(self.period_ms), self.repeats, _every_ns(self))


class SquareSettings(_Between):
    kind: Literal["square"]
    low: Finite = 0.0
    high: Finite = 1.0
    period_ms: Millis = Field(description="time of one high and one low part")
    high_percent: float = Field(default=50.0, gt=0, lt=100, description="share of the high part, which comes first")

    @model_validator(mode="after")
    def _has_two_parts(self) -> Self:
        if not 0 < self._high_ns() < _ns(self.period_ms):
            what = f"a part of {self.period_ms:g} ms is too short"
            _refuse(self, ("period_ms",), what, "expected parts of at least a nanosecond")
        return self

    def begin(self, name: str) -> Source:
        return Square(self.low, self.high, _ns(self.period_ms), self._high_ns())

    def _high_ns(self) -> int:
        return round(_ns(self.period_ms) * self.high_percent / 100)


class RandomWalkSettings(_Between):
    kind: Literal["random_walk"]
    step: float = Field(gt=0, allow_inf_nan=False, description="largest change at once")
    step_ms: float = Field(default=1000.0, ge=1, le=1e12, description="time from one change to the next")
    first: Finite | None = Field(default=None, description="value at power-on; default: the middle")
    seed: int | None = Field(
        default=None, description="the same seed gives the same way; default: one by rig, device and name"
    )

    @model_validator(mode="after")
    def _begins_inside(self) -> Self:
        if self.first is not None and not self.low <= self.first <= self.high:
            what = f"{self.first:.12g} is not between low and high"
            _refuse(self, ("first",), what, f"expected {self.low:.12g} to {self.high:.12g}, got {self.first:.12g}")
        return self

    def begin(self, name: str) -> Source:
        first = self.low + (self.high - self.low) / 2 if self.first is None else self.first
        seed = name if self.seed is None else str(self.seed)
        return RandomWalk(self.low, self.high, first, self.step, _ns(self.step_ms), seed)


class CounterSettings(Settings):
    kind: Literal["counter"]
    per_s: Finite = Field(ge=-1e6, le=1e6, description="change in a second; below 0 it counts down")
    first: Finite = Field(default=0.0, description="count at power-on")
    step: float = Field(default=1.0, ge=1e-9, allow_inf_nan=False, description="change at once")
    wraps_at: float | None = Field(
        default=None, gt=0, allow_inf_nan=False, description="count that is 0 again, such as 65536; default: none"
    )

    @model_validator(mode="after")
    def _is_no_faster_than_time(self) -> Self:
        if abs(self.per_s) / self.step > 1e6:
            what = f"these are {abs(self.per_s) / self.step:g} changes a second"
            _refuse(self, ("step", "per_s"), what, "expected at most 1,000,000 changes a second")
        return self

    def begin(self, name: str) -> Source:
        return Counter(self.first, _exact(self.per_s), _exact(self.step), self.wraps_at)


class UptimeSettings(Settings):
    kind: Literal["uptime"]
    unit_ms: float = Field(default=1000.0, ge=1, le=1e12, description="what one count is; 1000 counts seconds")

    def begin(self, name: str) -> Source:
        return Counter(0, Fraction(S, _ns(self.unit_ms)), Fraction(1), None)


def _date(value: object) -> object:
    """Return the date in a text.  The time zone is left out: the clock of a device does not know it."""
    if not isinstance(value, str):
        return value
    try:
        date = datetime.fromisoformat(value).replace(tzinfo=None)
    except ValueError:
        raise ValueError(f"expected a date such as 2026-01-31T08:00:00, got {value!r}") from None
    if date.year > LAST_YEAR:
        raise ValueError(f"expected a date up to the year {LAST_YEAR}, got {value!r}")
    return date


class ClockSettings(Settings):
    kind: Literal["clock"]
    part: Literal["unix", "year", "month", "day", "weekday", "hour", "minute", "second"] = Field(
        default="unix", description="unix: seconds since 1970; weekday: 1 is Monday"
    )
    first: Annotated[datetime, BeforeValidator(_date)] = Field(
        default=datetime(2020, 1, 1),  # noqa: DTZ001 - the clock of a device knows no time zone
        description="date and time at power-on",
    )

    def begin(self, name: str) -> Source:
        return DateAndTime(self.first, self.part)


class ReplaySettings(Settings):
    kind: Literal["replay"]
    file: ConfigFile = Field(description="CSV file with the names of its columns in the first line")
    column: str = Field(description="name of the column")
    time_column: str | None = Field(default=None, description="column with seconds or dates; default: row by row")
    step_ms: float = Field(default=1000.0, ge=0.001, le=1e12, description="time of a row without time_column")
    repeats: bool = Field(default=True, description="begins again after its last row; otherwise the last value stays")

    @model_validator(mode="after")
    def _can_be_read(self) -> Self:
        try:
            self._recording()
        except ValueError as cause:
            _refuse(self, ("file",), f"{self.file.name}: {cause}")
        return self

    def begin(self, name: str) -> Source:
        recording = self._recording()
        return Replay(recording.ages_ns, recording.values, recording.period_ns if self.repeats else None)

    def _recording(self) -> Recording:
        return read_recording(self.file, self.column, self.time_column, _ns(self.step_ms))


SourceSettings = Annotated[
    ConstantSettings
    | SineSettings
    | RampSettings
    | SquareSettings
    | RandomWalkSettings
    | CounterSettings
    | UptimeSettings
    | ClockSettings
    | ReplaySettings,
    Field(discriminator="kind"),
]
"""A value that lives by itself."""


def _refuse(source: Settings, keys: tuple[str, ...], what: str, remedy: str = "") -> None:
    """Refuse what is wrong together at the first of the keys that is given."""
    given = [key for key in keys if key in source.model_fields_set] or [keys[0]]
    refuse_all([WrongKey((given[0],), what, remedy)])


def _every_ns(source: SineSettings | RampSettings) -> int:
    """Return the time between two changes: a period that is not much longer would look like another one."""
    return _ns(min(100.0, source.period_ms / STEPS) if source.every_ms is None else source.every_ms)


def _exact(number: float) -> Fraction:
    """Return a number as it is written: 0.1 is a tenth."""
    return Fraction(str(number))


def _ns(ms: float) -> int:
    return round(ms * MS)
