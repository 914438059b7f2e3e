"""A CANopen master: boots its slaves, supervises them, and exchanges PDOs with them.

Source: CiA 301 and CiA 302-2.  COB-IDs are those of the predefined connection set.  Received PDOs become visible by
`take`, and changed values are sent by `give`, so the owner decides when values change.
Left out: dynamic PDO linking, node guarding, identity checks, LSS.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, Protocol

from fieldrig.clock import MS, Clock, Timer
from fieldrig.link import Link
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.managed_slave import ManagedSlave, Presence
from fieldrig_devices.canopen.master_settings import CanMasterSettings, CanNodeSettings
from fieldrig_devices.canopen.nmt import BOOT_UP, ERROR_CONTROL_ID
from fieldrig_devices.canopen.service import State
from fieldrig_devices.registers.packed import Element, Packed

SYNC_ID: Final = 0x80
EMCY_ID, EMCY_SIZE = 0x80, 8
TPDO_ID, RPDO_ID, PDO_STEP = 0x180, 0x200, 0x100
OPERATIONAL: Final = bytes((State.OPERATIONAL,))

Pack = Callable[[Sequence[Element], bool], Packed]
"""Returns the values of a PDO, which the master sends if the second argument is true."""


class Reporter(Protocol):
    """The owner of a master, which learns what happens to its slaves."""

    def on_lost(self, slave: "MasterSlave") -> None:
        """Called when a slave is lost."""

    def on_back(self, slave: "MasterSlave") -> None:
        """Called when a lost slave has been started again."""

    def on_emergency(self, slave: "MasterSlave", code: int, register: int) -> None:
        """Called with the error code and the error register of an emergency message."""


class CanopenMaster:
    """The master of one controller, from `boot` to `stop`."""

    def __init__(self, clock: Clock, can: Link[CanFrame], settings: CanMasterSettings, reporter: Reporter) -> None:
        self._clock, self._settings = clock, settings
        shared = SharedLink(can)
        self._can = shared.share()
        self.nodes: Mapping[str, MasterSlave] = {
            name: MasterSlave(clock, shared, name, node, reporter) for name, node in settings.nodes.items()
        }
        self._timers: dict[int, Timer] = {}

    def boot(self) -> None:
        """Start the slaves, SYNC and the heartbeat."""
        settings, own_id = self._settings, ERROR_CONTROL_ID + self._settings.node_id
        if settings.heartbeat_ms:
            self._can.send(CanFrame(own_id, BOOT_UP))
        for slave in self.nodes.values():
            slave.boot()
        self._repeat(CanFrame(own_id, OPERATIONAL), settings.heartbeat_ms)
        self._repeat(CanFrame(SYNC_ID, b""), settings.sync_ms)

    def stop(self) -> None:
        """Stop sending."""
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()
        for slave in self.nodes.values():
            slave.stop()

    def _repeat(self, frame: CanFrame, every_ms: int) -> None:
        """Send a frame periodically, for the first time after one period."""
        if not every_ms:
            return

        def again() -> None:
            self._can.send(frame)
            self._repeat(frame, every_ms)

        self._timers[frame.identifier] = self._clock.call_at(self._clock.now_ns() + every_ms * MS, again)


class MasterSlave:
    """One slave with the values of its PDOs."""

    def __init__(
        self, clock: Clock, shared: SharedLink, name: str, settings: CanNodeSettings, reporter: Reporter
    ) -> None:
        self.name, self._settings, self._reporter = name, settings, reporter
        self._can = shared.share()
        self.node = ManagedSlave(
            clock,
            shared.share(),
            settings.node_id,
            settings.heartbeat_ms,
            self._on_lost,
            self._on_back,
            configuration=settings.configuration(),
            limit_ms=settings.limit_ms,
        )
        self._inputs: dict[int, Packed] = {}
        self._outputs: dict[int, Packed] = {}
        """Values by COB-ID."""
        self._heard: dict[int, bytes] = {}
        self._sent: dict[int, bytes] = {}
        self._is_lost = self._is_zeroed = False
        self.losses = 0
        self._hears: dict[int, Callable[[CanFrame], None]] = {EMCY_ID + settings.node_id: self._on_emergency}
        for number in settings.inputs:
            self._hears[self._cob_id(TPDO_ID, number)] = self._on_pdo
        self._can.on_receive(self._on_frame, [[cob_id, EXTENDED_KEY | STANDARD_MASK] for cob_id in self._hears])

    def use(self, pack: Pack) -> None:
        """Exchange PDOs with these values from now on."""
        settings = self._settings
        self._inputs = {
            self._cob_id(TPDO_ID, number): pack(elements, False) for number, elements in settings.inputs.items()
        }
        self._outputs = {
            self._cob_id(RPDO_ID, number): pack(elements, True) for number, elements in settings.outputs.items()
        }

    def boot(self) -> None:
        self.losses, self._is_lost, self._is_zeroed = 0, False, False
        self._heard.clear()
        self._sent.clear()
        self.node.start()

    def stop(self) -> None:
        self.node.stop()

    # ---- values

    def take(self) -> None:
        """Put what has been received into the controller."""
        if self._is_zeroed:
            self._is_zeroed = False
            for data in self._inputs.values():
                data.clear()
        for cob_id, received in self._heard.items():
            self._inputs[cob_id].unpack(received)
        self._heard.clear()

    def give(self) -> None:
        """Send what has changed in the controller."""
        if not self.node.is_running:
            return
        for cob_id, data in self._outputs.items():
            packed = data.packed()
            if packed != self._sent.get(cob_id):
                self._sent[cob_id] = packed
                self._can.send(CanFrame(cob_id, packed))

    # ---- events of the slave

    def _on_lost(self) -> None:
        self._is_lost = True
        self.losses += 1
        self._heard.clear()
        self._is_zeroed = self._settings.lost_inputs == "zero"
        self._reporter.on_lost(self)

    def _on_back(self) -> None:
        self._sent.clear()
        if self._is_lost:
            self._is_lost = False
            self._reporter.on_back(self)
        if self._settings.ask:
            for cob_id in self._inputs:
                self._can.send(CanFrame(cob_id, is_remote=True))

    def _on_frame(self, frame: CanFrame) -> None:
        if self.node.presence is not Presence.OFF and not frame.is_remote:
            self._hears[frame.identifier](frame)

    def _on_pdo(self, frame: CanFrame) -> None:
        if self.node.is_running:
            self._heard[frame.identifier] = frame.data

    def _on_emergency(self, frame: CanFrame) -> None:
        if len(frame.data) == EMCY_SIZE:
            self._reporter.on_emergency(self, int.from_bytes(frame.data[:2], "little"), frame.data[2])

    def _cob_id(self, first: int, number: int) -> int:
        return first + (number - 1) * PDO_STEP + self.node.node_id
