"""The faults of a Modbus bus: their settings.

A fault says where (unit, function, register, client), what, when and for how long (`start_ms`, `duration_ms`) and how
often (`nth`, `count`, `probability`).  `effects` has what they do.
"""

from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.clock import MS
from fieldrig.faults.faults import LONGEST_MS, Repeated, Timed, models_of
from fieldrig.faults.hex_bytes import Hex
from fieldrig_bus.modbus.message import LONGEST_PDU

LONGEST_FRAME: Final = 2 * (LONGEST_PDU + 2) + 3
"""Bytes of the longest frame, which is one of ASCII."""


class ModbusWhere(Repeated):
    """The exchanges that a fault concerns."""

    names: ClassVar = {"unit": "unit"}

    unit: int | None = Field(default=None, ge=0, le=255, description="unit id; left out: any")
    function: int | None = Field(default=None, ge=1, le=127, description="function code; left out: any")
    address: int | None = Field(
        default=None, ge=0, le=0xFFFF, description="register or bit on the wire, from 0, that the request names"
    )
    client: str | None = Field(default=None, description="the client that asks, such as tcp:1; left out: any")


class Drop(ModbusWhere):
    """No answer comes: the device has done what was asked, or with `of: request` has never heard of it."""

    what: Literal["drop"]
    of: Literal["answer", "request"] = Field(default="answer", description="the message that is lost")


class Delay(ModbusWhere):
    """The answer is late."""

    what: Literal["delay"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")

    @property
    def delay_ns(self) -> int:
        """The delay in nanoseconds."""
        return round(self.delay_ms * MS)


class Duplicate(ModbusWhere):
    """The answer comes twice."""

    what: Literal["duplicate"]


class Replace(ModbusWhere):
    """The answer has other data than the device gave, in a right frame."""

    what: Literal["replace"]
    data: Hex | None = Field(default=None, max_length=3 * LONGEST_PDU, description="hex; the PDU behind its function")
    xor: Hex | None = Field(default=None, max_length=3 * LONGEST_PDU, description="hex; bits to flip there")

    @model_validator(mode="after")
    def _check_there_is_one(self) -> Self:
        if (self.data is None) == (self.xor is None):
            raise ValueError("expected either data or xor")
        return self


class Refusal(ModbusWhere):
    """The device refuses with an exception, and does nothing."""

    what: Literal["exception"]
    code: int = Field(default=6, ge=1, le=255, description="exception code; 6 is server device busy")


class WrongUnit(ModbusWhere):
    """The answer has the id of another unit."""

    what: Literal["wrong_unit"]
    answers_as: int | None = Field(default=None, ge=0, le=255, description="its unit id; left out: the next one")


class WrongTransaction(ModbusWhere):
    """The answer has another transaction id (TCP)."""

    what: Literal["wrong_transaction"]
    offset: int = Field(default=1, ge=-0xFFFF, le=0xFFFF, description="added to the right one")


class WrongCheck(ModbusWhere):
    """The answer has a wrong CRC or LRC (serial line)."""

    what: Literal["wrong_crc"]


class Truncate(ModbusWhere):
    """The end of the answer is missing."""

    what: Literal["truncate"]
    keep: int | None = Field(default=None, ge=0, le=LONGEST_FRAME, description="bytes that are there; left out: half")


class Garbage(ModbusWhere):
    """Other bytes stand directly before the answer."""

    what: Literal["garbage"]
    data: Hex = Field(default="00", min_length=1, max_length=1024, description="hex")


class Split(ModbusWhere):
    """The answer comes in two pieces."""

    what: Literal["split"]
    keep: int | None = Field(default=None, ge=1, le=LONGEST_FRAME, description="bytes of the first; left out: half")
    gap_ms: float = Field(default=20.0, gt=0, le=LONGEST_MS, description="silence between them")


class Cut(ModbusWhere):
    """The connection is closed instead of an answer, or in the middle of it (TCP)."""

    what: Literal["cut"]
    keep: int = Field(default=0, ge=0, le=LONGEST_FRAME, description="bytes of the answer that still come")


class Refuse(Repeated):
    """New connections are refused; with `nth`, `count` or `probability` they are closed at once (TCP)."""

    what: Literal["refuse"]


class Noise(ModbusWhere):
    """Bits of the answer are inverted at random (serial line)."""

    what: Literal["noise"]
    bit_error_rate: float = Field(default=0.01, gt=0, le=0.5, description="share of the bits")


class LoseBytes(ModbusWhere):
    """Bytes of the answer are missing at random (serial line)."""

    what: Literal["lose_bytes"]
    share: float = Field(default=0.1, gt=0, le=1, description="share of the bytes")


class WrongBaud(ModbusWhere):
    """The device sends at another rate than the line has (serial line)."""

    what: Literal["wrong_baud"]
    baud: int = Field(ge=50, le=10_000_000, description="its rate, in bit/s")


class Stuck(Timed):
    """The line is held at one level, so nothing passes in either direction (serial line); `low` is a break."""

    what: Literal["stuck"]
    level: Literal["high", "low"] = Field(default="high", description="high is the level of an idle line")


ANYWHERE: Final = (Drop, Delay, Duplicate, Replace, Refusal, WrongUnit, Truncate, Garbage, Split)
TCP_ONLY: Final = (WrongTransaction, Cut, Refuse)
LINE_ONLY: Final = (WrongCheck, Noise, LoseBytes, WrongBaud, Stuck)

_Anywhere = Drop | Delay | Duplicate | Replace | Refusal | WrongUnit | Truncate | Garbage | Split
_Tcp = WrongTransaction | Cut | Refuse
_Line = WrongCheck | Noise | LoseBytes | WrongBaud | Stuck
TcpFault = Annotated[_Anywhere | _Tcp, Field(discriminator="what")]
LineFault = Annotated[_Anywhere | _Line, Field(discriminator="what")]
ModbusFault = Annotated[_Anywhere | _Tcp | _Line, Field(discriminator="what")]
TCP_MODELS: Final = models_of(TcpFault)
LINE_MODELS: Final = models_of(LineFault)
MODELS: Final = models_of(ModbusFault)
