"""The parameters of an axis as its control loop uses them: floats in user units, seconds and volts.

Source: manual 3.2; digest chapter 6.2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.motion.counter import Span
from fieldrig_devices.arp.parameters import Kind, ParX
from fieldrig_devices.motion.profile import Limits

_NS_OF_RAW: Final = 1_000_000  # one raw unit of a time is a millisecond
_FULL: Final = 100.0  # per cent
_SMALLEST: Final = 0.001
"""Limit that 0 % results in: the smallest value that its parameter can hold."""
_REVERSED_ENCODER, _REVERSED_OUTPUT = 1, 2  # bits of @ParX[3]


@dataclass(frozen=True, slots=True)
class Offset:
    """An offset of PST: its target, and the largest step toward it in a sampling period."""

    wanted: float
    step: float


@dataclass(frozen=True, slots=True)
class Setup:
    kind: Kind
    per_count: float
    """Units per encoder count; negative for a reversed encoder."""
    span: Span
    speed: float
    acceleration: float
    feed_forward: float
    kp: float
    ki: float
    kd: float
    output_sign: float
    error_maximum: float
    dwell_ns: int
    window: float
    slave_offset: Offset
    master_gear: float
    master_offset: Offset
    master_speed: float
    entry_speed: float

    @classmethod
    def of(cls, table: Sequence[int]) -> Self:
        """Build the setup from the raw parameters of one axis."""
        value = [raw / SCALE for raw in table]
        signs = table[ParX.SIGNS] // SCALE
        return cls(
            kind=Kind(table[ParX.KIND] // SCALE),
            per_count=(-1 if signs & _REVERSED_ENCODER else 1) / value[ParX.COUNTS_PER_UNIT],
            span=Span(value[ParX.COUNTER_MINIMUM], value[ParX.COUNTER_MAXIMUM]),
            speed=value[ParX.SPEED],
            acceleration=value[ParX.ACCELERATION],
            feed_forward=value[ParX.FEED_FORWARD],
            kp=value[ParX.KP],
            ki=value[ParX.KI],
            kd=value[ParX.KD],
            output_sign=-1.0 if signs & _REVERSED_OUTPUT else 1.0,
            error_maximum=value[ParX.TRACKING_ERROR],
            dwell_ns=table[ParX.ARRIVAL_DWELL_S] * _NS_OF_RAW,
            window=value[ParX.ARRIVAL_WINDOW],
            slave_offset=Offset(value[ParX.SLAVE_OFFSET], value[ParX.SLAVE_OFFSET_STEP]),
            master_gear=value[ParX.MASTER_GEAR],
            master_offset=Offset(value[ParX.MASTER_OFFSET], value[ParX.MASTER_OFFSET_STEP]),
            master_speed=value[ParX.MASTER_SPEED],
            entry_speed=value[ParX.SPEED] * value[ParX.ENTRY_PERCENT] / _FULL,
        )


@dataclass(slots=True)
class Overrides:
    """Limits set by VEL, ACC and DEC, in per cent of the parameters."""

    speed: float = _FULL
    acceleration: float = _FULL
    deceleration: float = _FULL

    def of(self, setup: Setup) -> Limits:
        """Limits in effect now; each instruction takes them when it begins (digest 12)."""
        return Limits(
            max(setup.speed * self.speed / _FULL, _SMALLEST),
            max(setup.acceleration * self.acceleration / _FULL, _SMALLEST),
            max(setup.acceleration * self.deceleration / _FULL, _SMALLEST),
        )

    def of_electronic_cam(self, setup: Setup) -> Limits:
        """Limits of an electronic cam, whose acceleration is the smaller of the two (digest 13.2)."""
        speed, acceleration, deceleration = self.of(setup)[:3]
        return Limits(speed, min(acceleration, deceleration), min(acceleration, deceleration))
