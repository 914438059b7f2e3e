"""The drive's end of the line to its motor's encoder; it is what `mc4` sees of the encoder.

The encoder may be a device of its own at a serial bus, or one built into the drive, at an internal line: same class,
same bytes, same time.
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
from fieldrig_devices.hiperface.line import FORM, InternalLine, Seat
from fieldrig_devices.hiperface.plate import NamePlate
from fieldrig_devices.hiperface.shaft import increments_of
from fieldrig_devices.hiperface.telegram import FACTORY_ADDRESS

T = TypeVar("T")
Action = Callable[[], None]
SHARED: Final = tuple(MotorData.__dataclass_fields__)
"""Fields of a motor's data, which all are fields of a plate."""


def motor_data(plate: NamePlate) -> MotorData:
    return MotorData(**{name: getattr(plate, name) for name in SHARED})


class EncoderEnd:
    """Asks one thing after the other, in the order of asking."""

    def __init__(
        self,
        clock: Clock,
        link: Link[SerialMessage],
        *,
        motor_type: str | None = None,
        serial_number: str | None = None,
        address: int = FACTORY_ADDRESS,
    ) -> None:
        """A plate of another motor than that of `motor_type` and `serial_number` is refused, if they are given."""
        self._clock, self._link, self._address = clock, link, address
        self._wanted = (motor_type, serial_number)
        self._waiting: deque[tuple[Conversation[Any], Callable[[Conversation[Any]], None], Action | None]] = deque()
        self.motor: Motor | None = None
        """As it was read last."""
        self.failure: Failure | None = None
        """Of the last reading; None: it was right, or there was none."""
        self.why = ""
        self._seat = Seat(clock, link, self)

    def start(self) -> None:
        self._link.send(FORM)

    def ask(self, script: Script[T], done: Callable[[Conversation[T]], None], on_asked: Action | None = None) -> None:
        """`on_asked` is called when the encoder has heard a request."""
        self._waiting.append((Conversation(script, self._address), done, on_asked))
        self._seat.wake()

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
        """None: `failure` says why."""
        self.read_motor(lambda found: done(motor_data(found.plate) if isinstance(found, Motor) else None))

    def read_position(self, done: Callable[[int | None], None], on_asked: Action | None = None) -> None:
        """In increments, to within a step of the encoder, at the instant of `on_asked`; None: no answer."""

        def ended(conversation: Conversation[int]) -> None:
            try:
                steps: int | None = conversation.result()
            except (NoAnswerError, AnsweredError):
                steps = None
            done(None if steps is None else increments_of(steps))

        self.ask(read_position(), ended, on_asked)

    # ---- what its seat asks

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
    """An encoder that has no line of its own in the rig, and the drive's end of the line to it."""
    line = InternalLine(clock, encoder.form)
    encoder.start(clock.now_ns())
    Seat(clock, line.ends[1], encoder)
    return EncoderEnd(clock, line.ends[0], motor_type=motor_type, address=encoder.eeprom.address)
