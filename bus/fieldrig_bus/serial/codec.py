"""Serial messages as bytes, for other processes and traces, and as a line of text.

The first byte is the kind of message; numbers after it are little endian.
"""

import struct
from collections.abc import Callable
from typing import Any

from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage

DATA, LINES, FORMAT, BREAK = range(4)

_FORMAT = struct.Struct("<IBcB")  # baud, data bits, parity letter, stop bits
_BREAK = struct.Struct("<I")  # ms
_DTR, _RTS, _RI, _DCD_SET, _DCD = 1, 2, 4, 8, 16
_LONGEST_SHOWN = 24


def encode(message: SerialMessage) -> bytes:
    if type(message) is bytes:
        return b"\x00" + message
    return _ENCODERS[type(message)](message)


def decode(data: bytes) -> Any:
    """The inverse of `encode`, or the note of a fault, from a trace.  ValueError for anything else."""
    if not data or data[0] > BREAK:
        if data.startswith(note.LEAD):
            return note.decode(data)
        raise ValueError(f"not a serial message: {data.hex(' ')}")
    if data[0] == DATA:
        return data[1:]
    try:
        return _DECODERS[data[0]](data[1:])
    except (struct.error, KeyError, IndexError, UnicodeDecodeError) as cause:
        raise ValueError(f"not a serial message: {data.hex(' ')}") from cause


def show(message: SerialMessage | FaultNote) -> str:
    match message:
        case bytes():
            shown = message[:_LONGEST_SHOWN]
            rest = f" … {len(message)} bytes" if len(message) > _LONGEST_SHOWN else ""
            return f"{shown.hex(' ')}  {repr(shown)[1:]}{rest}"
        case ControlLines(dtr=dtr, rts=rts, ri=ri, dcd=dcd):
            states = {"DTR": dtr, "RTS": rts, "RI": ri} | ({} if dcd is None else {"DCD": dcd})
            return " ".join(f"{line}={'on' if state else 'off'}" for line, state in states.items())
        case Format(baud=baud, data_bits=data_bits, parity=parity, stop_bits=stop_bits):
            return f"{baud} {data_bits}{parity}{stop_bits}"
        case Break(duration_ms=duration_ms):
            return f"break {duration_ms} ms"
        case FaultNote():
            return note.show(message)


def _encode_lines(lines: ControlLines) -> bytes:
    flags = lines.dtr * _DTR | lines.rts * _RTS | lines.ri * _RI
    if lines.dcd is not None:
        flags |= _DCD_SET | lines.dcd * _DCD
    return bytes((LINES, flags))


def _decode_lines(body: bytes) -> ControlLines:
    (flags,) = struct.unpack("B", body)
    if flags >= 2 * _DCD or flags & (_DCD | _DCD_SET) == _DCD:
        raise KeyError(flags)
    dcd = bool(flags & _DCD) if flags & _DCD_SET else None
    return ControlLines(bool(flags & _DTR), bool(flags & _RTS), bool(flags & _RI), dcd)


def _encode_format(form: Format) -> bytes:
    packed = _FORMAT.pack(form.baud, form.data_bits, form.parity.encode(), form.stop_bits)
    return bytes((FORMAT,)) + packed


def _decode_format(body: bytes) -> Format:
    baud, data_bits, parity, stop_bits = _FORMAT.unpack(body)
    return format_of(baud, data_bits, parity.decode("ascii"), stop_bits)


def format_of(baud: int, data_bits: int, parity: str, stop_bits: int) -> Format:
    """The format from its numbers in bytes.  KeyError if there is no such format."""
    if baud < 1:
        raise KeyError(baud)
    return Format(baud, _DATA_BITS[data_bits], _PARITIES[parity], _STOP_BITS[stop_bits])


_DATA_BITS: dict[int, Any] = {bits: bits for bits in (5, 6, 7, 8)}
_PARITIES: dict[str, Any] = {letter: letter for letter in "NEO"}
_STOP_BITS: dict[int, Any] = {bits: bits for bits in (1, 2)}

_ENCODERS: dict[type, Callable[[Any], bytes]] = {
    ControlLines: _encode_lines,
    Format: _encode_format,
    Break: lambda message: bytes((BREAK,)) + _BREAK.pack(message.duration_ms),
    FaultNote: note.encode,
}
_DECODERS: dict[int, Callable[[bytes], SerialMessage]] = {
    LINES: _decode_lines,
    FORMAT: _decode_format,
    BREAK: lambda body: Break(*_BREAK.unpack(body)),
}
