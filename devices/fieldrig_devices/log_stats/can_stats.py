"""The statistics of one CAN bus: by identifier and by node, with the load by second."""

from collections import Counter
from typing import Any, Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, CanError
from fieldrig_devices.canopen.emcy_words import emcy_words
from fieldrig_devices.canopen.names import EMCY, ERROR_CONTROL, NMT, NODES, SDO_REQUEST, SDO_RESPONSE, CanopenNames
from fieldrig_devices.dialogues import Dialogue, SdoDialogues, SdoTransfer, Stray
from fieldrig_devices.log_stats.answers import Answers
from fieldrig_devices.log_stats.load import Load
from fieldrig_devices.log_stats.series import Series
from fieldrig_devices.named_logs.heartbeats import Heartbeats

MOST_IDENTIFIERS: Final = 5_000
"""Identifiers that are distinguished; a bus with 11 bits has 2048."""
SERVICES: Final = {SDO_RESPONSE: "SDO answer", SDO_REQUEST: "SDO request", ERROR_CONTROL: "heartbeat"}
"""The services of identifiers whose single messages are called otherwise."""
MOST_CODES: Final = 100
"""Different emergency messages that are distinguished."""


class NodeStats:
    """The figures of one node."""

    def __init__(self) -> None:
        self.frames = self.boot_ups = self.losses = 0
        self.emergencies: Counter[str] = Counter()
        self.sdo = Answers()

    def as_data(self) -> dict[str, Any]:
        return {
            "frames": self.frames,
            "boot_ups": self.boot_ups,
            "heartbeats_missing": self.losses,
            "emergencies": dict(self.emergencies.most_common()),
            "sdo": self.sdo.as_data(),
        }


class CanStats:
    """Counts the messages of one bus."""

    def __init__(self, names: CanopenNames, bitrate: int, data_bitrate: int) -> None:
        self.names, self.bitrate = names, bitrate
        self.load = Load(bitrate, data_bitrate)
        self.identifiers: dict[int, Series] = {}
        """The frames of each identifier; bit 31 marks one of 29 bits."""
        self.nodes: dict[int, NodeStats] = {}
        self.errors: Counter[str] = Counter()
        self.others = 0
        """Frames whose identifiers are beyond the bound."""
        self._samples: dict[int, CanFrame] = {}
        self._sdo, self._heartbeats = SdoDialogues(), Heartbeats()
        self._is_begun = False

    def take(self, number: int, entry: TraceEntry) -> None:
        try:
            message = decode(entry.data)
        except ValueError:
            self.errors["bytes that are no frame"] += 1
            return
        if not isinstance(message, CanFrame):
            self._count_notice(message)
            return
        key = message.identifier | EXTENDED if message.is_extended else message.identifier
        self._count(key, message, entry.time_ns)
        if entry.time_ns >= self._heartbeats.next_ns:
            for loss in self._heartbeats.missing(entry.time_ns):
                self.node(loss.node_id).losses += 1
        if not message.is_extended and message.identifier & 0x7F in NODES:
            self._count_service(message, entry.time_ns)
        if not self._is_begun:
            self._is_begun = True
            self._sdo.describe(entry.bus, self.names.dictionaries)
        for dialogue in self._sdo.take(number, entry):
            self._end(dialogue, message.identifier & 0x7F)

    def close(self) -> None:
        """Count what is open at the end of the log."""
        for dialogue in self._sdo.unfinished():
            self._end(dialogue, 0)

    def node(self, node_id: int) -> NodeStats:
        return self.nodes.setdefault(node_id, NodeStats())

    def label(self, key: int) -> tuple[str, str]:
        """Return service and node of an identifier, as far as they are known."""
        sample = self._samples[key]
        if not sample.is_extended:
            if sample.identifier == NMT:
                return "NMT", ""
            service, node_id = SERVICES.get(sample.identifier & 0x780), sample.identifier & 0x7F
            if service is not None and node_id in NODES:
                return service, self.names.name(node_id)
        named = self.names(sample)
        return named.kind, named.node

    def _count(self, key: int, frame: CanFrame, time_ns: int) -> None:
        series = self.identifiers.get(key)
        if series is None:
            if len(self.identifiers) >= MOST_IDENTIFIERS:
                self.others += 1
                return
            series = self.identifiers[key] = Series()
        if key not in self._samples or frame.data:
            self._samples[key] = frame
        series.add(time_ns, len(frame.data))
        self.load.add(time_ns, frame)

    def _count_service(self, frame: CanFrame, time_ns: int) -> None:
        base, node_id = frame.identifier & 0x780, frame.identifier & 0x7F
        producer = self.names.sender_of(frame)
        if producer is not None:
            self.node(producer).frames += 1
        if base == ERROR_CONTROL:
            self._count_heartbeat(frame, node_id, time_ns)
        elif base == EMCY:
            words = emcy_words(frame.data, is_drive=self.names.is_drive(node_id))
            emergencies = self.node(node_id).emergencies
            if words in emergencies or len(emergencies) < MOST_CODES:
                emergencies[words] += 1

    def _count_heartbeat(self, frame: CanFrame, node_id: int, time_ns: int) -> None:
        if frame.is_remote:
            self.node(node_id).losses += self._heartbeats.guarded(node_id, time_ns) is not None
        elif len(frame.data) == 1:
            self.node(node_id).boot_ups += frame.data[0] == 0
            self._heartbeats.heard(node_id, time_ns, frame.data[0] & 0x7F)

    def _count_notice(self, message: Any) -> None:
        if isinstance(message, CanError):
            self.errors[f"{message.kind.name.lower().replace('_', ' ')} error"] += 1
        elif isinstance(message, BusState):
            self.errors[f"controller is {message.state.name.lower().replace('_', ' ')}"] += 1

    def _end(self, dialogue: Dialogue, node_id: int) -> None:
        if isinstance(dialogue, Stray):
            self.node(node_id).sdo.strays += 1
        elif isinstance(dialogue, SdoTransfer):
            self.node(dialogue.node_id).sdo.take_sdo(dialogue)
            self.names.take(dialogue)
            self._heartbeats.take(dialogue)
