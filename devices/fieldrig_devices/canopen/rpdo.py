"""RPDO: takes values from the bus, at once or at the next SYNC.

Source: CiA 301 7.2.2, 7.5.2.35 (1400h).  The deadline of sub-index 5 is not watched.
"""

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import INVALID, can_key, guard, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.pdo_mapping import Direction, Mapping
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import Object, Reset, Service, State
from fieldrig_devices.canopen.sync import Sync

COMMUNICATION, MAPPING = 0x1400, 0x1600
"""Parameters of the first of 512."""

LAST_SYNCHRONOUS = 240
EVENT_DRIVEN = (254, 255)


class Rpdo(Service):
    """RPDO `number`, from 0."""

    def __init__(self, port: Port, dictionary: Dictionary, sync: Sync, errors: "emcy.Emcy", number: int) -> None:
        self._port, self._sync, self._errors, self._number = port, sync, errors, number
        self._cob_id = dictionary.get(COMMUNICATION + number, 1)
        self._type = dictionary.get(COMMUNICATION + number, 2)
        self._mapping = Mapping(dictionary, MAPPING + number, Direction.RECEIVE, self._is_valid)
        self._size = 0
        self._is_synchronous = self._is_short = False
        self._unpack = self._mapping.unpacker()
        self._waiting: bytes | None = None
        self._connect()

    def reset(self, scope: Reset) -> None:
        self._mapping.reset()
        self._is_short = False
        self._configure()

    def enter(self, state: State) -> None:
        self._waiting = None
        self._configure()

    def _connect(self) -> None:
        if self._cob_id is not None:
            guard(self._cob_id)
            self._cob_id.watchers.append(self._configure)
        if self._type is not None:
            self._type.writer = self._on_type_written
            self._type.watchers.append(self._configure)

    def _is_valid(self) -> bool:
        return self._cob_id is not None and is_valid(self._cob_id.number)

    def _configure(self) -> None:
        self._size, self._unpack = self._mapping.size, self._mapping.unpacker()
        cob_id = INVALID if self._cob_id is None else self._cob_id.number
        is_there = is_valid(cob_id) and self._size > 0
        self._is_synchronous = self._type is not None and self._type.number <= LAST_SYNCHRONOUS
        self._port.listen(self, Object.PDO, can_key(cob_id) if is_there else None, self._on_frame)
        is_synchronised = is_there and self._is_synchronous and self._port.state is State.OPERATIONAL
        self._sync.subscribe((0, self._number), self._on_sync if is_synchronised else None)

    def _on_frame(self, frame: CanFrame) -> None:
        data = frame.data
        if len(data) < self._size:
            self._on_short(frame)
            return
        if self._is_short:
            self._is_short = False
            self._errors.clear_error(emcy.Error.PDO_NOT_PROCESSED)
        if self._is_synchronous:
            self._waiting = data
        else:
            self._unpack(data)

    def _on_short(self, frame: CanFrame) -> None:
        """7.2.2.5.1: not taken, and reported."""
        if not frame.is_remote:
            self._is_short = True
            info = bytes((len(frame.data), self._size))
            self._errors.raise_error(emcy.Error.PDO_NOT_PROCESSED, emcy.COMMUNICATION, info)

    def _on_sync(self, counter: int | None) -> None:
        if self._waiting is not None:
            data, self._waiting = self._waiting, None
            self._unpack(data)

    def _on_type_written(self, data: bytes) -> None:
        if data[0] > LAST_SYNCHRONOUS and data[0] not in EVENT_DRIVEN:
            raise Abort(Code.INVALID_VALUE)
        assert self._type is not None
        self._type.set(data)
