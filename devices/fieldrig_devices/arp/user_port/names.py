"""The frames of a USER port in words: the command, the values of the card by their names, and what it answers.

Source: docs/devices/arp/arp-user-port.md.  An answer is named by its request, which has the same sequence number.
"""

import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

from fieldrig.traces.names import listed
from fieldrig_devices.arp.user_port.framing import Deframer
from fieldrig_devices.arp.user_port.messages import (
    ANSWER,
    ANY_CARD,
    BLOCK,
    EVENT,
    LINE,
    LOST,
    PROGRESS,
    QUANTITY,
    SAMPLES,
    STEPS,
    TRACE,
    WHOLE,
    Command,
    Condition,
    Identity,
    Message,
    ProgramCode,
    Quantity,
    Status,
    bits_in,
    values_in,
)
from fieldrig_devices.arp.user_port.quantities import BITS, Kind, name_of, state_name, text_of
from fieldrig_devices.line_names.described import Part

MOST_ENDS: Final = 8
UNSOLICITED: Final = {EVENT: "EVENT", SAMPLES: "SAMPLES", PROGRESS: "PROGRESS"}
COMMANDS: Final = {int(command): command.name for command in Command}
STATUSES: Final = {int(status): status.name for status in Status}
COPIES: Final = ("RAM", "flash")
PARAMETERS: Final = (Kind.GENERAL_PARAMETER, Kind.PARAMETER_1, Kind.PARAMETER_2)
_RANGE: Final = struct.Struct("<BHH")
_FIRST: Final = struct.Struct("<H")
_VALUE: Final = struct.Struct("<i")
_NO_DATA: Final = (struct.error, ValueError, IndexError, StopIteration)


class UserPortReader:
    """Reads the bytes of a line to a USER port."""

    def __init__(self) -> None:
        self._deframers: dict[str, Deframer] = {}
        self._asked: dict[int, Message] = {}
        """The last request with each sequence number."""

    def __call__(self, sender: str, data: bytes) -> Sequence[Part]:
        end = sender if sender in self._deframers or len(self._deframers) < MOST_ENDS else ""
        deframer = self._deframers.setdefault(end, Deframer())
        return [self._part(Message.decode(body)) for body in deframer.feed(data)]

    def _part(self, message: Message) -> Part:
        command, data = message.command, message.data
        card = "any card" if message.address == ANY_CARD else f"card {message.address:02}"
        if command in UNSOLICITED:
            return UNSOLICITED[command], f"{card}: {_tried(_UNSOLICITED[command], data)}"
        if not command & ANSWER:
            self._asked[message.sequence] = message
            return _command(command), _joined(card, _tried(_REQUESTS.get(command, _hex), data))
        asked = self._asked.get(message.sequence)
        kind = f"{_command(command & ~ANSWER)} answer"
        if not data or data[0] != Status.OK:
            return kind, _joined(card, _refusal(data))
        if asked is None or asked.command != command & ~ANSWER:
            return kind, _joined(card, _hex(data[1:]))
        answer, request = _ANSWERS.get(asked.command, _any_answer), asked.data
        return kind, _joined(card, _tried(lambda given: answer(request, given), data[1:]))


def _joined(card: str, text: str) -> str:
    return f"{card}: {text}" if text else card


def _command(code: int) -> str:
    return COMMANDS.get(code, f"command {code:02X}h")


def _refusal(data: bytes) -> str:
    if not data:
        return "no status"
    name = STATUSES.get(data[0], f"status {data[0]}")
    return " ".join(filter(None, (name, data[1:].decode(errors="replace"))))


def _hex(data: bytes) -> str:
    return data.hex(" ").upper()


def _any_answer(_request: bytes, data: bytes) -> str:
    return _hex(data)


def _tried(show: Callable[[bytes], str], data: bytes) -> str:
    """Return the words for data, or the data in hex if they are too short or too long for their command."""
    try:
        return show(data)
    except _NO_DATA:
        return _hex(data)


def _name(kind: int, number: int) -> str:
    return name_of(Quantity(kind, number))


def _from_to(kind: int, first: int, count: int) -> str:
    return _name(kind, first) + (f" to {_name(kind, first + count - 1)}" if count > 1 else "")


def _shown(quantities: Iterable[Quantity], raws: Iterable[int]) -> str:
    pairs = zip(quantities, raws, strict=False)
    return listed(f"{name_of(quantity)} = {text_of(quantity, raw)}" for quantity, raw in pairs)


def _span(kind: int, first: int, count: int) -> list[Quantity]:
    return [Quantity(kind, number) for number in range(first, first + count)]


def _quantities(data: bytes) -> list[Quantity]:
    return [Quantity(*each) for each in QUANTITY.iter_unpack(data)]


def _read_answer(request: bytes, data: bytes) -> str:
    kind, first, count = _RANGE.unpack(request)
    return _shown(_span(kind, first, count), bits_in(data, count) if kind in BITS else values_in(data))


def _write_variables(data: bytes) -> str:
    (first,), raws = _FIRST.unpack_from(data), values_in(data[_FIRST.size :])
    return _shown(_span(Kind.VARIABLE, first, len(raws)), raws)


def _write_bits(data: bytes) -> str:
    kind, first, count = _RANGE.unpack_from(data)
    return _shown(_span(kind, first, count), bits_in(data[_RANGE.size :], count))


def _read_parameters(data: bytes) -> str:
    copy, group, first, count = data
    return f"{COPIES[copy]} {_from_to(PARAMETERS[group], first, count)}"


def _parameters_answer(request: bytes, data: bytes) -> str:
    copy, group, first, count = request
    return f"{COPIES[copy]} {_shown(_span(PARAMETERS[group], first, count), values_in(data))}"


def _write_parameter(data: bytes) -> str:
    copy, group, number = data[:3]
    return f"{COPIES[copy]} {_shown(_span(PARAMETERS[group], number, 1), _VALUE.unpack(data[3:]))}"


def _whole(data: bytes) -> str:
    length, crc = WHOLE.unpack(data)
    return f"{length} octets, CRC {crc:08X}h"


def _block(data: bytes) -> str:
    return f"{len(data) - BLOCK.size} octets at {BLOCK.unpack_from(data)[0]}"


def _lines(data: bytes) -> str:
    return "lines " + listed(str(line) for (line,) in LINE.iter_unpack(data)) if data else "no lines"


def _trace(data: bytes) -> str:
    return f"every {TRACE.unpack_from(data)[0]} loops " + listed(map(name_of, _quantities(data[TRACE.size :])))


def _hello(data: bytes) -> str:
    identity = Identity.decode(data)
    return f"card {identity.number:02}, {identity.largest_data} octets, program {identity.name or 'none'}"


def _condition(data: bytes) -> str:
    now = Condition.decode(data)
    program = ProgramCode(now.program).name.lower()
    parts = [state_name(now.state), f"program {program}", f"line {now.line}" if now.line else ""]
    parts += [f"ERROR {now.error}" + (f" of axis {now.error_axis}" if now.error_axis else "")] if now.error else []
    parts += [f"WARNING {now.warning}"] if now.warning else []
    return ", ".join(filter(None, parts))


def _samples(data: bytes) -> str:
    return f"{len(data) - LOST.size} octets of samples, {LOST.unpack_from(data)[0]} lost"


def _progress(data: bytes) -> str:
    done, steps = STEPS.unpack_from(data)
    return f"{done} of {steps} {data[STEPS.size :].decode(errors='replace')}".rstrip()


_REQUESTS: Final[Mapping[int, Callable[[bytes], str]]] = {
    Command.READ: lambda data: _from_to(*_RANGE.unpack(data)),
    Command.READ_MANY: lambda data: listed(map(name_of, _quantities(data))),
    Command.WRITE_VARIABLES: _write_variables,
    Command.WRITE_BITS: _write_bits,
    Command.READ_PARAMETERS: _read_parameters,
    Command.WRITE_PARAMETER: _write_parameter,
    Command.DOWNLOAD_BEGIN: _whole,
    Command.DOWNLOAD_BLOCK: _block,
    Command.UPLOAD_BLOCK: _block,
    Command.BREAKPOINTS_SET: _lines,
    Command.EVENTS: lambda data: "on" if data[0] else "off",
    Command.TRACE_START: _trace,
}
_ANSWERS: Final[Mapping[int, Callable[[bytes, bytes], str]]] = {
    Command.HELLO: lambda _, data: _hello(data),
    Command.STATE: lambda _, data: _condition(data),
    Command.READ: _read_answer,
    Command.READ_MANY: lambda request, data: _shown(_quantities(request), values_in(data)),
    Command.READ_PARAMETERS: _parameters_answer,
    Command.UPLOAD_BEGIN: lambda _, data: _whole(data),
    Command.UPLOAD_BLOCK: lambda _, data: f"{len(data)} octets",
    Command.BREAKPOINTS_SET: lambda _, data: _lines(data),
    Command.BREAKPOINTS_GET: lambda _, data: _lines(data),
    Command.PLACE: lambda _, data: _lines(data),
}
_UNSOLICITED: Final[Mapping[int, Callable[[bytes], str]]] = {
    EVENT: _condition,
    SAMPLES: _samples,
    PROGRESS: _progress,
}
