"""TIME: the node's clock, as a consumer or producer of time stamps (1012h).

Source: CiA 301 7.2.6, 7.5.2.15, 7.1.6.5 (TIME_OF_DAY).  The clock starts at its epoch.  The standard doesn't define the
period of a producer: here it is a setting.
"""

from datetime import datetime, timedelta
from struct import Struct

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.device import Value
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.cob_id import BIT_30, INVALID, can_key, guard
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import ALLOWED, Object, Reset, Service, State

COB_ID = 0x1012
CONSUMES, PRODUCES = INVALID, BIT_30
"""Upper bits of 1012h."""

EPOCH = datetime(1984, 1, 1)  # noqa: DTZ001  the standard knows no time zones
TIME_OF_DAY = Struct("<LH")
MS_MASK = 0x0FFF_FFFF
DAY_MS = 86_400_000


class TimeOfDay(Service):
    def __init__(self, clock: Clock, port: Port, dictionary: Dictionary, period_ns: int) -> None:
        self._clock, self._port, self._period_ns = clock, port, period_ns
        self._cob_id = dictionary.get(COB_ID)
        self._due = Alarm(clock)
        self._at_zero_ms = -(clock.now_ns() // MS)
        if self._cob_id is not None:
            guard(self._cob_id, lambda cob_id: bool(cob_id & (CONSUMES | PRODUCES)), is_idle_checked=True)
            self._cob_id.watchers.append(self._configure)

    @property
    def milliseconds(self) -> int:
        """Milliseconds since the epoch."""
        return self._at_zero_ms + self._clock.now_ns() // MS

    def read(self) -> str:
        """Return the time in the form of ISO 8601."""
        return (EPOCH + timedelta(milliseconds=self.milliseconds)).isoformat(timespec="milliseconds")

    def write(self, value: Value) -> None:
        try:
            time = datetime.fromisoformat(str(value)).replace(tzinfo=None)
        except ValueError as cause:
            raise ValueError(f"{value!r} is not a time: expected ISO 8601, such as 2026-11-21T10:00:00") from cause
        if not 0 <= (time - EPOCH).days <= 0xFFFF:
            raise ValueError(f"{value!r} is out of range: expected a time within 65536 days from 1984-01-01 on")
        self._set((time - EPOCH) // timedelta(milliseconds=1))

    def reset(self, scope: Reset) -> None:
        self._configure()

    def enter(self, state: State) -> None:
        self._start()

    def _set(self, milliseconds: int) -> None:
        self._at_zero_ms = milliseconds - self._clock.now_ns() // MS

    def _configure(self) -> None:
        cob_id = 0 if self._cob_id is None else self._cob_id.number
        self._port.listen(self, Object.TIME, can_key(cob_id) if cob_id & CONSUMES else None, self._on_frame)
        self._start()

    def _start(self) -> None:
        is_producer = self._cob_id is not None and bool(self._cob_id.number & PRODUCES)
        if not is_producer or Object.TIME not in ALLOWED[self._port.state]:
            self._due.stop()
        elif not self._due.is_set:
            self._due.after(self._period_ns, self._on_due)

    def _on_due(self) -> None:
        assert self._cob_id is not None
        days, milliseconds = divmod(self.milliseconds, DAY_MS)
        self._port.send(can_key(self._cob_id.number), TIME_OF_DAY.pack(milliseconds, days & 0xFFFF))
        self._due.after(self._period_ns, self._on_due)

    def _on_frame(self, frame: CanFrame) -> None:
        if frame.is_remote or len(frame.data) != TIME_OF_DAY.size:
            return
        milliseconds, days = TIME_OF_DAY.unpack(frame.data)
        self._set(days * DAY_MS + min(milliseconds & MS_MASK, DAY_MS - 1))
