"""The converter: the end of a pipe, which drives its destination in a mode (PAML-480 to PAML-486)."""

from typing import Literal, Protocol

Mode = Literal["POSITION", "SPEED", "TORQUE", "VALUE"]


class Input(Protocol):
    """The end of a pipe at its destination."""

    def take(self, value: float) -> None:
        """Take a value of the flow, in the units of the destination."""

    @property
    def is_at_rest(self) -> bool:
        """True if the last value, taken once more, would change nothing."""


class Destination(Protocol):
    """An object that a pipe drives; it has one input at most (PAML-407)."""

    def attach(self, mode: Mode, period_s: float) -> Input:
        """A pipe drives the object from now on, every `period_s` seconds; return the input for its values."""

    def detach(self) -> None:
        """The pipe has ended, or another one takes its place."""


class Sink:
    """A destination that swallows values, as a stand-in for an axis (PAML-180)."""

    is_at_rest = True

    def attach(self, _mode: Mode, _period_s: float) -> Input:
        return self

    def detach(self) -> None:
        pass

    def take(self, value: float) -> None:
        pass


class Converter:
    """A converter; `ready` is true when the pipe exists and its first value has reached the destination (PAML-485)."""

    def __init__(self, destination: Destination, mode: Mode) -> None:
        self.destination, self.mode = destination, mode
        self.value = 0.0
        self.ready = False
        self._input: Input | None = None

    @property
    def is_at_rest(self) -> bool:
        """True if the last value, passed on once more, would change nothing."""
        return self._input is None or self._input.is_at_rest

    def start(self, period_s: float) -> None:
        self._input, self.ready = self.destination.attach(self.mode, period_s), False

    def stop(self) -> None:
        self.destination.detach()
        self._input, self.ready = None, False

    def give_up(self) -> None:
        """End without an effect on the destination, which another converter takes over (G-45)."""
        self._input, self.ready = None, False

    def pass_on(self, value: float) -> float:
        self.value, self.ready = value, True
        if self._input is not None:
            self._input.take(value)
        return value
