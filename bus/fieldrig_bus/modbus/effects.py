"""The effects of the faults of a Modbus bus on requests and answers.

An answer whose bytes are wrong leaves the bus as a `DamagedAnswer`: a client outside gets its bytes.  A client in the
rig gets no bytes but messages, and so it gets what a receiver by the book takes from them: an answer that comes in
pieces on TCP comes late, garbage before the colon of an ASCII frame is skipped (V1.02, 2.5.2), and nothing else passes.

Requests and lines: application protocol V1.1b3, chapter 6 has the place of a register in a request.
"""

from collections.abc import Callable, Collection, Iterable
from random import Random
from typing import Any, Final

from fieldrig.bus import Delivery
from fieldrig.clock import MS
from fieldrig.faults.chance import derived
from fieldrig.faults.disturbed import Effects, Struck
from fieldrig.faults.faults import Fault, Timed
from fieldrig.faults.hex_bytes import flipped, replaced
from fieldrig_bus.modbus import faults
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.framing_ascii import ascii_frame
from fieldrig_bus.modbus.framing_mbap import tcp_frame
from fieldrig_bus.modbus.framing_rtu import rtu_frame
from fieldrig_bus.modbus.message import (
    ClientConnected,
    DamagedAnswer,
    ModbusRequest,
    ModbusResponse,
    OnModbus,
)
from fieldrig_bus.modbus.routing import NOT_SIGNIFICANT, OUTSIDE
from fieldrig_bus.serial.garble import garbled_by_rate, noisy, thinned
from fieldrig_bus.serial.message import Format

LINE_PORTS: Final = frozenset({"pty", "port"})
"""Members that are the outside end of a line, and so have no colon in their name."""
MOST_ASKED: Final = 4096
"""Requests without an answer whose registers are remembered."""
_ONE: Final = frozenset({5, 6, 22, 24})
_MANY: Final = frozenset({1, 2, 3, 4, 15, 16, 23})
_ANSWERS: Final = (ModbusResponse, DamagedAnswer)


def registers_in(pdu: bytes) -> range:
    """Return the registers or bits that a request names first, from 0; an empty range for functions without any."""
    start = int.from_bytes(pdu[1:3], "big")
    if pdu[0] in _MANY and len(pdu) >= 5:
        return range(start, start + int.from_bytes(pdu[3:5], "big"))
    return range(start, start + 1) if pdu[0] in _ONE and len(pdu) >= 3 else range(0)


def _code(function: int) -> bytes:
    return bytes((function,))


class ModbusEffects(Effects[OnModbus]):
    models = faults.MODELS

    def __init__(
        self, given: Iterable[Timed] = (), timing: LineTiming | None = None, form: Format | None = None
    ) -> None:
        """`timing` and `form` are those of a serial line; without them the bus is one of TCP."""
        super().__init__(given)
        self._timing, self._form = timing, form or Format()
        self._asked: dict[tuple[str, int], bytes] = {}
        self._units: Callable[[], Collection[int]] = tuple
        """Returns the units that there have been on the bus; none if any may be there."""
        for settings in self.given:
            self.check(settings, ())

    def begin(self, medium: Any, random: Random) -> None:
        super().begin(medium, random)
        self._random = derived(random)
        self._units = lambda: medium.units

    def check(self, settings: Any, members: Iterable[str]) -> None:
        wrong = faults.TCP_ONLY if self._timing is not None else faults.LINE_ONLY
        if isinstance(settings, wrong):
            here, there = ("a serial line", "TCP") if self._timing is not None else ("TCP", "a serial line")
            models = faults.LINE_MODELS if self._timing is not None else faults.TCP_MODELS
            raise ValueError(
                f"{settings.what} is a fault of {there}, and this bus is {here}\nit takes {', '.join(models)}"
            )
        units, unit = self._units(), getattr(settings, "unit", None)
        if units and unit not in (None, *NOT_SIGNIFICANT, *units):
            raise ValueError(
                f"unit: nothing on the bus has unit {unit}\nthere are: {', '.join(map(str, sorted(units)))}"
            )

    def asked(self, member: str, message: OnModbus) -> None:
        if isinstance(message, ModbusRequest):
            self._asked[member, message.exchange] = message.pdu
            if len(self._asked) > MOST_ASKED:
                del self._asked[next(iter(self._asked))]

    def fits(self, settings: Any, delivery: Delivery[OnModbus]) -> bool:
        message = delivery.message
        if isinstance(settings, faults.Stuck):
            return isinstance(message, ModbusRequest | ModbusResponse) and bool(delivery.receivers)
        if isinstance(settings, faults.Refuse):
            return isinstance(message, ClientConnected)
        is_of_request = isinstance(settings, faults.Refusal) or (
            isinstance(settings, faults.Drop) and settings.of == "request"
        )
        if is_of_request:
            return isinstance(message, ModbusRequest) and self._is_there(
                settings, delivery.sender, delivery, message.pdu
            )
        kinds = _ANSWERS if isinstance(settings, faults.Drop | faults.Delay | faults.Duplicate) else ModbusResponse
        if not isinstance(message, kinds) or not delivery.receivers:
            return False
        asked = self._asked.get((delivery.receivers[0], message.exchange), message.pdu[:1])
        return self._is_there(settings, delivery.receivers[0], delivery, asked)

    def strike(self, fault: Fault[Any], delivery: Delivery[OnModbus]) -> Struck[OnModbus]:
        settings, message = fault.settings, delivery.message
        match settings:
            case faults.Refuse():
                return Struck(self._cut(delivery._replace(receivers=(delivery.sender,)), b""), "refused")
            case faults.Stuck():
                return Struck([delivery._replace(receivers=())], "lost, as the line is stuck")
            case faults.Refusal():
                return self._refused(settings.code, delivery)
            case faults.Drop(of="request"):
                return Struck([delivery._replace(receivers=())], "request dropped")
            case faults.Drop():
                return Struck(self._damaged_deliveries(delivery, (), False, 0), "answer dropped")
            case faults.Delay():
                return Struck([delivery._replace(time_ns=delivery.time_ns + settings.delay_ns)], "delayed")
            case faults.Duplicate():
                return Struck([delivery, delivery], "duplicated")
        assert isinstance(message, ModbusResponse)
        if isinstance(settings, faults.Replace):
            return self._replaced(settings, delivery, message)
        return self._damaged(settings, delivery, message)

    def turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[OnModbus]]:
        if isinstance(fault.settings, faults.Refuse) and fault.settings.is_for_each:
            self.refuse(fault, is_on)
        return []

    # ---- parts

    def _is_there(self, settings: faults.ModbusWhere, client: str, delivery: Delivery[Any], asked: bytes) -> bool:
        message = delivery.message
        return (
            bool(delivery.receivers)
            and settings.unit in (None, message.unit)
            and (
                settings.function is None
                or message.pdu[:1] in (_code(settings.function), _code(settings.function | 0x80))
            )
            and settings.client in (None, client)
            and (settings.address is None or settings.address in registers_in(asked))
        )

    def _refused(self, code: int, delivery: Delivery[Any]) -> Struck[OnModbus]:
        """The device does not hear the request, and the answer is an exception."""
        request, server = delivery.message, delivery.receivers[0]
        answer = ModbusResponse(request.unit, bytes((request.pdu[0] | 0x80, code)), request.exchange)
        self.medium.submit(delivery.time_ns, server, answer)
        return Struck([delivery._replace(receivers=())], f"refused with exception {code}")

    def _replaced(self, settings: faults.Replace, delivery: Delivery[Any], message: ModbusResponse) -> Struck[OnModbus]:
        head, rest = message.pdu[:1], message.pdu[1:]
        data = replaced(rest, settings.data) if settings.data is not None else flipped(rest, settings.xor or "")
        changed = ModbusResponse(message.unit, head + data, message.exchange, message.asked)
        return Struck([delivery._replace(message=changed)], f"data replaced, was {rest.hex(' ')}")

    def _damaged(self, settings: Any, delivery: Delivery[Any], message: ModbusResponse) -> Struck[OnModbus]:
        frame = self._frame(message.unit, message.pdu, message.exchange)
        half = max(1, len(frame) // 2)
        match settings:
            case faults.WrongUnit(answers_as=unit):
                unit = (message.unit + 1) % 256 if unit is None else unit
                return self._as(delivery, self._frame(unit, message.pdu, message.exchange), f"answered as unit {unit}")
            case faults.WrongTransaction(offset=offset):
                return self._as(delivery, self._frame(message.unit, message.pdu, message.exchange + offset), "wrong id")
            case faults.WrongCheck():
                return self._as(delivery, self._wrong_check(frame), "wrong checksum")
            case faults.Truncate(keep=keep):
                return self._as(delivery, frame[: half if keep is None else keep], "truncated")
            case faults.Garbage(data=data):
                return self._as(delivery, bytes.fromhex(data) + frame, "garbage before it", passes=self._is_ascii)
            case faults.Cut(keep=keep):
                return Struck(self._cut(delivery, frame[:keep]), "connection cut")
            case faults.Split(keep=keep, gap_ms=gap_ms):
                return self._split(delivery, frame, half if keep is None else keep, round(gap_ms * MS))
            case faults.Noise(bit_error_rate=rate):
                return self._changed(delivery, frame, noisy(frame, rate, self._random), "noise")
            case faults.LoseBytes(share=share):
                return self._changed(delivery, frame, thinned(frame, share, self._random), "bytes lost")
            case faults.WrongBaud(baud=baud):
                heard = garbled_by_rate(frame, baud, self._form)
                return self._changed(delivery, frame, heard, f"sent at {baud} bit/s")
        raise AssertionError(f"no effect of {settings}")

    @property
    def _is_ascii(self) -> bool:
        return self._timing is not None and self._timing.mode == "ascii"

    def _frame(self, unit: int, pdu: bytes, exchange: int) -> bytes:
        if self._timing is None:
            return tcp_frame(exchange & 0xFFFF, unit, pdu)
        return ascii_frame(unit, pdu) if self._is_ascii else rtu_frame(unit, pdu)

    def _wrong_check(self, frame: bytes) -> bytes:
        """The frame with every bit of its CRC flipped, or with an LRC that is one too high."""
        if not self._is_ascii:
            return frame[:-2] + bytes(byte ^ 0xFF for byte in frame[-2:])
        return frame[:-4] + f"{int(frame[-4:-2], 16) + 1 & 0xFF:02X}".encode() + frame[-2:]

    def _changed(self, delivery: Delivery[Any], frame: bytes, heard: bytes, what: str) -> Struck[OnModbus]:
        """Return the effect of chance, which may leave the frame as it was."""
        return Struck([delivery], f"{what}, without effect") if heard == frame else self._as(delivery, heard, what)

    def _split(self, delivery: Delivery[Any], frame: bytes, keep: int, gap_ns: int) -> Struck[OnModbus]:
        """On RTU a silence of more than 1.5 characters ends what can be a frame (V1.02, 2.5.1.1)."""
        timing = self._timing
        is_whole = timing is None or timing.mode == "ascii" or gap_ns <= timing.gap_ns
        pieces = ((0, frame[:keep]), (gap_ns, frame[keep:])) if keep < len(frame) else ((0, frame),)
        what = f"split after {len(pieces[0][1])} bytes"
        return Struck(self._damaged_deliveries(delivery, pieces, is_whole, gap_ns), what)

    def _as(self, delivery: Delivery[Any], frame: bytes, what: str, passes: bool = False) -> Struck[OnModbus]:
        return Struck(self._damaged_deliveries(delivery, ((0, frame),), passes, 0), what)

    def _cut(self, delivery: Delivery[Any], frame: bytes) -> list[Delivery[OnModbus]]:
        return self._damaged_deliveries(delivery, ((0, frame),) if frame else (), False, 0, is_cut=True)

    def _damaged_deliveries(
        self,
        delivery: Delivery[Any],
        pieces: tuple[tuple[int, bytes], ...],
        passes: bool,
        late_ns: int,
        is_cut: bool = False,
    ) -> list[Delivery[OnModbus]]:
        """The bytes for a client outside, and for one in the rig the message if it passes, `late_ns` later."""
        message = delivery.message
        unit, pdu, exchange, asked = 0, b"", 0, None
        if not isinstance(message, ClientConnected):
            unit, pdu, exchange, asked = message.unit, message.pdu, message.exchange, message.asked
        outside = tuple(name for name in delivery.receivers if OUTSIDE in name or name in LINE_PORTS)
        damaged = DamagedAnswer(unit, pdu, exchange, pieces, is_cut, asked=asked)
        deliveries: list[Delivery[OnModbus]] = [Delivery(delivery.time_ns, delivery.sender, damaged, outside)]
        inside = tuple(name for name in delivery.receivers if name not in outside)
        if passes and inside:
            deliveries.append(Delivery(delivery.time_ns + late_ns, delivery.sender, message, inside))
        return deliveries
