"""A slave that a master manages: configures it, starts it, supervises its heartbeat, and restarts it after a loss.

Source: CiA 302-2, 'boot NMT slave', in its simple form: the configuration is written by SDO, then the slave is started.
Left out: identity checks, node guarding, program download, and the reset of a slave that is still running (here it
becomes 'pre-operational' before it is configured, which doesn't affect its outputs).

    `start`, or a heartbeat of a lost slave               pre-operational, configuration, start
    boot-up message                                       configuration, start
    no answer                                             another attempt after `RETRY_NS`
    heartbeat with another state than 'operational'       start
    no heartbeat within the limit                         lost
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from functools import partial
from typing import Final

from fieldrig.clock import MS, Alarm, Clock, S
from fieldrig.link import Link
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.heartbeat import CONSUMER_TIME, PRODUCER_TIME
from fieldrig_devices.canopen.nmt import BOOT_UP, ERROR_CONTROL_ID, NMT_ID, Command
from fieldrig_devices.canopen.sdo.client import SdoClient
from fieldrig_devices.canopen.service import State

SDO_TIMEOUT_NS: Final = 500 * MS
RETRY_NS: Final = 1 * S
STATES: Final = {int(state): state for state in State}
TOGGLE: Final = 0x80
"""Toggle bit of node guarding; it is 0 in a heartbeat."""


@dataclass(frozen=True, slots=True)
class Write:
    """One object of a slave's configuration."""

    index: int
    subindex: int
    data: bytes


def watch_over(node_id: int, limit_ms: int) -> Write:
    """Return the write to 1016h:01h that lets a slave supervise the heartbeat of `node_id`, such as its master's."""
    return Write(CONSUMER_TIME, 1, (node_id << 16 | limit_ms).to_bytes(4, "little"))


class Presence(Enum):
    OFF = auto()
    """Not started."""
    CONFIGURING = auto()
    RUNNING = auto()
    ABSENT = auto()
    """The slave doesn't answer, or its heartbeat has stopped."""


class ManagedSlave:
    """The master's view of slave `node_id`.  `can` is a link of its own; `sdo` is its SDO client, for general use."""

    def __init__(
        self,
        clock: Clock,
        can: Link[CanFrame],
        node_id: int,
        heartbeat_ms: int,
        on_lost: Callable[[], None],
        on_back: Callable[[], None],
        *,
        configuration: Sequence[Write] = (),
        limit_ms: int | None = None,
        sdo_timeout_ns: int = SDO_TIMEOUT_NS,
    ) -> None:
        """`heartbeat_ms` is written to 1017h after `configuration`; with 0 there is no heartbeat and no supervision.

        The slave is lost after `limit_ms` without a heartbeat; the default is twice the heartbeat time.  `on_lost` is
        called once when the slave is lost, has rebooted, or doesn't answer after `start`; `on_back` is called each
        time that the slave has been started, including the first.
        """
        self._clock, self.node_id = clock, node_id
        self._on_lost, self._on_back = on_lost, on_back
        self._heartbeat = Write(PRODUCER_TIME, 0, heartbeat_ms.to_bytes(2, "little")) if heartbeat_ms else None
        self._configuration = (*configuration, *(() if self._heartbeat is None else (self._heartbeat,)))
        self._limit_ns = (2 * heartbeat_ms if limit_ms is None else limit_ms) * MS
        shared = SharedLink(can)
        self._can = shared.share()
        self.sdo = SdoClient(clock, shared.share(), node_id, sdo_timeout_ns)
        self._silence = Alarm(clock)
        self._retry = Alarm(clock)
        self._is_reported_lost = False
        self.presence = Presence.OFF
        self.state: State | None = None
        """NMT state of the last heartbeat."""
        self.refused: dict[Write, Abort] = {}
        """Writes that the slave refused in its last configuration; it is started nevertheless."""
        self._can.on_receive(self._on_frame, [[ERROR_CONTROL_ID + node_id, EXTENDED_KEY | STANDARD_MASK]])

    @property
    def is_running(self) -> bool:
        return self.presence is Presence.RUNNING

    def start(self) -> None:
        """Configure and start the slave, even if it is already running."""
        self._is_reported_lost = False
        self._boot()

    def stop(self) -> None:
        """End the supervision."""
        self._forget()
        self.presence = Presence.OFF

    def command(self, command: Command) -> None:
        """Send an NMT command to this slave only."""
        self._can.send(CanFrame(NMT_ID, bytes((command, self.node_id))))

    def _forget(self) -> None:
        self.sdo.cancel()
        self._silence.stop()
        self._retry.stop()

    def _boot(self) -> None:
        self.command(Command.ENTER_PRE_OPERATIONAL)
        self._configure()

    def _configure(self) -> None:
        self._forget()
        self.presence = Presence.CONFIGURING
        self.refused.clear()
        self._write(0)

    def _write(self, number: int) -> None:
        if number < len(self._configuration):
            write = self._configuration[number]
            self.sdo.download(write.index, write.subindex, write.data, partial(self._on_written, number))
        else:
            self._run()

    def _on_written(self, number: int, abort: Abort | None) -> None:
        if abort is not None and abort.code == Code.PROTOCOL_TIMED_OUT:
            self._lose()
            return
        if abort is not None:
            self.refused[self._configuration[number]] = abort
        self._write(number + 1)

    def _run(self) -> None:
        self.presence = Presence.RUNNING
        self.command(Command.START)
        if self._heartbeat is not None and self._heartbeat not in self.refused:
            self._watch()  # otherwise supervision starts with the first heartbeat
        self._is_reported_lost = False
        self._on_back()

    def _watch(self) -> None:
        if self._limit_ns:
            self._silence.after(self._limit_ns, self._lose)

    def _lose(self) -> None:
        self._forget()
        self.presence = Presence.ABSENT
        self.state = None
        self._retry.after(RETRY_NS, self._boot)
        self._report_lost()

    def _report_lost(self) -> None:
        if not self._is_reported_lost:
            self._is_reported_lost = True
            self._on_lost()

    def _on_frame(self, frame: CanFrame) -> None:
        if self.presence is Presence.OFF or frame.is_remote or len(frame.data) != 1:
            return
        if frame.data == BOOT_UP:
            self._on_boot_up()
        else:
            self._on_heartbeat(frame.data[0] & ~TOGGLE)

    def _on_boot_up(self) -> None:
        was_running, self.presence = self.is_running, Presence.CONFIGURING
        self.state = State.PRE_OPERATIONAL
        if was_running:
            self._report_lost()
        self._configure()

    def _on_heartbeat(self, code: int) -> None:
        self.state = STATES.get(code)
        if self.presence is Presence.ABSENT:
            self._boot()
        elif self.is_running:
            self._watch()
            if self.state is not State.OPERATIONAL:
                self.command(Command.START)
