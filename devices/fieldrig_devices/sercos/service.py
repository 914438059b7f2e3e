"""The service channel: two bytes a cycle beside the cyclic data, with a handshake.

Source: IEC 61491 by its public facts.  The master names element, direction and the last step in its control word, puts
its two bytes into the MDT and flips its handshake bit (MHS); the drive carries the step out and flips its own bit (AHS)
in the next AT, with two bytes or an error message.  First the IDN is written, then elements of it are read or written.
"""

from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Final, NamedTuple

from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import Attribute, Code, Element, ServiceError

# control word (MDT), bits 0 to 5
MHS: Final = 0x01
WRITE: Final = 0x02
LAST: Final = 0x04
ELEMENT_SHIFT: Final = 3
CONTROL_MASK: Final = 0x3F
# status word (AT), bits 0 to 2
AHS: Final = 0x01
BUSY: Final = 0x02
ERROR: Final = 0x04
STATUS_MASK: Final = 0x07

PATIENCE_CYCLES: Final = 10
"""Cycles that the master waits for the handshake."""
BUSY_CYCLES: Final = 5_000
"""Cycles that a drive may be busy with a step; our choice."""
TIMED_OUT: Final = 0x0002
"""The drive did not answer: a code of ours, in addition to the service channel error messages."""
RING_DOWN: Final = 0x0003
"""The ring went down before the answer: a code of ours."""


class ServiceServer:
    """The drive's end.  Call `step` when the low bits of the control word have changed."""

    def __init__(self, table: IdnTable, phase: Callable[[], int]) -> None:
        self._table, self._phase = table, phase
        self.reset()

    def reset(self) -> None:
        """Reset the channel for phases 0 and 1: both handshake bits low, no IDN open."""
        self.status, self.info = 0, 0
        self._datum: Datum | None = None
        self._element = Element.CLOSED
        self._is_write = False
        self._buffer = b""
        self._place = 0

    def step(self, control: int, info: int) -> None:
        if control & MHS == self.status & AHS:
            return
        self.status = control & MHS
        self.info = 0
        try:
            self._do(Element(control >> ELEMENT_SHIFT & 7), bool(control & WRITE), bool(control & LAST), info)
        except ServiceError as refused:
            self.status |= ERROR
            self.info = refused.code
            self._begin(Element.CLOSED, is_write=False)

    def _do(self, element: Element, is_write: bool, is_last: bool, info: int) -> None:
        if element is Element.CLOSED:
            self._datum = None
            self._begin(element, is_write=False)
        elif element is Element.IDN and is_write:
            self._datum = None
            self._datum = self._table.asked(info)
            self._begin(Element.CLOSED, is_write=False)
        elif self._datum is None:
            raise ServiceError(Code.CHANNEL_CLOSED)
        elif is_write:
            self._write(self._datum, element, is_last, info)
        else:
            self._read(self._datum, element, is_last)

    def _begin(self, element: Element, *, is_write: bool) -> None:
        self._element, self._is_write, self._buffer, self._place = element, is_write, b"", 0

    def _read(self, datum: Datum, element: Element, is_last: bool) -> None:
        if self._element is not element or self._is_write:
            self._begin(element, is_write=False)
            self._buffer = datum.element(element)
        if self._place >= len(self._buffer):
            raise ServiceError(element << 12 | Code.TOO_LONG & 0xFFF)
        self.info = int.from_bytes(self._buffer[self._place : self._place + 2], "little")
        self._place += 2
        if is_last:
            self._begin(Element.CLOSED, is_write=False)

    def _write(self, datum: Datum, element: Element, is_last: bool, info: int) -> None:
        if element is not Element.DATA:
            raise ServiceError(element << 12 | Code.READ_ONLY & 0xFFF)
        if self._phase() >= 3 and datum.idn in self._table.cyclic:
            raise ServiceError(Code.CYCLIC)
        if self._element is not element or not self._is_write:
            self._begin(element, is_write=True)
        self._buffer += info.to_bytes(2, "little")
        if len(self._buffer) > datum.largest + 5:  # more than the longest list of this datum
            raise ServiceError(Code.TOO_LONG)
        if is_last:
            data = self._buffer
            self._begin(Element.CLOSED, is_write=False)
            datum.write(data, self._phase())


class _Step(NamedTuple):
    element: Element
    is_write: bool
    is_last: bool
    info: int = 0


Done = Callable[[bytes | ServiceError], None]


@dataclass(slots=True)
class _Request:
    idn: int
    element: Element
    data: bytes | None
    """Data to write, or None to read."""
    done: Done


class ServiceClient:
    """The master's end of a drive's channel.  It carries requests out one by one.

    `control` and `info` go into the drive's record of each MDT; `step` gets the words of its AT.
    """

    def __init__(self) -> None:
        self.control, self.info = 0, 0
        self._waiting: deque[_Request] = deque()
        self._present: _Request | None = None
        self._steps: Generator[_Step, int, bytes] | None = None
        self._patience = self._busy = 0
        self.more_patience = 0
        """Cycles to wait in addition to `PATIENCE_CYCLES`."""
        self._attributes: dict[int, Attribute] = {}

    @property
    def is_idle(self) -> bool:
        return self._present is None and not self._waiting

    def read(self, idn: int, element: Element, done: Done) -> None:
        """Read an element; `done` gets its bytes, lists and texts without their lengths, or the error."""
        self._waiting.append(_Request(idn, element, None, done))

    def write(self, idn: int, data: bytes, done: Done) -> None:
        """Write operation data; for a list or text, its contents without the lengths."""
        self._waiting.append(_Request(idn, Element.DATA, data, done))

    def reset(self) -> None:
        """End all requests when the ring goes down; both handshake bits are low."""
        waiting = ([] if self._present is None else [self._present]) + list(self._waiting)
        self.control = self.info = 0
        self._present = self._steps = None
        self._waiting.clear()
        self._attributes.clear()
        for request in waiting:
            request.done(ServiceError(RING_DOWN))

    def step(self, status: int, info: int) -> None:
        """Take the words of the AT, once per cycle; not needed while idle."""
        if self._steps is None:
            self._begin()
        elif status & BUSY and self._busy < BUSY_CYCLES:
            self._busy += 1
        elif status & BUSY or (status ^ self.control) & AHS:
            self.wait()
        elif status & ERROR:
            self._end(ServiceError(info))
        else:
            self._advance(info)

    def wait(self) -> None:
        """Count a cycle without an answer."""
        if self._steps is not None:
            self._patience -= 1
            if self._patience <= 0:
                self._end(ServiceError(TIMED_OUT))

    def _begin(self) -> None:
        if self._waiting:
            request = self._present = self._waiting.popleft()
            self._steps = self._transfer(request)
            self._put(next(self._steps))

    def _advance(self, info: int) -> None:
        assert self._steps is not None
        try:
            self._put(self._steps.send(info))
        except StopIteration as ended:
            self._end(ended.value)

    def _put(self, step: _Step) -> None:
        word = step.element << ELEMENT_SHIFT | (WRITE if step.is_write else 0) | (LAST if step.is_last else 0)
        self.control = word | (~self.control & MHS)
        self.info = step.info
        self._patience, self._busy = PATIENCE_CYCLES + self.more_patience, 0

    def _end(self, outcome: bytes | ServiceError) -> None:
        request, self._present, self._steps = self._present, None, None
        assert request is not None
        request.done(outcome)
        self._begin()

    # ---- the steps of a request

    def _transfer(self, request: _Request) -> Generator[_Step, int, bytes]:
        yield _Step(Element.IDN, is_write=True, is_last=True, info=request.idn)
        element = request.element
        if element in (Element.NAME, Element.UNIT):
            return (yield from self._read_led(element))
        if element is Element.ATTRIBUTE:
            return (yield from self._read(element, 4))
        if element is Element.IDN:
            return (yield from self._read(element, 2))
        length = (yield from self._attribute(request.idn)).length
        if request.data is not None:
            return (yield from self._write(request.data, length.is_list))
        if length.is_list and element is Element.DATA:
            return (yield from self._read_led(element))
        return (yield from self._read(element, length.bytes if not length.is_list else max(length.bytes, 2)))

    def _attribute(self, idn: int) -> Generator[_Step, int, Attribute]:
        known = self._attributes.get(idn)
        if known is None:
            word = int.from_bytes((yield from self._read(Element.ATTRIBUTE, 4)), "little")
            try:
                known = self._attributes[idn] = Attribute.of(word)
            except ValueError:
                known = Attribute.of(
                    0x0001_0001
                )  # the attribute violates the standard; two bytes is the smallest length
        return known

    def _read(self, element: Element, size: int) -> Generator[_Step, int, bytes]:
        data = b""
        while len(data) < size:
            info = yield _Step(element, is_write=False, is_last=len(data) + 2 >= size)
            data += info.to_bytes(2, "little")
        return data[:size]

    def _read_led(self, element: Element) -> Generator[_Step, int, bytes]:
        actual = yield _Step(element, is_write=False, is_last=False)
        yield _Step(element, is_write=False, is_last=actual == 0)
        return (yield from self._read(element, actual)) if actual else b""

    def _write(self, data: bytes, is_list: bool) -> Generator[_Step, int, bytes]:
        if is_list:
            data = len(data).to_bytes(2, "little") * 2 + data
        for offset in range(0, len(data), 2):
            info = int.from_bytes(data[offset : offset + 2], "little")
            yield _Step(Element.DATA, is_write=True, is_last=offset + 2 >= len(data), info=info)
        return b""
