"""The sides of a log: the messages that are played, and those that the rig is expected to send.

By default everything is played that no device of the rig sends, which is the master's side.  The sender in the log
decides where it has one of the rig's names.  Otherwise the identifier of CAN does (CiA 301, predefined connection set,
and the PDOs of the nodes' EDS files), and on Modbus the direction: requests come from outside.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from fnmatch import fnmatchcase
from typing import Final, NamedTuple

from fieldrig.config.entries import DeviceEntry
from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.names import Member, Namer, members_of, namer_of
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.modbus.codec import RESPONSE
from fieldrig_devices.canopen.names import ERROR_CONTROL, NMT, SDO_REQUEST, SYNC, TIME, CanopenNames
from fieldrig_devices.replay.log_names import bus_in
from fieldrig_devices.replay.selection import Selection

HEAD_OF_FRAME: Final = 5
OPERATIONAL: Final = b"\x05"
TPDO_1, TPDO_4 = 0x180, 0x480
"""The predefined identifiers of TPDOs (CiA 301, 7.3.5)."""
MOST_BUSES: Final = 10_000


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
    strangers: dict[int, None] = field(default_factory=dict)
    """The nodes of the log that the rig does not have, and whose messages are played."""
    strange_units: dict[int, None] = field(default_factory=dict)
    """The Modbus units of the log that the rig does not have."""
    _known: dict[str, _Bus | None] = field(default_factory=dict)

    def bus_of(self, entry: TraceEntry) -> str | None:
        """Return the bus of the rig that a message belongs to."""
        known = self._of(entry)
        return None if known is None else known.name

    def side(self, entry: TraceEntry) -> Side:
        """Return the side of a message."""
        known = self._of(entry)
        if known is None:
            return Side.OUTSIDE
        if entry.family == "can":
            return self._can(known, entry)
        if entry.family == "modbus":
            return self._modbus(known, entry)
        device = self._device(entry.sender)
        if device is not None:
            return self._of_device(device)
        is_wanted = self._is_sender(entry.sender) or (self.selection.is_master and bool(entry.sender))
        return Side.PLAYED if is_wanted else Side.OUTSIDE

    def running_node(self, entry: TraceEntry) -> int | None:
        """Return the node of the rig that a message shows to be operational: by its heartbeat, or by a TPDO."""
        known = self._of(entry)
        if known is None or entry.family != "can" or len(entry.data) < HEAD_OF_FRAME:
            return None
        word = int.from_bytes(entry.data[:4], "little")
        node = self._node(known, word)
        if node is None or node not in known.nodes or node in known.mastered:
            return None
        base = word & 0x780
        is_running = entry.data[HEAD_OF_FRAME:] == OPERATIONAL if base == ERROR_CONTROL else TPDO_1 <= base <= TPDO_4
        return node if is_running else None

    def _can(self, known: _Bus, entry: TraceEntry) -> Side:
        word = int.from_bytes(entry.data[:4], "little")
        if len(entry.data) < 5 or word & ~(EXTENDED | REMOTE | 0x1FFF_FFFF):
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
        if node is not None and selection.is_master:
            self.strangers[node] = None
        is_wanted = selection.is_master or self._is_sender(entry.sender)
        return Side.PLAYED if is_wanted else Side.OUTSIDE

    def _node(self, known: _Bus, word: int) -> int | None:
        """Return the node-ID of the node that sends this identifier, as far as it is known."""
        if word & EXTENDED or not isinstance(known.namer, CanopenNames):
            return None
        is_remote = bool(word & REMOTE)
        return known.namer.sender_of(CanFrame(word & STANDARD_MASK, is_remote=is_remote))

    def _modbus(self, known: _Bus, entry: TraceEntry) -> Side:
        kind, unit = (entry.data[0], entry.data[1]) if len(entry.data) > 1 else (0xFF, 0)
        device = self._device(entry.sender)
        if kind == RESPONSE:
            if unit in self.selection.units:
                return Side.PLAYED
            return Side.EXPECTED if unit in known.units or unit in (0, 255) or device else Side.OUTSIDE
        if kind > 3:
            return Side.OUTSIDE
        if device is not None:
            return self._of_device(device)
        if not entry.sender and unit in known.asked:
            return Side.EXPECTED
        is_there = unit in known.units or unit in (0, 255)
        if not is_there:
            self.strange_units[unit] = None
        is_wanted = self.selection.is_master or self._is_sender(entry.sender)
        return Side.PLAYED if is_wanted and is_there else Side.OUTSIDE

    def _of_device(self, device: DeviceEntry) -> Side:
        return Side.PLAYED if device.name in self.selection.devices else Side.EXPECTED

    def _device(self, sender: str) -> DeviceEntry | None:
        return self.config.devices.get(sender)

    def _is_sender(self, sender: str) -> bool:
        return any(fnmatchcase(sender, pattern) for pattern in self.selection.senders)

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
