"""The servers' end of one serial line.  It is passive: its creator provides the clock and transports the bytes."""

from collections import deque
from collections.abc import Callable
from typing import Any

from fieldrig.clock import Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.damaged import write_damaged
from fieldrig_bus.modbus.framing import LineFramer, LineTiming
from fieldrig_bus.modbus.framing_ascii import AsciiFramer
from fieldrig_bus.modbus.message import DamagedAnswer, LineState, ModbusRequest, ModbusResponse

SET_DELIMITER = b"\x08\x00\x03"


class LineSession:
    """Turns received bytes into requests, and responses into bytes, at the pace of the line."""

    def __init__(
        self,
        clock: Clock,
        link: Link[Any],
        write: Callable[[bytes], None],
        framer: LineFramer,
        timing: LineTiming,
        is_paced: bool,
    ) -> None:
        self._clock, self._link, self._write = clock, link, write
        self._framer, self._timing, self._is_paced = framer, timing, is_paced
        self._outbound: deque[tuple[int, bytes | DamagedAnswer]] = deque()
        self._free_ns = 0  # the instant at which the last written frame is over
        self._wake = Alarm(self._clock)
        self._send = Alarm(self._clock)
        link.on_receive(self._on_response, ())

    def on_bytes(self, data: bytes) -> None:
        self._framer.feed(self._clock.now_ns(), data)
        self._take()

    def close(self) -> None:
        self._wake.stop()
        self._send.stop()

    @property
    def ahead(self) -> int:
        return self._framer.ahead(self._clock.now_ns())

    def _take(self) -> None:
        framer = self._framer
        for unit, pdu in framer.take(self._clock.now_ns()):
            line = LineState(framer.messages, framer.errors, self._timing.mode == "ascii")
            self._link.send(ModbusRequest(unit, pdu, 0, line))
        self._wake.stop()
        next_ns = framer.next_ns()
        self._wake.at(next_ns, self._take)

    def _on_response(self, response: ModbusResponse | DamagedAnswer) -> None:
        pdu = response.pdu
        frame = response if isinstance(response, DamagedAnswer) else self._framer.frame(response.unit, pdu)
        if isinstance(self._framer, AsciiFramer) and len(pdu) == 5 and pdu.startswith(SET_DELIMITER):
            self._framer.delimiter = pdu[3]
        if not self._is_paced:
            self._write_out(frame)
            return
        begin_ns = max(self._clock.now_ns(), self._free_ns)
        end_ns = begin_ns + self._timing.frame_ns(len(pdu))
        self._free_ns = end_ns + self._timing.silence_ns
        self._outbound.append((end_ns, frame))
        if len(self._outbound) == 1:
            self._send.at(end_ns, self._on_sent)

    def _on_sent(self) -> None:
        _, frame = self._outbound.popleft()
        self._write_out(frame)
        if self._outbound:
            self._send.at(self._outbound[0][0], self._on_sent)

    def _write_out(self, frame: bytes | DamagedAnswer) -> None:
        if isinstance(frame, DamagedAnswer):
            write_damaged(self._clock, self._write, frame)
        else:
            self._write(frame)
