"""A PWM channel: when its output is on, and when a change takes effect (SCU-066 to SCU-071, digest 10)."""

from collections.abc import Callable
from fractions import Fraction
from math import ceil
from typing import NamedTuple

from fieldrig.clock import MS, NEVER_NS, S
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_devices.hmiscu.filtered_input import FilteredInput
from fieldrig_devices.hmiscu.pwm.settings import HIGHEST_FREQUENCY, LOWEST_FREQUENCY, PwmSettings

OnSignal = Callable[[Pwm], None]
"""Called with the new state of the output; an output that is off has a duty of 0 %."""


class Wave(NamedTuple):
    frequency: int
    """In 0.1 Hz."""
    duty: int
    """In %."""

    @property
    def is_legal(self) -> bool:
        return LOWEST_FREQUENCY <= self.frequency <= HIGHEST_FREQUENCY and 0 <= self.duty <= 100


class PwmPins(NamedTuple):
    """The inputs of the block PWM."""

    is_enable_allowed: bool = False
    """EN_Enable."""
    is_enable_forced: bool = False
    """F_Enable."""
    is_sync_allowed: bool = False
    """EN_Sync."""
    is_sync_forced: bool = False
    """F_Sync."""
    wave: Wave = Wave(0, 0)


class PwmChannel:
    """The output behind a PWM block.  Call `advance` at `next_ns`, or any method later: instants never go back."""

    def __init__(self, settings: PwmSettings, on_signal: OnSignal, *, name: str = "") -> None:
        """`name` is the wire of the output."""
        self._settings, self._on_signal, self._name = settings, on_signal, name
        self._enable = FilteredInput(settings.enable_filter_ms * MS)
        self._sync = FilteredInput(settings.sync_filter_ms * MS)
        self._pins = PwmPins()
        self._wave: Wave | None = None
        """The wave on the output; None while the output is off."""
        self._change_ns = NEVER_NS
        """The beginning of the next period, at which a changed wave takes effect."""
        self.signal = Pwm(name, 0)

    @property
    def next_ns(self) -> int:
        """The next instant at which something happens by itself; `NEVER_NS` if nothing will."""
        return min(self._enable.next_ns, self._sync.next_ns, self._change_ns)

    @property
    def is_enabled(self) -> bool:
        is_input = self._settings.enable_input and self._pins.is_enable_allowed and self._enable.level
        return self._pins.is_enable_forced or is_input

    @property
    def is_wrong(self) -> bool:
        """True if the output should be on, but its frequency or duty is out of range.  It keeps the last wave."""
        return self.is_enabled and not self._pins.wave.is_legal

    @property
    def is_in_frequency(self) -> bool:
        return self._wave is not None and self._wave == self._pins.wave

    def put_enable(self, now_ns: int, level: bool) -> None:
        """Take the level of the input IN_EN."""
        self.advance(now_ns)
        self._enable.put(now_ns, level)

    def put_sync(self, now_ns: int, level: bool) -> None:
        """Take the level of the input IN_SYNC."""
        self.advance(now_ns)
        self._sync.put(now_ns, level)

    def set_pins(self, now_ns: int, pins: PwmPins) -> None:
        self.advance(now_ns)
        is_forced = pins.is_sync_forced and not self._pins.is_sync_forced
        self._pins = pins
        if is_forced:
            self._restart(now_ns)
        self._settle(now_ns)

    def advance(self, now_ns: int) -> None:
        """Carry out everything that is due, each at its own instant."""
        while (due_ns := self.next_ns) <= now_ns:
            self._enable.advance(due_ns)
            before = self._sync.level
            self._sync.advance(due_ns)
            if self._sync.level != before and self._is_sync_edge(self._sync.level):
                self._restart(due_ns)
            if self._change_ns <= due_ns:
                self._begin(due_ns)
            self._settle(due_ns)

    def _is_sync_edge(self, level: bool) -> bool:
        edge = self._settings.sync_edge
        is_wanted = edge == "both" or (edge == "rising") == level
        return self._settings.sync_input and self._pins.is_sync_allowed and is_wanted

    def _restart(self, now_ns: int) -> None:
        """Interrupt the present period, and begin a new one (SCU-068), unless the output goes off at this instant."""
        if self._wave is not None and self.is_enabled:
            self._begin(now_ns)

    def _begin(self, now_ns: int) -> None:
        """Begin a period now, with the wave of the pins if that is legal."""
        if self._pins.wave.is_legal:
            self._wave = self._pins.wave
        self._change_ns = NEVER_NS
        if self._wave is not None:
            frequency = Fraction(self._wave.frequency, 10)
            self._publish(Pwm(self._name, self._wave.duty, start_ns=now_ns, frequency=frequency))

    def _settle(self, now_ns: int) -> None:
        if not self.is_enabled:
            self._change_ns = NEVER_NS
            if self._wave is not None:
                self._wave = None
                self._publish(Pwm(self._name, 0, start_ns=now_ns))
        elif self._wave is None:
            self._begin(now_ns)
        elif self._wave != self._pins.wave and self._pins.wave.is_legal:
            self._plan_change(now_ns)
        else:
            self._change_ns = NEVER_NS

    def _plan_change(self, now_ns: int) -> None:
        start_ns, period = self.signal.start_ns, S / Fraction(self.signal.frequency)
        begun = int((now_ns - start_ns) / period)
        if start_ns + ceil(begun * period) == now_ns:
            self._begin(now_ns)
        else:
            self._change_ns = start_ns + ceil((begun + 1) * period)

    def _publish(self, signal: Pwm) -> None:
        self.signal = signal
        self._on_signal(signal)
