"""The program of an ST1: it passes the orders of the PAM on to the axis, the boards and the registers."""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import Clock
from fieldrig_devices.pamring.ends import NodePort, RingFault
from fieldrig_devices.pamring.frames import (
    Answer,
    AxisItem,
    AxisOrder,
    Configuration,
    EndOfPipe,
    InputItem,
    Order,
    OutputItem,
    Read,
    SetOutput,
    SetPoint,
    Severity,
    Trouble,
)
from fieldrig_devices.st1.boards import Boards
from fieldrig_devices.st1.registers import Registers
from fieldrig_devices.st1.servo import Servo
from fieldrig_devices.st1.settings import St1Settings

WARNING: Final = 0x00C
"""The message of a node with a code of table 12-2 (11772-11800)."""
UNDECLARED: Final = 0x0B
DEAD: Final = (RingFault.INACTIVE, RingFault.CARRIER)
"""Faults without cycles."""


class Program:
    """The `NodeProgram` of an ST1; its three parts can be used alone."""

    def __init__(self, clock: Clock, settings: St1Settings, port: NodePort, drive: Callable[[int, bool], None]) -> None:
        """`drive` is called with the number of an output and its level."""
        self._port = port
        self.servo = Servo(clock, settings, port.send)
        self.boards = Boards(
            clock,
            settings.parameters.cacout,
            settings.readings,
            has_oio=settings.oio_board,
            send=port.send,
            drive=drive,
        )
        self.registers = Registers({}, {}, {})

    def forget(self) -> None:
        self.boards.forget()
        self.servo.forget()

    def accept(self, item: Configuration) -> bool:
        if isinstance(item, InputItem):
            return self.boards.accept_input(item)
        if isinstance(item, OutputItem):
            return self.boards.accept_output(item)
        return isinstance(item, AxisItem) and self.servo.accept(item)

    def run(self) -> None:
        self.boards.run()
        self.servo.report()

    def order(self, order: Order) -> None:
        if isinstance(order, SetPoint):
            self.servo.set_point(order)
        elif isinstance(order, AxisOrder):
            self.servo.order(order)
        elif isinstance(order, EndOfPipe):
            self.servo.end_of_pipe(order)
        elif isinstance(order, Read):
            self._port.send(Answer(order.request, self.registers.read(order.register)))
        elif not isinstance(order, SetOutput) or not self.boards.set_output(order.item, bool(order.value & 1)):
            self._refuse(order)

    def _refuse(self, order: Order) -> None:
        """Report an item that is not there (0Bh); what the node's end answers itself has none."""
        item: int | None = getattr(order, "item", None)
        if item is not None:
            self._port.send(Trouble(Severity.WARNING, WARNING, (UNDECLARED, item)))

    def cycle(self) -> None:
        self.servo.cycle()

    def ring(self, fault: RingFault) -> None:
        self.servo.ring(fault in DEAD, fault is not RingFault.NONE)
