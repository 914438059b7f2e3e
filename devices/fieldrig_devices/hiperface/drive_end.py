"""The drive's end of the line to its motor's encoder: the encoder as `mc4` sees it.

The encoder may be a device on a serial bus, or built into the drive on an internal line.  Both use the same class, and
the same bytes at the same times.
"""

from collections import deque
from collections.abc import Callable
from typing import Any, Final, TypeVar

from fieldrig.clock import Clock, S
from fieldrig.link import Link
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_devices.drives.motor import MotorData
from fieldrig_devices.hiperface.client import Failure, Motor, MotorError, read_motor, read_position
from fieldrig_devices.hiperface.conversation import AnsweredError, Conversation, NoAnswerError, Script
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder
from fieldrig_devices.hiperface.line import FORM, InternalLine, StationPort
from fieldrig_devices.hiperface.plate import NamePlate
from fieldrig_devices.hiperface.shaft import increments_of
from fieldrig_devices.hiperface.telegram import FACTORY_ADDRESS

T = TypeVar("T")
Action = Callable[[], None]
SHARED: Final = tuple(MotorData.__dataclass_fields__)
"""Fields of a motor's data; a plate has all of them."""


def motor_data(plate: NamePlate) -> MotorData:
    return MotorData(**{name: getattr(plate, name) for name in SHARED})


class EncoderEnd:
    """The drive's end of the line; it carries requests out in their order."""

    def __init__(
        self,
        clock: Clock,
        link: Link[SerialMessage],
        *,
        motor_type: str | None = None,
        serial_number: str | None = None,
        address: int = FACTORY_ADDRESS,
    ) -> None:
        """`motor_type` and `serial_number`, if given, have to match the plate."""
        self._clock, self._link, self._address = clock, link, address
        self._wanted = (motor_type, serial_number)
        self._waiting: deque[tuple[Conversation[Any], Callable[[Conversation[Any]], None], Action | None]] = deque()
        self.motor: Motor | None = None
        """The motor as last read."""
        self.failure: Failure | None = None
        """Failure of the last reading, or None if it succeeded or there was none."""
        self.why = ""
        self._station_port = StationPort(clock, link, self)

    def start(self) -> None:
        self._link.send(FORM)

    def ask(self, script: Script[T], done: Callable[[Conversation[T]], None], on_asked: Action | None = None) -> None:
        """Run a script; `on_asked` is called when the encoder has received a request."""
        self._waiting.append((Conversation(script, self._address), done, on_asked))
        self._station_port.wake()

    def read_motor(self, done: Callable[[Motor | Failure], None]) -> None:
        def ended(conversation: Conversation[Motor]) -> None:
            try:
                self.motor, self.failure, self.why = conversation.result(), None, ""
                done(self.motor)
            except MotorError as wrong:
                self.motor, self.failure, self.why = None, wrong.failure, str(wrong)
                done(wrong.failure)

        self.ask(read_motor(*self._wanted), ended)

    def read_plate(self, done: Callable[[MotorData | None], None]) -> None:
        """Read the plate; `done` gets None after a `failure`."""
        self.read_motor(lambda motor: done(motor_data(motor.plate) if isinstance(motor, Motor) else None))

    def read_position(self, done: Callable[[int | None], None], on_asked: Action | None = None) -> None:
        """Read the position at the instant of `on_asked`, in increments to within a step; None without an answer."""

        def ended(conversation: Conversation[int]) -> None:
            try:
                steps: int | None = conversation.result()
            except (NoAnswerError, AnsweredError):
                steps = None
            done(None if steps is None else increments_of(steps))

        self.ask(read_position(), ended, on_asked)

    # ---- station on the line

    def receive(self, now_ns: int, data: bytes) -> None:
        if self._waiting:
            self._waiting[0][0].receive(now_ns, data)

    def due(self, now_ns: int) -> bytes:
        while self._waiting:
            conversation, done, on_asked = self._waiting[0]
            sent = conversation.due(now_ns)
            if not conversation.is_done:
                if sent and on_asked is not None:
                    self._clock.call_at(now_ns + len(sent) * FORM.bits_per_character * S // FORM.baud, on_asked)
                return sent
            self._waiting.popleft()
            done(conversation)
        return b""

    def next_ns(self) -> int | None:
        return self._waiting[0][0].next_ns() if self._waiting else None


def built_in(clock: Clock, encoder: HiperfaceEncoder, motor_type: str | None = None) -> EncoderEnd:
    """Connect an encoder to an internal line, and return the drive's end of it."""
    line = InternalLine(clock, encoder.form)
    encoder.start(clock.now_ns())
    StationPort(clock, line.ends[1], encoder)
    return EncoderEnd(clock, line.ends[0], motor_type=motor_type, address=encoder.eeprom.address)
