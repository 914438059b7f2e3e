"""The node's peers in the CANopen benchmark: a client for blocks, a SYNC producer, an EDS with 8 TPDOs."""

from binascii import crc_hqx
from collections.abc import Callable

from fieldrig.clock import MS, Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame

NODE_ID = 5
REQUEST_ID, RESPONSE_ID, SYNC_ID = 0x600 + NODE_ID, 0x580 + NODE_ID, 0x080
DOMAIN = bytes.fromhex("03 20 00")  # multiplexer of 2003h
DATA = bytes(number * 7 & 0xFF for number in range(100_000))
SYNC_PERIOD_NS = 4 * MS
TPDOS = 8


class BlockClient:
    """Downloads DATA in blocks, uploads it again; `on_done` receives both durations, in nanoseconds."""

    def __init__(self, link: Link[CanFrame], clock: Clock, on_done: Callable[[int, int], None]) -> None:
        self._link, self._clock, self._on_done = link, clock, on_done
        self._start_ns = self._downloaded_ns = 0
        self._position = self._sent = 0
        self._received = bytearray()
        self._on_frame: Callable[[bytes], None] = self._on_download
        link.on_receive(lambda frame: self._on_frame(frame.data), [[RESPONSE_ID, 0x7FF]])

    def begin(self) -> None:
        self._start_ns = self._clock.now_ns()
        self._send(b"\xc6" + DOMAIN + len(DATA).to_bytes(4, "little"))

    def _send(self, data: bytes) -> None:
        self._link.send(CanFrame(REQUEST_ID, data.ljust(8, b"\x00")))

    def _on_download(self, answer: bytes) -> None:
        if answer[0] == 0xA1:
            self._begin_upload()
            return
        assert answer[0] & 0xE0 == 0xA0, answer.hex(" ")
        if answer[0] & 0x03 == 2:
            self._position += answer[1] * 7
        if self._position >= len(DATA):
            self._send(bytes((0xC1 | -len(DATA) % 7 << 2,)) + crc_hqx(DATA, 0).to_bytes(2, "little"))
            return
        for number in range(1, 128):
            first = self._position + 7 * (number - 1)
            is_last = first + 7 >= len(DATA)
            self._send(bytes((number | is_last << 7,)) + DATA[first : first + 7])
            if is_last:
                break

    def _begin_upload(self) -> None:
        self._downloaded_ns = self._clock.now_ns()
        self._on_frame = self._on_upload_initiated
        self._send(b"\xa4" + DOMAIN + b"\x7f")

    def _on_upload_initiated(self, answer: bytes) -> None:
        assert answer[0] == 0xC6, answer.hex(" ")
        self._on_frame = self._on_segment
        self._send(b"\xa3")

    def _on_segment(self, answer: bytes) -> None:
        self._received += answer[1:]
        self._sent = answer[0] & 0x7F
        if answer[0] & 0x80:
            self._on_frame = self._on_end
        if answer[0] & 0x80 or self._sent == 127:
            self._send(bytes((0xA2, self._sent, 127)))

    def _on_end(self, answer: bytes) -> None:
        del self._received[len(self._received) - (answer[0] >> 2 & 7) :]
        assert self._received == DATA
        assert crc_hqx(DATA, 0) == int.from_bytes(answer[1:3], "little")
        self._send(b"\xa1")
        now_ns = self._clock.now_ns()
        self._on_done(self._downloaded_ns - self._start_ns, now_ns - self._downloaded_ns)


class SyncProducer:
    def __init__(self, link: Link[CanFrame], clock: Clock) -> None:
        self._link, self._clock = link, clock
        self.count = 0

    def begin(self) -> None:
        self._link.send(CanFrame(0x000, bytes((0x01, NODE_ID))))
        self._clock.call_at(self._clock.now_ns() + SYNC_PERIOD_NS, self._on_due)

    def _on_due(self) -> None:
        self.count += 1
        self._link.send(CanFrame(SYNC_ID))
        self._clock.call_at(self._clock.now_ns() + SYNC_PERIOD_NS, self._on_due)


def eds_with_tpdos() -> str:
    """8 TPDOs of 8 bytes that answer each SYNC."""
    sections = [
        ("1000", "DataType=7\nAccessType=ro"),
        ("1005", "DataType=7\nAccessType=rw\nDefaultValue=0x80"),
    ]
    for number in range(TPDOS):
        communication, mapping, value = f"18{number:02X}", f"1A{number:02X}", f"200{number:X}"
        sections += [
            (communication, "ObjectType=9"),
            (f"{communication}sub1", f"DataType=7\nAccessType=rw\nDefaultValue={0x4000_0180 + 0x10 * number}"),
            (f"{communication}sub2", "DataType=5\nAccessType=rw\nDefaultValue=1"),
            (mapping, "ObjectType=9"),
            (f"{mapping}sub0", "DataType=5\nAccessType=rw\nDefaultValue=1"),
            (f"{mapping}sub1", f"DataType=7\nAccessType=rw\nDefaultValue=0x{value}0040"),
            (value, "DataType=0x1B\nAccessType=ro\nPDOMapping=1"),
        ]
    return "".join(f"[{name}]\nParameterName={name}\n{body}\n" for name, body in sections)
