"""The compression of TCP/IP headers by Van Jacobson: 40 bytes become some 3 to 7 (RFC 1144; in PPP: RFC 1332, 4).

Both ends keep the last header of each connection in a slot, and a packet has only what has changed in it.  What cannot
be said so goes out whole: as IP, or with the number of its slot in the place of the protocol, which fills the slot.
A packet that is lost makes the ones behind it wrong, which the checksum of TCP finds, until one is whole again.
"""

from dataclasses import dataclass
from struct import Struct
from typing import Final

from fieldrig_devices.ip.checksum import checksum

TCP: Final = 6
MOST_SLOTS: Final = 16
"""Slots of this end; the highest one is asked for in the option of IPCP."""

# RFC 1144, 3.2.2: the bits of the change mask.
NEW_C, NEW_I, PUSH, NEW_S, NEW_A, NEW_W, NEW_U = 0x40, 0x20, 0x10, 0x08, 0x04, 0x02, 0x01
SPECIAL_I: Final = NEW_S | NEW_W | NEW_U
"""The sequence number and the acknowledgment both grow by the data before: an echo of interactive traffic."""
SPECIAL_D: Final = NEW_S | NEW_A | NEW_W | NEW_U
"""The sequence number grows by the data before: a transfer in one direction."""

_FIN, _SYN, _RST, _PSH, _ACK, _URG = 0x01, 0x02, 0x04, 0x08, 0x10, 0x20
_IP: Final = Struct("!BBHHHBBH4s4s")
_TCP: Final = Struct("!HHIIBBHHH")
_FRAGMENT: Final = 0x3FFF
"""More fragments, and the place of a fragment; a packet that may not become fragments has neither."""
_WORD, _LONG = 0xFFFF, 0xFFFF_FFFF


@dataclass(slots=True)
class _Headers:
    """The headers of a packet: the fields that may change, and everything else as it is."""

    length: int
    identification: int
    sequence: int
    acknowledgment: int
    flags: int
    window: int
    check: int
    urgent: int
    ends: bytes
    """Addresses and ports: the key of a connection."""
    rest: tuple[object, ...]
    """Fields that have to be the same for a packet to be compressed, such as options."""
    size: int
    """Bytes of both headers."""

    @property
    def data_bytes(self) -> int:
        return self.length - self.size

    @classmethod
    def of(cls, packet: bytes) -> "_Headers | None":
        """Return the headers of a TCP packet; None for everything else."""
        if len(packet) < 40 or packet[0] >> 4 != 4 or packet[9] != TCP:
            return None
        first, service, length, identification, fragment, ttl, protocol, _, _, _ = _IP.unpack_from(packet)
        ip_bytes = (first & 0x0F) * 4
        if ip_bytes < 20 or len(packet) < ip_bytes + 20 or length != len(packet) or fragment & _FRAGMENT:
            return None
        _, _, sequence, acknowledgment, words, flags, window, check, urgent = _TCP.unpack_from(packet, ip_bytes)
        size = ip_bytes + (words >> 4) * 4
        if size < ip_bytes + 20 or size > len(packet):
            return None
        rest = (first, service, fragment, ttl, protocol, words, packet[20:ip_bytes], packet[ip_bytes + 20 : size])
        ends = packet[12:20] + packet[ip_bytes : ip_bytes + 4]
        return cls(length, identification, sequence, acknowledgment, flags, window, check, urgent, ends, rest, size)


class Compressor:
    """The sending end."""

    def __init__(self, slots: int, *, may_omit_slot: bool) -> None:
        """`slots` and `may_omit_slot` are what the peer has asked for."""
        self._slots = max(slots, 1)
        self._may_omit_slot = may_omit_slot
        self._numbers: dict[bytes, int] = {}
        """The slots by the ends of their connections, the one that was used last at the end."""
        self._last: dict[bytes, _Headers] = {}
        self._sent: int | None = None

    def whole(self, packet: bytes, slot: int) -> bytes:
        return packet[:9] + bytes((slot,)) + packet[10:]

    def compress(self, packet: bytes) -> tuple[bytes, bool] | None:
        """Return what to send, and whether it is compressed or whole with its slot; None to send the packet as IP."""
        now = _Headers.of(packet)
        if now is None or now.flags & (_FIN | _SYN | _RST | _ACK) != _ACK:
            return None
        slot = self._numbers.pop(now.ends, None)
        before = self._last.get(now.ends) if slot is not None else None
        if slot is None:
            slot = self._free()
        self._numbers[now.ends], self._last[now.ends] = slot, now
        body = _changes(before, now) if before is not None else None
        if body is None:
            self._sent = slot
            return self.whole(packet, slot), False
        mask, deltas = body
        is_said = not self._may_omit_slot or slot != self._sent
        self._sent = slot
        head = bytes((mask | NEW_C, slot)) if is_said else bytes((mask,))
        return head + now.check.to_bytes(2, "big") + deltas + packet[now.size :], True

    def _free(self) -> int:
        """Return a slot that is free, or that of the connection that was used longest ago."""
        if len(self._numbers) < self._slots:
            return len(self._numbers)
        oldest = next(iter(self._numbers))
        del self._last[oldest]
        return self._numbers.pop(oldest)


def _changes(before: _Headers, now: _Headers) -> tuple[int, bytes] | None:
    """Return the change mask and the changes (RFC 1144, A.2); None if the packet has to go out whole."""
    if now.rest != before.rest:
        return None
    mask, deltas = 0, b""
    if now.flags & _URG:
        mask, deltas = NEW_U, _encoded(now.urgent, has_zero=True)
    elif now.urgent != before.urgent:
        return None  # something that RFC 793 does not allow
    if window := (now.window - before.window) & _WORD:
        mask, deltas = mask | NEW_W, deltas + _encoded(window)
    acknowledged = (now.acknowledgment - before.acknowledgment) & _LONG
    sent = (now.sequence - before.sequence) & _LONG
    if max(acknowledged, sent) > _WORD:
        return None
    if acknowledged:
        mask, deltas = mask | NEW_A, deltas + _encoded(acknowledged)
    if sent:
        mask, deltas = mask | NEW_S, deltas + _encoded(sent)
    if mask == 0 and (now.length == before.length or before.data_bytes):
        return None  # sent again, or a probe of the window: the peer's slot may be wrong
    if mask in (SPECIAL_I, SPECIAL_D):
        return None
    if mask == NEW_S | NEW_A and sent == acknowledged == before.data_bytes:
        mask, deltas = SPECIAL_I, b""
    elif mask == NEW_S and sent == before.data_bytes:
        mask, deltas = SPECIAL_D, b""
    identification = (now.identification - before.identification) & _WORD
    if identification != 1:
        mask, deltas = mask | NEW_I, deltas + _encoded(identification, has_zero=True)
    return mask | (PUSH if now.flags & _PSH else 0), deltas


def _encoded(value: int, *, has_zero: bool = False) -> bytes:
    """Return a change of 1 to 65535, or 0 where that can be: a byte, or 0 and two bytes (RFC 1144, 3.2.2)."""
    is_short = 0 < value <= 0xFF
    assert is_short or value or has_zero, "a change of 0 is no change"
    return bytes((value,)) if is_short else b"\0" + value.to_bytes(2, "big")


class Decompressor:
    """The receiving end."""

    def __init__(self, slots: int = MOST_SLOTS) -> None:
        self._slots = slots
        self._packets: dict[int, bytearray] = {}
        """The headers of the last packet of each slot."""
        self._data_bytes: dict[int, int] = {}
        self._slot: int | None = None

    def toss(self) -> None:
        """A frame was lost: drop what does not name its slot, until one does (RFC 1144, 4.1)."""
        self._slot = None

    def whole(self, data: bytes) -> bytes:
        """Return the packet that fills a slot.  ValueError for anything else."""
        slot = data[9] if len(data) > 9 else self._slots
        packet = data[:9] + bytes((TCP,)) + data[10:]
        headers = _Headers.of(packet)
        if slot >= self._slots or headers is None:
            self.toss()
            raise ValueError("no packet of TCP with the number of a slot")
        self._slot = slot
        self._packets[slot] = bytearray(packet[: headers.size])
        self._data_bytes[slot] = headers.data_bytes
        return packet

    def compressed(self, data: bytes) -> bytes:
        """Return the packet that has these changes.  ValueError for anything else."""
        try:
            return self._restored(_Reader(data))
        except (IndexError, KeyError) as cause:
            self.toss()
            raise ValueError("changes of a packet that are cut short, or of an unknown slot") from cause

    def _restored(self, reader: "_Reader") -> bytes:
        mask = reader.byte()
        if mask & NEW_C:
            self._slot = reader.byte()
        if self._slot is None:
            raise ValueError("changes without a slot, after a frame was lost")
        check = reader.word()
        header, data_bytes = self._packets[self._slot], self._data_bytes[self._slot]
        at = (header[0] & 0x0F) * 4
        source, target, sequence, acknowledgment, words, flags, window, _, urgent = _TCP.unpack_from(header, at)
        flags = flags & ~(_PSH | _URG) | (_PSH if mask & PUSH else 0)
        changes = mask & SPECIAL_D
        if changes == SPECIAL_I:
            sequence, acknowledgment = sequence + data_bytes, acknowledgment + data_bytes
        elif changes == SPECIAL_D:
            sequence += data_bytes
        else:
            if changes & NEW_U:
                flags, urgent = flags | _URG, reader.change()
            window += reader.change() if changes & NEW_W else 0
            acknowledgment += reader.change() if changes & NEW_A else 0
            sequence += reader.change() if changes & NEW_S else 0
        step = reader.change() if mask & NEW_I else 1
        identification = int.from_bytes(header[4:6], "big") + step
        rest = reader.rest()
        length = len(header) + len(rest)
        if length > _WORD:
            raise IndexError(length)
        header[2:6] = length.to_bytes(2, "big") + (identification & _WORD).to_bytes(2, "big")
        header[10:12] = bytes(2)
        header[10:12] = checksum(bytes(header[:at])).to_bytes(2, "big")
        fields = (sequence & _LONG, acknowledgment & _LONG, words, flags, window & _WORD, check, urgent)
        _TCP.pack_into(header, at, source, target, *fields)
        self._data_bytes[self._slot] = len(rest)
        return bytes(header) + rest


class _Reader:
    """Reads the changes of a packet.  IndexError at their end."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def byte(self) -> int:
        value = self._data[self._at]
        self._at += 1
        return value

    def word(self) -> int:
        return self.byte() << 8 | self.byte()

    def change(self) -> int:
        return self.byte() or self.word()

    def rest(self) -> bytes:
        return self._data[self._at :]
