"""SYNC: receives it and passes it on to the PDOs (1005h, 1019h), and produces it if so configured (1006h).

Source: CiA 301 7.2.5, 7.5.2.5, 7.5.2.6, 7.5.2.7, 7.5.2.21.  TPDOs are sent at the instant of their SYNC, so the window
of 1007h applies to RPDOs only.
"""

from collections.abc import Callable

from fieldrig.clock import US, Alarm, Clock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import BIT_30, can_key, guard
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import ALLOWED, Object, Reset, Service, State

COB_ID, PERIOD, WINDOW, OVERFLOW = 0x1005, 0x1006, 0x1007, 0x1019
USUAL_COB_ID = 0x80
"""The default of 1005h.  A device whose EDS file has synchronous PDOs and no 1005h takes part in this SYNC."""
MAX_COUNTER = 240

Order = tuple[int, int]
"""Order of handlers: RPDOs (0, n) precede TPDOs (1, n), so that a TPDO has the values that its SYNC put into effect."""

Handler = Callable[[int | None], None]
"""Handler of a SYNC; it receives the counter, or None if the SYNC has none."""


def is_produced(cob_id: int) -> bool:
    return bool(cob_id & BIT_30)


class Sync(Service):
    def __init__(self, clock: Clock, port: Port, dictionary: Dictionary, errors: "emcy.Emcy") -> None:
        self._clock, self._port, self._errors = clock, port, errors
        self._cob_id, self._period = dictionary.get(COB_ID), dictionary.get(PERIOD)
        self._window, self._overflow = dictionary.get(WINDOW), dictionary.get(OVERFLOW)
        self._last_ns: int | None = None
        self._due = Alarm(clock)
        self._subscribers: dict[Order, Handler] = {}
        self._handlers: tuple[Handler, ...] = ()
        self._length = 0
        self._counter = 0
        self._connect()

    def subscribe(self, order: Order, handler: Handler | None) -> None:
        """Call `handler` at each SYNC, sorted by `order`; None removes it."""
        if handler == self._subscribers.get(order):
            return
        if handler is None:
            del self._subscribers[order]
        else:
            self._subscribers[order] = handler
        self._handlers = tuple(self._subscribers[order] for order in sorted(self._subscribers))
        if self._cob_id is None:
            self._listen()

    @property
    def is_window_open(self) -> bool:
        """True if a synchronous RPDO that arrives now still takes part in the next SYNC."""
        if self._window is None or self._last_ns is None or self._window.number == 0:
            return True
        return self._clock.now_ns() < self._last_ns + self._window.number * US

    def reset(self, scope: Reset) -> None:
        self._counter = 0
        self._last_ns = None
        self._configure()

    def enter(self, state: State) -> None:
        """Stop production where SYNC isn't allowed; the counter restarts afterwards (7.2.5.2.1)."""
        if Object.SYNC not in ALLOWED[state]:
            self._counter = 0
            self._due.stop()
        elif not self._due.is_set:
            self._start()

    def _connect(self) -> None:
        if self._cob_id is not None:
            guard(self._cob_id, is_produced, is_idle_checked=True)
            self._cob_id.watchers.append(self._configure)
        if self._period is not None:
            self._period.watchers.append(self._configure)
        if self._overflow is not None:
            self._overflow.writer = self._on_overflow_written

    def _configure(self) -> None:
        self._length = 1 if self._overflow is not None and self._overflow.number > 0 else 0
        self._listen()
        self._due.stop()
        self._start()
        if not self._due.is_set:
            self._counter = 0  # a producer that was stopped starts with 1 (7.2.5.2.1, as in CiA's own log)

    def _listen(self) -> None:
        cob_id = (USUAL_COB_ID if self._handlers else None) if self._cob_id is None else self._cob_id.number
        self._port.listen(self, Object.SYNC, None if cob_id is None else can_key(cob_id), self._on_frame)

    @property
    def _period_ns(self) -> int:
        return 0 if self._period is None else self._period.number * US

    def _start(self) -> None:
        is_producer = self._cob_id is not None and is_produced(self._cob_id.number)
        if is_producer and self._period_ns > 0 and Object.SYNC in ALLOWED[self._port.state]:
            self._due.after(self._period_ns, self._on_due)

    def _on_due(self) -> None:
        assert self._cob_id is not None
        data = b""
        if self._overflow is not None and self._length > 0:
            self._counter = self._counter % self._overflow.number + 1
            data = bytes((self._counter,))
        self._port.send(can_key(self._cob_id.number), data)
        self._due.after(self._period_ns, self._on_due)
        self._pass_on(data)

    def _on_frame(self, frame: CanFrame) -> None:
        if frame.is_remote:
            return
        if len(frame.data) != self._length:
            self._errors.raise_error(emcy.Error.SYNC_LENGTH, emcy.COMMUNICATION, bytes((len(frame.data),)))
            return
        self._errors.clear_error(emcy.Error.SYNC_LENGTH)
        self._pass_on(frame.data)

    def _pass_on(self, data: bytes) -> None:
        counter = data[0] if data else None
        self._last_ns = self._clock.now_ns()
        for handler in self._handlers:
            handler(counter)

    def _on_overflow_written(self, data: bytes) -> None:
        if self._period is not None and self._period.number > 0:
            raise Abort(Code.DEVICE_STATE)  # 7.5.2.21
        if data[0] == 1 or data[0] > MAX_COUNTER:
            raise Abort(Code.INVALID_VALUE)
        assert self._overflow is not None
        self._overflow.set(data)
        self._configure()
