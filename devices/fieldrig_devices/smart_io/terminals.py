"""The terminals of a node with their wires: electrical levels, whatever ACTIVE makes of them.

in101 to in1612 are inputs, out101 to out1612 outputs, key1 and so on the keys of the keyboard, led1 and so on its LEDs,
and analog1 is the analog output.  An output with a short circuit is off while the node drives it high.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal

Watcher = Callable[[], None]
INPUTS: Final = ("in", "key")
"""Beginnings of the names of inputs."""
MV_PER_V: Final = 1_000


class Terminals:
    """All terminals of one node."""

    def __init__(self, clock: Clock, wires: Link[Signal] | None, names: Mapping[str, str]) -> None:
        """`names` are the wires by terminal."""
        self._clock, self._wires, self._names = clock, wires, names
        self._inputs: dict[str, list[str]] = {}
        for terminal, wire in names.items():
            if terminal.startswith(INPUTS):
                self._inputs.setdefault(wire, []).append(terminal)
        self._signals: dict[str, Signal] = {}
        self._watchers: dict[str, dict[Watcher, None]] = {}
        self._driven: dict[str, bool] = {}
        """Levels of outputs as the node drives them."""
        self._shown: dict[str, bool | float] = {}
        """The last values on the wires of outputs."""
        self._broken: frozenset[str] = frozenset()
        self._shorted: frozenset[str] = frozenset()
        self.on_short: Callable[[], None] = lambda: None
        """Called after an output with a short circuit was switched."""
        if wires is not None and self._inputs:
            wires.on_receive(self._on_signal, sorted(self._inputs))

    def start(self) -> None:
        """Drive the wires of all outputs at their present levels."""
        self._shown.clear()
        for terminal in self._names:
            if terminal.startswith(("out", "led")):
                self._show(terminal, self.is_on(terminal))
            elif not terminal.startswith(INPUTS):
                self._show(terminal, 0.0)

    def has_wire(self, terminal: str) -> bool:
        return terminal in self._names

    # ---- inputs

    def _on_signal(self, signal: Signal) -> None:
        for terminal in self._inputs[signal.name]:
            self.put(terminal, signal)

    def put(self, terminal: str, signal: Signal) -> None:
        """Take a new signal of an input."""
        self._signals[terminal] = signal
        self._tell(terminal)

    def _tell(self, terminal: str) -> None:
        for watcher in tuple(self._watchers.get(terminal, ())):
            watcher()

    def watch(self, terminal: str, watcher: Watcher) -> None:
        """Call `watcher` after each signal for an input."""
        self._watchers.setdefault(terminal, {})[watcher] = None

    def unwatch(self, terminal: str, watcher: Watcher) -> None:
        """Do so no longer, if it did."""
        self._watchers.get(terminal, {}).pop(watcher, None)

    def level(self, terminal: str) -> bool:
        """The present level of an input; low without a signal."""
        return self.level_at(terminal, self._clock.now_ns())

    def level_at(self, terminal: str, when_ns: int) -> bool:
        """The level of an input at an instant of the past, as far as its present signal has it."""
        signal = self._signals.get(terminal)
        if signal is None or terminal in self._broken:
            return False
        if isinstance(signal, PulseTrain | Pwm):
            return signal.level_at(when_ns)
        return bool(signal.at(when_ns))

    def is_moving_at(self, terminal: str, when_ns: int) -> bool:
        """True if the level may change without another signal, as that of a pulse train does until its end."""
        signal = self._signals.get(terminal)
        if isinstance(signal, Pwm):
            return 0 < signal.value < 100
        if isinstance(signal, PulseTrain):
            end_ns = signal.end_ns
            return signal.is_moving and (end_ns is None or when_ns < end_ns)
        return signal is not None and signal.is_moving

    def has_instants(self, terminal: str) -> bool:
        """True if the signal of an input says when its level changes."""
        return isinstance(self._signals.get(terminal), PulseTrain)

    def began_ns(self, terminal: str) -> int:
        """The instant from which the signal of an input holds: now, or before it for pulses that arrive late."""
        now_ns, signal = self._clock.now_ns(), self._signals.get(terminal)
        return min(signal.start_ns, now_ns) if isinstance(signal, PulseTrain) else now_ns

    # ---- outputs

    def is_on(self, terminal: str) -> bool:
        """True if an output is at the high level."""
        return self._driven.get(terminal, False) and terminal not in self._shorted

    def drive(self, terminal: str, level: bool) -> None:
        """Switch an output to an electrical level."""
        if self._driven.get(terminal, False) is level:
            return
        self._driven[terminal] = level
        self._show(terminal, self.is_on(terminal))
        if terminal in self._shorted:
            self.on_short()

    def drive_analog(self, terminal: str, millivolts: int) -> None:
        self._show(terminal, millivolts / MV_PER_V, "V")

    def _show(self, terminal: str, value: bool | float, unit: str = "") -> None:
        wire = self._names.get(terminal)
        if wire is None or self._wires is None or self._shown.get(terminal) == value:
            return
        self._shown[terminal] = value
        self._wires.send(Signal(wire, value, unit))

    # ---- faults

    def fail(self, broken: frozenset[str], shorted: frozenset[str]) -> None:
        """Set the inputs whose wire is broken, and the outputs that have a short circuit."""
        inputs, outputs = broken ^ self._broken, shorted ^ self._shorted
        self._broken, self._shorted = broken, shorted
        for terminal in sorted(inputs):
            self._tell(terminal)
        for terminal in sorted(outputs):
            self._show(terminal, self.is_on(terminal))
        if outputs:
            self.on_short()

    def shorts(self) -> list[str]:
        """The outputs whose short circuit is felt, because the node drives them high."""
        return sorted(terminal for terminal in self._shorted if self._driven.get(terminal, False))
