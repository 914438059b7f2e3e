"""The PC's end of the USER port, for service tools, scripts and tests.

    with ArpPort.open("/dev/ttyUSB0") as card:
        card.set_variables(1, [2500])
        card.run()

`open` accepts the addresses of pyserial's `serial_for_url`: a device or pty, socket://HOST:PORT, rfc2217://HOST:PORT.
Values are raw integers.  Methods raise BusError if the port is lost or does not answer, and RefusedByCardError for a
request that the card refuses.
"""

import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from types import TracebackType
from typing import Final, NamedTuple, Self

from fieldrig.errors import RefusedError
from fieldrig.loop.background import Report
from fieldrig_devices.arp.parameters import PARAMETERS
from fieldrig_devices.arp.user_port import messages
from fieldrig_devices.arp.user_port.line import CardLine, open_line
from fieldrig_devices.arp.user_port.memory import RAM
from fieldrig_devices.arp.user_port.messages import (
    ANY_CARD,
    BLOCK,
    EVENT,
    LARGEST_BLOCK,
    LINE,
    LOST,
    MOST_BITS,
    MOST_QUANTITIES,
    MOST_VARIABLES,
    QUANTITY,
    SAMPLES,
    STEPS,
    TRACE,
    UNNUMBERED,
    WHOLE,
    Command,
    Condition,
    Identity,
    Message,
    Quantity,
    Status,
)
from fieldrig_devices.arp.user_port.quantities import GROUPS, Kind

LOAD_S: Final = 60.0
"""Time that a card may take between two reports while it compiles a program, in seconds."""

OnProgress = Callable[[int, int], None]
"""Called with the number of bytes done and the total."""


class RefusedByCardError(RefusedError):
    """A request that the card refuses."""

    def __init__(self, status: Status, what: str, remedy: str = "") -> None:
        super().__init__(what, remedy)
        self.status = status


class Sample(NamedTuple):
    loop: int
    """Number of the control loop."""
    values: tuple[int, ...]
    lost: int
    """Number of samples that the card had to leave out since the trace began."""


WRONG: Final = {
    Status.VERSION: (
        "the card speaks another version of the protocol",
        "use the fieldrig version that the card runs on",
    ),
    Status.COMMAND: ("the card does not know this request", "use the fieldrig version that the card runs on"),
    Status.LENGTH: ("the request is too short or too long", ""),
    Status.RANGE: ("the object does not exist, or cannot have this value", ""),
    Status.REFUSED: ("the card refuses the request", ""),
    Status.ORDER: ("the blocks of the program arrived out of order", "start the transfer again"),
    Status.DAMAGED: ("the program was damaged in transfer; the card keeps the old program", "try again"),
    Status.OBJECT: (
        "the file is not a program for the card; the card keeps the old program",
        "compile it: fieldrig arp compile FILE",
    ),
    Status.NO_PROGRAM: ("the card has no program", "download one: fieldrig arp download FILE"),
}
"""Problem and remedy for each status of an answer."""


class ArpPort:
    """A client of the USER port of a card, emulated or not: values, commands, programs and parameters."""

    def __init__(self, line: CardLine) -> None:
        """Create a client of an open line.  Call `hello` first, or use `open` instead."""
        self._line = line
        self._number = ANY_CARD
        self._sequence = 0
        self._sample = struct.Struct("<I")
        self._samples: deque[Sample] = deque()

    @classmethod
    def open(
        cls, port: str, number: int | None = None, baud: int = 9600, timeout_s: float = 1.0, retries: int = 3
    ) -> Self:
        """Open a port and greet the card; `number` is its expected address nn."""
        opened = cls(open_line(port, baud, timeout_s, retries))
        try:
            opened.hello(number)
        except BaseException:
            opened.close()
            raise
        return opened

    def close(self) -> None:
        self._line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, fault_type: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None
    ) -> None:
        self.close()

    def request(
        self,
        command: Command,
        data: bytes = b"",
        patience_s: float = 0.0,
        on_progress: Callable[[bytes], None] | None = None,
    ) -> bytes:
        """Send a request and return the data of the answer, for commands without a method.

        It may take `patience_s`, and as long again after each PROGRESS, whose data `on_progress` is called with.
        """
        self._sequence = self._sequence % 255 + 1
        return _checked(self._line.ask(Message(self._number, self._sequence, command, data), patience_s, on_progress))

    # ---- the card

    def hello(self, number: int | None = None) -> Identity:
        """Begin a session; the card ends the session of any other PC."""
        identity = Identity.decode(_checked(self._line.ask(Message(ANY_CARD, UNNUMBERED, Command.HELLO))))
        if number is not None and identity.number != number:
            raise RefusedByCardError(
                Status.RANGE,
                f"the card at this port is number {identity.number:02}, not {number:02}",
                f"name the program NAME.I{identity.number:02}, or use the port of card {number:02}",
            )
        self._number, self._sequence = identity.number, 0
        return identity

    @property
    def number(self) -> int:
        """Address nn of the card that was greeted."""
        return self._number

    def condition(self) -> Condition:
        return Condition.decode(self.request(Command.STATE))

    def run(self) -> None:
        """Run the program: from its first instruction, or on from a pause."""
        self.request(Command.RUN)

    def stop(self) -> None:
        self.request(Command.STOP)

    def ensure_stopped(self) -> None:
        """Stop the program if it runs."""
        try:
            self.stop()
        except RefusedByCardError as cause:
            if cause.status is not Status.REFUSED:
                raise

    def reset(self) -> None:
        """Reset the card, as Ctrl-F2 does."""
        self.request(Command.RESET)

    # ---- values

    def variables(self, first: int, count: int) -> list[int]:
        values = list[int]()
        for start, some in _parts(count, MOST_VARIABLES):
            head = struct.pack("<BHH", Kind.VARIABLE, first + start, some)
            values += messages.values_in(self.request(Command.READ, head))
        return values

    def bits(self, kind: Kind, first: int, count: int) -> list[int]:
        """Read flags, inputs or outputs."""
        levels = list[int]()
        for start, some in _parts(count, MOST_BITS):
            head = struct.pack("<BHH", kind, first + start, some)
            levels += messages.bits_in(self.request(Command.READ, head), some)
        return levels

    def values(self, wanted: Sequence[Quantity]) -> list[int]:
        answers = list[int]()
        for start, some in _parts(len(wanted), MOST_QUANTITIES):
            answers += messages.values_in(self.request(Command.READ_MANY, _packed(wanted[start : start + some])))
        return answers

    def polled(self, wanted: Sequence[Quantity], every_s: float) -> Iterator[list[int]]:
        """Read the values at once, and then every `every_s` seconds."""
        for _ in self._line.paced(every_s):
            yield self.values(wanted)

    def set_variables(self, first: int, values: Sequence[int]) -> None:
        for start, some in _parts(len(values), MOST_VARIABLES):
            part = messages.packed_values(values[start : start + some])
            self.request(Command.WRITE_VARIABLES, struct.pack("<H", first + start) + part)

    def set_bits(self, kind: Kind, first: int, bits: Sequence[int]) -> None:
        """Write flags or outputs."""
        for start, some in _parts(len(bits), MOST_BITS):
            part = messages.packed_bits(bits[start : start + some])
            self.request(Command.WRITE_BITS, struct.pack("<BHH", kind, first + start, some) + part)

    def set(self, quantity: Quantity, raw: int) -> None:
        """Write V, F, O, or the RAM copy of a parameter; the card refuses other quantities."""
        kind = Kind(quantity.kind)
        if kind is Kind.VARIABLE:
            self.set_variables(quantity.number, [raw])
        elif kind in GROUPS:
            self.set_parameter(RAM, GROUPS[kind], quantity.number, raw)
        else:
            self.set_bits(kind, quantity.number, [raw])

    def parameters(self, copy: int, group: int) -> list[int]:
        """Read all parameters of a group; element 0 is not used."""
        head = bytes((copy, group, 1, len(PARAMETERS[group])))
        return [0, *messages.values_in(self.request(Command.READ_PARAMETERS, head))]

    def set_parameter(self, copy: int, group: int, number: int, raw: int) -> None:
        """Write the copy in RAM, or the copies in flash and RAM."""
        self.request(Command.WRITE_PARAMETER, struct.pack("<BBBi", copy, group, number, raw))

    # ---- the program

    def download(
        self,
        data: bytes,
        on_progress: OnProgress = lambda _done, _all: None,
        on_compiling: Report = lambda _what, _done, _steps: None,
    ) -> None:
        """Download an object file, and wait until the card has compiled it.

        The card keeps its old program until this returns.
        """

        def on_report(report: bytes) -> None:
            done, steps = STEPS.unpack_from(report)
            on_compiling(report[STEPS.size :].decode(errors="replace"), done, steps)

        self.request(Command.DOWNLOAD_BEGIN, WHOLE.pack(len(data), zlib.crc32(data)))
        for offset in range(0, len(data), LARGEST_BLOCK):
            on_progress(offset, len(data))
            self.request(Command.DOWNLOAD_BLOCK, BLOCK.pack(offset) + data[offset : offset + LARGEST_BLOCK])
        on_progress(len(data), len(data))
        self.request(Command.DOWNLOAD_COMMIT, patience_s=LOAD_S, on_progress=on_report)

    def upload(self, on_progress: OnProgress = lambda _done, _all: None) -> bytes:
        """Read the object file of the card's program."""
        length, crc = WHOLE.unpack(self.request(Command.UPLOAD_BEGIN))
        data = b""
        while len(data) < length:
            on_progress(len(data), length)
            data += self.request(Command.UPLOAD_BLOCK, BLOCK.pack(len(data)))
        on_progress(length, length)
        if zlib.crc32(data) != crc:
            raise RefusedByCardError(Status.DAMAGED, "the card's program was damaged in transfer", "try again")
        return data

    def break_at(self, lines: Iterable[int]) -> list[int]:
        """Set breakpoints on these source lines and no others.  Returns the lines that have an instruction."""
        return _lines(self.request(Command.BREAKPOINTS_SET, b"".join(map(LINE.pack, sorted(set(lines))))))

    def breakpoints(self) -> list[int]:
        return _lines(self.request(Command.BREAKPOINTS_GET))

    def pause(self) -> None:
        self.request(Command.PAUSE)

    def step(self) -> None:
        """Execute one instruction."""
        self.request(Command.STEP)

    def place(self) -> list[int]:
        """Line of the next instruction, then the lines to which the callers return, innermost first."""
        return _lines(self.request(Command.PLACE))

    # ---- unsolicited messages

    def events(self, is_on: bool) -> None:
        self._line.forget(EVENT)
        self.request(Command.EVENTS, bytes((is_on,)))

    def event(self, patience_s: float) -> Condition | None:
        """The next event, or None if none arrives within the time."""
        event = self._line.unsolicited(EVENT, patience_s, self.condition)
        return None if event is None else Condition.decode(event.data)

    def trace(self, every: int, wanted: Sequence[Quantity]) -> None:
        """Start a trace that samples these quantities in every `every`th control loop."""
        self._line.forget(SAMPLES)
        self._samples.clear()
        self._sample = struct.Struct(f"<I{len(wanted)}i")
        self.request(Command.TRACE_START, TRACE.pack(every) + _packed(wanted))

    def sample(self, patience_s: float) -> Sample | None:
        """The next sample, or None if none arrives within the time."""
        if not self._samples and (message := self._line.unsolicited(SAMPLES, patience_s, self.condition)) is not None:
            self._samples += self._samples_in(message.data)
        return self._samples.popleft() if self._samples else None

    def end_trace(self) -> None:
        self.request(Command.TRACE_STOP)
        self._line.forget(SAMPLES)
        self._samples.clear()

    def _samples_in(self, data: bytes) -> Iterator[Sample]:
        (lost,) = LOST.unpack_from(data)
        for loop, *values in self._sample.iter_unpack(data[LOST.size :]):
            yield Sample(loop, tuple(values), lost)


def _checked(answer: Message) -> bytes:
    """Return the data of an answer whose status is OK, or raise RefusedByCardError."""
    code, data = answer.data[0], answer.data[1:]
    if code == Status.OK:
        return data
    if code not in WRONG:
        raise RefusedByCardError(
            Status.COMMAND, f"the card refuses with code {code}", "use the fieldrig version that the card runs on"
        )
    what, remedy = WRONG[Status(code)]
    text = data.decode(errors="replace")
    raise RefusedByCardError(Status(code), f"{what}: {text}" if text else what, remedy)


def _parts(count: int, most: int) -> Iterator[tuple[int, int]]:
    """First index and size of each part, with at most `most` elements."""
    for start in range(0, count, most):
        yield start, min(most, count - start)


def _packed(wanted: Sequence[Quantity]) -> bytes:
    return b"".join(QUANTITY.pack(*quantity) for quantity in wanted)


def _lines(data: bytes) -> list[int]:
    return [line for (line,) in LINE.iter_unpack(data)]
