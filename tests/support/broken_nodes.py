"""CANopen nodes that break one rule each: our own node behind a link that changes frames.

The node itself is whole; a fault only sees the frames that come and go, so it is a fault of any node.
"""

from collections.abc import Callable, Iterator
from typing import ClassVar

from fieldrig.clock import MS, Clock, VirtualClock
from fieldrig.device import Device
from fieldrig.link import Link
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings

NODE_ID = 5
NMT, SYNC, EMCY, TPDO, REQUEST, RESPONSE, CONTROL = 0x000, 0x080, 0x085, 0x185, 0x605, 0x585, 0x705
STOPPED, START = 2, 1
TAKEN = b"\x60"
Frames = Iterator[CanFrame]


class Fault:
    """A fault of a node: frames from and to the node pass through here."""

    cases: ClassVar[tuple[str, ...]] = ()
    """The cases that must fail."""

    def __init__(self) -> None:
        self.request = bytes(8)
        """The last SDO request."""
        self.command = 0
        """The last NMT command."""
        self.say: Callable[[CanFrame], None] = _nowhere
        """Sends a frame as the node."""
        self.clock: Clock = VirtualClock()

    def from_node(self, frame: CanFrame) -> Frames:
        yield frame

    def to_node(self, frame: CanFrame) -> Frames:
        yield frame

    def hear(self, frame: CanFrame) -> Frames:
        if frame.identifier == REQUEST:
            self.request = frame.data
        elif frame.identifier == NMT and frame.data[1] in (0, NODE_ID):
            self.command = frame.data[0]
        return self.to_node(frame)

    def answer(self, data: bytes) -> None:
        self.say(CanFrame(RESPONSE, data.ljust(8, b"\x00")))

    def say_after(self, ms: int, frame: CanFrame) -> None:
        self.clock.call_at(self.clock.now_ns() + ms * MS, lambda: self.say(frame))

    @property
    def multiplexer(self) -> bytes:
        return self.request[1:4]


def _nowhere(frame: CanFrame) -> None:
    """Before there is a link."""


class BrokenNode(Device):
    """`fault` is the name of one of `FAULTS`."""

    class Settings(CanopenSettings):
        fault: str

    def __init__(self, clock: Clock, name: str, can: Link[CanFrame], settings: Settings, store: Store) -> None:
        self._can, self._fault = can, FAULTS[settings.fault]()
        self._fault.say, self._fault.clock = can.send, clock
        self._handler: Callable[[CanFrame], None] | None = None
        plain = CanopenSettings.model_validate({"node_id": settings.node_id, "eds": settings.eds})
        self._node = CanopenNode(clock, name, self, plain, store)

    def start(self) -> None:
        self._node.start()

    def send(self, message: CanFrame) -> None:
        for frame in self._fault.from_node(message):
            self._can.send(frame)

    def on_receive(self, handler: Callable[[CanFrame], None], interest: object = None) -> None:
        self._handler = handler
        self._can.on_receive(self._on_frame)

    def _on_frame(self, frame: CanFrame) -> None:
        for item in self._fault.hear(frame):
            if self._handler is not None:
                self._handler(item)


def is_abort(frame: CanFrame, *codes: int) -> bool:
    data = frame.data
    is_one = frame.identifier == RESPONSE and data[0] == 0x80
    return is_one and (not codes or int.from_bytes(data[4:], "little") in codes)


def sdo(data: bytes) -> CanFrame:
    return CanFrame(RESPONSE, data.ljust(8, b"\x00"))


class _Takes(Fault):
    """Says that it took what it refused with one of the codes."""

    codes: ClassVar[tuple[int, ...]] = ()

    def from_node(self, frame: CanFrame) -> Frames:
        yield sdo(TAKEN + self.multiplexer) if is_abort(frame, *self.codes) else frame


class _Swallows(Fault):
    """Answers a write to an object, and does nothing."""

    index: ClassVar[int] = 0
    value: ClassVar[bytes] = b""

    def to_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        is_it = frame.identifier == REQUEST and data[0] >> 5 == 1 and data[1:3] == self.index.to_bytes(2, "little")
        if is_it and data[4:].startswith(self.value):
            self.answer(TAKEN + data[1:4])
        else:
            yield frame


class _Reads(Fault):
    """Gives another value of an object than the one it has."""

    key: ClassVar[bytes] = b""
    value: ClassVar[bytes] = b""

    def from_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == RESPONSE and self.request[0] == 0x40 and self.multiplexer == self.key:
            first = 0x43 | (4 - len(self.value)) << 2
            yield sdo(bytes((first,)) + self.key + self.value)
        else:
            yield frame


class _Drops(Fault):
    """Loses every so-and-so-many frame with an identifier."""

    identifier: ClassVar[int] = 0
    every: ClassVar[int] = 2
    is_to_node: ClassVar[bool] = False

    def __init__(self) -> None:
        super().__init__()
        self._count = 0

    def from_node(self, frame: CanFrame) -> Frames:
        return iter([frame]) if self.is_to_node else self._thin(frame)

    def to_node(self, frame: CanFrame) -> Frames:
        return self._thin(frame) if self.is_to_node else iter([frame])

    def _thin(self, frame: CanFrame) -> Frames:
        if frame.identifier == self.identifier and not frame.is_remote:
            self._count += 1
            if self._count % self.every == 0:
                return
        yield frame


# SDO


class WrongAbortCode(Fault):
    """0606 0000h, a hardware error, whatever is refused."""

    cases = ("2.3", "2.5", "2.6", "2.7", "2.17", "2.28", "3.23", "4.3")

    def from_node(self, frame: CanFrame) -> Frames:
        yield sdo(frame.data[:4] + b"\x00\x00\x06\x06") if is_abort(frame) else frame


class TakesReadOnly(_Takes):
    cases = ("2.3", "4.3")
    codes = (0x0601_0002,)


class TakesShortData(_Takes):
    cases = ("2.9",)
    codes = (0x0607_0013,)


class TakesLongData(_Takes):
    cases = ("2.8",)
    codes = (0x0607_0012,)


class TakesValuesBeyondLimits(_Takes):
    cases = ("2.10", "2.11", "4.6")
    codes = (0x0609_0031, 0x0609_0032)


class GivesWriteOnly(Fault):
    cases = ("2.4", "4.4")

    def from_node(self, frame: CanFrame) -> Frames:
        yield sdo(b"\x4f" + self.multiplexer) if is_abort(frame, 0x0601_0001) else frame


class SilentOnUnknownCommand(Fault):
    cases = ("2.7",)

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier != REQUEST or frame.data[0] != 0xE0:
            yield frame


class ReadsNotExpedited(Fault):
    cases = ("2.1",)

    def from_node(self, frame: CanFrame) -> Frames:
        is_one = frame.identifier == RESPONSE and frame.data[:1] == b"\x43"
        yield sdo(b"\x42" + frame.data[1:]) if is_one else frame


class _Diverts(Fault):
    """Writes to an object end in another one of the same size (1015h), by whichever transfer."""

    key: ClassVar[bytes] = b""

    def to_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        is_write = frame.identifier == REQUEST and (data[0] & 0xF0 == 0x20 or data[0] & 0xF9 == 0xC0)
        is_it = is_write and data[1:4] == self.key
        yield CanFrame(REQUEST, data[:1] + b"\x15\x10\x00" + data[4:]) if is_it else frame

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == RESPONSE and frame.data[1:4] == b"\x15\x10\x00"
        yield sdo(frame.data[:1] + self.multiplexer + frame.data[4:]) if is_it else frame


class HeartbeatTimeIsKept(_Diverts):
    cases = ("2.15", "2.21", "2.25", "7.101")
    key = b"\x17\x10\x00"


class TakesWrongToggle(Fault):
    cases = ("2.17",)

    def to_node(self, frame: CanFrame) -> Frames:
        is_first = frame.identifier == REQUEST and frame.data[0] == 0x70
        yield CanFrame(REQUEST, b"\x60" + frame.data[1:]) if is_first else frame


class AnnouncesWrongSize(Fault):
    cases = ("2.16", "2.18")

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == RESPONSE and frame.data[0] == 0x41
        yield sdo(frame.data[:4] + bytes((frame.data[4] + 1,)) + frame.data[5:]) if is_it else frame


class WrongCrc(Fault):
    cases = ("2.23",)

    def from_node(self, frame: CanFrame) -> Frames:
        is_end = frame.identifier == RESPONSE and frame.data[0] & 0xE3 == 0xC1 and frame.data[3:] == bytes(5)
        yield sdo(frame.data[:1] + bytes((frame.data[1] ^ 1,)) + frame.data[2:]) if is_end else frame


class LosesSegmentsOfBlocks(Fault):
    cases = ("2.19", "2.22", "2.23")

    def from_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        is_segment = frame.identifier == RESPONSE and self.request[0] == 0xA3
        yield sdo(bytes((data[0] & 0x80 | 2,)) + data[1:]) if is_segment else frame


class TakesLargeBlocks(Fault):
    cases = ("2.26",)

    def to_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == REQUEST and frame.data[0] & 0xFB == 0xA0 and frame.data[4] > 127
        yield CanFrame(REQUEST, frame.data[:4] + b"\x7f" + frame.data[5:]) if is_it else frame


class TakesWrongAcknowledgement(Fault):
    cases = ("2.27",)

    def to_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == REQUEST and frame.data[:2] == b"\xa2\x80"
        yield CanFrame(REQUEST, b"\xa2\x01" + frame.data[2:]) if is_it else frame


class GivesSegmentsUnasked(Fault):
    cases = ("2.13",)

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = self.request[0] == 0x60 and is_abort(frame, 0x0504_0001)
        yield sdo(b"\x0f") if is_it else frame


class ChannelElsewhere(_Reads):
    cases = ("2.12",)
    key, value = b"\x00\x12\x01", b"\x06\x06\x00\x00"


class FurtherChannelElsewhere(_Reads):
    cases = ("2.28",)
    key, value = b"\x01\x12\x03", b"\x11"


class KeepsChannels(Fault):
    """A further SDO server keeps its settings over a reset."""

    cases = ("2.29",)

    def __init__(self) -> None:
        super().__init__()
        self._kept: dict[bytes, bytes] = {}

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == REQUEST and frame.data[0] & 0xF3 == 0x23 and frame.data[1:3] == b"\x01\x12":
            self._kept[self.multiplexer] = frame.data[4:]
        yield frame

    def from_node(self, frame: CanFrame) -> Frames:
        is_read = frame.identifier == RESPONSE and self.request[0] == 0x40 and self.multiplexer in self._kept
        yield sdo(frame.data[:4] + self._kept[self.multiplexer]) if is_read else frame


# PDO


class CountsSyncsWrong(Fault):
    """A TPDO of type n goes out at each n+1st SYNC."""

    cases = ("3.6",)

    def to_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        is_type = frame.identifier == REQUEST and data[:1] == b"\x2f" and data[2:4] == b"\x18\x02"
        is_cyclic = is_type and 1 <= data[4] <= 240
        yield CanFrame(REQUEST, data[:4] + bytes((data[4] + 1,)) + data[5:]) if is_cyclic else frame


class EventTimerTooSlow(_Drops):
    cases = ("3.5",)
    identifier = TPDO


class SendsAtEachSync(Fault):
    """Whatever the transmission type and state."""

    cases = ("3.4", "3.7", "3.8", "3.12", "3.13", "3.14", "3.18", "3.19", "3.20", "9.2", "9.4")

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == SYNC:
            self.say(CanFrame(TPDO, bytes(4)))
        yield frame


class SendsInAnyState(Fault):
    """Events, and answers to remote requests."""

    cases = ("3.9", "3.10", "3.11", "3.15", "3.16", "3.17")

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == NMT:
            self.say_after(120, CanFrame(TPDO, bytes(4)))
        elif frame.is_remote and frame.identifier == TPDO:
            self.say(CanFrame(TPDO, bytes(4)))
        yield frame


class SilentOnRemoteRequests(Fault):
    cases = ("3.3",)

    def to_node(self, frame: CanFrame) -> Frames:
        if not (frame.is_remote and frame.identifier == TPDO):
            yield frame


class MapsAnything(_Takes):
    cases = ("3.28", "3.29", "3.31", "3.32")
    codes = (0x0604_0041,)


class MapsTooMuch(_Takes):
    cases = ("3.25", "3.26")
    codes = (0x0604_0042,)


class MapsAtAnyTime(_Takes):
    cases = ("3.23", "3.24")
    codes = (0x0800_0022, 0x0601_0000)


class MapsNothing(Fault):
    cases = ("3.22", "3.27", "3.30", "3.33")

    def to_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        is_entry = frame.identifier == REQUEST and data[:1] == b"\x23" and data[2] in (0x16, 0x1A) and data[3] > 0
        if is_entry:
            self.answer(b"\x80" + data[1:4] + b"\x41\x00\x04\x06")
        else:
            yield frame


class ShortTpdo(Fault):
    cases = ("3.3", "3.5", "3.6", "3.22")

    def from_node(self, frame: CanFrame) -> Frames:
        yield CanFrame(TPDO, frame.data[:-1]) if frame.identifier == TPDO else frame


class ReservedType(_Reads):
    cases = ("3.2",)
    key, value = b"\x00\x18\x02", b"\xf5"


class RpdoElsewhere(_Reads):
    cases = ("3.1",)
    key, value = b"\x00\x14\x01", b"\x06\x02\x00\x00"


class MapsWhatIsNotThere(_Reads):
    cases = ("3.21",)
    key, value = b"\x00\x1a\x01", b"\x08\x01\x00\x5f"


# Object dictionary


class WrongDefault(_Reads):
    cases = ("4.2", "4.8")
    key, value = b"\x15\x10\x00", b"\x07\x00"


class WrongSize(_Reads):
    cases = ("4.1", "4.7", "5.2")
    key, value = b"\x01\x10\x00", b"\x00\x00"


class WrongStructure(Fault):
    cases = ("4.5",)

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = self.request[0] == 0x40 and self.multiplexer[2] == 0xFF and frame.identifier == RESPONSE
        yield sdo(b"\x43" + self.multiplexer + b"\x08\x55\x00\x00") if is_it else frame


class RefusesItsOwnValue(Fault):
    cases = ("2.2", "4.9")

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == REQUEST and frame.data[:1] == b"\x2b" and frame.data[1:3] == b"\x15\x10":
            self.answer(b"\x80" + frame.data[1:4] + b"\x00\x00\x00\x08")
        else:
            yield frame


# Emergency


class NoEmcy(Fault):
    cases = ("5.4", "5.5", "5.6", "7.6", "7.106")

    def from_node(self, frame: CanFrame) -> Frames:
        if frame.identifier != EMCY:
            yield frame


class WrongErrorCode(Fault):
    cases = ("5.4", "5.6", "7.6", "7.106")

    def from_node(self, frame: CanFrame) -> Frames:
        yield CanFrame(EMCY, b"\x00\x10" + frame.data[2:]) if frame.identifier == EMCY else frame


class NoHistory(_Reads):
    cases = ("5.6",)
    key, value = b"\x03\x10\x00", b"\x00"


class EmptyHistoryReads(Fault):
    cases = ("5.3",)

    def from_node(self, frame: CanFrame) -> Frames:
        yield sdo(b"\x43" + self.multiplexer) if is_abort(frame, 0x0800_0024) else frame


class RegisterStaysZero(_Reads):
    cases = ("5.5",)
    key, value = b"\x01\x10\x00", b"\x00"


class RegisterWithoutGenericBit(_Reads):
    cases = ("5.2",)
    key, value = b"\x01\x10\x00", b"\x10"


class EmcyElsewhere(_Reads):
    cases = ("5.1",)
    key, value = b"\x14\x10\x00", b"\x86\x00\x00\x00"


# Synchronization


class CounterFromZero(Fault):
    cases = ("6.7",)

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == SYNC and frame.data
        yield CanFrame(SYNC, bytes((frame.data[0] - 1,))) if is_it else frame


class CounterAlways(Fault):
    cases = ("6.6",)

    def from_node(self, frame: CanFrame) -> Frames:
        yield CanFrame(SYNC, frame.data or b"\x00") if frame.identifier == SYNC else frame


class SyncTooSlow(_Drops):
    cases = ("6.2", "6.6", "6.7")
    identifier = SYNC


class SyncNeverEnds(Fault):
    """A period of 0, and a COB-ID of a consumer, are accepted, and SYNC goes on."""

    cases = ("6.4",)

    def to_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        is_it = frame.identifier == REQUEST and data[:1] == b"\x23" and data[1:3] in (b"\x05\x10", b"\x06\x10")
        if is_it and (data[1:8] == b"\x06\x10" + bytes(5) or data[3:] == b"\x00\x80\x00\x00\x00"):
            self.answer(TAKEN + data[1:4])
        else:
            yield frame


class TakesAnyOverflow(_Takes):
    cases = ("6.5",)
    codes = (0x0609_0030, 0x0609_0031, 0x0609_0032)


class OverflowAtAnyTime(_Takes):
    cases = ("6.9",)
    codes = (0x0800_0022,)


class SyncElsewhere(_Reads):
    cases = ("6.1",)
    key, value = b"\x05\x10\x00", b"\x81\x00\x00\x00"


class PdoMissesSyncs(_Drops):
    cases = ("3.6", "6.3")
    identifier, every = TPDO, 5


# Guarding


class ToggleStuck(Fault):
    cases = ("7.3", "7.203")

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == CONTROL
        yield CanFrame(CONTROL, bytes((frame.data[0] & 0x7F,))) if is_it else frame


class ToggleStartsAtOne(Fault):
    cases = ("7.2", "7.3")

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == CONTROL and frame.data != b"\x00"
        yield CanFrame(CONTROL, bytes((frame.data[0] ^ 0x80,))) if is_it else frame


class GuardsForOthers(Fault):
    cases = ("7.4",)

    def to_node(self, frame: CanFrame) -> Frames:
        is_it = frame.is_remote and frame.identifier == CONTROL + 1
        yield CanFrame(CONTROL, is_remote=True, remote_length=1) if is_it else frame


class GuardTimeIsKept(_Diverts):
    cases = ("2.14", "2.20", "2.24", "7.5")
    key = b"\x0c\x10\x00"


class GuardTimeWrongSize(_Reads):
    cases = ("7.1",)
    key, value = b"\x0c\x10\x00", b"\x00"


# Heartbeat


class HeartbeatTooSlow(_Drops):
    cases = ("7.102", "7.204", "7.206")
    identifier = CONTROL


class HeartbeatWithWrongState(Fault):
    cases = ("7.102", "7.105", "9.2", "9.3", "9.4", "10.2", "10.3")

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == CONTROL and frame.data != b"\x00"
        yield CanFrame(CONTROL, b"\x04" if self.command != STOPPED else b"\x05") if is_it else frame


class HeartbeatNeverEnds(Fault):
    """Not even by a heartbeat time of 0, which it says it took."""

    cases = ("7.103",)

    def to_node(self, frame: CanFrame) -> Frames:
        data = frame.data
        is_it = frame.identifier == REQUEST and data[:6] == b"\x2b\x17\x10\x00\x00\x00"
        yield CanFrame(REQUEST, data[:4] + b"\x64" + data[5:]) if is_it else frame


class WatchesOneNodeTwice(_Takes):
    cases = ("7.104",)
    codes = (0x0604_0043,)


class MissesHeartbeats(Fault):
    """Hears one of three."""

    cases = ("7.105",)

    def __init__(self) -> None:
        super().__init__()
        self._count = 0

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == CONTROL - NODE_ID + 127:
            self._count += 1
            if self._count % 6 != 1:
                return
        yield frame


class WatchesBeforeTheFirst(Fault):
    cases = ("7.107",)

    def to_node(self, frame: CanFrame) -> Frames:
        yield frame
        if frame.identifier == NMT and frame.data[0] == START:
            self.say_after(300, CanFrame(EMCY, b"\x30\x81\x11\x00\x00\x00\x00\x00"))


# Heartbeat versus guarding


class GuardsBesideHeartbeat(Fault):
    cases = ("7.205", "7.207")

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.is_remote and frame.identifier == CONTROL:
            self.say(CanFrame(CONTROL, b"\x7f"))
        else:
            yield frame


class HeartbeatUnreadable(Fault):
    cases = ("7.201",)

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == RESPONSE and self.request[:3] == b"\x40\x17\x10"
        yield sdo(b"\x80" + self.multiplexer + b"\x00\x00\x02\x06") if is_it else frame


class TalksUnasked(Fault):
    """A byte of error control beside each heartbeat time that is written, some time later."""

    cases = ("7.202", "7.204", "7.206")

    def from_node(self, frame: CanFrame) -> Frames:
        yield frame
        if frame.identifier == RESPONSE and self.request[:1] == b"\x2b" and self.multiplexer == b"\x17\x10\x00":
            for ms in range(60, 1200, 60):
                self.say_after(ms, CanFrame(CONTROL, b"\x7f"))


# Testing other: storing


class StoresNothing(_Swallows):
    cases = ("6.8", "6.10", "8.2", "8.6", "8.9")
    index = 0x1010
    value = b"save"


class RestoresNothing(_Swallows):
    cases = ("8.4", "8.8")
    index = 0x1011
    value = b"load"


class TakesAnySignature(_Takes):
    cases = ("8.1", "8.3", "8.5", "8.7")
    codes = (0x0800_0020,)


class TakesRestrictedIds(_Takes):
    cases = ("8.10",)
    codes = (0x0609_0030,)


class KeepsTheDate(_Reads):
    cases = ("8.9",)
    key, value = b"\x20\x10\x01", b"\x39\x30\x00\x00"


# States and transitions


class NoBootUp(Fault):
    cases = ("9.1", "9.2", "10.1")

    def from_node(self, frame: CanFrame) -> Frames:
        if frame != CanFrame(CONTROL, b"\x00"):
            yield frame


class TwoBootUps(Fault):
    cases = ("9.1",)

    def from_node(self, frame: CanFrame) -> Frames:
        yield frame
        if frame == CanFrame(CONTROL, b"\x00"):
            yield frame


class SdoInStopped(Fault):
    cases = ("9.4",)

    def to_node(self, frame: CanFrame) -> Frames:
        if self.command == STOPPED and frame.identifier == REQUEST:
            self.answer(b"\x80" + frame.data[1:4] + b"\x22\x00\x00\x08")
        yield frame


class NoPdoInOperational(Fault):
    cases = ("3.6", "6.3", "9.3")

    def from_node(self, frame: CanFrame) -> Frames:
        if frame.identifier != TPDO:
            yield frame


class _Ignores(Fault):
    """An NMT command that comes after another."""

    before: ClassVar[int] = 0
    ignored: ClassVar[int] = 0

    def __init__(self) -> None:
        super().__init__()
        self._last = 0

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier == NMT and frame.data[1] in (0, NODE_ID):
            if (self._last, frame.data[0]) == (self.before, self.ignored):
                return
            self._last = frame.data[0]
        yield frame


class IgnoresStartWhenStopped(_Ignores):
    cases = ("10.3",)
    before, ignored = STOPPED, START


class IgnoresStopInOperation(_Ignores):
    cases = ("10.4",)
    before, ignored = START, STOPPED


class StaysInOperation(_Ignores):
    cases = ("10.2",)
    before, ignored = START, 128


class IgnoresResetWhenStopped(_Ignores):
    cases = ("10.1",)
    before, ignored = STOPPED, 129


class ObeysForOthers(Fault):
    cases = ("10.2", "10.3", "10.4")

    def to_node(self, frame: CanFrame) -> Frames:
        yield CanFrame(NMT, bytes((frame.data[0], NODE_ID))) if frame.identifier == NMT else frame


class DeafToAllNodes(Fault):
    cases = ("10.1", "10.2", "10.3", "10.4")

    def to_node(self, frame: CanFrame) -> Frames:
        if frame.identifier != NMT or frame.data[1] != 0:
            yield frame


class StateAfterBootIsUnknown(Fault):
    """Heartbeats after a reset carry the state 'initialising' until the next NMT command."""

    cases = ("7.204", "7.205", "7.206", "7.207", "10.1")

    def from_node(self, frame: CanFrame) -> Frames:
        is_it = frame.identifier == CONTROL and self.command in (129, 130) and not frame.is_remote
        yield CanFrame(CONTROL, b"\x00") if is_it else frame


FAULTS: dict[str, type[Fault]] = {
    name: entry
    for name, entry in list(globals().items())
    if isinstance(entry, type) and issubclass(entry, Fault) and entry is not Fault and not name.startswith("_")
}
