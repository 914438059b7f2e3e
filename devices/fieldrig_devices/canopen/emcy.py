"""EMCY producer: the errors of the node, its error register (1001h) and its error history (1003h).

Source: CiA 301 7.2.7, 7.5.2.2, 7.5.2.4, 7.5.2.17 (COB-ID 1014h), 7.5.2.18 (inhibit time 1015h).
The history doesn't survive power-off.
"""

import logging
from collections import deque
from enum import IntEnum

from fieldrig.clock import US, Alarm, Clock
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.cob_id import can_key, guard, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import ALLOWED, Object, Reset, Service, State
from fieldrig_devices.canopen.variable import Variable

log = logging.getLogger(__name__)

ERROR_REGISTER, HISTORY, COB_ID, INHIBIT_TIME = 0x1001, 0x1003, 0x1014, 0x1015
INHIBIT_UNIT_NS = 100 * US

GENERIC = 0x01
COMMUNICATION = 0x10
"""Bits of the error register."""

NO_ERROR = 0x0000
OF_COMMUNICATION = (0x81, 0x82)
"""First bytes of error codes: communication and protocol (table 26)."""


class Error(IntEnum):
    """Error codes that communication itself raises (table 26)."""

    ERROR_PASSIVE = 0x8120
    HEARTBEAT = 0x8130
    RECOVERED_FROM_BUS_OFF = 0x8140
    PDO_NOT_PROCESSED = 0x8210
    PDO_LENGTH_EXCEEDED = 0x8220
    MPDO_NOT_PROCESSED = 0x8230
    SYNC_LENGTH = 0x8240
    RPDO_TIMEOUT = 0x8250


class Emcy(Service):
    """The error list of the node: the device and its services raise and clear errors by code."""

    def __init__(self, clock: Clock, port: Port, dictionary: Dictionary) -> None:
        self._clock, self._port = clock, port
        self._inhibited = Alarm(clock)
        self._active: dict[tuple[int, int], int] = {}
        self._shared: set[int] = set()
        """Codes of events that have several sources, and are reported once."""
        self._waiting: deque[bytes] = deque()
        self._history: deque[bytes] = deque(maxlen=max(1, len(dictionary.members(HISTORY))))
        self._register = dictionary.get(ERROR_REGISTER)
        self._count, self._entries = dictionary.get(HISTORY), dictionary.members(HISTORY)
        self._cob_id, self._inhibit_time = dictionary.get(COB_ID), dictionary.get(INHIBIT_TIME)
        self.last_code = NO_ERROR
        """Error code of the last report, whether or not it could be sent."""
        self._connect()

    def raise_error(
        self, code: int, register: int = 0, info: bytes = b"", source: int = 0, *, is_shared: bool = False
    ) -> None:
        """Report error `code` with its bits of the error register and up to 5 manufacturer-specific bytes.

        An active error is not reported again.  The same code from another `source`, such as an axis, is another error;
        with `is_shared` it is the same event (7.2.7.1: one EMCY per event), which ends with its last source.
        """
        if (code, source) in self._active:
            return
        is_known = is_shared and self._has(code)
        self._active[code, source] = register | GENERIC
        if is_shared:
            self._shared.add(code)
        if is_known:
            self._show()
            return
        log.info("error %04X", code)
        self._history.appendleft(code.to_bytes(2, "little") + info[:2].ljust(2, b"\x00"))
        self._report(code, info)

    def clear_error(self, code: int, source: int = 0) -> None:
        """Clear an error, and report 'error reset or no error' with the remaining bits of the register."""
        if self._active.pop((code, source), None) is None:
            return
        if code in self._shared and self._has(code):
            self._show()
            return
        self._shared.discard(code)
        self._report(NO_ERROR, b"")

    def _has(self, code: int) -> bool:
        return any(active == code for active, _ in self._active)

    def clear_all(self) -> None:
        for code, source in list(self._active):
            self.clear_error(code, source)

    @property
    def register(self) -> int:
        bits = 0
        for more in self._active.values():
            bits |= more
        return bits

    def reset(self, scope: Reset) -> None:
        """Clear communication errors; errors of the application are cleared by a reset of the node only."""
        self._inhibited.stop()
        self._waiting.clear()
        if scope is Reset.NODE:
            self._active.clear()
            self._history.clear()
            self.last_code = NO_ERROR
        for error in [error for error in self._active if error[0] >> 8 in OF_COMMUNICATION]:
            del self._active[error]
        self._shared = {code for code in self._shared if self._has(code)}
        self._show()

    def enter(self, state: State) -> None:
        self._send_waiting()

    def _connect(self) -> None:
        if self._cob_id is not None:
            guard(self._cob_id)
        if self._count is not None:
            self._count.writer = self._on_count_written
        for number, entry in enumerate(self._entries):
            entry.reader = lambda number=number, entry=entry: self._read_history(number, entry)

    def _report(self, code: int, info: bytes) -> None:
        self.last_code = code
        self._show()
        self._waiting.append(code.to_bytes(2, "little") + bytes((self.register,)) + info[:5].ljust(5, b"\x00"))
        self._send_waiting()

    def _send_waiting(self) -> None:
        if self._cob_id is None or not is_valid(self._cob_id.number):
            self._waiting.clear()
        while self._waiting and not self._inhibited.is_set and Object.EMCY in ALLOWED[self._port.state]:
            assert self._cob_id is not None
            self._port.send(can_key(self._cob_id.number), self._waiting.popleft())
            inhibit = 0 if self._inhibit_time is None else self._inhibit_time.number
            if inhibit > 0:
                self._inhibited.after(inhibit * INHIBIT_UNIT_NS, self._send_waiting)

    def _show(self) -> None:
        """Write register and history into the dictionary."""
        for entry, error in zip(self._entries, self._history, strict=False):
            entry.set(error)
        if self._count is not None:
            self._count.set(bytes((min(len(self._history), len(self._entries)),)))
        if self._register is not None:
            self._register.set(bytes((self.register,)))

    def _read_history(self, number: int, entry: Variable) -> bytes:
        if number >= len(self._history):
            raise Abort(Code.NO_DATA)
        return entry.data

    def _on_count_written(self, data: bytes) -> None:
        if data != b"\x00":  # 7.5.2.4: only 0, which empties the history
            raise Abort(Code.INVALID_VALUE)
        self._history.clear()
        self._show()
