"""Modems in virtual time: one whose telephone line is in the hands of the test, and two at a telephone network."""

from collections.abc import Callable
from random import Random
from typing import Any

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.link import Link
from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.serial.line import SerialVirtual, SerialVirtualSettings
from fieldrig_bus.serial.message import ControlLines, ModemInputs, SerialMessage, inputs_from
from fieldrig_bus.telephone.bus import TelephoneSettings, TelephoneVirtual
from fieldrig_bus.telephone.message import Carrier, Heard, Offer, TelephoneMessage, Tone
from fieldrig_bus.telephone.modulation import everything
from fieldrig_devices.modem.device import Modem, ModemSettings

OFF = ControlLines(dtr=False, rts=False)


class ModemBench:
    """One modem; the test is the terminal and the exchange."""

    def __init__(self, store: Store | None = None, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.line, self.telephone = RecordedLink[SerialMessage](), RecordedLink[TelephoneMessage]()
        self.store = MemoryStore() if store is None else store
        self.modem = Modem(
            self.clock, ModemSettings.model_validate(settings), self.store, Random(1), self.line, self.telephone
        )
        self.modem.start()
        self.lines = ControlLines()
        self.heard()

    def wait(self, seconds: float) -> "ModemBench":
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))
        return self

    def type(self, text: str | bytes) -> "ModemBench":
        self.line.deliver(text.encode() if isinstance(text, str) else text)
        return self

    def heard(self) -> str:
        """Return what the terminal has got since the last call."""
        self.wait(0.5)  # a long text takes its time on the serial line
        sent = self.line.take()
        for message in sent:
            if isinstance(message, ControlLines):
                self.lines = message
        return b"".join(message for message in sent if isinstance(message, bytes)).decode("latin-1")

    def ask(self, command: str) -> str:
        return self.type(command + "\r").heard()

    def lines_of(self, command: str) -> list[str]:
        """Return the lines that a command gives, without its echo."""
        return [line for line in self.ask(command).replace("\r", "\n").split("\n") if line][1:]

    def result(self, command: str) -> str:
        return self.lines_of(command)[-1]

    @property
    def inputs(self) -> ModemInputs:
        """The lines as the terminal sees them."""
        self.heard()
        return inputs_from(self.lines)

    def set(self, **lines: bool) -> "ModemBench":
        """Set the lines of the terminal."""
        self.line.deliver(ControlLines(**lines))
        return self

    def point(self, key: str) -> Any:
        return self.modem.points()[key].read()

    def said(self) -> list[TelephoneMessage]:
        """Return what the modem has sent to the exchange since the last call."""
        return self.telephone.take()

    def hear(self, *messages: TelephoneMessage) -> "ModemBench":
        for message in messages:
            self.telephone.deliver(message)
        return self

    def dialled(self, command: str = "ATDT200") -> "ModemBench":
        """Dial with the tone of the exchange, up to the wait for a carrier."""
        self.type(command + "\r").hear(Heard(Tone.DIAL)).wait(3.5)
        self.hear(Heard(Tone.RINGING))
        return self

    def connected(self, bps: int = 9600, correction: int = 1, command: str = "ATDT200") -> "ModemBench":
        """A call that the other end has answered; what was heard until then is dropped."""
        self.dialled(command).hear(Offer(everything(300, bps), correction)).wait(3.1)
        self.hear(Carrier(bps, correction > 0))
        return self


class Desk:
    """One modem of `Pair` with its terminal."""

    def __init__(self, pair: "Pair", name: str, **settings: Any) -> None:
        self.name, self.pair = name, pair
        self.got = bytearray()
        self.lines = ControlLines()
        bus = SerialVirtual("com", SerialVirtualSettings(baud=settings.get("baud", 38_400), paced=pair.is_paced))
        self.com = bus.model()
        for member in ("modem", "terminal"):
            self.com.join(member)
        self.com.listen(0, "terminal", ("data", "lines"))
        self._handler: Callable[[Any], None] = lambda _message: None
        line: Link[SerialMessage] = _End(lambda message: self.submit("modem", message), self._on_listen)
        telephone: Link[TelephoneMessage] = _End(
            lambda message: pair.net.submit(pair.clock.now_ns(), name, message),
            lambda handler: pair.handlers.__setitem__(name, handler),
        )
        pair.net.join(name)
        pair.net.listen(0, name, None)
        settings["paced"] = pair.is_paced
        self.modem = Modem(
            pair.clock, ModemSettings.model_validate(settings), MemoryStore(), Random(1), line, telephone
        )
        self.com.listen(0, "modem", ("data", "lines", "format"))
        self.modem.start()

    def _on_listen(self, handler: Callable[[Any], None]) -> None:
        self._handler = handler

    def submit(self, member: str, message: SerialMessage) -> None:
        self.com.submit(self.pair.clock.now_ns(), member, message)

    def type(self, text: str | bytes) -> "Desk":
        self.submit("terminal", text.encode() if isinstance(text, str) else text)
        return self

    def deliver(self, receiver: str, message: SerialMessage) -> None:
        if receiver == "modem":
            self._handler(message)
        elif isinstance(message, bytes):
            self.got += message
        elif isinstance(message, ControlLines):
            self.lines = message

    def take(self) -> bytes:
        got = bytes(self.got)
        self.got.clear()
        return got

    @property
    def text(self) -> str:
        return self.got.decode("latin-1")


class _End:
    """A link whose two methods are given."""

    def __init__(self, send: Callable[[Any], None], on_receive: Callable[[Callable[[Any], None]], None]) -> None:
        self.send = send
        self._on_receive = on_receive

    def on_receive(self, handler: Callable[[Any], None], interest: object = None) -> None:
        self._on_receive(handler)


class Pair:
    """Two modems, `a` with number 100 and `b` with 200, at one network, with their serial lines."""

    def __init__(self, *, paced: bool = True, net: dict[str, Any] | None = None, **settings: Any) -> None:
        self.clock, self.is_paced = VirtualClock(), paced
        given = {"numbers": {"a": "100", "b": "200"}, "paced": paced, **(net or {})}
        self.net = TelephoneVirtual("net", TelephoneSettings.model_validate(given)).model()
        self.net.begin(0, Random(1))
        self.handlers: dict[str, Callable[[Any], None]] = {}
        self.a, self.b = Desk(self, "a", **settings), Desk(self, "b", **settings)
        self.run(0.1)

    def next_ns(self) -> int | None:
        instants = [self.net.next_ns(), self.clock.next_ns(), self.a.com.next_ns(), self.b.com.next_ns()]
        return min((instant for instant in instants if instant is not None), default=None)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> "Pair":
        end_ns = self.clock.now_ns() + round(seconds * S)
        while not until() and (next_ns := self.next_ns()) is not None and next_ns <= end_ns:
            self.clock.advance_to(max(next_ns, self.clock.now_ns()))
            for delivery in self.net.collect(next_ns):
                for receiver in delivery.receivers:
                    self.handlers[receiver](delivery.message)
            for desk in (self.a, self.b):
                for message in desk.com.collect(next_ns):
                    for receiver in message.receivers:
                        desk.deliver(receiver, message.message)
        if not until():
            self.clock.advance_to(end_ns)
        return self

    def until(self, is_so: Callable[[], bool], seconds: float = 120) -> "Pair":
        self.run(seconds, is_so)
        assert is_so(), (self.a.text[-200:], self.b.text[-200:])
        return self

    def connected(self, init: str = "ATE0S0=1") -> "Pair":
        """A call from `a` to `b`, whose terminals have read everything."""
        for desk in (self.a, self.b):
            desk.type(init + "\r")
        self.run(1)
        self.a.type("ATDT200\r")
        self.until(lambda: "CONNECT" in self.a.text and "CONNECT" in self.b.text).run(1)
        self.a.take()
        self.b.take()
        return self

    @property
    def now_ms(self) -> float:
        return self.clock.now_ns() / MS
