"""An LED: on, off, or blinking at the fixed rate of the node, which the program does not set (PAML-104, G-11).

A blinking LED blinks whether it is set or not; `no_blink` brings its steady state back.
"""

from typing import Final

from fieldrig.clock import Clock, S, Timer
from fieldrig_devices.smart_io.terminals import Terminals

HALF_NS: Final = S // 2
"""Blinking is at 1 Hz, on for one half of the time."""


class Lamp:
    def __init__(self, clock: Clock, terminals: Terminals, terminal: str) -> None:
        self._clock, self._terminals, self._terminal = clock, terminals, terminal
        self._since_ns: int | None = None
        self._timer: Timer | None = None
        self.value = False
        """The steady state."""

    @property
    def is_blinking(self) -> bool:
        return self._since_ns is not None

    @property
    def is_lit(self) -> bool:
        """True if it is lit at this instant."""
        if self._since_ns is None:
            return self.value
        return (self._clock.now_ns() - self._since_ns) // HALF_NS % 2 == 0

    def set(self, value: bool) -> None:
        self.value = value
        self._show()

    def blink(self, on: bool) -> None:
        if on == self.is_blinking:
            return
        self._since_ns = self._clock.now_ns() if on else None
        self._show()
        if on:
            self._wait()
        elif self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def clear(self) -> None:
        """Switch it off."""
        self.blink(False)
        self.set(False)

    def _show(self) -> None:
        self._terminals.drive(self._terminal, self.is_lit)

    def _wait(self) -> None:
        if self._terminals.has_wire(self._terminal):  # without one, the state is computed when it is read
            self._timer = self._clock.call_at(self._clock.now_ns() + HALF_NS, self._on_half)

    def _on_half(self) -> None:
        self._show()
        self._wait()
