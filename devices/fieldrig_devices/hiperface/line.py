"""The HIPERFACE line inside a drive: same bytes at the same times as on a bus of family serial."""

from collections.abc import Callable, Sequence
from typing import Final, Protocol

from fieldrig.clock import MS, Clock, Timer
from fieldrig.link import Link
from fieldrig_bus.serial.message import Format, SerialMessage
from fieldrig_bus.serial.model import SerialModel

FORM: Final = Format(9600, 8, "E", 1)
CHUNK_NS: Final = 2 * MS

Handler = Callable[[SerialMessage], None]


class InternalLine:
    """`ends` are the links of its two ends."""

    def __init__(self, clock: Clock, form: Format = FORM) -> None:
        self._clock = clock
        self._model = SerialModel(form, CHUNK_NS)
        self._timer: Timer | None = None
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
        if self._timer is not None:
            self._timer.cancel()
        next_ns = self._model.next_ns()
        self._timer = None if next_ns is None else self._clock.call_at(next_ns, self._deliver)

    def _deliver(self) -> None:
        self._timer = None
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


class Talker(Protocol):
    """One who takes bytes and time, and gives bytes and a wish for time back."""

    def receive(self, now_ns: int, data: bytes) -> None: ...

    def due(self, now_ns: int) -> bytes: ...

    def next_ns(self) -> int | None: ...


class Seat:
    """A talker at a link, woken when it wishes."""

    def __init__(self, clock: Clock, link: Link[SerialMessage], talker: Talker) -> None:
        self._clock, self._link, self._talker = clock, link, talker
        self._timer: Timer | None = None
        link.on_receive(self._on_receive)

    def wake(self) -> None:
        """Something has changed at the talker."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        now_ns = self._clock.now_ns()
        if sent := self._talker.due(now_ns):
            self._link.send(sent)
        next_ns = self._talker.next_ns()
        if next_ns is not None:
            self._timer = self._clock.call_at(next_ns, self.wake)

    def _on_receive(self, message: SerialMessage) -> None:
        if isinstance(message, bytes):
            self._talker.receive(self._clock.now_ns(), message)
            self.wake()
