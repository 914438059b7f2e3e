"""Messages of a serial line: bytes, the state of the control lines, the format, a break.

A receiver gets `bytes` only, unless its interest names others: any of "data", "lines", "format", "break".
"""

from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple, get_args, get_type_hints

from fieldrig.bus import words_of


@dataclass(frozen=True, slots=True)
class ControlLines:
    """The outputs of one end, as that end sets them (TIA-232: DTE side).

    The line is a null modem: DTR of one end is DSR and DCD of the other, and RTS is CTS.  With `ri` a modem rings, and
    with `dcd` it reports a carrier of its own (None: it follows `dtr`).
    """

    dtr: bool = True
    rts: bool = True
    ri: bool = False
    dcd: bool | None = None


class ModemInputs(NamedTuple):
    """The inputs of one end, as that end reads them (TIA-232: DTE side)."""

    cts: bool
    dsr: bool
    dcd: bool
    ri: bool


def inputs_from(other_end: ControlLines) -> ModemInputs:
    """The inputs of an end when the other end of the null-modem line has set `other_end`."""
    dcd = other_end.dtr if other_end.dcd is None else other_end.dcd
    return ModemInputs(cts=other_end.rts, dsr=other_end.dtr, dcd=dcd, ri=other_end.ri)


@dataclass(frozen=True, slots=True)
class Format:
    """The format in which one end sends and expects characters."""

    baud: int = 9600
    data_bits: Literal[5, 6, 7, 8] = 8
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1

    @property
    def bits_per_character(self) -> int:
        return 1 + self.data_bits + (self.parity != "N") + self.stop_bits


@dataclass(frozen=True, slots=True)
class Break:
    """A break: the line was held at space for `duration_ms`."""

    duration_ms: int


SerialMessage = bytes | ControlLines | Format | Break
"""Every message that a serial line carries; bytes are characters."""

KINDS: Final[dict[type, str]] = {bytes: "data", ControlLines: "lines", Format: "format", Break: "break"}
"""The word of an interest for each kind of message."""
FASTEST: Final = 0xFFFF_FFFF
"""Lowest and highest rate, in baud."""
LONGEST_BREAK_MS: Final = 0xFFFF_FFFF

_FORMATS: Final = {
    name: get_args(hint)
    for name, hint in get_type_hints(Format).items()
    if name in ("data_bits", "parity", "stop_bits")
}


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that cannot be on a serial line."""
    if type(message) is bytes:
        return
    match message:
        case ControlLines():
            for name in ("dtr", "rts", "ri", "dcd"):
                value = getattr(message, name)
                if type(value) is not bool and not (name == "dcd" and value is None):
                    raise TypeError(f"{name}: expected bool, found {type(value).__name__}")
        case Format():
            _check_number("baud", message.baud, 1, FASTEST)
            for name, choices in _FORMATS.items():
                value = getattr(message, name)
                if type(value) is not type(choices[0]):
                    raise TypeError(f"{name}: expected {type(choices[0]).__name__}, found {type(value).__name__}")
                if value not in choices:
                    raise ValueError(f"{name} {value!r}: expected one of {choices}")
        case Break():
            _check_number("duration_ms", message.duration_ms, 0, LONGEST_BREAK_MS)
        case _:
            raise TypeError(f"expected bytes, ControlLines, Format or Break, found {type(message).__name__}")


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for an interest in anything but the words of `KINDS`."""
    for word in words_of(interest):
        if word not in KINDS.values():
            raise ValueError(f"interest {word!r} on a serial line: expected one of {list(KINDS.values())}")


def _check_number(name: str, value: Any, lowest: int, highest: int) -> None:
    if type(value) is not int:
        raise TypeError(f"{name}: expected int, found {type(value).__name__}")
    if not lowest <= value <= highest:
        raise ValueError(f"{name} {value}: expected {lowest} to {highest}")
