"""The motion blocks: PTOMoveRelative, PTOMoveVelocity and PTOStop (SCU-033 to SCU-052)."""

from typing import Final

from fieldrig_devices.hmiscu.blocks.axis_block import AxisBlock
from fieldrig_devices.hmiscu.blocks.tables import PTO_MOVE_RELATIVE, PTO_MOVE_VELOCITY, PTO_STOP
from fieldrig_devices.hmiscu.pto.channel import PtoChannel
from fieldrig_devices.hmiscu.pto.command import Command, Order
from fieldrig_devices.hmiscu.pto.matrix import Next

_ORDER_PINS: Final = ("Velocity", "Distance", "Acceleration", "Deceleration", "Direction")


class MotionBlock(AxisBlock):
    """A block whose command the channel carries out."""

    kind: Next
    _command: Command | None = None

    def _start(self, now_ns: int, axis: PtoChannel) -> None:
        order = Order(self.kind, *(self.inputs.get(pin, 0) for pin in _ORDER_PINS))
        self._command = axis.give(now_ns, order)
        self._take_status()

    def _follow(self, now_ns: int, axis: PtoChannel, is_executed: bool) -> None:
        if self._command is not None:
            self._command.is_held = is_executed
        axis.advance(now_ns)
        self._take_status()

    def _take_status(self) -> None:
        if self._command is not None:
            self.status, self.error = self._command.status, self._command.error


class PTOMoveRelative(MotionBlock):
    """Moves the axis by a number of pulses."""

    type = PTO_MOVE_RELATIVE
    kind = Next.MOVE_RELATIVE

    def call(self, now_ns: int) -> None:
        super().call(now_ns)
        self.outputs["Active"] = self._command is not None and self._command.is_active
        for axis in self._axes.values():
            axis.executing.discard(self)
        axis_now = self._axes.get(self.inputs["PTO_REF_IN"])
        if axis_now is not None and self.inputs["Execute"]:
            axis_now.executing.add(self)


class PTOMoveVelocity(MotionBlock):
    """Moves the axis at a velocity until another command comes."""

    type = PTO_MOVE_VELOCITY
    kind = Next.MOVE_VELOCITY
    reached = "InVelocity"


class PTOStop(MotionBlock):
    """Stops the axis, and holds it while Execute is TRUE."""

    type = PTO_STOP
    kind = Next.STOP
