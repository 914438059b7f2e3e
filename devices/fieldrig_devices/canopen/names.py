"""CANopen messages by name: service, node, object and value of each frame, from what EDS files say.

Source: CiA 301 version 4.2, chapters 7.2.2 to 7.2.8 (protocols) and 7.3.5 (predefined connection set), tables 22, 26
and 39, and CiA 305 (LSS).  COB-IDs and PDO mappings begin as in the node's dictionary, and follow the expedited SDO
transfers that are seen to succeed; what goes over segments is learned with `take`, and a change by the node itself is
not seen.
"""

from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus
from fieldrig.traces.names import Member, Named, Namer
from fieldrig.traces.parts import Part, Parts
from fieldrig_bus.can.codec import show
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.described import nodes_of
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.canopen.emcy_words import emcy_words, is_drive
from fieldrig_devices.canopen.lss_words import lss_words
from fieldrig_devices.canopen.node_settings import CanopenSettings
from fieldrig_devices.canopen.parts import emcy_parts, frame_parts, object_part, sdo_parts
from fieldrig_devices.canopen.pdo_maps import Accessed
from fieldrig_devices.canopen.pdo_names import PdoNames
from fieldrig_devices.canopen.sdo_names import SdoNames

NMT_COMMANDS: Final = {
    1: "start",
    2: "stop",
    128: "enter pre-operational",
    129: "reset node",
    130: "reset communication",
}
NMT_STATES: Final = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}
LSS_MASTER, LSS_SLAVE = 0x7E5, 0x7E4
FIRST_DAY: Final = datetime(1984, 1, 1)  # noqa: DTZ001 - the standard names no time zone
NMT, SYNC, TIME, EMCY, ERROR_CONTROL = 0x000, 0x080, 0x100, 0x080, 0x700
SDO_RESPONSE, SDO_REQUEST = 0x580, 0x600
NODES: Final = range(1, 128)


class KnownNode(NamedTuple):
    """A node of the bus: its name in the rig, and its dictionary if there is one."""

    name: str
    dictionary: Dictionary | None


class CanopenNames:
    """Names the messages of one bus."""

    def __init__(self, nodes: dict[int, KnownNode]) -> None:
        """`nodes` are those that the rig knows, by node-ID; others are named by their number."""
        self._nodes = nodes
        dictionaries = self.dictionaries
        self._known = dict(dictionaries)
        """The names of objects, by node-ID."""
        self._pdos = PdoNames(dictionaries, self._known)
        self._sdo = SdoNames(self._known, self._pdos.note)

    def __call__(self, message: Any, sender: str = "") -> Named:
        if not isinstance(message, CanFrame):
            return Named("", "", show(message))
        found = self._pdos.named(message)
        if found is not None:
            node_id, kind, text = found
            return Named(kind, self.name(node_id), text)
        return Named("", "", show(message)) if message.is_extended else self._by_identifier(message)

    def take(self, transfer: Accessed) -> None:
        """Learn from a completed SDO transfer, in whatever form it came."""
        self._pdos.take(transfer)

    def parts(self, message: Any, request: bytes = b"") -> Parts | None:
        """Return the values of a frame; a PDO has those of the objects that are mapped into it at present."""
        if not isinstance(message, CanFrame):
            return None
        pdo = self._pdos.values(message)
        if pdo is not None:
            node_id, kind, mapped = pdo
            dictionary = self.dictionary(node_id)
            values = [object_part(dictionary, *each) for each in mapped if _is_object(dictionary, *each[:2])]
            return Parts(self.name(node_id), kind, values or frame_parts(message))
        if message.is_extended:
            return None
        base, node_id = message.identifier & 0x780, message.identifier & 0x7F
        if base in (SDO_REQUEST, SDO_RESPONSE) and node_id in NODES and not message.is_remote:
            kind = "SDO request" if base == SDO_REQUEST else "SDO answer"
            return Parts(self.name(node_id), kind, self._values(message))
        named = self._by_identifier(message)
        return Parts(named.node, named.kind, self._values(message))

    def sender_of(self, frame: CanFrame) -> int | None:
        """Return the node-ID of the node that sends frames with this identifier; None for those of a master.

        A remote frame comes from the master that asks for the data, not from the node that has them.
        """
        if frame.is_remote:
            return None
        producer = self._pdos.producer_of(frame)
        if producer is not None or frame.is_extended:
            return producer
        base, node_id = frame.identifier & 0x780, frame.identifier & 0x7F
        if base in (EMCY, SDO_RESPONSE, ERROR_CONTROL) and node_id in NODES:
            is_master = base == ERROR_CONTROL and node_id > NODES[-1]
            return None if is_master or frame.identifier in (LSS_MASTER, LSS_SLAVE) else node_id
        return None

    def node_of_pdo(self, frame: CanFrame) -> int | None:
        """Return the node-ID of the node that sends or receives this PDO; None for a frame that is no PDO."""
        return self._pdos.node_of(frame)

    def pdo(self, key: int, data: bytes) -> tuple[int, str, str] | None:
        """Return node-ID, kind and content of a PDO by its identifier, where bit 31 marks one of 29 bits; else None."""
        return self._pdos.of_data(key, data)

    @property
    def dictionaries(self) -> Mapping[int, Dictionary]:
        """The dictionaries of the nodes that have one, by node-ID."""
        return {node_id: node.dictionary for node_id, node in self._nodes.items() if node.dictionary is not None}

    @property
    def nodes(self) -> Mapping[int, KnownNode]:
        """The nodes that are known, by node-ID."""
        return self._nodes

    def _values(self, frame: CanFrame) -> Sequence[Part]:
        base, node_id, data = frame.identifier & 0x780, frame.identifier & 0x7F, frame.data
        if node_id in NODES and not frame.is_remote:
            if base == EMCY:
                return emcy_parts(data, is_drive=self.is_drive(node_id))
            if base == ERROR_CONTROL and len(data) == 1:
                state = data[0] & 0x7F
                return (Part("state", "", data[0], NMT_STATES.get(state, f"state {state}")),)
            if base in (SDO_REQUEST, SDO_RESPONSE):
                return sdo_parts(self.dictionary(node_id), data, is_request=base == SDO_REQUEST)
        return frame_parts(frame)

    def dictionary(self, node_id: int) -> Dictionary | None:
        """Return the dictionary that names the objects of a node; None if there is none."""
        return self._known.get(node_id)

    def describe(self, node_id: int, dictionary: Dictionary) -> None:
        """Name the objects of a node without an EDS as this dictionary does, from now on."""
        self._known[node_id] = dictionary
        self._pdos.forget_texts()

    def wants(self) -> Mapping[str, Sequence[str]]:
        return {self.name(node_id): keys for node_id, keys in self._pdos.parameters().items()}

    def learn(self, device: str, values: Mapping[str, Any]) -> None:
        for node_id, node in self._nodes.items():
            if node.name == device:
                self._pdos.learn(node_id, values)

    def name(self, node_id: int) -> str:
        """Return the name of a node in the rig, or `node 5`."""
        node = self._nodes.get(node_id)
        return f"node {node_id}" if node is None else node.name

    def is_drive(self, node_id: int) -> bool:
        """True if the dictionary of a node says that it is a drive."""
        dictionary = self._known.get(node_id)
        return dictionary is not None and is_drive(dictionary)

    def _by_identifier(self, frame: CanFrame) -> Named:
        identifier, data = frame.identifier, frame.data
        base, node_id = identifier & 0x780, identifier & 0x7F
        match identifier:
            case 0x000:
                return self._nmt(data)
            case 0x080:
                return Named("SYNC", "", f"counter {data[0]}" if data else "")
            case 0x100:
                return Named("TIME", "", _time(data))
            case 0x7E5 | 0x7E4:
                is_request = identifier == LSS_MASTER
                return Named(f"LSS {'request' if is_request else 'answer'}", "", lss_words(data, is_request=is_request))
        if node_id in NODES:
            match base:
                case 0x080:
                    return Named("EMCY", self.name(node_id), emcy_words(data, is_drive=self.is_drive(node_id)))
                case 0x700:
                    return Named(*_error_control(frame, self.name(node_id)))
                case 0x600 | 0x580 if not frame.is_remote:
                    kind, text = self._sdo.named(node_id, data, is_request=base == SDO_REQUEST)
                    return Named(kind, self.name(node_id), text)
        return Named("", "", show(frame))

    def _nmt(self, data: bytes) -> Named:
        if len(data) != 2:
            return Named("NMT", "", f"{data.hex(' ').upper()} (expected two bytes)")
        command = NMT_COMMANDS.get(data[0], f"command {data[0]}")
        return Named("NMT", self.name(data[1]) if data[1] else "", f"{command}{'' if data[1] else ' all nodes'}")


def _is_object(dictionary: Dictionary | None, index: int, subindex: int) -> bool:
    """Return whether what is mapped is an object; the others are dummies, which nothing means."""
    return dictionary is None or dictionary.get(index, subindex) is not None


def _error_control(frame: CanFrame, name: str) -> tuple[str, str, str]:
    if frame.is_remote:
        return "guarding request", name, ""
    if len(frame.data) != 1:
        return "heartbeat", name, frame.data.hex(" ").upper()
    state = frame.data[0] & 0x7F
    kind = "boot-up" if frame.data[0] == 0 else "heartbeat"
    return kind, name, NMT_STATES.get(state, f"state {state}") if kind == "heartbeat" else ""


def _time(data: bytes) -> str:
    """Return TIME_OF_DAY (7.1.6.5) as a date: days since 1 January 1984, and milliseconds after midnight."""
    if len(data) != 6:
        return data.hex(" ").upper()
    milliseconds = int.from_bytes(data[:4], "little") & 0x0FFF_FFFF
    instant = FIRST_DAY + timedelta(days=int.from_bytes(data[4:], "little"), milliseconds=milliseconds)
    return instant.isoformat(" ", "milliseconds")


def namer(bus: Bus[Any], members: Sequence[Member]) -> Namer:
    """Return the namer of a CAN bus with these devices."""
    nodes: dict[int, KnownNode] = {}
    for member in members:
        for claim in member.claims("node-ID"):
            if isinstance(claim.value, int):
                nodes.setdefault(claim.value, KnownNode(member.entry.name, _dictionary(member, claim.value)))
    return CanopenNames(nodes)


def _dictionary(member: Member, node_id: int) -> Dictionary | None:
    """Return the dictionary that the EDS of a node describes, with the values of the rig file; None without an EDS."""
    settings = member.entry.settings
    if isinstance(settings, CanopenSettings) and settings.node_id == node_id:
        return settings.dictionary()
    for node in nodes_of(settings):
        if node.node_id == node_id:
            dictionary = load(node.eds, node_id)
            for key, value in node.objects.items():
                dictionary.by_key(key).put(value)
            return dictionary
    return None
