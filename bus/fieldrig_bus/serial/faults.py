"""The faults of a serial line: their settings, and what they do to the bytes on their way.

Bytes travel in chunks (`model`); a fault that says how often it applies counts chunks.
"""

from collections.abc import Collection, Hashable, Iterable, Mapping
from random import Random
from typing import Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.bus import CutOff, Delivery
from fieldrig.clock import MS
from fieldrig.faults import faults
from fieldrig.faults.chance import derived
from fieldrig.faults.disturbed import Effects, Struck
from fieldrig.faults.faults import LONGEST_MS, Fault, Repeated, Timed
from fieldrig.faults.hex_bytes import Hex, flipped, replaced
from fieldrig.text.nearest import closest
from fieldrig_bus.serial.garble import garbled_by_rate, noisy, thinned
from fieldrig_bus.serial.message import Break, ControlLines, SerialMessage
from fieldrig_bus.serial.model import SerialModel

LONGEST_BREAK_MS: Final = 1_000_000.0
_SPACE: Final = b"\0"
"""The character that a receiver reads once from a line at space."""


class OfEnd(Timed):
    """The end that a fault concerns."""

    end: str | None = Field(default=None, description="the member that sends; left out: both ends")


class OfChunks(OfEnd, Repeated):
    """The chunks of bytes that a fault concerns."""


class Drop(OfChunks):
    """Bytes do not arrive."""

    what: Literal["drop"]


class Delay(OfChunks):
    """Bytes arrive later."""

    what: Literal["delay"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")


class Duplicate(OfChunks):
    """Bytes arrive twice."""

    what: Literal["duplicate"]


class Replace(OfChunks):
    """Other bytes arrive than were sent."""

    what: Literal["replace"]
    data: Hex | None = Field(default=None, max_length=1024, description="hex; instead of the first bytes of a chunk")
    xor: Hex | None = Field(default=None, max_length=1024, description="hex; bits to flip in the first bytes")

    @model_validator(mode="after")
    def _check_there_is_one(self) -> Self:
        if (self.data is None) == (self.xor is None):
            raise ValueError("expected either data or xor")
        return self


class Garbage(OfChunks):
    """Other bytes arrive before those that were sent."""

    what: Literal["garbage"]
    data: Hex = Field(default="00", min_length=1, max_length=1024, description="hex")


class Noise(OfEnd):
    """Bits are inverted at random."""

    what: Literal["noise"]
    bit_error_rate: float = Field(default=0.01, gt=0, le=0.5, description="share of the bits")


class LoseBytes(OfEnd):
    """Single bytes are missing at random."""

    what: Literal["lose_bytes"]
    share: float = Field(default=0.1, gt=0, le=1, description="share of the bytes")


class WrongBaud(OfEnd):
    """An end sends at another rate than it should, so that the other one reads other bytes."""

    what: Literal["wrong_baud"]
    baud: int = Field(ge=50, le=10_000_000, description="its rate, in bit/s")


class LineBreak(OfEnd):
    """The line is held at space for a while: a break, and nothing else arrives."""

    what: Literal["break"]
    length_ms: float = Field(default=100.0, gt=0, le=LONGEST_BREAK_MS, description="length of the break")

    @model_validator(mode="after")
    def _check_duration(self) -> Self:
        if self.duration_ms is not None:
            raise ValueError("duration_ms: expected length_ms instead, as a break happens once")
        return self


class Stuck(OfEnd):
    """The line is held at one level, so nothing arrives; `low` is a break without end."""

    what: Literal["stuck"]
    level: Literal["high", "low"] = Field(default="high", description="high is the level of an idle line")


class Unplugged(Timed):
    """The cable is pulled out: nothing arrives, and both ends see all control lines off."""

    what: Literal["unplugged"]


class Cut(OfChunks):
    """The connection of the client is closed when the next bytes pass, which are lost (TCP)."""

    what: Literal["cut"]


class Refuse(Timed):
    """New connections are refused (TCP)."""

    what: Literal["refuse"]


_OnAnyLine = (
    Drop | Delay | Duplicate | Replace | Garbage | Noise | LoseBytes | WrongBaud | LineBreak | Stuck | Unplugged
)
SerialFault = Annotated[_OnAnyLine, Field(discriminator="what")]
SerialTcpFault = Annotated[_OnAnyLine | Cut | Refuse, Field(discriminator="what")]
MODELS: Final = faults.models_of(SerialFault)
TCP_MODELS: Final = faults.models_of(SerialTcpFault)
"""The faults of a line with an end on a TCP port."""
_OFF: Final = ControlLines(dtr=False, rts=False, ri=False, dcd=False)


class SerialEffects(Effects[SerialMessage]):
    models: ClassVar[Mapping[str, type[Timed]]] = MODELS
    medium: SerialModel
    turns_are_struck = False

    def __init__(self, given: Iterable[Timed] = ()) -> None:
        super().__init__(given)
        self._unplugged: set[int] = set()
        """The faults that have pulled out the cable, by number."""
        self._spaces: dict[int, tuple[Collection[str], int]] = {}
        """The faults that hold the line at space, by number: the ends, and until when."""

    def begin(self, medium: Any, random: Random) -> None:
        super().begin(medium, random)
        self._random = derived(random)

    def check(self, settings: Any, members: Iterable[str]) -> None:
        end = getattr(settings, "end", None)
        if end is not None and end not in members:
            raise ValueError(f"the line has no end {end!r}\n{closest(end, list(members))}")

    def stream_of(self, delivery: Delivery[SerialMessage]) -> Hashable:
        return delivery.sender if type(delivery.message) in (bytes, Break) else None

    def fits(self, settings: Any, delivery: Delivery[SerialMessage]) -> bool:
        message = delivery.message
        if isinstance(settings, Unplugged):
            return message != _OFF
        if isinstance(settings, Refuse) or not delivery.receivers:
            return False
        if type(message) is not bytes and not (isinstance(message, Break) and isinstance(settings, Stuck | LineBreak)):
            return False
        return settings.end in (None, delivery.sender)

    def strike(self, fault: Fault[Any], delivery: Delivery[SerialMessage]) -> Struck[SerialMessage]:
        settings, data = fault.settings, delivery.message
        if isinstance(settings, Unplugged):
            is_lines = isinstance(data, ControlLines)
            return Struck([delivery._replace(message=_OFF)] if is_lines else [], "lost, as the cable is pulled out")
        if isinstance(data, Break):
            return Struck([], "break lost")
        assert type(data) is bytes
        match settings:
            case Drop() | Stuck() | LineBreak():
                return Struck([], f"{len(data)} bytes lost")
            case Cut():
                self.tell(CutOff())
                return Struck([], "connection cut")
            case Delay(delay_ms=delay_ms):
                return Struck([delivery._replace(time_ns=delivery.time_ns + round(delay_ms * MS))], "delayed")
            case Duplicate():
                return Struck([delivery, delivery], "duplicated")
            case Replace(data=given, xor=xor):
                changed = replaced(data, given) if given is not None else flipped(data, xor or "")
                return self._as(delivery, changed, "replaced")
            case Garbage(data=given):
                return self._as(delivery, bytes.fromhex(given) + data, "garbage before it")
            case Noise(bit_error_rate=rate):
                return self._as(delivery, noisy(data, rate, self._random), "noise")
            case LoseBytes(share=share):
                return self._as(delivery, thinned(data, share, self._random), "bytes lost")
            case WrongBaud(baud=baud):
                heard = garbled_by_rate(data, baud, self.medium.format_of(delivery.sender))
                return self._as(delivery, heard, f"sent at {baud} bit/s")
        raise AssertionError(f"no effect of {settings}")

    def turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[SerialMessage]]:
        match fault.settings:
            case LineBreak(length_ms=length_ms, end=end) if is_on:
                fault.until_ns = now_ns + round(length_ms * MS)
                return self._held(fault, now_ns, end, max(1, round(length_ms)))
            case Stuck(level="low", end=end, duration_ms=duration_ms) if is_on:
                return self._held(fault, now_ns, end, round(duration_ms or LONGEST_BREAK_MS))
            case LineBreak() | Stuck():
                self._spaces.pop(fault.number, None)
            case Unplugged():
                return self._plugged(fault, now_ns, is_on)
            case Refuse():
                self.refuse(fault, is_on)
        return []

    def _held(self, fault: Fault[Any], now_ns: int, end: str | None, duration_ms: int) -> list[Delivery[SerialMessage]]:
        """The break for those who hear breaks, and for the others the character of zeros that a UART reads from it.

        Of an end whose line is at space already, or unplugged, nothing new is heard.
        """
        fault.applied += 1
        held: list[Delivery[SerialMessage]] = []
        at_space = {name for ends, until_ns in self._spaces.values() if until_ns > now_ns for name in ends}
        ends = [name for name in self.medium.members if end in (None, name)]
        self._spaces[fault.number] = ends, now_ns + duration_ms * MS
        for sender in ends:
            if sender in at_space or self._unplugged:
                continue
            hearing = self.medium.receivers_of(sender, "break")
            deaf = tuple(name for name in self.medium.receivers_of(sender, "data") if name not in hearing)
            held += [Delivery(now_ns, sender, Break(max(1, duration_ms)), hearing)] if hearing else []
            held += [Delivery(now_ns, sender, _SPACE, deaf)] if deaf else []
        return held

    def _plugged(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[SerialMessage]]:
        """All control lines go off, or come back as they are now, with the formats that were set meanwhile."""
        fault.applied += is_on
        was_out = bool(self._unplugged)
        if is_on:
            self._unplugged.add(fault.number)
        else:
            self._unplugged.discard(fault.number)
        if was_out is bool(self._unplugged):
            return []  # another fault has pulled it out as well
        told: list[Delivery[SerialMessage]] = []
        for name in self.medium.members:
            lines = _OFF if is_on else self.medium.lines_of(name)
            told.append(Delivery(now_ns, name, lines, self.medium.receivers_of(name, "lines")))
            form = None if is_on else self.medium.given_format(name)
            if form is not None:
                told.append(Delivery(now_ns, name, form, self.medium.receivers_of(name, "format")))
        return [delivery for delivery in told if delivery.receivers]

    def _as(self, delivery: Delivery[Any], data: bytes, what: str) -> Struck[SerialMessage]:
        """Bytes that chance leaves as they are arrive; none at all are no delivery."""
        return Struck([delivery._replace(message=data)] if data else [], what)


class SerialTcpEffects(SerialEffects):
    """The same, and those on the connections of the end on a TCP port."""

    models = TCP_MODELS
