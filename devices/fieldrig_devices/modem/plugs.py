"""The two plugs of a modem: an end of a bus that can be pulled out and put back."""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import MS, Clock
from fieldrig.link import Link
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage
from fieldrig_bus.telephone.message import Carrier, Hook, TelephoneMessage

FLASH_NS: Final = 100 * MS
"""How long the LEDs of data are lit after the last character: a character alone is too short to be seen."""
ALL_OFF: Final = ControlLines(dtr=False, rts=False, ri=False, dcd=False)


class SerialPlug:
    """The plug of the serial line.  Pulled out, each end sees all lines of the other one off.

    While `is_miswired`, no data pass.
    """

    def __init__(self, link: Link[SerialMessage], clock: Clock) -> None:
        self._link, self._clock = link, clock
        self._sent_ns = self._received_ns = -FLASH_NS
        """The instants of the last data to the terminal, and from it."""
        self._on_message: Callable[[SerialMessage], None] = lambda _message: None
        self._is_in = True
        self.is_miswired = False
        self._lines, self._their_lines = ALL_OFF, ControlLines()
        self._form = Format()
        self._their_form: Format | None = None

    def send(self, message: SerialMessage) -> None:
        if isinstance(message, ControlLines):
            self._lines = message
        elif isinstance(message, Format):
            self._form = message
        if self._passes(message):
            if isinstance(message, bytes):
                self._sent_ns = self._clock.now_ns()
            self._link.send(message)

    @property
    def is_sending(self) -> bool:
        """True while data pass to the terminal, and shortly after."""
        return self._clock.now_ns() - self._sent_ns < FLASH_NS

    @property
    def is_receiving(self) -> bool:
        """True while data come from the terminal, and shortly after."""
        return self._clock.now_ns() - self._received_ns < FLASH_NS

    def on_receive(self, handler: Callable[[SerialMessage], None], interest: object = None) -> None:
        self._on_message = handler
        self._link.on_receive(self._receive, ("data", "lines", "format"))

    def put(self, is_in: bool) -> None:
        if is_in is self._is_in:
            return
        self._is_in = is_in
        self._link.send(self._lines if is_in else ALL_OFF)
        if is_in:
            self._link.send(self._form)
            if self._their_form is not None:
                self._on_message(self._their_form)
        self._on_message(self._their_lines if is_in else ALL_OFF)

    def _receive(self, message: SerialMessage) -> None:
        if isinstance(message, ControlLines):
            self._their_lines = message
        elif isinstance(message, Format):
            self._their_form = message
        if self._passes(message):
            if isinstance(message, bytes):
                self._received_ns = self._clock.now_ns()
            self._on_message(message)

    def _passes(self, message: SerialMessage) -> bool:
        return self._is_in and not (self.is_miswired and isinstance(message, bytes | Break))


class TelephonePlug:
    """The plug of the telephone line.  Pulled out, the exchange sees the line free and the modem hears nothing."""

    def __init__(self, link: Link[TelephoneMessage]) -> None:
        self._link = link
        self._on_message: Callable[[TelephoneMessage], None] = lambda _message: None
        self._is_in, self._is_off_hook = True, False

    def send(self, message: TelephoneMessage) -> None:
        if isinstance(message, Hook):
            self._is_off_hook = message.is_off
        if self._is_in:
            self._link.send(message)

    def on_receive(self, handler: Callable[[TelephoneMessage], None], interest: object = None) -> None:
        self._on_message = handler
        self._link.on_receive(self._receive)

    def put(self, is_in: bool) -> None:
        if is_in is self._is_in:
            return
        self._is_in = is_in
        if self._is_off_hook:
            self._link.send(Hook(is_in))
        if not is_in:
            self._on_message(Carrier(0))

    def _receive(self, message: TelephoneMessage) -> None:
        if self._is_in:
            self._on_message(message)
