"""Which messages of a bus are meant: by identifier, node, service, code and the rest, as in `fieldrig trace show`.

The names of nodes and services are those of the rig file.  Only what asks for names pays for them: identifiers and
contents are compared without.
"""

from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, Final, TypeVar

from fieldrig.config.rig_file import RigConfig
from fieldrig.errors import ControlError
from fieldrig.faults.note import FaultNote
from fieldrig.text.nearest import closest, is_slip
from fieldrig.traces.names import Namer, members_of, namer_of
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.names import CanopenNames
from fieldrig_devices.modbus.names import ModbusNames
from fieldrig_devices.named_logs.can_rows import CanRows
from fieldrig_devices.named_logs.filters import Filter, identifiers_of
from fieldrig_devices.named_logs.modbus_rows import ModbusRows
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.named_logs.row import Row, row_of

Read = TypeVar("Read")
NAMED: Final = ("node", "service", "unit", "register", "text")
"""Keys that need the name of a message."""

_OF_FAMILIES: Final = (
    ("id", "can", "identifiers"),
    ("code", "can", "emergency messages"),
    ("unit", "modbus", "units"),
    ("register", "modbus", "registers"),
)
"""Keys that messages of one family of buses have, with the name of what they choose."""


class Messages:
    """Says of each message of a bus whether it is meant.  It reads them in their order."""

    def __init__(self, config: RigConfig, bus: str, words: Mapping[str, str]) -> None:
        """ControlError, with what was expected, for a bus, a node or a word that is wrong."""
        if bus not in config.buses:
            raise ControlError(f"the rig has no bus {bus!r}", closest(bus, list(config.buses)))
        self._bus, self._words = config.buses[bus].bus, words
        try:
            self._ids = identifiers_of(words["id"]) if "id" in words else None
            self._code = _read(words, "code", lambda text: int(text, 0), "expected a number such as code=0x8611")
            self._data = _read(words, "data", bytes.fromhex, 'expected hex digits such as data="10 43"')
            self._filter = _filter_of(config, words)
        except ValueError as wrong:
            what, _, remedy = str(wrong).partition("\n")
            raise ControlError(f"{bus}: {what}", remedy or "expected one such as id=0x181 or id=0x180-0x1FF") from wrong
        family = self._bus.family
        for key, wanted, about in _OF_FAMILIES:
            if key in words and family != wanted:
                raise ControlError(f"{bus} has no {about}: it is a bus of {family}", f"expected a bus of {wanted}")
        names = [member.entry.name for member in members_of(config, bus)]
        node = words.get("node", "*")
        if not node.isdigit() and not any(fnmatchcase(name, node) for name in names):
            raise ControlError(f"{bus} has no node {node!r}", closest(node, names))
        _check_sender(config, bus, words.get("sender", "*"), names)
        needs_names = any(key in words for key in NAMED)
        self._namer: Namer | None = namer_of(config, bus) if needs_names or self._code is not None else None
        self._rows = _rows_of(self._namer)

    def has(self, sender: str, message: Any) -> bool:
        """Return whether a message is meant."""
        if isinstance(message, FaultNote) or not fnmatchcase(sender, self._words.get("sender", "*")):
            return False
        if not (self._has_identifier(message) and self._has_data(message)):
            return False
        if self._namer is None:
            return True
        row = self._row(sender, message)
        if self._code is not None and not self._has_code(row, message):
            return False
        return self._filter.takes(row) and fnmatchcase(row.words, self._words.get("text", "*"))

    def _has_identifier(self, message: Any) -> bool:
        if self._ids is None:
            return True
        if not isinstance(message, CanFrame):
            return False
        first, last, mask = self._ids
        return first <= (message.identifier | (EXTENDED_KEY if message.is_extended else 0)) & mask <= last

    def _has_data(self, message: Any) -> bool:
        """Return whether its content begins with the bytes that were given."""
        if self._data is None:
            return True
        content = message.pdu if isinstance(message, ModbusRequest | ModbusResponse) else message
        content = getattr(content, "data", content)
        if not isinstance(content, bytes):
            content = self._bus.encode(message)
        return bytes(content).startswith(self._data)

    def _has_code(self, row: Row, message: Any) -> bool:
        """Return whether it is an emergency message with the code (CiA 301, 7.2.7.3.1)."""
        return "emcy" in row.services and int.from_bytes(message.data[:2], "little") == self._code

    def _row(self, sender: str, message: Any) -> Row:
        entry = TraceEntry(0, self._bus.name, self._bus.family, sender, self._bus.encode(message))
        if self._rows is not None:
            return self._rows.row(0, entry)
        assert self._namer is not None
        named = self._namer(message, sender)
        return row_of(0, entry, ("other",), named.kind, named.node, named.text)


def _check_sender(config: RigConfig, bus: str, sender: str, members: Sequence[str]) -> None:
    """ControlError for a device that is not on the bus, or a name that is nearly one there; others may join the bus."""
    if sender not in members and (sender in config.devices or any(is_slip(sender, name) for name in members)):
        raise ControlError(f"{bus} has no sender {sender!r}", closest(sender, members))


def _rows_of(namer: Namer | None) -> CanRows | ModbusRows | None:
    if isinstance(namer, CanopenNames):
        return CanRows(namer)
    return ModbusRows(namer) if isinstance(namer, ModbusNames) else None


def _read(words: Mapping[str, str], key: str, read: Callable[[str], Read], remedy: str) -> Read | None:
    """Return the value of a key, if it is given.  ValueError, with the remedy in its second line."""
    if key not in words:
        return None
    try:
        return read(words[key])
    except ValueError as wrong:
        raise ValueError(f"{key} cannot be {words[key]!r}\n{remedy}") from wrong


def _filter_of(config: RigConfig, words: Mapping[str, str]) -> Filter:
    def given(key: str) -> tuple[str, ...]:
        return (words[key],) if key in words else ()

    return Filter(given("node"), (), given("unit"), given("register"), given("service"), NamedLog(config=config).tables)
