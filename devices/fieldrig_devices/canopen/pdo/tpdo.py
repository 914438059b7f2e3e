"""TPDO: sends values at SYNC, on change, by event timer, or on request.

Source: CiA 301 7.2.2, 7.5.2.37 (1800h).  Changes at the same instant are sent in one PDO; an event-driven PDO
is also sent when it becomes active (valid and operational), so that its consumers know the values.
"""

from collections.abc import Callable

from fieldrig.clock import MS, US, Alarm, Clock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import BIT_30, INVALID, can_key, guard, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.pdo import mpdo
from fieldrig_devices.canopen.pdo.mapping import Direction, Mapping, Mode, Pack
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import Object, Reset, Service, State
from fieldrig_devices.canopen.sync import Sync
from fieldrig_devices.canopen.variable import Variable

COMMUNICATION, MAPPING = 0x1800, 0x1A00
"""Parameter objects of the first of 512 TPDOs."""

# Transmission types, table 'description of TPDO transmission type'.
ACYCLIC, LAST_CYCLIC = 0, 240
RTR_SYNCHRONOUS = 252  # 253 samples at the request, as all other types do
EVENT_DRIVEN = (254, 255)

INHIBIT_UNIT_NS = 100 * US


class Tpdo(Service):
    """The TPDO with this number, from 0."""

    def __init__(self, clock: Clock, port: Port, dictionary: Dictionary, sync: Sync, number: int) -> None:
        self._clock, self._port, self._dictionary, self._sync, self._number = clock, port, dictionary, sync, number
        index = COMMUNICATION + number
        self._cob_id, self._type_variable = dictionary.get(index, 1), dictionary.get(index, 2)
        self._inhibit_time, self._event_time = dictionary.get(index, 3), dictionary.get(index, 5)
        self._sync_start = dictionary.get(index, 6)
        self._mapping = Mapping(dictionary, MAPPING + number, Direction.TRANSMIT, self._is_valid)
        self._pack = self._mapping.packer()
        self._key = self._type = self._inhibit_ns = self._event_ns = 0
        self._is_active = False
        self._is_due = False
        """True after an event that has not been sent yet."""
        self._is_asked = False
        """True if `_on_asked` is scheduled for the end of this instant."""
        self._is_waiting_for_start = False
        self._syncs = 0
        self._sample: bytes | None = None
        self._inhibited = Alarm(clock)
        self._event_timer = Alarm(clock)
        self._watches: list[tuple[Variable, Callable[[], None]]] = []
        self.reads_when_sent = False
        """True if sending calls the readers; otherwise the application keeps the variables up to date."""
        self.watched: list[Variable] = []
        """Variables that the application keeps up to date: all mapped ones, unless they are read when sending."""
        self.on_change: Callable[[], None] = lambda: None
        """Called when `watched` has changed."""
        self._scanner: mpdo.Scanner | None = None
        self.destination: tuple[int, int, int] | None = None
        """Node-ID, index and sub-index of the destination of a multiplexed PDO."""
        self._connect()

    def reset(self, scope: Reset) -> None:
        self._mapping.reset()
        self._configure()

    def enter(self, state: State) -> None:
        self._configure()

    def _connect(self) -> None:
        self._mapping.on_change = self._configure
        if self._cob_id is not None:
            guard(self._cob_id)
        for variable, writer in (
            (self._type_variable, _check_type),
            (self._inhibit_time, self._check_not_valid),
            (self._sync_start, self._check_not_valid),
        ):
            if variable is not None:
                variable.writer = _checked(variable, writer)
        for variable in (self._cob_id, self._type_variable, self._inhibit_time, self._event_time, self._sync_start):
            if variable is not None:
                variable.watchers.append(self._configure)

    def _is_valid(self) -> bool:
        return self._cob_id is not None and is_valid(self._cob_id.number)

    def _check_not_valid(self, data: bytes) -> None:
        if self._is_valid():
            raise Abort(Code.DEVICE_STATE)

    # Configuration.

    def _configure(self) -> None:
        was_active = self._is_active
        cob_id = INVALID if self._cob_id is None else self._cob_id.number
        is_there = is_valid(cob_id) and (bool(self._mapping.parts) or self._mapping.mode is Mode.SOURCE)
        self._key = can_key(cob_id)
        is_asked_for = is_there and not cob_id & BIT_30 and self._mapping.mode is Mode.MAPPED
        self._port.listen(self, Object.PDO, self._key if is_asked_for else None, self._on_frame)
        self._deactivate()
        if is_there and self._port.state is State.OPERATIONAL:
            self._activate()
            if not was_active and self._type in EVENT_DRIVEN and self._scanner is None:
                self._on_event()

    def _deactivate(self) -> None:
        self._is_active = self._is_due = False
        self.watched = []
        self.on_change()
        self._inhibited.stop()
        self._event_timer.stop()
        self._sync.subscribe((1, self._number), None)
        for variable, on_event in self._watches:
            variable.events.remove(on_event)
        self._watches, self._scanner = [], None

    def _activate(self) -> None:
        self._is_active = True
        self._refresh(with_readers=True)
        self._pack, self._sample = self._packer(), None
        self._type = _number(self._type_variable, 255) if self._mapping.mode is Mode.MAPPED else EVENT_DRIVEN[-1]
        self._inhibit_ns = _number(self._inhibit_time) * INHIBIT_UNIT_NS
        self._event_ns = _number(self._event_time) * MS if self._type in EVENT_DRIVEN else 0
        self._syncs, self._is_waiting_for_start = 0, _number(self._sync_start) > 0
        if self._type <= LAST_CYCLIC or self._type == RTR_SYNCHRONOUS:
            self._sync.subscribe((1, self._number), self._sync_handler())
        is_sent_on_events = self._type == ACYCLIC or self._type in EVENT_DRIVEN
        if is_sent_on_events:
            self._watch()
        if is_sent_on_events or not self.reads_when_sent:
            self.watched = _carried(self._mapping)
        self.on_change()
        self._start_event_timer()

    def _watch(self) -> None:
        if self._mapping.mode is Mode.SOURCE:
            self._scanner = mpdo.Scanner(self._dictionary, self._port.node_id, self._on_event)
            self._watches = self._scanner.watches
        else:
            self._watches = [(variable, self._on_event) for variable in _carried(self._mapping)]
        for variable, on_event in self._watches:
            variable.events.append(on_event)

    def _refresh(self, *, with_readers: bool) -> None:
        """Update variables that follow moving signals and, if requested, those with readers."""
        for variable in _carried(self._mapping):
            if variable.live is not None:
                variable.sample()
            elif with_readers and variable.reader is not None:
                variable.set(variable.reader())

    def _sampled(self) -> bytes:
        """Update the variables and return the bytes of the PDO."""
        self._refresh(with_readers=self.reads_when_sent)
        return self._pack()

    def _packer(self) -> Pack:
        return self._mapping.packer() if self._mapping.mode is Mode.MAPPED else self._pack_addressed

    def _pack_addressed(self) -> bytes:
        """Return a multiplexed PDO: the mapped variable for its destination, or the next changed variable."""
        if self._scanner is not None:
            return self._scanner.take()
        assert self.destination is not None
        (variable,) = (part.variable for part in self._mapping.parts)
        assert variable is not None
        node_id, index, subindex = self.destination
        return mpdo.encode(mpdo.TO_ADDRESS | node_id, index, subindex, variable.data)

    @property
    def _has_data(self) -> bool:
        if self._mapping.mode is Mode.MAPPED:
            return True
        return self._scanner.is_waiting if self._scanner is not None else self.destination is not None

    def _sync_handler(self) -> Callable[[int | None], None]:
        if self._type == ACYCLIC:
            return self._on_sync_acyclic
        return self._on_sync_rtr if self._type == RTR_SYNCHRONOUS else self._on_sync_cyclic

    # Triggers.

    def send_to(self, node_id: int, index: int, subindex: int) -> None:
        """Send the mapped variable in a multiplexed PDO; its later changes go to the same destination."""
        self.destination = node_id, index, subindex
        self._on_event()

    def _on_event(self) -> None:
        self._is_due = True
        if self._type != ACYCLIC and not self._is_asked:
            self._is_asked = True
            self._clock.call_at(self._clock.now_ns(), self._on_asked)

    def _on_asked(self) -> None:
        self._is_asked = False
        if not self._inhibited.is_set:
            self._send_due()

    def _send_due(self) -> None:
        while self._is_due and self._is_active and self._has_data:
            self._is_due = False  # first, as an RPDO that arrives while this is sent may be an event
            self._send(self._sampled())
            self._is_due = self._is_due or (self._scanner is not None and self._scanner.is_waiting)
            if self._inhibited.is_set:
                return

    def _on_sync_acyclic(self, counter: int | None) -> None:
        self._send_due()

    def _on_sync_cyclic(self, counter: int | None) -> None:
        if self._is_waiting_for_start and counter is not None:
            if counter != _number(self._sync_start):
                return
            self._is_waiting_for_start = False
        self._syncs += 1
        if self._syncs >= self._type:
            self._syncs = 0
            self._send(self._sampled())

    def _on_sync_rtr(self, counter: int | None) -> None:
        self._sample = self._sampled()

    def _on_frame(self, frame: CanFrame) -> None:
        if frame.is_remote and self._is_active:
            self._send(self._sampled() if self._sample is None else self._sample)

    def _send(self, data: bytes) -> None:
        self._is_due = False
        self._port.send(self._key, data)
        if self._inhibit_ns > 0 and self._type in EVENT_DRIVEN:
            self._inhibited.after(self._inhibit_ns, self._send_due)
        self._start_event_timer()

    def _start_event_timer(self) -> None:
        if self._event_ns > 0:
            self._event_timer.after(self._event_ns, self._on_event)


def _carried(mapping: Mapping) -> list[Variable]:
    return [part.variable for part in mapping.parts if part.variable is not None]


def _number(variable: Variable | None, default: int = 0) -> int:
    return default if variable is None else variable.number


def _check_type(data: bytes) -> None:
    if not is_type(data[0]):
        raise Abort(Code.INVALID_VALUE)


def is_type(number: int) -> bool:
    """True for a transmission type that a TPDO may have."""
    return not LAST_CYCLIC < number < RTR_SYNCHRONOUS


def _checked(variable: Variable, check: Callable[[bytes], None]) -> Callable[[bytes], None]:
    def write(data: bytes) -> None:
        if data != variable.data:
            check(data)
        variable.set(data)

    return write
