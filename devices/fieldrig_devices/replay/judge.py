"""The comparison of what a rig sends with what a log expects of it.

Messages that are no answers (PDOs, EMCY, bytes of a line) are aligned stream by stream.  Answers are compared by
dialogue: an SDO transfer or a Modbus exchange of the log with that of the rig, whatever frames it took.  Heartbeats
are compared by state and period, because the instant at which a device was switched on says nothing.
"""

from operator import attrgetter
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_bus.can.notices import NOTICE
from fieldrig_bus.modbus.codec import REQUEST, REQUEST_ON_ASCII
from fieldrig_devices.canopen.names import ERROR_CONTROL, NODES
from fieldrig_devices.replay.families import COMPARED
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.heartbeats import Heartbeats
from fieldrig_devices.replay.log_names import LogNames
from fieldrig_devices.replay.modbus_answers import ModbusAnswers
from fieldrig_devices.replay.replay_result import ReplayResult
from fieldrig_devices.replay.sdo_answers import SdoAnswers
from fieldrig_devices.replay.streams import Streams
from fieldrig_devices.replay.tolerances import Tolerances
from fieldrig_devices.replay.unasked import Unasked

NOTHING_EXPECTED: Final = "the log has no message of the rig's devices, so nothing is compared"
HEAD_OF_FRAME: Final = 5


class Judge(Grounds):
    """Compares.  All instants are of the rig's clock, and all buses are called as in the rig."""

    def __init__(self, names: tuple[LogNames, LogNames], tolerances: Tolerances, result: ReplayResult) -> None:
        """`names` are those of the log and of the rig: each follows the mappings of its own side."""
        super().__init__(names, tolerances, result)
        self.expected = 0
        """Messages of the log that the rig was expected to send."""
        self._places = (Streams(), Streams())
        self.unasked = Unasked(self)
        self.sdo = SdoAnswers(self)
        self.modbus = ModbusAnswers(self)
        self._heartbeats = Heartbeats(self)

    # what comes

    def expect(self, entry: TraceEntry, log_ns: int) -> None:
        """Take a message of the log that the rig is expected to send at its instant.

        `log_ns` is the instant without the time that was spent waiting; heartbeats go by it.
        """
        self.expected += 1
        self.buses.add(entry.bus)
        self._take(0, entry, log_ns)

    def heard(self, entry: TraceEntry) -> None:
        """Take a message that a device of the rig has sent."""
        self._take(1, entry, entry.time_ns)

    def played(self, entry: TraceEntry) -> None:
        """Take a message of the log that was sent to the rig: both sides learn from it."""
        self.buses.add(entry.bus)
        if entry.family == "can":
            self.unasked.played(entry)
            for side in (0, 1):
                self._learn(side, entry)

    def settle(self, now_ns: int) -> None:
        """Decide what can be decided when everything up to this instant is there."""
        self.unasked.settle(now_ns)

    def finish(self, end_ns: int) -> None:
        """Decide everything; what the rig sent after `end_ns` is more than the log knows of."""
        self.unasked.finish(end_ns)
        if not self.expected:
            self.result.forget(NOTHING_EXPECTED)
            return
        self._heartbeats.finish(end_ns)
        self.sdo.finish()
        self.modbus.finish(end_ns)
        self.runs.finish()
        self.unasked.tell_rest()
        self.result.differences.sort(key=attrgetter("time_ns"))

    def _take(self, side: int, entry: TraceEntry, own_ns: int) -> None:
        if entry.family not in COMPARED:
            return
        if entry.family == "can":
            if self.sdo.take(side, entry):
                self._learn(side, entry)
                return
            word = int.from_bytes(entry.data[:4], "little")
            if word & ~EXTENDED_MASK == NOTICE:
                return  # errors and injected faults are no messages of a device
            if word - ERROR_CONTROL in NODES and not word & REMOTE and len(entry.data) == HEAD_OF_FRAME + 1:
                self._heartbeats.take(side, word - ERROR_CONTROL, entry, own_ns)
                return
        elif entry.family == "modbus" and not REQUEST <= entry.data[0] <= REQUEST_ON_ASCII:
            return  # answers are taken by their exchange
        self.unasked.take(side, entry, own_ns)

    def _learn(self, side: int, entry: TraceEntry) -> None:
        stream, item = self._places[side].place(0, entry)
        self.names[side].note(stream, item)
