"""Faults that can be injected into a telephone network, their settings, and what they do to a line at an instant.

A fault concerns the line of one member, or all lines.  It ends when it is cleared, or after its duration.
"""

from collections.abc import Iterator
from random import Random
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.clock import MS, NEVER_NS
from fieldrig.faults import faults
from fieldrig.faults.faults import LONGEST_MS, Timed
from fieldrig_bus.serial.garble import noisy
from fieldrig_bus.telephone.modulation import FASTEST_BPS, SLOWEST_BPS


class _LineFault(Timed):
    line: str | None = Field(default=None, description="the member whose line it is; left out: all lines")


class Cut(_LineFault):
    """The line is dead: no dial tone, no ringing, and a call ends."""

    what: Literal["cut"]


class NoDialTone(_LineFault):
    """The exchange gives no dial tone and takes no digits."""

    what: Literal["no_dial_tone"]


class Busy(_LineFault):
    """A caller of this line hears the busy tone."""

    what: Literal["busy"]


class NoRinging(_LineFault):
    """A caller of this line hears it ring, but it does not."""

    what: Literal["no_ringing"]


class Noise(_LineFault):
    """Bits are inverted.  Modems that correct errors repeat the data, which takes time."""

    what: Literal["noise"]
    bit_error_rate: float = Field(gt=0, le=0.5, description="share of the bits")


class Dropout(_LineFault):
    """Nothing is heard: one time, or again and again, as from the pulses of a charge meter."""

    what: Literal["dropout"]
    period_ms: float | None = Field(default=None, gt=0, le=LONGEST_MS, description="period of repeated drop-outs")
    length_ms: float | None = Field(default=None, gt=0, le=LONGEST_MS, description="duration of each of them")

    @model_validator(mode="after")
    def _both(self) -> Self:
        if (self.period_ms is None) != (self.length_ms is None):
            raise ValueError("period_ms and length_ms: expected both, or neither")
        if self.period_ms is not None and self.length_ms is not None and self.length_ms >= self.period_ms:
            raise ValueError("length_ms: expected less than period_ms")
        return self


class Slow(_LineFault):
    """A poor line: modems that connect from now on agree on a lower rate."""

    what: Literal["slow"]
    highest_bps: int = Field(ge=SLOWEST_BPS, le=FASTEST_BPS, description="bit/s")


class Delay(_LineFault):
    """Everything takes longer, as over a satellite."""

    what: Literal["delay"]
    delay_ms: float = Field(gt=0, le=60_000, description="added to the delay of the network, in each direction")


TelephoneFault = Annotated[
    Cut | NoDialTone | Busy | NoRinging | Noise | Dropout | Slow | Delay, Field(discriminator="what")
]
MODELS: Final = faults.models_of(TelephoneFault)


class LineFaults(faults.Faults[faults.Fault[Any]]):
    """The injected faults of one network."""

    def __init__(self, random: Random | None = None) -> None:
        super().__init__(faults.Fault, random)
        self._chance = random or Random(0)

    def active(self, now_ns: int, model: type[Any], *members: str) -> Iterator[Any]:
        """Yield the settings of the faults of this kind that concern the line of one of the members now."""
        for fault in self.of(model):
            settings = fault.settings
            if fault.is_on(now_ns) and (settings.line is None or settings.line in members):
                yield settings

    def has(self, now_ns: int, model: type[Any], *members: str) -> bool:
        return next(self.active(now_ns, model, *members), None) is not None

    def is_silent(self, now_ns: int, *members: str) -> bool:
        """Return whether a drop-out concerns the line of one of the members now."""
        for fault in self.of(Dropout):
            settings = fault.settings
            if fault.is_on(now_ns) and (settings.line is None or settings.line in members):
                period_ns, length_ns = _period(settings)
                if not period_ns or (now_ns - fault.start_ns) % period_ns < length_ns:
                    return True
        return False

    def with_noise(self, now_ns: int, data: bytes, *members: str) -> bytes:
        """Return `data` as it is heard over the lines of the members."""
        rate = max((noise.bit_error_rate for noise in self.active(now_ns, Noise, *members)), default=0.0)
        return noisy(data, rate, self._chance) if rate else data

    def next_change_ns(self, now_ns: int) -> int | None:
        """Return the next instant after `now_ns` at which a fault begins, ends or repeats; None without one."""
        instants = [instant for fault in self if (instant := _next_change_ns(fault, now_ns)) < NEVER_NS]
        return min(instants, default=None)


def _period(settings: Dropout) -> tuple[int, int]:
    """Return the period and the length of repeated drop-outs in nanoseconds; 0 and 0 without repetition."""
    if settings.period_ms is None or settings.length_ms is None:
        return 0, 0
    return max(1, round(settings.period_ms * MS)), max(1, round(settings.length_ms * MS))


def _next_change_ns(fault: faults.Fault[Any], now_ns: int) -> int:
    if fault.start_ns > now_ns:
        return fault.start_ns
    until_ns = NEVER_NS if fault.until_ns is None else fault.until_ns
    if until_ns <= now_ns:
        return NEVER_NS
    if isinstance(fault.settings, Dropout) and (period := _period(fault.settings))[0]:
        period_ns, length_ns = period
        since_ns = (now_ns - fault.start_ns) % period_ns
        edge_ns = now_ns - since_ns + (length_ns if since_ns < length_ns else period_ns)
        return min(edge_ns, until_ns)
    return until_ns
