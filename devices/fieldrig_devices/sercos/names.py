"""Messages of a SERCOS ring by name: phase, drives, service channel, states, and cyclic values by their IDNs.

Source: IEC 61491 by its public facts.  Where a record is in the MDT and what the telegrams carry is learnt from what
the master writes in CP2 (S-0-0009, S-0-0015, S-0-0016, S-0-0024), or from the points of the drives.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple, Protocol, runtime_checkable

from fieldrig.bus import Bus
from fieldrig.points.values import counted
from fieldrig.traces.names import MOST_SHOWN, Member, Named, Namer
from fieldrig.traces.parts import Part, Parts
from fieldrig_bus.ring.sercos.message import BROADCAST, Answers, Cycle, show
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.datum import Datum
from fieldrig_devices.sercos.idn import idn_of, idn_text
from fieldrig_devices.sercos.service_names import ServiceNames
from fieldrig_devices.sercos.telegram import AT_HEAD, CONFIGURED, HEAD_BYTES, STANDARD
from fieldrig_devices.sercos.telegram_parts import CONTROL, STATUS, data_parts, head_parts, ring_parts, unknown_parts

PHASE_MASK: Final = 7
CYCLIC_PHASE: Final = 3
"""The first phase in which all drives have a record in the MDT."""
CONFIGURATION: Final = (std.RECORD_POSITION, std.TELEGRAM_TYPE, std.AT_CONFIGURATION, std.MDT_CONFIGURATION)
"""The data that say what the telegrams of a drive carry."""
_HEAD: Final = struct.Struct("<HH")
STATES: Final = {
    words.NOT_READY: "not ready",
    words.READY_FOR_POWER: "ready for power",
    words.POWERED: "powered",
    words.IN_OPERATION: "in operation",
}


@runtime_checkable
class HasIdns(Protocol):
    """The settings of a drive that say which operation data it has."""

    def operation_data(self) -> Iterable[Datum]:
        """Return the data of a new drive of these settings."""


class KnownDrive(NamedTuple):
    """A drive of the ring: its name in the rig, and its operation data by IDN."""

    name: str
    table: Mapping[int, Datum]


class _Drive:
    """The things that have been seen of one drive."""

    def __init__(self, known: KnownDrive) -> None:
        self.name, self._table = known
        self.service = ServiceNames(known.table)
        self._order = self._state = -1

    @property
    def is_known(self) -> bool:
        """True if the rig says which operation data it has."""
        return bool(self._table)

    def learn(self, values: Mapping[str, Any]) -> None:
        """Take its configuration, as its points show it."""
        for key, value in values.items():
            numbers = [idn_of(text) for text in value.split()] if isinstance(value, str) else [int(value)]
            data = b"".join(number.to_bytes(2, "little") for number in numbers)
            self.service.written.setdefault(idn_of(key), data)

    @property
    def position(self) -> int | None:
        """The first byte of its record in the MDT, whose byte 0 is the address; None if it is not known."""
        return self._number(std.RECORD_POSITION)

    def on_record(self, data: bytes) -> Iterator[str]:
        control, info = _HEAD.unpack_from(data)
        yield self.service.on_control(control, info)
        order, self._order = self._order, control & (words.DRIVE_ON | words.ENABLE)
        if order != self._order:
            is_on, is_enabled = self._order & words.DRIVE_ON, self._order & words.ENABLE
            yield f"drive {'on' if is_on else 'off'}, {'enabled' if is_enabled else 'not enabled'}"
        yield from self._values(std.MDT_CONFIGURATION, 0, data[HEAD_BYTES:])

    def on_answer(self, at: bytes) -> Iterator[str]:
        _, status, info = AT_HEAD.unpack_from(at)
        yield self.service.on_status(status, info)
        state, self._state = self._state, status & words.IN_OPERATION | status & words.CLASS_1_ERROR
        if state != self._state:
            error = ", class 1 error" if status & words.CLASS_1_ERROR else ""
            yield STATES[status & words.IN_OPERATION] + error
        yield from self._values(std.AT_CONFIGURATION, 1, at[AT_HEAD.size :])

    def _values(self, listed: int, side: int, data: bytes) -> Iterator[str]:
        for datum, value in self._data(listed, side, data):
            yield f"{idn_text(datum.idn)} {datum.shown(value)} {datum.unit}".rstrip()

    def record_parts(self, data: bytes) -> Iterator[Part]:
        """Yield the values of the drive's record in an MDT."""
        yield from head_parts(self.name, CONTROL, data)
        yield from data_parts(self.name, self._data(std.MDT_CONFIGURATION, 0, data[HEAD_BYTES:]))

    def answer_parts(self, at: bytes) -> Iterator[Part]:
        """Yield the values of the drive's AT."""
        yield from head_parts(self.name, STATUS, at[1:])
        yield from data_parts(self.name, self._data(std.AT_CONFIGURATION, 1, at[AT_HEAD.size :]))

    def _data(self, listed: int, side: int, data: bytes) -> Iterator[tuple[Datum, bytes]]:
        at = 0
        for idn in self._carried(listed, side):
            datum = self._table.get(idn)
            size = 0 if datum is None else datum.attribute.length.bytes
            if datum is None or at + size > len(data):
                return
            yield datum, data[at : at + size]
            at += size

    def _carried(self, listed: int, side: int) -> Sequence[int]:
        kind = self._number(std.TELEGRAM_TYPE)
        if kind == CONFIGURED:
            data = self.service.written.get(listed, b"")
            return [int.from_bytes(data[at : at + 2], "little") for at in range(0, len(data) - 1, 2)]
        return STANDARD[kind][side] if kind is not None and kind in STANDARD else ()

    def _number(self, idn: int) -> int | None:
        data = self.service.written.get(idn)
        return None if data is None else int.from_bytes(data, "little")


class SercosNames:
    """Names the messages of one ring."""

    def __init__(self, drives: Mapping[int, KnownDrive]) -> None:
        """`drives` are those that the rig knows, by ring address."""
        self._drives = {address: _Drive(known) for address, known in drives.items()}
        self._phase = 0

    def __call__(self, message: Any, sender: str = "") -> Named:
        if isinstance(message, Cycle):
            if not message.mst:
                return Named("MST failed", "", "")
            self._phase = message.mst[1] & PHASE_MASK if len(message.mst) > 1 else self._phase
            return self._named("MDT", self._in_mdt(message.mdt), "" if message.mdt else "none")
        if isinstance(message, Answers):
            trouble = [] if message.ring_closed else ["ring open"]
            trouble += [f"{message.errors} with a wrong FCS"] if message.errors else []
            trouble += [f"{message.late} late"] if message.late else []
            head = ", ".join([counted(len(message.ats), "drive"), *trouble])
            return self._named("AT", self._in_ats(message.ats), head)._replace(
                aside=f"{message.late} late" if message.late else ""
            )
        return Named("", "", show(message))

    def note(self, message: Any) -> None:
        """Learn from a message of CP0 to CP2 what telegrams carry; the later ones say nothing of it."""
        if isinstance(message, Cycle) and len(message.mst) > 1:
            self._phase = message.mst[1] & PHASE_MASK
        if self._phase < CYCLIC_PHASE:
            self(message)

    def parts(self, message: Any, request: bytes = b"") -> Parts | None:
        """Return the values of all drives in a telegram, as far as it is known what it carries."""
        if isinstance(message, Cycle):
            phase = message.mst[1] & PHASE_MASK if len(message.mst) > 1 else -1
            first = Part("phase", "", phase, f"CP{phase}" if phase >= 0 else "MST failed")
            found = [part for drive, record in self._records(message.mdt) for part in drive.record_parts(record)]
            return Parts("", "MDT", (first, *(found or unknown_parts("MDT", [message.mdt]))))
        if isinstance(message, Answers):
            return Parts("", "AT", (*ring_parts(message), *self._answer_parts(message.ats)))
        return None

    def _answer_parts(self, ats: Iterable[bytes]) -> Iterator[Part]:
        for at in ats:
            drive = self._drives.get(at[0]) if len(at) >= AT_HEAD.size else None
            yield from unknown_parts("AT", [at]) if drive is None else drive.answer_parts(at)

    def wants(self) -> Mapping[str, Sequence[str]]:
        return {
            drive.name: [idn_text(idn) for idn in CONFIGURATION] for drive in self._drives.values() if drive.is_known
        }

    def learn(self, device: str, values: Mapping[str, Any]) -> None:
        for drive in self._drives.values():
            if drive.name == device:
                drive.learn(values)

    def _named(self, what: str, parts: Iterable[tuple[str, str]], head: str) -> Named:
        told: dict[str, list[str]] = {}
        for name, text in parts:
            if text:
                told.setdefault(name, []).append(text)
        texts = [f"{name}: {', '.join(texts)}" for name, texts in list(told.items())[:MOST_SHOWN]]
        if len(told) > MOST_SHOWN:
            texts.append(f"{len(told) - MOST_SHOWN} more")
        text = "; ".join(part for part in (head, *texts) if part)
        is_one = len(told) == 1
        nodes = () if is_one else tuple(told)
        return Named(f"CP{self._phase} {what}", next(iter(told)) if is_one else "", text, nodes)

    def _in_mdt(self, mdt: bytes) -> Iterator[tuple[str, str]]:
        for drive, record in self._records(mdt):
            yield from ((drive.name, text) for text in drive.on_record(record))

    def _records(self, mdt: bytes) -> Iterator[tuple[_Drive, bytes]]:
        """Yield the drives that an MDT speaks to, with all bytes from their record on."""
        if len(mdt) == 1 + HEAD_BYTES and mdt[0] != BROADCAST:
            drive = self._drives.get(mdt[0])
            if drive is not None:
                yield drive, mdt[1:]
            return
        for drive in self._drives.values() if mdt[:1] == bytes((BROADCAST,)) else ():
            position = drive.position
            if position is not None and 0 < position <= len(mdt) - HEAD_BYTES:
                yield drive, mdt[position:]

    def _in_ats(self, ats: Iterable[bytes]) -> Iterator[tuple[str, str]]:
        for at in ats:
            drive = self._drives.get(at[0]) if len(at) >= AT_HEAD.size else None
            if drive is not None:
                yield from ((drive.name, text) for text in drive.on_answer(at))


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a ring with these devices."""
    drives: dict[int, KnownDrive] = {}
    for member in members:
        settings = member.entry.settings
        table = {datum.idn: datum for datum in settings.operation_data()} if isinstance(settings, HasIdns) else {}
        for claim in member.claims("ring address"):
            if isinstance(claim.value, int):
                drives[claim.value] = KnownDrive(member.entry.name, table)
    return SercosNames(drives)
