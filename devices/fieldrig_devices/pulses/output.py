"""A pulse output: sends the segments of a train on a wire, and keeps their totals.

In the edge-exact mode it drives the wire as a digital one, with a message for each edge, and the direction on a wire of
its own.  That costs about as much as everything else in a rig together, and is meant for tests and for receivers that
know nothing but levels.
"""

from collections.abc import Iterator
from functools import partial
from itertools import chain
from typing import Final, Literal

from fieldrig.clock import Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.signals.parabola import Exact
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal

Mode = Literal["segments", "edges"]
FAR_NS: Final = 1 << 62


class EdgePlayer:
    """Drives a digital wire with each edge of a waveform at its instant."""

    def __init__(self, clock: Clock, wires: Link[Signal], wire: str) -> None:
        self._clock, self._wires, self._wire = clock, wires, wire
        self._edges: Iterator[tuple[int, bool]] = iter(())
        self._timer = Alarm(self._clock)
        self._level: bool | None = None
        self._waveform: PulseTrain | Pwm | None = None

    def play(self, waveform: PulseTrain | Pwm) -> None:
        """Play a waveform when it begins, instead of the one before.  Edges of the past are not repeated.

        Several waveforms that begin at one instant are one change of the wire: that of the last one.
        """
        now_ns, before = self._clock.now_ns(), self._waveform
        begin_ns = max(waveform.start_ns, now_ns)
        rest = _rest(before, now_ns, begin_ns) if before is not None else iter(())
        self._waveform = waveform
        self._edges = chain(rest, _beginning(waveform, begin_ns), waveform.edges(begin_ns + 1, FAR_NS))
        self._timer.at(now_ns, self._next)

    def _next(self) -> None:
        for instant_ns, level in self._edges:
            if instant_ns > self._clock.now_ns():
                self._timer.at(instant_ns, partial(self._on_time, level))
                return
            self._drive(level)

    def _on_time(self, level: bool) -> None:
        """Wait for everything that is due at this instant, because another waveform may begin with it.

        An edge at that instant is the other waveform's; driven, it would be a pulse of no width.
        """
        self._timer.at(self._clock.now_ns(), partial(self._on_edge, level))

    def _on_edge(self, level: bool) -> None:
        self._drive(level)
        self._next()

    def _drive(self, level: bool) -> None:
        if level is not self._level:
            self._level = level
            self._wires.send(Signal(self._wire, level))


def _rest(waveform: PulseTrain | Pwm, now_ns: int, before_ns: int) -> Iterator[tuple[int, bool]]:
    """Yield what is left of a waveform until another one begins, with its level now, which may not be driven yet."""
    if now_ns < before_ns:
        yield now_ns, waveform.level_at(now_ns)
        yield from waveform.edges(max(now_ns, waveform.start_ns) + 1, before_ns)


def _beginning(waveform: PulseTrain | Pwm, begin_ns: int) -> Iterator[tuple[int, bool]]:
    """Yield the level with which a waveform begins, which is that after an edge at this instant.

    Only a pulse that rises while the one before it is still high needs a fall at the same instant, without which a
    receiver would count one pulse for the two.
    """
    level = waveform.level_at(begin_ns)
    if level and isinstance(waveform, PulseTrain) and begin_ns == waveform.rise_ns(1):
        yield begin_ns, False
    yield begin_ns, level


class PulseOutput:
    """The train on one wire."""

    def __init__(
        self,
        clock: Clock,
        wires: Link[Signal],
        wire: str,
        mode: Mode = "segments",
        direction_wire: str | None = None,
    ) -> None:
        """`direction_wire` is driven in either mode: true for forwards."""
        self._wires, self._clock = wires, clock
        now_ns = clock.now_ns()
        self.train = PulseTrain(wire, 0, start_ns=now_ns, epoch_ns=now_ns)
        """The present segment."""
        self._player = EdgePlayer(clock, wires, wire) if mode == "edges" else None
        self._direction_wire = direction_wire
        self._direction: int | None = None

    def start(self) -> None:
        """Publish the output at rest, with totals of 0 from now on."""
        now_ns = self._clock.now_ns()
        self._publish(PulseTrain(self.train.name, 0, start_ns=now_ns, epoch_ns=now_ns))

    def send(
        self,
        frequency: Exact = 0,
        rate: Exact = 0,
        count: int | None = 0,
        *,
        direction: int | None = None,
        phase: Exact = 0,
        start_ns: int | None = None,
    ) -> PulseTrain:
        """Begin a segment at `start_ns`, by default now, and return it.  Without arguments the output rests."""
        start_ns = self._clock.now_ns() if start_ns is None else start_ns
        train = self.train.then(start_ns, frequency, rate, count, direction=direction, phase=phase)
        self._publish(train)
        return train

    def _publish(self, train: PulseTrain) -> None:
        self.train = train
        if self._direction_wire is not None and train.direction != self._direction:
            self._direction = train.direction
            self._wires.send(Signal(self._direction_wire, train.direction > 0))
        if self._player is None:
            self._wires.send(train)
        else:
            self._player.play(train)
