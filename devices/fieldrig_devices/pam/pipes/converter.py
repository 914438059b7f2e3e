"""The converter: the end of a pipe, which drives its destination in a mode (PAML-480 to PAML-486)."""

from collections.abc import Callable
from typing import Literal, Protocol

Mode = Literal["POSITION", "SPEED", "TORQUE", "VALUE"]

Taker = Callable[[float], None]
"""Takes a value of the flow, in the units of the destination."""


class Destination(Protocol):
    """An object that a pipe drives; it has one input at most (PAML-407)."""

    def attach(self, mode: Mode, period_s: float) -> Taker:
        """A pipe drives the object from now on, every `period_s` seconds; return the function for its values."""

    def detach(self) -> None:
        """The pipe has ended, or another one takes its place."""


class Sink:
    """A destination that swallows values, as a stand-in for an axis (PAML-180)."""

    def attach(self, _mode: Mode, _period_s: float) -> Taker:
        return self._take

    def detach(self) -> None:
        pass

    def _take(self, value: float) -> None:
        pass


class Converter:
    """A converter; `ready` is true when the pipe exists and its first value has reached the destination (PAML-485)."""

    def __init__(self, destination: Destination, mode: Mode) -> None:
        self.destination, self.mode = destination, mode
        self.value = 0.0
        self.ready = False
        self._take: Taker | None = None

    @property
    def is_settled(self) -> bool:
        """True unless the position is still the integral of a speed."""
        return self.mode != "SPEED" or self.value == 0

    def start(self, period_s: float) -> None:
        self._take, self.ready = self.destination.attach(self.mode, period_s), False

    def stop(self) -> None:
        self.destination.detach()
        self._take, self.ready = None, False

    def give_up(self) -> None:
        """End without an effect on the destination, which another converter takes over (G-45)."""
        self._take, self.ready = None, False

    def pass_on(self, value: float) -> float:
        self.value, self.ready = value, True
        if self._take is not None:
            self._take(value)
        return value
