"""RPDO: receives values from the bus and writes them at once or at the next SYNC.

Source: CiA 301 7.2.2, 7.5.2.35 (1400h).  The event timer (sub-index 5) supervises from the first reception on.
"""

from fieldrig.clock import MS, Alarm, Clock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import INVALID, can_key, guard, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.pdo import mpdo
from fieldrig_devices.canopen.pdo.mapping import Direction, Mapping, Mode, Unpack
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import Object, Reset, Service, State
from fieldrig_devices.canopen.sync import Sync

COMMUNICATION, MAPPING = 0x1400, 0x1600
"""Parameter objects of the first of 512 RPDOs."""
NUMBERS = 512

LAST_SYNCHRONOUS = 240
EVENT_DRIVEN = (254, 255)


class Rpdo(Service):
    """The RPDO with this number, from 0."""

    def __init__(
        self, clock: Clock, port: Port, dictionary: Dictionary, sync: Sync, errors: "emcy.Emcy", number: int
    ) -> None:
        self._clock, self._port, self._dictionary = clock, port, dictionary
        self._sync, self._errors, self._number = sync, errors, number
        self._cob_id = dictionary.get(COMMUNICATION + number, 1)
        self._type = dictionary.get(COMMUNICATION + number, 2)
        self._event_time = dictionary.get(COMMUNICATION + number, 5)
        self._overdue = Alarm(clock)
        self._mapping = Mapping(dictionary, MAPPING + number, Direction.RECEIVE, self._is_valid)
        self._order = 0, number
        self._size = 0
        self._timeout_ns = 0
        self._is_synchronous = False
        self._problem: emcy.Error | None = None
        """The reported error of the reception, or None."""
        self._unpack = self._mapping.unpacker()
        self._waiting: bytes | None = None
        self._connect()

    def reset(self, scope: Reset) -> None:
        self._mapping.reset()
        self._problem = None
        self._overdue.stop()
        self._configure()

    def enter(self, state: State) -> None:
        self._waiting = None
        self._overdue.stop()
        self._configure()

    def _connect(self) -> None:
        self._mapping.on_change = self._configure
        if self._cob_id is not None:
            guard(self._cob_id)
            self._cob_id.watchers.append(self._configure)
        if self._type is not None:
            self._type.writer = self._on_type_written
            self._type.watchers.append(self._configure)
        if self._event_time is not None:
            self._event_time.watchers.append(self._configure)

    def _is_valid(self) -> bool:
        return self._cob_id is not None and is_valid(self._cob_id.number)

    def _configure(self) -> None:
        mode = self._mapping.mode
        self._size = self._mapping.size if mode is Mode.MAPPED else mpdo.SIZE
        self._unpack = self._mapping.unpacker() if mode is Mode.MAPPED else self._multiplexed(mode)
        cob_id = INVALID if self._cob_id is None else self._cob_id.number
        is_there = is_valid(cob_id) and self._size > 0
        self._is_synchronous = self._type is not None and self._type.number <= LAST_SYNCHRONOUS
        self._is_synchronous = self._is_synchronous and mode is Mode.MAPPED
        self._timeout_ns = 0 if self._event_time is None else self._event_time.number * MS
        self._watch_time(is_there)
        self._port.listen(self, Object.PDO, can_key(cob_id) if is_there else None, self._on_frame)
        is_synchronised = is_there and self._is_synchronous and self._port.state is State.OPERATIONAL
        self._sync.subscribe(self._order, None)
        # an RPDO with a command comes after all others, so that the command sees their values
        self._order = 0, self._number + NUMBERS * self._mapping.has_command
        self._sync.subscribe(self._order, self._on_sync if is_synchronised else None)
        if not is_synchronised:
            self._waiting = None  # the PDO may have another mapping when it is synchronous again

    def _watch_time(self, is_there: bool) -> None:
        was_watched = self._overdue.is_set
        self._overdue.stop()
        if self._timeout_ns > 0 and is_there:
            if was_watched:
                self._overdue.after(self._timeout_ns, self._on_overdue)
        elif self._problem is emcy.Error.RPDO_TIMEOUT:
            self._report(None)

    def _on_frame(self, frame: CanFrame) -> None:
        data = frame.data
        size = len(data)
        if size != self._size and not self._is_length_good(frame):
            return
        if self._timeout_ns > 0:
            self._overdue.after(self._timeout_ns, self._on_overdue)
        if self._problem is not None and size == self._size:
            self._report(None)
        if not self._is_synchronous:
            self._unpack(data)
        elif self._sync.is_window_open:
            self._waiting = data

    def _is_length_good(self, frame: CanFrame) -> bool:
        """Report a wrong length (7.2.2.5.1); True if the frame is too long, so that its first bytes are used."""
        if frame.is_remote:
            return False
        is_long = len(frame.data) > self._size
        self._report(
            emcy.Error.PDO_LENGTH_EXCEEDED if is_long else emcy.Error.PDO_NOT_PROCESSED,
            bytes((len(frame.data), self._size)),
        )
        return is_long

    def _on_overdue(self) -> None:
        self._report(emcy.Error.RPDO_TIMEOUT)

    def _report(self, problem: "emcy.Error | None", info: bytes = b"") -> None:
        """Report a problem instead of the previous one; None clears it.  RPDOs with the same problem have one EMCY."""
        if problem is self._problem:
            return
        before, self._problem = self._problem, problem
        if problem is not None:
            self._errors.raise_error(problem, emcy.COMMUNICATION, info, self._number, is_shared=True)
        if before is not None:
            self._errors.clear_error(before, self._number)

    def _multiplexed(self, mode: Mode) -> Unpack:
        return self._on_message_from if mode is Mode.SOURCE else self._on_message_to

    def _on_message_from(self, message: bytes) -> None:
        if not message[0] & mpdo.TO_ADDRESS:
            mpdo.put(mpdo.dispatched(self._dictionary, message), message)

    def _on_message_to(self, message: bytes) -> None:
        address, index, subindex = mpdo.MULTIPLEXER.unpack_from(message)
        if address not in (mpdo.TO_ADDRESS, mpdo.TO_ADDRESS | self._port.node_id):
            return
        if mpdo.put(self._dictionary.get(index, subindex), message):
            self._errors.clear_error(emcy.Error.MPDO_NOT_PROCESSED)
        else:
            self._errors.raise_error(emcy.Error.MPDO_NOT_PROCESSED, emcy.COMMUNICATION, message[1:4])

    def _on_sync(self, counter: int | None) -> None:
        if self._waiting is not None:
            data, self._waiting = self._waiting, None
            self._unpack(data)

    def _on_type_written(self, data: bytes) -> None:
        if not is_type(data[0]):
            raise Abort(Code.INVALID_VALUE)
        assert self._type is not None
        self._type.set(data)


def is_type(number: int) -> bool:
    """True for a transmission type that an RPDO may have."""
    return number <= LAST_SYNCHRONOUS or number in EVENT_DRIVEN
