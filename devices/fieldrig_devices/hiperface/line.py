"""The HIPERFACE line inside a drive, with the same bytes at the same times as on a serial bus of a rig."""

from collections.abc import Callable, Sequence
from typing import Final, Protocol

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.serial.message import Format, SerialMessage
from fieldrig_bus.serial.model import SerialModel

FORM: Final = Format(9600, 8, "E", 1)
CHUNK_NS: Final = 2 * MS

Handler = Callable[[SerialMessage], None]


class InternalLine:
    """A serial line between two ends; `ends` are their links."""

    def __init__(self, clock: Clock, form: Format = FORM) -> None:
        self._clock = clock
        self._model = SerialModel(form, CHUNK_NS)
        self._timer = Alarm(self._clock)
        self.ends: tuple[Link[SerialMessage], Link[SerialMessage]] = (_End(self, "a"), _End(self, "b"))

    def join(self, member: str) -> None:
        self._model.join(member)

    def listen(self, member: str, interest: Sequence[object] | None) -> None:
        self._model.listen(self._clock.now_ns(), member, interest)
        self._arm()

    def submit(self, member: str, message: SerialMessage) -> None:
        self._model.submit(self._clock.now_ns(), member, message)
        self._arm()

    def _arm(self) -> None:
        self._timer.at(self._model.next_ns(), self._deliver)

    def _deliver(self) -> None:
        for delivery in self._model.collect(self._clock.now_ns()):
            for end in self.ends:
                assert isinstance(end, _End)
                if end.name in delivery.receivers:
                    end.handler(delivery.message)
        self._arm()


class _End:
    def __init__(self, line: InternalLine, name: str) -> None:
        self._line, self.name = line, name
        self.handler: Handler = lambda _message: None
        line.join(name)

    def send(self, message: SerialMessage) -> None:
        self._line.submit(self.name, message)

    def on_receive(self, handler: Handler, interest: Sequence[object] | None = None) -> None:
        self.handler = handler
        self._line.listen(self.name, interest)


class Station(Protocol):
    """A station on the line, as bytes and times: the encoder or the drive."""

    def receive(self, now_ns: int, data: bytes) -> None: ...

    def due(self, now_ns: int) -> bytes: ...

    def next_ns(self) -> int | None: ...


class StationPort:
    """Connects a station to its link, and calls it when it is due."""

    def __init__(self, clock: Clock, link: Link[SerialMessage], station: Station) -> None:
        self._clock, self._link, self._station = clock, link, station
        self._timer = Alarm(self._clock)
        link.on_receive(self._on_receive)

    def wake(self) -> None:
        """Call this when the station has changed: send what is due, and set the timer."""
        self._timer.stop()
        now_ns = self._clock.now_ns()
        if sent := self._station.due(now_ns):
            self._link.send(sent)
        next_ns = self._station.next_ns()
        if next_ns is not None:
            self._timer.at(next_ns, self.wake)

    def _on_receive(self, message: SerialMessage) -> None:
        if isinstance(message, bytes):
            self._station.receive(self._clock.now_ns(), message)
            self.wake()
