"""A PC on the encoder's line: conversations over a serial port of the host.

`open_port` accepts the ports of pyserial's `serial_for_url`: a device or pty, socket://HOST:PORT, rfc2217://HOST:PORT.
"""

import contextlib
from typing import Any, Final, TypeVar

import serial
from serial import serialutil

from fieldrig.clock import MS, S
from fieldrig.errors import BusError, RefusedError
from fieldrig_bus.serial.port_errors import reason
from fieldrig_bus.serial.reading import read_arrived
from fieldrig_devices.hiperface.client import MotorError
from fieldrig_devices.hiperface.conversation import AnsweredError, Conversation, NoAnswerError, Script
from fieldrig_devices.hiperface.telegram import FACTORY_ADDRESS

# pyserial has no types
_now_s: Final[Any] = serialutil.Timeout.TIME
_serial_for_url: Final[Any] = serial.serial_for_url

try:
    import termios
except ImportError:  # Windows has no pty
    NO_PARITY: tuple[type[Exception], ...] = ()
    """The error of a pty, which has no parity."""
else:
    NO_PARITY = (termios.error,) if hasattr(termios, "error") else ()

READ_S: Final = 0.01
"""Longest wait of a read from the port."""
SLACK_NS: Final = 500 * MS
"""Extra time for answers, for the way into the rig and back."""

T = TypeVar("T")


class RefusedByEncoderError(RefusedError):
    """The encoder answered, but refused the request."""


class EncoderPort:
    def __init__(self, line: Any, address: int = FACTORY_ADDRESS, slack_ns: int = SLACK_NS, retries: int = 3) -> None:
        """`line` is an open port of pyserial with a short read time-out."""
        self._line, self._address, self._slack_ns, self._retries = line, address, slack_ns, retries

    def close(self) -> None:
        self._line.close()

    def run(self, script: Script[T]) -> T:
        """Run a script.  Raises BusError without an answer, and RefusedByEncoderError if the encoder refuses."""
        conversation = Conversation(script, self._address, retries=self._retries, slack_ns=self._slack_ns)
        try:
            while not conversation.is_done:
                self._step(conversation)
        except (serial.SerialException, OSError) as cause:
            raise BusError(
                f"{self._line.port} is gone: {cause}", "check whether its rig has ended, and start it again"
            ) from cause
        try:
            return conversation.result()
        except NoAnswerError as wrong:
            raise BusError(
                f"{wrong} at {self._line.port}",
                "check that its rig is up, that this is the encoder's line, and the encoder's address",
            ) from wrong
        except (AnsweredError, MotorError) as wrong:
            raise RefusedByEncoderError(str(wrong)) from wrong

    def _step(self, conversation: Conversation[Any]) -> None:
        if sent := conversation.due(_now_ns()):
            self._line.write(sent)
        if data := read_arrived(self._line):
            conversation.receive(_now_ns(), data)


def _now_ns() -> int:
    now_s: float = _now_s()
    return round(now_s * S)


def open_port(port: str, baud: int = 9600, address: int = FACTORY_ADDRESS) -> EncoderPort:
    """Open the port of an encoder.  Raises BusError with a remedy if the port is not available."""
    try:
        line = _serial_for_url(port, baud, timeout=READ_S)
        with contextlib.suppress(*NO_PARITY):
            line.parity = serial.PARITY_EVEN
    except (serial.SerialException, OSError, ValueError) as cause:
        raise BusError(
            f"cannot open {port}: {reason(cause)}",
            "expected a device, a pty, socket://HOST:PORT or rfc2217://HOST:PORT",
        ) from cause
    return EncoderPort(line, address)
