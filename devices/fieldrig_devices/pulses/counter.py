"""Counter inputs, for devices that have some: a counter of pulses, and an input for an incremental encoder.

A counter has two inputs, `a` and `b`, which its mode gives a meaning.  A value may be loaded at any time, and the count
wraps within a number of bits.  Each input accepts pulse trains, PWM and single edges, and a train is counted without a
message for each pulse.
"""

from math import floor
from typing import Final, Literal

from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.pulses.pulse_input import PulseInput

CounterMode = Literal["direction", "up_down"]
Input = Literal["a", "b"]

# A and B before and after an edge, each as 2 A + B: forwards, A leads.  Both at once is no step.
QUADRATURE: Final = {
    (0b00, 0b10): 1, (0b10, 0b11): 1, (0b11, 0b01): 1, (0b01, 0b00): 1,
    (0b10, 0b00): -1, (0b11, 0b10): -1, (0b01, 0b11): -1, (0b00, 0b01): -1,
}  # fmt: skip
# The edges that count, by the multiplication: rising edges of A, both edges of A, or all of them.
COUNTED: Final = {
    1: {(0b00, 0b10), (0b10, 0b00)},
    2: {(0b00, 0b10), (0b10, 0b00), (0b11, 0b01), (0b01, 0b11)},
    4: set(QUADRATURE),
}


class Counter:
    """A counter of pulses.

    In the mode `direction`, `a` has the pulses, and `b` is true for forwards if the pulses are single edges.  In the
    mode `up_down`, pulses at `a` count up and pulses at `b` count down.
    """

    def __init__(self, mode: CounterMode, since_ns: int, bits: int = 32) -> None:
        """The counter is switched on at `since_ns`, with a value of 0; its values are signed numbers of `bits`."""
        self._mode, self._bits = mode, bits
        self._inputs = {"a": PulseInput(since_ns), "b": PulseInput(since_ns)}
        self._loaded, self._mark = 0, 0

    def receive(self, which: Input, signal: Signal, now_ns: int) -> None:
        """Handle what arrived at an input at `now_ns`."""
        if which == "b" and self._mode == "direction":
            self._inputs["a"].is_reverse = not signal.value
        else:
            self._inputs[which].receive(signal, now_ns)

    def load(self, value: int, now_ns: int) -> None:
        """Set the value, from which the counter goes on; this is its preset."""
        self._loaded, self._mark = value, self._position_at(now_ns)

    def value_at(self, now_ns: int) -> int:
        """Return the value, of which the pulses up to and including `now_ns` are a part."""
        half = 1 << (self._bits - 1)
        return (self._loaded + self._position_at(now_ns) - self._mark + half) % (2 * half) - half

    def speed_at(self, now_ns: int) -> float:
        """Return the change of the value in 1/s."""
        return self._inputs["a"].speed_at(now_ns) - self._inputs["b"].speed_at(now_ns)

    def reaches_ns(self, value: int, now_ns: int) -> int | None:
        """Return when the pulses that come at `a` take the value to this one; None if they do not get there."""
        present = self._inputs["a"].present
        if present is None:
            return None
        ahead = (value - self.value_at(now_ns)) * (present.direction if isinstance(present, PulseTrain) else 1)
        return present.rise_ns(present.pulses_at(now_ns) + ahead) if ahead > 0 else now_ns if ahead == 0 else None

    @property
    def missed(self) -> int:
        """Number of pulses that were sent and not counted."""
        return sum(pulses.missed for pulses in self._inputs.values())

    @property
    def surplus(self) -> int:
        """Number of pulses that were counted and not sent."""
        return sum(pulses.surplus for pulses in self._inputs.values())

    @property
    def restarts(self) -> int:
        """Number of times that a sender started again."""
        return sum(pulses.restarts for pulses in self._inputs.values())

    def _position_at(self, now_ns: int) -> int:
        return self._inputs["a"].position_at(now_ns) - self._inputs["b"].position_at(now_ns)


class IncrementalInput:
    """An input for an incremental encoder.

    Edges of two channels in quadrature arrive at `a` and `b`, and count by the multiplication 1, 2 or 4.  A `Motion` at
    `a` is the position in counts.  A pulse train at `a` counts a whole period at each of its pulses.
    """

    def __init__(self, since_ns: int, multiplication: Literal[1, 2, 4] = 4) -> None:
        self._counted, self._multiplication = COUNTED[multiplication], multiplication
        self._pulses = PulseInput(since_ns)
        self._motion: Motion | None = None
        self._levels: dict[Input, bool] = {}
        self._count = 0  # of edges
        self._offset = 0

    def receive(self, which: Input, signal: Signal, now_ns: int) -> None:
        """Handle what arrived at a channel at `now_ns`.  A motion or a train counts at `a` only."""
        if which == "b" and isinstance(signal, Motion | PulseTrain):
            return
        if isinstance(signal, Motion):
            self._motion = signal
        elif isinstance(signal, PulseTrain):
            self._pulses.receive(signal, now_ns)
        else:
            self._step(which, bool(signal.value))

    def load(self, value: int, now_ns: int) -> None:
        """Set the value, such as at the index of the encoder."""
        self._offset += value - self.value_at(now_ns)

    def value_at(self, now_ns: int) -> int:
        """Return the value at `now_ns`."""
        shaft = 0 if self._motion is None else floor(self._motion.at(now_ns))
        return self._offset + self._count + shaft + self._multiplication * self._pulses.position_at(now_ns)

    def _step(self, which: Input, level: bool) -> None:
        before = self._place()
        self._levels[which] = level
        after = self._place()
        if before is not None and after is not None and (before, after) in self._counted:
            self._count += QUADRATURE[before, after]

    def _place(self) -> int | None:
        """Return the two channels as one number; None until both have been received."""
        if len(self._levels) < 2:
            return None
        return 2 * self._levels["a"] + self._levels["b"]
