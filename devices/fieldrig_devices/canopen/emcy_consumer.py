"""EMCY consumer: the errors that other nodes report (1028h).

Source: CiA 301 7.2.7, 7.5.2.31.  Sub-index n is for node n.  What is heard is kept to be looked at and does nothing
else: which error of another node matters is the application's affair.
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
        """The last error heard: of which node, its code and register, what the manufacturer adds."""
        self._ears = [_Ear(port, entry, self) for entry in dictionary.members(CONSUMER)]

    def reset(self, scope: Reset) -> None:
        self.last = ""
        for ear in self._ears:
            ear.configure()


class _Ear:
    """One entry."""

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
