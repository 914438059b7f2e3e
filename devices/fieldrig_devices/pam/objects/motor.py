"""DC motors: the PAM's side; the motion is in the Smart-IO (section 2.6 of the language's digest)."""

from typing import Final

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.inputs import BinaryInput, CounterInput
from fieldrig_devices.pam.objects.object_item import ObjectItem, has_error
from fieldrig_devices.pam.objects.outputs import BinaryOutput
from fieldrig_devices.pam.objects.site import ApplicationNode, Site, number_after
from fieldrig_devices.pam.objects.whole import whole_count
from fieldrig_devices.pam.runtime.item import Pending
from fieldrig_devices.pamring.frames import Motor, MotorItem, MotorOrder, MotorReport

POSITION_TIMEOUT: Final = 0x000008
"""DCM_INQ_POS_TIMEOUT in the error code of a motor (PAMS-053)."""
POSITION_TIMEOUT_CODE: Final = 0x12
POSITION_LOST: Final = 0x002000
"""The error that outlives the next order: it ends when the position is named."""
DIRECTIONS: Final = {"INC": 1, "DEC": -1}


class DcMotor(ObjectItem):
    """Positions are in pulses."""

    def __init__(
        self,
        declared: Declared,
        site: Site,
        node: ApplicationNode,
        outputs: tuple[BinaryOutput, BinaryOutput],
        inputs: tuple[BinaryInput, CounterInput],
    ) -> None:
        super().__init__(declared.name)
        self._site, self._node = site, node
        self._is_ready = True
        self._error = 0
        self._ordered = 0
        """The number of the last order that ends."""
        parts = (outputs[0].item, outputs[1].item, inputs[0].item, inputs[1].item)
        timeout_ms, braking = declared.integer("TIMEOUT"), declared.integer("BRAKING")
        self._item = node.add(lambda item: MotorItem(item, *parts, timeout_ms, braking), self._on_report, MotorReport)

    def _on_report(self, report: MotorReport) -> None:
        """Take the state of the motor, unless it is that of before the last order."""
        if report.number != self._ordered:
            return
        self._is_ready, self._error = report.is_ready, report.error
        self._site.kernel.touched(self.name)

    def ask_ready(self) -> bool:
        return self._is_ready

    def ask_error(self) -> bool:
        return bool(self._error)

    def ask_error_code(self, mask: int | None = None) -> int | bool:
        return has_error(self._error, mask)

    def ask_position(self) -> Pending:
        """Ask the node over the ring; a time-out is an error of the motor (PAML-128)."""
        answer = Pending()

        def take(position: int | None) -> None:
            answer.value = position if position is not None else 0
            if position is None:
                self._error |= POSITION_TIMEOUT
                self._site.kernel.report("04..W010", (self._node.address, self._item, POSITION_TIMEOUT_CODE))
            self._site.kernel.touched(self.name)

        self._site.read(self._node, self._item, take)
        return answer

    def do_absolute_move(self, target: float) -> None:
        self._move(Motor.ABSOLUTE_MOVE, whole_count(target))

    def do_relative_move(self, distance: float) -> None:
        self._move(Motor.RELATIVE_MOVE, whole_count(distance))

    def do_run(self, direction: str) -> None:
        self._move(Motor.RUN, DIRECTIONS[direction])

    def do_stop(self) -> None:
        self._begin(Motor.STOP)

    def do_zero_position(self, direction: str, level: str) -> None:
        self._move(Motor.ZERO_POSITION, DIRECTIONS[direction], int(level == "HIGH"))

    def do_position(self, position: float) -> None:
        self._send(Motor.POSITION, whole_count(position))

    def do_stroke_limits(self, lower: float, upper: float) -> None:
        self._limits = whole_count(lower), whole_count(upper)
        self._send(Motor.STROKE_LIMITS, *self._limits)

    def do_disable_stroke_limits(self) -> None:
        self._send(Motor.DISABLE_STROKE_LIMITS)

    def do_enable_stroke_limits(self) -> None:
        """Set the last limits again; there is no effect before the first."""
        if self._limits is not None:
            self._send(Motor.STROKE_LIMITS, *self._limits)

    _limits: tuple[int, int] | None = None

    def _move(self, order: Motor, *values: int) -> None:
        """Send an order to move, which ends the errors of the last one."""
        self._error &= POSITION_LOST
        self._begin(order, *values)

    def _begin(self, order: Motor, *values: int) -> None:
        """Send an order that ends; the node reports its end with the number of the order."""
        self._ordered = number_after(self._ordered)
        self._is_ready = False
        self._node.send(MotorOrder(self._item, order, values, self._ordered))
        self._site.kernel.touched(self.name)

    def _send(self, order: Motor, *values: int) -> None:
        self._node.send(MotorOrder(self._item, order, values))
