"""The blocks that manage, adjust and diagnose an axis (SCU-028 to SCU-032, SCU-056 to SCU-059)."""

import logging

from fieldrig_devices.hmiscu.blocks.axis_block import AxisBlock
from fieldrig_devices.hmiscu.blocks.pins import Block
from fieldrig_devices.hmiscu.blocks.tables import PTO_GET_DIAG, PTO_GET_PARAM, PTO_SET_PARAM, PTO_SIMPLE
from fieldrig_devices.hmiscu.enumerations import ErrorId
from fieldrig_devices.hmiscu.pto.channel import PtoChannel
from fieldrig_devices.hmiscu.pto.command import Status
from fieldrig_devices.hmiscu.pto.status import MotionState

log = logging.getLogger(__name__)

_WRAP = 1 << 32


class PTOSimple(Block):
    """The axis itself.  A program calls it in every MAST cycle."""

    type = PTO_SIMPLE

    def __init__(self, channel: PtoChannel, reference: int) -> None:
        """`reference` is the value of PTO_REF, from 1 to 255."""
        super().__init__()
        self._channel, self._reference = channel, reference
        self._was_reset = False

    def call(self, now_ns: int) -> None:
        channel = self._channel
        channel.is_drive_ready_ignored = bool(self.inputs["DIS_AuxInput"])
        channel.advance(now_ns)
        is_reset = bool(self.inputs["ResetError"])
        if is_reset and not self._was_reset:
            channel.reset(now_ns)
            if channel.reset_problem:
                log.warning("ResetError has no effect: %s", channel.reset_problem)
        self._was_reset = is_reset
        self.outputs.update(
            PTO_REF=self._reference,
            PTOError=channel.state is MotionState.ERROR_STOP,
            Moving=channel.is_moving,
            Stopping=channel.is_stopping,
            Frequency=channel.output.frequency_at(now_ns),
            Distance=channel.distance_at(now_ns) % _WRAP,
        )


class _ParameterBlock(AxisBlock):
    """A block whose outputs hold until the next rising edge (SCU-058)."""

    def _show(self, is_executed: bool) -> None:
        self._set_pins(self.status)

    def _finish(self, error: ErrorId = ErrorId.NO_ERROR) -> None:
        self.status = Status.REACHED if error is ErrorId.NO_ERROR else Status.ERROR
        self.error = error


class PTOGetParam(_ParameterBlock):
    """Reads the start or stop frequency."""

    type = PTO_GET_PARAM

    def _start(self, now_ns: int, axis: PtoChannel) -> None:
        value = axis.parameters.get(self.inputs["Param"])
        if value is None:
            self._finish(ErrorId.PTO_UNKNOW_PARAMETER)
        else:
            self.outputs["ParamValue"] = value
            self._finish()


class PTOSetParam(_ParameterBlock):
    """Writes the start or stop frequency, for the commands that follow."""

    type = PTO_SET_PARAM

    def _start(self, now_ns: int, axis: PtoChannel) -> None:
        selector, value = self.inputs["Param"], self.inputs["Param_Value"]
        if selector not in axis.parameters:
            self._finish(ErrorId.PTO_UNKNOW_PARAMETER)
        elif not 0 <= value <= axis.settings.maximum_frequency_hz:
            self._finish(ErrorId.PTO_INVALID_PARAMETER)
        else:
            axis.parameters[selector] = value
            self._finish()


class PTOGetDiag(AxisBlock):
    """Reads the causes of the axis' error."""

    type = PTO_GET_DIAG

    def _start(self, now_ns: int, axis: PtoChannel) -> None:
        axis.advance(now_ns)
        self.outputs["PTODiag"] = int(axis.diagnosis)
        self.status, self.error = Status.REACHED, ErrorId.NO_ERROR
