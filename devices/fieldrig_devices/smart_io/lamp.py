"""An LED: on, off, or blinking at the rate of the node, which the program does not set (PAML-104, G-11).

A blinking LED blinks whether it is set or not; `no_blink` brings its steady state back.
"""

from fieldrig.clock import Alarm, Clock
from fieldrig_devices.smart_io.terminals import Terminals


class Lamp:
    def __init__(self, clock: Clock, terminals: Terminals, terminal: str, half_ns: int) -> None:
        """A blinking LED is on for `half_ns`, and off as long."""
        self._clock, self._terminals, self._terminal, self._half_ns = clock, terminals, terminal, half_ns
        self._since_ns: int | None = None
        self._timer = Alarm(self._clock)
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
        return (self._clock.now_ns() - self._since_ns) // self._half_ns % 2 == 0

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
        else:
            self._timer.stop()

    def clear(self) -> None:
        """Switch it off."""
        self.blink(False)
        self.set(False)

    def _show(self) -> None:
        self._terminals.drive(self._terminal, self.is_lit)

    def _wait(self) -> None:
        if self._terminals.has_wire(self._terminal):  # without one, the state is computed when it is read
            self._timer.after(self._half_ns, self._on_half)

    def _on_half(self) -> None:
        self._show()
        self._wait()
