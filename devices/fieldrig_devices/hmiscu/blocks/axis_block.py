"""The part that all PTO blocks with Execute have in common: reference, edge, and status pins (SCU-077 to SCU-082)."""

from collections.abc import Mapping

from fieldrig_devices.hmiscu.blocks.pins import Block
from fieldrig_devices.hmiscu.enumerations import ErrorId
from fieldrig_devices.hmiscu.pto.channel import PtoChannel
from fieldrig_devices.hmiscu.pto.command import Status
from fieldrig_devices.hmiscu.pto.status import Diagnosis

Axes = Mapping[int, PtoChannel]
"""The PTO channels by the value of PTO_REF.  0 is the reference of no channel."""

REF_OF_CHANNEL_0 = 1


class AxisBlock(Block):
    """A block that acts on a rising edge of Execute.  The reference is read at the edge as well (SCU-076)."""

    reached = "Done"
    """The pin that shows success."""

    def __init__(self, axes: Axes) -> None:
        super().__init__()
        self._axes = axes
        self._axis: PtoChannel | None = None
        self._was_executed = False
        self._is_shown = True
        """True once the final status has been shown."""
        self.status: Status | None = None
        self.error = ErrorId.NO_ERROR

    def call(self, now_ns: int) -> None:
        is_executed = bool(self.inputs["Execute"])
        if is_executed and not self._was_executed:
            self._begin(now_ns)
        elif self._axis is not None:
            self._follow(now_ns, self._axis, is_executed)
        self._was_executed = is_executed
        self.outputs["PTO_REF_OUT"] = self.inputs["PTO_REF_IN"]
        self._show(is_executed)

    def _begin(self, now_ns: int) -> None:
        self._axis = self._axes.get(self.inputs["PTO_REF_IN"])
        self._is_shown = False
        if self._axis is not None:
            self._start(now_ns, self._axis)
            return
        self.status, self.error = Status.ERROR, ErrorId.PTO_UNKNOW_REF
        for axis in self._axes.values():
            axis.diagnosis |= Diagnosis.CONFIGURATION_ERROR

    def _start(self, now_ns: int, axis: PtoChannel) -> None:
        """Act at the rising edge; set `status` and `error`."""
        raise NotImplementedError

    def _follow(self, now_ns: int, axis: PtoChannel, is_executed: bool) -> None:
        """Bring `status` and `error` up to date, in every other cycle."""

    def _show(self, is_executed: bool) -> None:
        """Set the status pins.  A final status without Execute is shown once (SCU-082)."""
        status = self.status
        if status is not Status.BUSY and not is_executed and self._is_shown:
            status = None
        if status is not None and status is not Status.BUSY:
            self._is_shown = True
        self._set_pins(status)

    def _set_pins(self, status: Status | None) -> None:
        self.outputs[self.reached] = status is Status.REACHED
        self.outputs["Busy"] = status is Status.BUSY
        if "CommandAborted" in self.outputs:
            self.outputs["CommandAborted"] = status is Status.ABORTED
        self.outputs["Error"] = status is Status.ERROR
        self.outputs["ErrID"] = self.error if status is Status.ERROR else ErrorId.NO_ERROR
