"""EMCY consumer: the errors that other nodes report (1028h).

Source: CiA 301 7.2.7, 7.5.2.31.  Sub-index n belongs to node n.  A received error is only kept for inspection: the
application decides which errors of other nodes matter.
"""

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.cob_id import can_key, guard, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import Object, Reset, Service
from fieldrig_devices.canopen.variable import Variable

CONSUMER = 0x1028
SIZE = 8


class EmcyConsumer(Service):
    def __init__(self, port: Port, dictionary: Dictionary) -> None:
        self.last = ""
        """The last error received, as text: node, error code, error register and manufacturer-specific bytes."""
        self._receivers = [_Receiver(port, entry, self) for entry in dictionary.members(CONSUMER)]

    def reset(self, scope: Reset) -> None:
        self.last = ""
        for receiver in self._receivers:
            receiver.configure()


class _Receiver:
    """The receiver of one entry of 1028h."""

    def __init__(self, port: Port, entry: Variable, consumer: EmcyConsumer) -> None:
        self._port, self._entry, self._consumer = port, entry, consumer
        guard(entry)
        entry.watchers.append(self.configure)

    def configure(self) -> None:
        cob_id = self._entry.number
        self._port.listen(self, Object.EMCY, can_key(cob_id) if is_valid(cob_id) else None, self._on_frame)

    def _on_frame(self, frame: CanFrame) -> None:
        if frame.is_remote or len(frame.data) != SIZE:
            return
        data = frame.data
        code = int.from_bytes(data[:2], "little")
        self._consumer.last = f"node {self._entry.subindex}: {code:04X}h, register {data[2]:02X}h, {data[3:].hex(' ')}"
