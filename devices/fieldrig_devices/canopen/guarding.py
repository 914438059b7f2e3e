"""Node guarding, the answer to the master's remote frame; life guarding, the supervision of the master (100Ch, 100Dh).

Source: CiA 301 7.2.8.2.2.1, 7.2.8.3.2.1, 7.5.2.12, 7.5.2.13.  Heartbeat takes precedence: while 1017h is not 0,
there is no guarding.  A life time of 0 only disables life guarding; the node still answers.
"""

from collections.abc import Callable

from fieldrig.clock import MS, Alarm, Clock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.heartbeat import PRODUCER_TIME
from fieldrig_devices.canopen.nmt import ERROR_CONTROL_ID
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import Object, Reset, Service

GUARD_TIME, LIFE_TIME_FACTOR = 0x100C, 0x100D
TOGGLE = 0x80


class NodeGuarding(Service):
    """Calls `on_change` with True after a life time without a request of the master, and with False at the next one."""

    def __init__(self, clock: Clock, port: Port, dictionary: Dictionary, on_change: Callable[[bool], None]) -> None:
        self._clock, self._port, self._on_change = clock, port, on_change
        self._guard_time, self._factor = dictionary.get(GUARD_TIME), dictionary.get(LIFE_TIME_FACTOR)
        self._heartbeat_time = dictionary.get(PRODUCER_TIME)
        self._life = Alarm(clock)
        self._toggle = 0
        self._is_lost = False
        for variable in (self._guard_time, self._factor, self._heartbeat_time):
            if variable is not None:
                variable.watchers.append(self._configure)

    def reset(self, scope: Reset) -> None:
        self._toggle = 0
        self._is_lost = False
        self._life.stop()
        self._configure()

    @property
    def _life_time_ns(self) -> int:
        if self._guard_time is None or self._factor is None:
            return 0
        return self._guard_time.number * self._factor.number * MS

    def _configure(self) -> None:
        is_heartbeat = self._heartbeat_time is not None and self._heartbeat_time.number > 0
        is_enabled = self._guard_time is not None and not is_heartbeat
        self._port.listen(
            self, Object.ERROR_CONTROL, ERROR_CONTROL_ID + self._port.node_id if is_enabled else None, self._on_frame
        )
        if not is_enabled or self._life_time_ns == 0:
            self._life.stop()
            self._judge(False)
        elif self._life.is_set:
            self._life.after(self._life_time_ns, self._on_life_over)

    def _on_frame(self, frame: CanFrame) -> None:
        if not frame.is_remote:
            return
        self._port.send(ERROR_CONTROL_ID + self._port.node_id, bytes((self._toggle | self._port.state,)))
        self._toggle ^= TOGGLE
        life_time_ns = self._life_time_ns
        if life_time_ns > 0:  # supervision starts with the first request
            self._life.after(life_time_ns, self._on_life_over)
            self._judge(False)

    def _on_life_over(self) -> None:
        self._judge(True)

    def _judge(self, is_lost: bool) -> None:
        if is_lost != self._is_lost:
            self._is_lost = is_lost
            self._on_change(is_lost)
