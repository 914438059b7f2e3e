"""Heartbeat: the node's own (1017h), and its supervision of other nodes' heartbeats (1016h).

Source: CiA 301 7.2.8.2.2.3, 7.5.2.19, 7.5.2.20.
"""

from collections.abc import Callable, Iterable

from fieldrig.clock import MS, Alarm, Clock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.nmt import ERROR_CONTROL_ID
from fieldrig_devices.canopen.port import UNCONFIGURED, Port
from fieldrig_devices.canopen.service import Object, Reset, Service, State
from fieldrig_devices.canopen.variable import Variable

PRODUCER_TIME = 0x1017
CONSUMER_TIME = 0x1016


class HeartbeatProducer(Service):
    """Sends the NMT state every 1017h milliseconds; a new time takes effect at once."""

    def __init__(self, clock: Clock, port: Port, dictionary: Dictionary) -> None:
        self._clock, self._port = clock, port
        self._due = Alarm(clock)
        self._time = dictionary.get(PRODUCER_TIME)
        self._reset_ns = clock.now_ns()
        self._is_initialising = True
        if self._time is not None:
            self._time.watchers.append(self._on_time)

    def reset(self, scope: Reset) -> None:
        self._reset_ns = self._clock.now_ns()
        self._begin()

    def enter(self, state: State) -> None:
        """Count from the boot-up message on where it comes later than the reset."""
        if self._is_initialising and state is not State.INITIALISING and self._clock.now_ns() > self._reset_ns:
            self._begin()
        self._is_initialising = state is State.INITIALISING

    def _begin(self) -> None:
        """Send the next heartbeat after a whole period, as the boot-up message counts as one."""
        self._due.stop()
        if self._period_ns > 0 and self._port.node_id != UNCONFIGURED:
            self._due.after(self._period_ns, self._on_due)

    @property
    def _period_ns(self) -> int:
        return 0 if self._time is None else self._time.number * MS

    def _on_time(self) -> None:
        self._due.stop()
        if self._period_ns > 0:
            # The answer to the SDO that wrote the time goes first: ros_canopen's master waits for it with a lock that
            # its handler of heartbeats needs, so it hears no answer behind a heartbeat.
            self._due.after(0, self._on_due)

    def _on_due(self) -> None:
        if self._is_initialising:
            return
        self._port.send(ERROR_CONTROL_ID + self._port.node_id, bytes((self._port.state,)))
        self._due.after(self._period_ns, self._on_due)


class HeartbeatConsumer(Service):
    """Supervises the producers of 1016h from their first heartbeat on; calls `on_change` when that state changes."""

    def __init__(self, clock: Clock, port: Port, dictionary: Dictionary, on_change: Callable[[bool], None]) -> None:
        self._clock, self._port, self._on_change = clock, port, on_change
        self._entries = dictionary.members(CONSUMER_TIME)
        self._watches: list[_Watch] = []
        self.is_lost = False
        """True if the heartbeat of a producer has stopped."""
        for entry in self._entries:
            entry.writer = self._writer(entry)
            entry.watchers.append(self._configure)

    def reset(self, scope: Reset) -> None:
        self.is_lost = False
        self._configure()

    def _configure(self) -> None:
        for watch in self._watches:
            watch.end()
        self._watches = [
            _Watch(self._clock, self._port, node_id, time_ms * MS, self._judge)
            for node_id, time_ms in map(_parse, self._entries)
            if _is_used(node_id, time_ms)
        ]
        self._judge()

    def _judge(self) -> None:
        is_lost = any(watch.is_lost for watch in self._watches)
        if is_lost != self.is_lost:
            self.is_lost = is_lost
            self._on_change(is_lost)

    def _writer(self, entry: Variable) -> Callable[[bytes], None]:
        def write(data: bytes) -> None:
            node_id, time_ms = data[2], int.from_bytes(data[:2], "little")
            if _has_other(entry, node_id, time_ms, self._entries):
                raise Abort(Code.PARAMETER_INCOMPATIBLE)  # 7.5.2.19: only one time per node
            entry.set(data)

        return write


class _Watch:
    """Supervision of one heartbeat producer."""

    def __init__(self, clock: Clock, port: Port, node_id: int, time_ns: int, on_change: Callable[[], None]) -> None:
        self._clock, self._port, self._time_ns, self._on_change = clock, port, time_ns, on_change
        self._due = Alarm(clock)
        self.is_lost = False
        port.listen(self, Object.ERROR_CONTROL, ERROR_CONTROL_ID + node_id, self._on_frame)

    def end(self) -> None:
        self._due.stop()
        self._port.listen(self, Object.ERROR_CONTROL, None, self._on_frame)

    def _on_frame(self, frame: CanFrame) -> None:
        # A boot-up message is not a heartbeat: supervision starts with the first heartbeat.
        if frame.is_remote or len(frame.data) != 1 or frame.data[0] == State.INITIALISING:
            return
        self._due.after(self._time_ns, self._on_due)
        if self.is_lost:
            self.is_lost = False
            self._on_change()

    def _on_due(self) -> None:
        self.is_lost = True
        self._on_change()


def is_watched_twice(entry: Variable, entries: Iterable[Variable]) -> bool:
    """True if another entry of 1016h is in use for the same node (7.5.2.19: only one time per node)."""
    return _has_other(entry, *_parse(entry), entries)


def _has_other(entry: Variable, node_id: int, time_ms: int, entries: Iterable[Variable]) -> bool:
    others = [_parse(other) for other in entries if other is not entry]
    return _is_used(node_id, time_ms) and any(node_id == other and time > 0 for other, time in others)


def _parse(entry: Variable) -> tuple[int, int]:
    """Return node-ID and time in milliseconds of an entry of 1016h."""
    return entry.number >> 16 & 0xFF, entry.number & 0xFFFF


def _is_used(node_id: int, time_ms: int) -> bool:
    """True if an entry is in use: node-ID 1 to 127 and a time other than 0 (7.5.2.19)."""
    return 1 <= node_id <= 127 and time_ms > 0
