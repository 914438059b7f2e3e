"""The sides of a log: the messages that are played, and those that the rig is expected to send.

By default everything is played that no device of the rig sends, which is the master's side.  The sender in the log
decides where it has one of the rig's names.  Otherwise the identifier of CAN does (CiA 301, predefined connection set,
and the PDOs of the nodes' EDS files), and on Modbus the direction: requests come from outside.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from fnmatch import fnmatchcase
from typing import Final, NamedTuple

from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.names import Member, Namer, members_of, namer_of
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK, CanFrame
from fieldrig_bus.can.notices import NOTICE
from fieldrig_bus.modbus.codec import REQUEST_ON_ASCII, is_response, unit_in
from fieldrig_devices.canopen.names import ERROR_CONTROL, NMT, SDO_REQUEST, SYNC, TIME, CanopenNames
from fieldrig_devices.dialogues.modbus_dialogues import is_address
from fieldrig_devices.dialogues.modbus_servers import plain_bus
from fieldrig_devices.replay.absent import Absent
from fieldrig_devices.replay.families import INNER, MEDIA, OUTER
from fieldrig_devices.replay.log_names import bus_in
from fieldrig_devices.replay.selection import Asked, Selection

HEAD_OF_FRAME: Final = 5
OPERATIONAL: Final = b"\x05"
TPDO_1, TPDO_4 = 0x180, 0x480
"""The predefined identifiers of TPDOs (CiA 301, 7.3.5)."""
MOST_BUSES: Final = 10_000
MOST_NAMES: Final = 2_000
NO_TARGET: Final = (10, 11)
"""Exceptions of a gateway that reaches no device (V1.1b3, chapter 7)."""


class Side(Enum):
    """The part of a message of a log."""

    PLAYED = auto()
    EXPECTED = auto()
    OUTSIDE = auto()
    """It is of a bus that the rig does not have, or of a device that is not there."""


class _Bus(NamedTuple):
    """A bus of the rig that a bus of the log is."""

    name: str
    namer: Namer
    nodes: frozenset[int]
    """Node-IDs of devices that the rig has."""
    units: frozenset[int]
    mastered: frozenset[int]
    """Node-IDs of slaves whose master is a device of the rig."""
    asked: frozenset[int]
    """Modbus units that a device of the rig is a client of."""


@dataclass
class Sides:
    """Divides the messages of a log into what is played and what is expected."""

    config: RigConfig
    """The rig, with the devices that are played."""
    selection: Selection
    buses: Mapping[str, str] = field(default_factory=dict)
    """The bus of the rig by that of the log, where the names say nothing."""
    absent: Absent = field(default_factory=Absent)
    """The buses, nodes and units of the log that the rig does not have."""
    _taken: dict[str, str] = field(default_factory=dict)
    """The bus of the log that each bus of the rig is."""
    _known: dict[str, _Bus | None] = field(default_factory=dict)
    asked: list[Asked] = field(init=False)
    """The words of the selection that have named no message so far."""
    seen: dict[str, None] = field(default_factory=dict)
    """The nodes, identifiers, units and senders of the log, as the selection names them; empty once each was met."""

    def __post_init__(self) -> None:
        self.asked = list(self.selection.asked)

    def bus_of(self, entry: TraceEntry) -> str | None:
        """Return the bus of the rig that a message belongs to."""
        known = self._of(entry)
        return None if known is None else known.name

    def side(self, entry: TraceEntry) -> Side:
        """Return the side of a message."""
        known = self._of(entry)
        if self.asked:
            names = set(_names(known, entry, self._node))
            self.asked = [asked for asked in self.asked if not any(fnmatchcase(x, asked.pattern) for x in names)]
            if len(self.seen) < MOST_NAMES:
                self.seen.update(dict.fromkeys(names))
        if known is None:
            if entry.family in OUTER:
                self.absent.take("bus", entry.bus, "", entry.time_ns)
            return Side.OUTSIDE
        if entry.family == "can":
            return self._can(known, entry)
        if entry.family == "modbus":
            return self._modbus(known, entry)
        device = self._device(entry.sender)
        if device is not None:
            return self._of_device(device)
        if entry.family in INNER and entry.sender in MEDIA:
            return Side.EXPECTED
        is_wanted = self._is_sender(entry.sender) or (self.selection.is_master and bool(entry.sender))
        return Side.PLAYED if is_wanted else Side.OUTSIDE

    def expect_buses(self, head: Iterable[TraceEntry]) -> None:
        """Take the first messages of a log, so that a bus goes to the one of its name, whichever comes first."""
        for entry in head:
            name = next((name for name in (entry.bus, plain_bus(entry.bus)) if name in self.config.buses), None)
            if name is not None:
                self._taken.setdefault(name, entry.bus)

    def sending_node(self, entry: TraceEntry) -> int | None:
        """Return the node of the rig that a frame comes from; None if it is no frame of a node."""
        known = self._of(entry)
        if known is None or entry.family != "can" or len(entry.data) < HEAD_OF_FRAME:
            return None
        node = self._node(known, int.from_bytes(entry.data[:4], "little"))
        return node if node in known.nodes else None

    def is_mastered(self, bus: str, node: int) -> bool:
        """Return whether the master of a node is a device of the rig."""
        return any(known is not None and known.name == bus and node in known.mastered for known in self._known.values())

    def running_node(self, entry: TraceEntry) -> int | None:
        """Return the node of the rig that a message shows to be operational: by its heartbeat, or by a TPDO."""
        node, bus = self.sending_node(entry), self.bus_of(entry)
        if node is None or bus is None or self.is_mastered(bus, node):
            return None
        base = int.from_bytes(entry.data[:4], "little") & 0x780
        is_running = entry.data[HEAD_OF_FRAME:] == OPERATIONAL if base == ERROR_CONTROL else TPDO_1 <= base <= TPDO_4
        return node if is_running else None

    def _can(self, known: _Bus, entry: TraceEntry) -> Side:
        word = int.from_bytes(entry.data[:4], "little")
        if len(entry.data) < 5 or word & ~EXTENDED_MASK == NOTICE:
            return Side.OUTSIDE  # a notice of a controller
        identifier = word & 0x1FFF_FFFF
        selection = self.selection
        if identifier in selection.identifiers:
            return Side.PLAYED
        node = self._node(known, word)
        if node is not None and node in (*selection.nodes, *known.nodes):
            return Side.PLAYED if node in selection.nodes else Side.EXPECTED
        device = self._device(entry.sender)
        if device is not None:
            return self._of_device(device)
        if not entry.sender and known.mastered and _is_of_master(identifier, known.mastered):
            return Side.EXPECTED
        if self._is_sender(entry.sender):
            return Side.PLAYED
        if not selection.is_master:
            self.absent.take("sender", known.name, entry.sender or "its master", entry.time_ns, is_sure=False)
            return Side.OUTSIDE
        if node is not None:  # a master has a heartbeat too
            is_sure = identifier & 0x780 != ERROR_CONTROL
            self.absent.take("node", known.name, str(node), entry.time_ns, is_sure=is_sure)
        return Side.PLAYED

    def _node(self, known: _Bus, word: int) -> int | None:
        """Return the node-ID of the node that sends this identifier, as far as it is known."""
        if word & EXTENDED or not isinstance(known.namer, CanopenNames):
            return None
        is_remote = bool(word & REMOTE)
        return known.namer.sender_of(CanFrame(word & STANDARD_MASK, is_remote=is_remote))

    def _modbus(self, known: _Bus, entry: TraceEntry) -> Side:
        if len(entry.data) < 2:
            return Side.OUTSIDE  # no message has a kind alone
        kind, unit = entry.data[0], unit_in(entry.data)
        device = self._device(entry.sender)
        if is_response(entry.data):
            if unit in self.selection.units:
                return Side.PLAYED
            if unit in known.units or unit in (0, 255) or device:
                return Side.EXPECTED
            is_there = not (entry.data[-2:-1] > b"\x80" and entry.data[-1] in NO_TARGET)
            self.absent.take("unit", known.name, str(unit), entry.time_ns, is_sure=is_there)
            return Side.OUTSIDE
        if kind > REQUEST_ON_ASCII:
            return Side.OUTSIDE
        if device is not None:
            return self._of_device(device)
        if not entry.sender and unit in known.asked:
            return Side.EXPECTED
        is_there = unit in known.units or unit in (0, 255)
        if not is_there:
            self.absent.take("unit", known.name, str(unit), entry.time_ns, is_sure=False)
        is_wanted = self.selection.is_master or self._is_sender(entry.sender)
        return Side.PLAYED if is_wanted and is_there else Side.OUTSIDE

    def _of_device(self, device: DeviceEntry) -> Side:
        return Side.PLAYED if device.name in self.selection.devices else Side.EXPECTED

    def _device(self, sender: str) -> DeviceEntry | None:
        return self.config.devices.get(sender)

    def _is_sender(self, sender: str) -> bool:
        names = (sender, sender.rpartition(":")[0]) if is_address(sender) else (sender,)
        return any(fnmatchcase(name, pattern) for name in names for pattern in self.selection.senders)

    def _of(self, entry: TraceEntry) -> _Bus | None:
        if entry.bus not in self._known:
            if len(self._known) >= MOST_BUSES:
                return None
            self._known[entry.bus] = self._found(entry)
        return self._known[entry.bus]

    def _found(self, entry: TraceEntry) -> _Bus | None:
        name = bus_in(self.config, entry.bus, entry.family, self.buses)
        if name is None or self.config.buses[name].bus.family != entry.family:
            return None
        is_said = name in (entry.bus, plain_bus(entry.bus)) or entry.bus in self.buses
        if self._taken.setdefault(name, entry.bus) != entry.bus and not is_said:
            return None  # two networks whose nodes have the same numbers
        selected = self.selection
        members = [member for member in members_of(self.config, name) if member.entry.name not in selected.devices]
        return _Bus(
            name,
            namer_of(self.config, name),
            _claimed(members, "node-ID"),
            _claimed(members, "unit"),
            _claimed(members, "master of node-ID"),
            _needed(members, "unit"),
        )


def _names(known: _Bus | None, entry: TraceEntry, node_of: Callable[[_Bus, int], int | None]) -> Iterator[str]:
    """Yield what `--play` may call a message."""
    if entry.sender:
        yield f"sender={entry.sender}"
        if is_address(entry.sender):
            yield f"sender={entry.sender.rpartition(':')[0]}"
    if entry.family == "can" and len(entry.data) >= HEAD_OF_FRAME:
        word = int.from_bytes(entry.data[:4], "little")
        yield f"id={word & EXTENDED_MASK:X}"
        node = None if known is None else node_of(known, word)
        if node is not None:
            yield f"node={node}"
    elif entry.family == "modbus" and len(entry.data) > 1:
        yield f"unit={unit_in(entry.data)}"


def _claimed(members: Sequence[Member], what: str) -> frozenset[int]:
    claims = (claim for member in members for claim in member.claims(what))
    return frozenset(claim.value for claim in claims if isinstance(claim.value, int))


def _needed(members: Sequence[Member], what: str) -> frozenset[int]:
    needs = (need for member in members for need in member.entry.settings.needs(member.entry.name))
    return frozenset(need.value for need in needs if need.what == what and isinstance(need.value, int))


def _is_of_master(identifier: int, nodes: Collection[int]) -> bool:
    """Return whether the master of these nodes sends frames with this identifier."""
    is_request = identifier & 0x780 == SDO_REQUEST and identifier & 0x7F in nodes
    return is_request or identifier in (NMT, SYNC, TIME)
