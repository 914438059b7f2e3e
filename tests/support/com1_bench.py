"""COM1 of a controller with a scripted modem: the bench reads what the port sends, and answers as the test says."""

from collections.abc import Callable
from typing import Self

from fieldrig.clock import S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.serial.message import ControlLines, SerialMessage
from fieldrig_devices.max4.com1.parameters import Com1Parameters
from fieldrig_devices.max4.com1.port import Com1
from fieldrig_devices.max4.com1.states import User
from fieldrig_devices.max4.configuration.tree import ObjectTree

OFF = ControlLines(dtr=False, rts=False, dcd=False)
READY = ControlLines(dcd=False)
CARRIER = ControlLines(dcd=True)
OK = b"\r\nOK\r\n"
ERROR = b"\r\nERROR\r\n"
CONNECT = b"\r\nCONNECT 38400\r\n"


class AnsweredCall:
    """A call that keeps what it gets."""

    def __init__(self, send: Callable[[bytes], None], hang_up: Callable[[], None], waiting: Callable[[], int]) -> None:
        self.send, self.hang_up, self.waiting = send, hang_up, waiting
        self.heard = b""
        self.has_ended = False
        self.rooms = 0
        """How often the line had room again."""

    def received(self, data: bytes) -> None:
        self.heard += data

    def has_room(self) -> None:
        self.rooms += 1

    def ended(self) -> None:
        self.has_ended = True


class Com1Bench:
    """A port that has booted at 0 s.  `modem` false: the project has no Modem object."""

    def __init__(self, user: User = User.MODEM, *, modem: bool = True, baud: int | None = None) -> None:
        self.clock = VirtualClock()
        self.link = RecordedLink[SerialMessage]()
        self.calls: list[AnsweredCall] = []
        self.port = Com1(self.clock, self.link, self._answer, baud)
        self.tree = ObjectTree()
        self.parameters = Com1Parameters(self.tree, ["Modem"] if modem else [], self.port)
        self.tree.set("MAx-4.Com1User", int(user))
        self.port.boot(self.parameters)

    def _answer(
        self, send: Callable[[bytes], None], hang_up: Callable[[], None], waiting: Callable[[], int]
    ) -> AnsweredCall:
        self.calls.append(AnsweredCall(send, hang_up, waiting))
        return self.calls[-1]

    def run(self, seconds: float) -> Self:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))
        return self

    def says(self, *messages: SerialMessage) -> Self:
        """The modem sends these."""
        for message in messages:
            self.link.deliver(message)
        return self

    def choose(self, user: User) -> Self:
        self.tree.set("MAx-4.Com1User", int(user))
        return self

    def offline(self) -> Self:
        """A modem is found, and accepts both strings."""
        return self.says(READY).run(1.5).says(OK).run(0.5).says(OK).run(0.5)

    def online(self) -> Self:
        return self.offline().says(CARRIER, CONNECT)

    @property
    def states(self) -> tuple[int, int]:
        """Com1UserState, and State of the Modem object."""
        return int(self.tree.get("MAx-4.Com1UserState")), int(self.tree.get("Modem.State"))

    def sent(self) -> bytes:
        """Return the bytes that the port has sent since the last call."""
        return b"".join(message for message in self.link.take() if isinstance(message, bytes))

    def dtr(self) -> bool:
        """DTR of the port."""
        lines = [message for message in self.link.sent if isinstance(message, ControlLines)]
        return lines[-1].dtr
