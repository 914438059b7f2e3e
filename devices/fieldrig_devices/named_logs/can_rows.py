"""The messages of one CAN bus as rows: CANopen by name, and any other frame as it is."""

from collections.abc import Iterator
from functools import cache, partial
from typing import Any, Final

from fieldrig.traces.instants import instant, span
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import REMOTE
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.traces.can_fields import fields_of
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.io_names import PROFILE as IO_MODULES
from fieldrig_devices.canopen.io_names import IoDictionary
from fieldrig_devices.canopen.names import NODES, SDO_REQUEST, SDO_RESPONSE, CanopenNames
from fieldrig_devices.canopen.standard_names import StandardDictionary
from fieldrig_devices.dialogues import SdoTransfer
from fieldrig_devices.drive_profile.objects import PROFILE as DRIVES
from fieldrig_devices.named_logs.heartbeats import Heartbeats, Loss
from fieldrig_devices.named_logs.row import Row, row_of

SERVICES: Final = {
    "NMT": ("nmt",), "SYNC": ("sync",), "TIME": ("time",), "EMCY": ("emcy",), "SDO": ("sdo",),
    "boot-up": ("heartbeat", "boot-up"), "heartbeat": ("heartbeat",), "guarding request": ("guarding",),
    "LSS request": ("lss",), "LSS answer": ("lss",),
}  # fmt: skip
PDO: Final = {"T": ("pdo", "tpdo"), "R": ("pdo", "rpdo")}
"""Services by the first letter of the kind of a PDO."""
OF_ONE_NODE: Final = frozenset({"EMCY", "boot-up", "heartbeat", "guarding request"})
"""Services whose identifiers end in a node-ID, besides SDO."""
DEVICE_TYPE: Final = 0x1000
STANDARD: Final = StandardDictionary()
ERROR_CONTROL: Final = 0x700


class CanRows:
    """Makes the rows of one bus."""

    def __init__(self, names: CanopenNames, *, has_values: bool = False) -> None:
        """The rows of frames have their values one by one if `has_values`, for scripts."""
        self.names, self._has_values = names, has_values
        self._heartbeats = Heartbeats()
        self._described: set[int] = set(names.nodes)
        self._last: tuple[str, str] = ("", "can")

    def row(self, number: int, entry: TraceEntry) -> Row:
        """Return the row of a single frame."""
        row = self.pdo(number, entry)
        return self.any_row(number, entry) if row is None else row

    def pdo(self, number: int, entry: TraceEntry) -> Row | None:
        """Return the row of a PDO without making a frame, as `any_row` does in twice the time; None for all others."""
        fields = None if self._has_values else fields_of(entry.data)
        if fields is None or fields.is_fd or fields.word & (REMOTE | ERROR):
            return None
        found = self.names.pdo(fields.word, fields.data)
        if found is None:
            return None
        node_id, kind, text = found
        return Row(
            entry.time_ns, entry.bus, entry.family, entry.sender, PDO[kind[0]], kind, self.names.name(node_id), text,
            (number,), None, entry.data, (node_id,), (fields.word,),
        )  # fmt: skip

    def any_row(self, number: int, entry: TraceEntry) -> Row:
        """Return the row of a frame or notice of any kind."""
        try:
            message = decode(entry.data)
        except ValueError:
            return row_of(number, entry, ("other",), "", "", entry.data.hex(" "))
        if not isinstance(message, CanFrame):
            named = self.names(message, entry.sender)
            return row_of(number, entry, ("error",), named.kind, named.node, named.text)
        if message.identifier & 0x780 in (SDO_REQUEST, SDO_RESPONSE):
            self.meet(message.identifier & 0x7F)
        named = self.names(message, entry.sender)
        row = row_of(number, entry, _services(named.kind), named.kind, named.node, named.text)
        row.node_ids = self._nodes_of(message, named.kind)
        row.identifiers = (message.identifier | EXTENDED_KEY if message.is_extended else message.identifier,)
        if self._has_values:
            row.details = partial(dict, values=self._values(message))
        return row

    def _values(self, frame: CanFrame) -> list[dict[str, Any]]:
        """Return the values as they are now; a later mapping may be another one."""
        parts = self.names.parts(frame)
        values = () if parts is None else parts.values
        return [{"key": part.key, "name": part.name, "value": part.value, "text": part.text} for part in values]

    @property
    def next_loss_ns(self) -> int:
        """The instant from which some heartbeat is missing."""
        return self._heartbeats.next_ns

    def losses(self, entry: TraceEntry) -> Iterator[Row]:
        """Yield the heartbeats that a message shows to have stayed out before it."""
        self._last = entry.bus, entry.family
        yield from map(self._loss, self._heartbeats.missing(entry.time_ns))

    def heard(self, row: Row) -> Row | None:
        """Take a heartbeat or a guarding request, and return the loss that it shows, or its end, if there is one."""
        if row.services[0] == "heartbeat" and row.data is not None and row.node_ids:
            self._last = row.bus, row.family
            state = row.data[-1] & 0x7F if row.kind == "heartbeat" else 0
            back = self._heartbeats.heard(row.node_ids[0], row.time_ns, state)
            return None if back is None else self._loss(back)
        if row.services[0] == "guarding" and row.node_ids:
            self._last = row.bus, row.family
            loss = self._heartbeats.guarded(row.node_ids[0], row.time_ns)
            return None if loss is None else self._loss(loss)
        return None

    def take(self, transfer: SdoTransfer) -> None:
        """Learn from a completed transfer."""
        self.meet(transfer.node_id)
        self.names.take(transfer)
        self._heartbeats.take(transfer)
        if not transfer.is_done or transfer.data is None or transfer.subindex:
            return
        number = int.from_bytes(transfer.data[:4], "little")
        if transfer.index == DEVICE_TYPE and number & 0xFFFF in PROFILES and self._is_standard(transfer.node_id):
            self.names.describe(transfer.node_id, PROFILES[number & 0xFFFF]())

    def meet(self, node_id: int) -> None:
        """Give a node without an EDS the names that every node has."""
        if node_id not in self._described:
            self._described.add(node_id)
            if self.names.dictionary(node_id) is None:
                self.names.describe(node_id, STANDARD)

    def _is_standard(self, node_id: int) -> bool:
        return self.names.dictionary(node_id) is STANDARD

    def _loss(self, loss: Loss) -> Row:
        what = "guarding" if loss.is_guarding else "heartbeat"
        if loss.is_back:
            kind, text = f"{what} back", f"after {span(loss.time_ns - loss.last_ns)}"
        elif loss.is_guarding:
            kind, text = "guarding unanswered", f"since the request of {instant(loss.last_ns)}"
        else:
            kind, text = "heartbeat missing", f"since {instant(loss.last_ns)}, expected every {span(loss.period_ns)}"
        details = {"since_ns": loss.last_ns, "period_ns": loss.period_ns}
        return Row(
            loss.time_ns, *self._last, "", (what, "loss"), kind, self.names.name(loss.node_id), text,
            node_ids=(loss.node_id,), identifiers=(ERROR_CONTROL + loss.node_id,), details=lambda: details,
        )  # fmt: skip

    def _nodes_of(self, frame: CanFrame, kind: str) -> tuple[int, ...]:
        if kind.startswith(("TPDO", "RPDO")):
            node_id = self.names.node_of_pdo(frame)
            return () if node_id is None else (node_id,)
        if kind == "NMT":
            return (frame.data[1],) if len(frame.data) == 2 and frame.data[1] else ()
        node_id = frame.identifier & 0x7F
        is_of_node = kind in OF_ONE_NODE or kind.startswith("SDO")
        return (node_id,) if is_of_node and node_id in NODES else ()


def _services(kind: str) -> tuple[str, ...]:
    if kind.startswith(("TPDO", "RPDO")):
        return PDO[kind[0]]
    return SERVICES.get(kind) or (("sdo",) if kind.startswith("SDO") else ("other",))


@cache
def _drive() -> Dictionary:
    """Return the names of the objects of CiA 402, as our drive has them."""
    from fieldrig_devices.canopen.eds.reader import load
    from fieldrig_devices.cia402.single.own_objects import EDS

    return StandardDictionary(load(EDS, 1))


@cache
def _io_module() -> Dictionary:
    return StandardDictionary(IoDictionary())


PROFILES: Final = {DRIVES: _drive, IO_MODULES: _io_module}
"""The names of the objects of nodes without an EDS, by the device profile that they say they have."""
