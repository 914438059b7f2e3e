"""Faults that can be injected into a CAN bus: their settings, and the frames that they apply to.

A fault says where (identifier, node), what, when and for how long (`start_ms` after it was added, `duration_ms`) and
how often (`count`, `probability`).  In a rig file it is listed under `faults:` of its bus; a running rig takes the same
by `add_fault`, as `given_fault` reads it.  Chance depends on the frame and its sender.
"""

from dataclasses import replace
from random import Random
from typing import Annotated, ClassVar, Final, Literal

from pydantic import Field, model_validator

from fieldrig.clock import MS
from fieldrig.faults import faults
from fieldrig.faults.faults import LONGEST_MS, Repeated, Timed
from fieldrig.faults.hex_bytes import Hex, flipped, replaced
from fieldrig.settings import MEMBER
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK, CanFrame
from fieldrig_bus.can.notices import FASTEST, SLOWEST


class _FrameFault(Repeated):
    names: ClassVar = {"node": MEMBER}

    identifier: int | None = Field(
        default=None, ge=0, le=EXTENDED_MASK, description="identifier of the frames; left out: any"
    )
    mask: int | None = Field(default=None, ge=0, le=EXTENDED_MASK, description="bits of the identifier that count")
    extended: bool | None = Field(default=None, description="29 bits or 11; left out: as the identifier needs, or both")
    node: str | None = Field(default=None, description="the sender; left out: any")

    @model_validator(mode="after")
    def _check_mask(self) -> "_FrameFault":
        if self.mask is not None and self.identifier is None:
            raise ValueError("mask: expected an identifier beside it")
        return self

    def fits(self, sender: str, frame: CanFrame) -> bool:
        """True if the fault concerns this frame, apart from time and chance."""
        if self.node is not None and sender != self.node:
            return False
        if self.extended is not None and frame.is_extended is not self.extended:
            return False
        if self.identifier is None:
            return True
        if self.extended is None and self.mask is None and frame.is_extended is not (self.identifier > STANDARD_MASK):
            return False
        mask = EXTENDED_MASK if self.mask is None else self.mask
        return frame.identifier & mask == self.identifier & mask


class Drop(_FrameFault):
    """The frame is on the wire and acknowledged, but `receivers` (all, if left out) do not get it."""

    names: ClassVar = {"node": MEMBER, "receivers": MEMBER}

    what: Literal["drop"]
    receivers: list[str] | None = Field(default=None, description="members that lose the frame; left out: all")


class Delay(_FrameFault):
    """The frame takes part in arbitration later, and so do the frames that its sender asks for after it."""

    what: Literal["delay"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")

    @property
    def delay_ns(self) -> int:
        """The delay in nanoseconds."""
        return round(self.delay_ms * MS)


class Duplicate(_FrameFault):
    """The frame is sent a second time."""

    what: Literal["duplicate"]


class Replace(_FrameFault):
    """Receivers get different data than was sent, with a valid CRC."""

    what: Literal["replace"]
    data: Hex | None = Field(default=None, description="hex; as many bytes as the frame has are used")
    xor: Hex | None = Field(default=None, description="hex; bits to flip, from the first byte on")

    @model_validator(mode="after")
    def _check_there_is_one(self) -> "Replace":
        if (self.data is None) == (self.xor is None):
            raise ValueError("expected either data or xor")
        return self

    def of(self, frame: CanFrame) -> CanFrame:
        """The frame that receivers get."""
        return replace(frame, data=self._replaced(frame.data))

    def _replaced(self, data: bytes) -> bytes:
        return replaced(data, self.data) if self.data is not None else flipped(data, self.xor or "")


class Corrupt(_FrameFault):
    """One bit is flipped on the wire, which causes an error frame; the sender tries again."""

    what: Literal["corrupt"]
    bit: int | None = Field(
        default=None, ge=0, description="0: start of frame; left out: a random bit after arbitration"
    )


class ErrorFrame(_FrameFault):
    """Six dominant bits are forced onto the bus, like an error flag."""

    what: Literal["error_frame"]
    bit: int | None = Field(
        default=None, ge=0, description="the first of these bits; left out: a random bit after arbitration"
    )


class Short(Timed):
    """The wire is held dominant, or recessive, regardless of what members send."""

    what: Literal["short"]
    level: Literal["dominant", "recessive"] = "dominant"


class WrongBitRate(Timed):
    """The bit rate of one member is wrong: others see errors in its frames, and it sees errors in theirs."""

    names: ClassVar = {"node": MEMBER}

    what: Literal["wrong_bit_rate"]
    node: str
    bitrate: int = Field(ge=SLOWEST, le=FASTEST, description="its wrong bit rate, in bit/s")


class Babble(Timed):
    """A member sends the same frame again and again: a babbling idiot."""

    names: ClassVar = {"node": MEMBER}

    what: Literal["babble"]
    node: str
    identifier: int = Field(ge=0, le=EXTENDED_MASK)
    extended: bool | None = Field(default=None, description="29 bits; left out: as the identifier needs")
    data: Hex = Field(default="", max_length=23, description="hex")
    period_ms: float = Field(default=0, ge=0, le=LONGEST_MS, description="period; 0: one frame directly after another")
    count: int | None = Field(default=None, ge=1, description="number of frames; left out: any number")

    @model_validator(mode="after")
    def _check_identifier(self) -> "Babble":
        if self.extended is False and self.identifier > STANDARD_MASK:
            raise ValueError(f"identifier {self.identifier:#x} has 29 bits: expected at most 0x7ff, or extended: true")
        return self

    def frame(self) -> CanFrame:
        """The frame that the member sends."""
        is_extended = self.identifier > STANDARD_MASK if self.extended is None else self.extended
        return CanFrame(self.identifier, bytes.fromhex(self.data)[:8], is_extended)


CanFault = Annotated[
    Drop | Delay | Duplicate | Replace | Corrupt | ErrorFrame | Short | WrongBitRate | Babble,
    Field(discriminator="what"),
]
PACED: Final = (Corrupt, ErrorFrame, Short, WrongBitRate, Babble)
"""Faults that need bit times."""


class Fault(faults.Fault[CanFault]):
    """One injected fault of a CAN bus."""

    __slots__ = ("is_framed",)

    def __init__(self, number: int, settings: CanFault, now_ns: int, salt: int) -> None:
        super().__init__(number, settings, now_ns, salt)
        self.is_framed = isinstance(settings, Drop | Duplicate | Replace | Corrupt | ErrorFrame)
        """It applies to frames on the wire."""

    def applies(self, now_ns: int, sender: str, frame: CanFrame, key: int) -> bool:
        """True if it applies to this frame now; `key` is the key of chance."""
        settings = self.settings
        assert isinstance(settings, _FrameFault)
        return self.is_on(now_ns) and settings.fits(sender, frame) and self.happens(key)

    def delay_ns(self, now_ns: int, sender: str, frame: CanFrame, key: int) -> int:
        """The delay that it causes for a frame that is asked for now, in nanoseconds."""
        if not isinstance(self.settings, Delay) or not self.applies(now_ns, sender, frame, key):
            return 0
        self.applied += 1
        return self.settings.delay_ns


class Faults(faults.Faults[Fault]):
    """The injected faults of one CAN bus."""

    def __init__(self, random: Random | None = None) -> None:
        super().__init__(Fault, random)
