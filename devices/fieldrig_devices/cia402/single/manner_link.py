"""The end of the bus of a drive with habits: how it boots, how fast it answers, and what it misses.

Source: docs/devices/drive-personalities.md; CiA 301 for the frames: boot-up and heartbeat at 700h + node-ID, SDO at
580h and 600h + node-ID, NMT at 0.  Only one node uses this end, so the upper bits of an identifier say what a frame is.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

from fieldrig.clock import MS, Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.cia402.single.personality import PersonalitySettings
from fieldrig_devices.cia402.single.sync_watch import SyncWatch

FUNCTION: Final = 0x780
"""The bits of an identifier that are not the node-ID."""
NMT, SYNC, ANSWER, REQUEST, ERROR_CONTROL = 0x000, 0x080, 0x580, 0x600, 0x700
RESET_NODE: Final = 0x81
GOLDEN: Final = 0.618034
PRE_OPERATIONAL: Final = b"\x7f"
SAVE: Final = (b"\x23\x10\x10", b"save")
"""A request that saves: a download of 4 bytes to 1010h, and the signature behind the sub-index (CiA 301, 7.5.2.13)."""


class MannerLink:
    """Stands between the node and its link."""

    def __init__(self, clock: Clock, link: Link[CanFrame], manner: PersonalitySettings, node_id: int) -> None:
        self._clock, self._link, self._manner, self._node_id = clock, link, manner, node_id
        self._share = 0.0
        """Place of the last answer time between its limits, from 0 to 1."""
        self._absent_until_ns = self._answered_ns = 0
        self._is_saving = self._has_lost = False
        self._is_reset = not manner.needs_reset_node
        self.sync_watch: SyncWatch | None = None

    def send(self, message: Any) -> None:
        """Send what the node sends, later or not at all."""
        if not isinstance(message, CanFrame):
            self._link.send(message)
            return
        now_ns, function = self._clock.now_ns(), message.identifier & FUNCTION
        if function == ERROR_CONTROL and message.data == b"\0":
            self._boot(message)
        elif function == ANSWER:
            self._answer(message)
        elif now_ns >= self._absent_until_ns:
            self._link.send(message)

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        """Call `handler` with what the drive hears."""
        self._link.on_receive(partial(self._hear, handler), interest)

    def _boot(self, message: CanFrame) -> None:
        self._has_lost, self._absent_until_ns = False, 0
        self._link.send(message)
        if self._manner.says_preoperational:
            self._link.send(CanFrame(message.identifier, PRE_OPERATIONAL))

    def _answer(self, message: CanFrame) -> None:
        manner, now_ns = self._manner, self._clock.now_ns()
        delay_ms = manner.sdo_answer_ms
        if manner.sdo_answer_most_ms > delay_ms:
            self._share = (self._share + GOLDEN) % 1  # spreads evenly, and is the same in each run
            delay_ms += (manner.sdo_answer_most_ms - delay_ms) * self._share
        if self._is_saving:
            delay_ms = max(manner.save_ms, delay_ms)
            self._is_saving = False
            if manner.silent_while_saving:
                self._absent_until_ns = now_ns + round(delay_ms * MS)
        if not delay_ms:
            self._link.send(message)
            return
        self._answered_ns = max(self._answered_ns, now_ns + round(delay_ms * MS))  # answers keep their order
        self._clock.call_at(self._answered_ns, partial(self._link.send, message))

    def _hear(self, handler: Callable[[Any], None], message: Any) -> None:
        if not isinstance(message, CanFrame):
            handler(message)
            return
        if self._clock.now_ns() < self._absent_until_ns:
            return
        if message.identifier == NMT and not self._is_reset and not self._takes_reset(message.data):
            return
        if message.identifier == SYNC and self.sync_watch is not None:
            self.sync_watch.on_sync()
        if message.identifier & FUNCTION == REQUEST:
            if self._manner.loses_first_sdo and not self._has_lost:
                self._has_lost = True
                return
            self._is_saving = message.data[3:4] != b"\0" and (message.data[:3], message.data[4:]) == SAVE
        handler(message)

    def _takes_reset(self, data: bytes) -> bool:
        """True if this is the reset of the node that it waits for."""
        self._is_reset = len(data) == 2 and data[0] == RESET_NODE and data[1] in (0, self._node_id)
        return self._is_reset
