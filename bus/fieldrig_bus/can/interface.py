"""The interface `fieldrig` of python-can: `can.Bus(interface="fieldrig", channel="can0")`, by the name in the rig file.

In a block of `virtual_time` it is an end of the bus itself.  In real time it joins the hub or the medium of the bus in
the rig at the control endpoint (`FIELDRIG_CONTROL`), so the bus needs no port for it.
Source: python-can 4.6, "Developer's overview".  Left out: error frames, and echoes of own frames.
"""

from typing import TYPE_CHECKING, Any

import can

from fieldrig.errors import RigError
from fieldrig.master_time.active import waiting_scheduler
from fieldrig.master_time.clocks import EPOCH_NS
from fieldrig.master_time.door import Door
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.python_can import from_python_can, to_python_can

if TYPE_CHECKING:
    from fieldrig.hub.program_end import ProgramEnd

NS: float = 1e-9


class FieldrigBus(can.BusABC):
    """One end of a CAN bus of the rig."""

    def __init__(self, channel: Any = None, can_filters: Any = None, **options: Any) -> None:
        """`channel` is the name of a bus in the rig file.  CanInitializationError if there is no such CAN bus."""
        if channel is None:
            known = ", ".join(_channels()) or "no rig answers, or it has no CAN bus"
            raise can.CanInitializationError(f"the interface fieldrig needs the channel of a bus: {known}")
        try:
            self._end = _end(str(channel))
        except RigError as wrong:
            raise can.CanInitializationError(str(wrong)) from wrong
        self.channel_info = f"fieldrig {channel}"
        super().__init__(channel, can_filters)
        self._can_protocol = can.CanProtocol.CAN_FD if options.get("fd") else can.CanProtocol.CAN_20

    @staticmethod
    def _detect_available_configs() -> list[Any]:
        """Return what `can.Bus` takes for each CAN bus of the rig, in the time of this thread."""
        return [{"interface": "fieldrig", "channel": name} for name in _channels()]

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a message.  CanOperationError for one that this bus cannot carry."""
        try:
            self._end.send(from_python_can(msg))
        except (TypeError, ValueError, RigError) as wrong:
            raise can.CanOperationError(str(wrong)) from wrong

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            received = self._end.receive(timeout)
        except RigError as wrong:
            raise can.CanOperationError(str(wrong)) from wrong
        if received is None:
            return None, False
        instant_ns, frame = received
        assert isinstance(frame, CanFrame)
        message = to_python_can(frame)
        message.timestamp, message.channel = instant_ns * NS, self.channel_info
        return message, False

    def shutdown(self) -> None:
        super().shutdown()
        self._end.close()


class _VirtualEnd(Door[CanMessage]):
    """An end in virtual time, with instants of Unix time as the clocks of the block have them."""

    def receive(self, timeout_s: float | None) -> tuple[int, CanMessage] | None:
        received = super().receive(timeout_s)
        return None if received is None else (EPOCH_NS + received[0], received[1])


def _end(bus: str) -> "_VirtualEnd | ProgramEnd[CanMessage]":
    """Join the bus in the time of this thread.  RigError if there is no such CAN bus."""
    if waiting_scheduler() is not None:
        return _VirtualEnd(bus, "python-can", is_wanted=_is_frame)
    from fieldrig.hub.program_end import ProgramEnd

    return ProgramEnd(bus, "can", "python-can", is_wanted=_is_frame)


def _channels() -> list[str]:
    """Return the CAN buses that this thread may join; none without a rig."""
    scheduler = waiting_scheduler()
    if scheduler is not None:
        return [name for name, entry in scheduler.rig.config.buses.items() if entry.bus.family == "can"]
    from fieldrig.hub.program_end import joinable

    return joinable("can")


def _is_frame(message: CanMessage) -> bool:
    return isinstance(message, CanFrame)
