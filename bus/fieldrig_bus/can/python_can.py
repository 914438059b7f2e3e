"""Any interface of python-can as a direct bus: adapters that have a driver there and no kernel network device.

Source: python-can 4.6, `can.Bus`.  There is no thread: where the interface has a file descriptor the event loop watches
it, elsewhere the interface is polled every millisecond.
Left out: error frames, filters in the adapter.
"""

import asyncio
import logging
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

from pydantic import ConfigDict, Field

from fieldrig.bus import Attachment, DirectBus, Time
from fieldrig.clock import MS
from fieldrig.errors import BusError
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.can.acceptance import Filters, filters_of, passes, received
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.family import CanFamily
from fieldrig_bus.can.frame import CanFrame

if TYPE_CHECKING:
    import can

log = logging.getLogger(__name__)

POLL_NS: Final = 1 * MS
BURST: Final = 64


class PythonCanSettings(Settings):
    """Settings of the interface.  All other keys are passed to `can.Bus` unchanged."""

    model_config = ConfigDict(strict=True, extra="allow", frozen=True)

    interface: str = Field(description="name of an interface of python-can, such as pcan or slcan")
    channel: str | int = Field(description="name or number of the channel, as this interface expects it")


class PythonCanEnd:
    def __init__(self, at: Attachment, bus: "can.BusABC") -> None:
        self._at, self._bus = at, bus
        self._handler: Callable[[CanFrame], None] | None = None
        self._filters: Filters | None = ()
        self._is_open = True
        self._fd = _descriptor(bus)
        if self._fd is None:
            self._poll()
        else:
            asyncio.get_running_loop().add_reader(self._fd, self._receive)

    def send(self, message: CanFrame) -> None:
        import can

        try:
            self._bus.send(to_python_can(message))
        except (can.CanError, OSError) as fault:  # a full queue or an unplugged adapter loses the frame, as a bus does
            log.debug("%s: %s", self._at.member, fault)
            return
        self._at.heard(self._at.member, message)

    def on_receive(self, handler: Callable[[CanFrame], None], interest: Sequence[object] | None = None) -> None:
        self._handler, self._filters = handler, filters_of(interest)

    def close(self) -> None:
        self._is_open = False
        if self._fd is not None:
            asyncio.get_running_loop().remove_reader(self._fd)
        self._bus.shutdown()

    def _poll(self) -> None:
        if self._is_open:
            self._receive()
            self._at.clock.call_at(self._at.clock.now_ns() + POLL_NS, self._poll)

    def _receive(self) -> None:
        import can

        try:
            for _ in range(BURST):
                message = self._bus.recv(0)
                if message is None:
                    return
                self._deliver(message)
        except (can.CanError, OSError) as fault:
            log.warning("%s: %s", self._at.member, fault)
            if self._fd is not None:
                asyncio.get_running_loop().remove_reader(self._fd)
                self._fd = None

    def _deliver(self, message: "can.Message") -> None:
        if message.is_error_frame or not message.is_rx or self._handler is None:
            return
        try:
            frame = from_python_can(message)
        except ValueError as fault:  # the driver of an adapter is from outside, too
            log.debug("%s: %s", self._at.member, fault)
            return
        if passes(received(frame), self._filters):
            self._at.deliver(self._handler, frame)


class PythonCan(CanFamily, DirectBus[CanMessage]):
    about: ClassVar[str] = "any interface of python-can"
    times: ClassVar[frozenset[Time]] = frozenset({"real"})
    messages: ClassVar[tuple[type, ...]] = (CanFrame,)
    settings: PythonCanSettings

    def __init__(self, name: str, settings: PythonCanSettings) -> None:
        super().__init__(name, settings)
        self._ends: dict[str, PythonCanEnd] = {}

    def python_can(self) -> dict[str, object]:
        return self.settings.model_dump()

    async def open(self, at: Attachment) -> Link[Any]:
        import can

        arguments: dict[str, Any] = self.python_can()
        try:
            bus = can.Bus(**arguments)
        except (can.CanError, OSError, ValueError, TypeError, ImportError) as cause:
            what = f"python-can cannot open {arguments}: {cause}"
            raise BusError(
                what, "`python -m can.viewer -i INTERFACE -c CHANNEL` shows whether it is available"
            ) from cause
        end = self._ends[at.member] = PythonCanEnd(at, bus)
        return end

    async def close(self, member: str) -> None:
        end = self._ends.pop(member, None)
        if end is not None:
            end.close()


def to_python_can(frame: CanFrame) -> "can.Message":
    import can

    return can.Message(
        arbitration_id=frame.identifier,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        dlc=frame.remote_length if frame.is_remote else len(frame.data),
        data=frame.data,
        is_fd=frame.is_fd,
        bitrate_switch=frame.is_bit_rate_switched,
    )


def from_python_can(message: "can.Message") -> CanFrame:
    """Return the frame of a message.  ValueError for one that no bus carries."""
    is_remote = bool(message.is_remote_frame)
    return CanFrame(
        message.arbitration_id,
        b"" if is_remote else bytes(message.data),
        bool(message.is_extended_id),
        is_remote,
        message.dlc if is_remote else 0,
        bool(message.is_fd),
        bool(message.bitrate_switch),
    )


def _descriptor(bus: "can.BusABC") -> int | None:
    try:
        fd = bus.fileno()
    except (NotImplementedError, OSError):
        return None
    return fd if fd >= 0 else None
