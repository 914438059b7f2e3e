"""What goes over a serial line: bytes, the state of the control lines, the format, a break.

A receiver hears `bytes` only, unless its interest names more: any of "data", "lines", "format", "break".
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple


@dataclass(frozen=True, slots=True)
class ControlLines:
    """The outputs of one end, as that end sets them (TIA-232: DTE side).

    A null-modem line: our DTR is the other end's DSR and DCD, our RTS its CTS.  `ri` lets a modem ring, `dcd`
    lets it report a carrier of its own (None: follows `dtr`).
    """

    dtr: bool = True
    rts: bool = True
    ri: bool = False
    dcd: bool | None = None


class ModemInputs(NamedTuple):
    """The inputs of one end of a line, as that end reads them (TIA-232: DTE side)."""

    cts: bool
    dsr: bool
    dcd: bool
    ri: bool


def inputs_from(other_end: ControlLines) -> ModemInputs:
    """What an end reads when the other end of its null-modem line has set `other_end`."""
    dcd = other_end.dtr if other_end.dcd is None else other_end.dcd
    return ModemInputs(cts=other_end.rts, dsr=other_end.dtr, dcd=dcd, ri=other_end.ri)


@dataclass(frozen=True, slots=True)
class Format:
    """How one end sends and expects characters."""

    baud: int = 9600
    data_bits: Literal[5, 6, 7, 8] = 8
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1

    @property
    def bits_per_character(self) -> int:
        return 1 + self.data_bits + (self.parity != "N") + self.stop_bits


@dataclass(frozen=True, slots=True)
class Break:
    """The line was held at space for `duration_ms`."""

    duration_ms: int


SerialMessage = bytes | ControlLines | Format | Break
