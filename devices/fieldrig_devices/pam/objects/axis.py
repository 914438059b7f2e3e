"""Axes: orders to the trapezoid in the node, and set-points of pipes (section 2.3 of the language's digest).

The position of an axis is the sum of two parts: its own, which its orders move, and that of a pipe (PAML-042).  The PAM
knows the destination of its orders, and the own part exactly only when they are done (PAML-061, PAML-064).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem, has_error
from fieldrig_devices.pam.objects.parameters import AboveZero
from fieldrig_devices.pam.objects.pipe_input import PIPE_INPUTS, PipeInput
from fieldrig_devices.pam.objects.site import ApplicationNode, Site
from fieldrig_devices.pam.objects.whole import nearest_units
from fieldrig_devices.pam.pipes.block import nearest, wrapped
from fieldrig_devices.pam.pipes.converter import Input, Mode
from fieldrig_devices.pamring.axis_words import ERROR_MASK, Status
from fieldrig_devices.pamring.frames import (
    AxisItem,
    AxisOrder,
    AxisReport,
    EndOfPipe,
    Move,
    SetPointMode,
)


class Axis(ObjectItem):
    travel_speed = AboveZero()
    acceleration = AboveZero()
    deceleration = AboveZero()

    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self.node, self.site = node, site
        self.units = declared.number("PULSES_PER_UNIT")
        """Resolver units in a unit of length; a negative number turns the motor the other way (PAML-046)."""
        self.period = declared.number("POSITION_PERIOD") or None
        self.travel_speed = declared.number("TRAVEL_SPEED")
        self.acceleration = declared.number("ACCELERATION")
        self.deceleration = declared.number("DECELERATION", self.acceleration)
        self.initial_position = declared.number("INITIAL_POSITION")
        """A program may write it; it has effect at the next start (E-01)."""
        self.pipe: PipeInput | None = None
        """The pipe that drives the axis."""
        self.watchers: list[Callable[[], None]] = []
        """They are called when an order is done."""
        self.on_stop: list[Callable[[], None]] = []
        """They are called before a stop, which ends what else moves the axis."""
        self.is_grouped = False
        self._run_lasts = not site.readings.run_is_ready_at_speed
        self._runs = False
        """True during a run that is complete only when it ends."""
        self._shows_in_node = site.readings.st1_nodes_have_errors
        self._status = self._error = 0
        self.ordered = self._done = 0
        """The numbers of the last order, and of the last that is done."""
        self._own = self.initial_position
        node.add(self._axis_item)
        node.axis_receiver = self.on_report

    def _axis_item(self, item: int) -> AxisItem:
        period = abs(round(self.units * self.period)) if self.period is not None else 0
        return AxisItem(item, round(self.initial_position * self.units), period)

    # ---- the state

    def on_report(self, report: AxisReport) -> None:
        """Take the state of the axis; a finished order makes the own part exact."""
        was_ready = self.is_ready
        self._status, self._error = report.status, report.error & ERROR_MASK
        self._done = report.number or self._done
        if self._runs and self._done == self.ordered and not report.status & Status.IN_RUN:
            self._runs = False  # the node has ended the run by itself
        if self._shows_in_node:
            self.node.error_word = self._error
            self.site.touched(self.node.name)
        if self.is_ready and not was_ready:
            self._correct(report)
            self.site.events += self.watchers
        self.site.touched(self.name)

    def _correct(self, report: AxisReport) -> None:
        """Make the own part exact, unless a pipe has begun or ended since the report, which changes the part."""
        if bool(report.status & Status.SYNCHRONISED) is not (self.pipe is not None and self.pipe.mode != "TORQUE"):
            return
        own = report.set_point / self.units
        # The report is in whole units, and the sum of the orders is known more exactly here.
        if abs(nearest(own - self._own, self.period)) > 1 / abs(self.units):
            self._own = wrapped(own, self.period)

    @property
    def is_ready(self) -> bool:
        return self._done == self.ordered and not self._runs

    @property
    def position(self) -> float:
        part = self.pipe.part if self.pipe is not None else 0.0
        return wrapped(self._own + part, self.period)

    def ask_ready(self) -> bool:
        return self.is_ready

    def ask_position(self) -> float:
        return self.position

    def ask_speed(self) -> float:
        return self.pipe.speed if self.pipe is not None else 0.0

    def ask_generator_position(self) -> float:
        return wrapped(self._own, self.period)

    def ask_pipe_motionless(self) -> bool:
        """True once the last set-point of the pipe has reached the node, one cycle after it was sent (PAML-063)."""
        return self.is_grouped or self.pipe is None or self.pipe.changed_in < self.site.cycle

    def ask_status(self, mask: int | None = None) -> int | bool:
        return has_error(self._status, mask)

    def ask_error(self) -> bool:
        return bool(self._error)

    def ask_error_code(self, mask: int | None = None) -> int | bool:
        return has_error(self._error, mask)

    # ---- orders

    def carry_out(self, function: str, arguments: Sequence[Any], number: int) -> AxisOrder:
        """Return the order of an executive function, as if it were sent, with its number in this PAM.

        An axes set sends one order for all axes of a group, so making an order and sending it are two steps.
        """
        order = _ORDERS[function](self, *arguments)
        if order.number:
            order = replace(order, number=number)
            self.ordered = number
            if order.move is not Move.POSITION:
                self._runs = self._run_lasts and order.move is Move.RUN and order.value != 0
        self.site.touched(self.name)
        return order

    def do(self, function: str, arguments: Sequence[Any] = ()) -> None:
        """Give an order.  A stop ends the pipe of all axes of a set that it drives (PAML-057)."""
        if function == "stop" and self.pipe is not None and self.pipe.stop_all is not None:
            self.pipe.stop_all()
        else:
            self._send(function, arguments)

    def _send(self, function: str, arguments: Sequence[Any] = ()) -> None:
        self.node.send(self.carry_out(function, arguments, self.site.next_number((self.ordered,))))

    def halt(self) -> None:
        """Stop the motion of the axis's own part alone, without an end of what else moves it."""
        self._send("halt")

    def _absolute_move(self, position: float) -> AxisOrder:
        position = float(position)
        if self.site.readings.takes_shorter_way:
            position = self._own + nearest(position - self._own, self.period)
        self._own = wrapped(position, self.period)
        return self._limited(Move.ABSOLUTE_MOVE, position, self.travel_speed)

    def _relative_move(self, distance: float) -> AxisOrder:
        self._own = wrapped(self._own + distance, self.period)
        return self._limited(Move.RELATIVE_MOVE, distance, self.travel_speed)

    def _run(self, speed: float) -> AxisOrder:
        return self._limited(Move.RUN, speed, abs(speed))

    def _power_on(self) -> AxisOrder:
        """Set the position to 0, or by the other reading to INITIAL_POSITION (1130, 6838)."""
        self._own = self.initial_position if self.site.readings.power_on_sets_initial_position else 0.0
        return AxisOrder(1, Move.POWER_ON, nearest_units(self._own * self.units))

    def _power_off(self) -> AxisOrder:
        return self._limited(Move.POWER_OFF, 0.0, 0.0)

    def _stop(self) -> AxisOrder:
        for action in list(self.on_stop):
            action()
        if self.pipe is not None:
            self._own, self.pipe = self.position, None
            self.site.joined(self.name)
        return self._halt()

    def _halt(self) -> AxisOrder:
        return self._limited(Move.STOP, 0.0, 0.0)

    def _position(self, position: float) -> AxisOrder:
        """Name the position; a report that is older has the old name, so a present order ends under a new number."""
        part = self.pipe.part if self.pipe is not None else 0.0
        self._own = wrapped(position - part, self.period)
        return AxisOrder(0 if self.is_ready else 1, Move.POSITION, nearest_units(position * self.units))

    def _update_status(self) -> AxisOrder:
        return AxisOrder(0, Move.UPDATE_STATUS)

    def _limited(self, move: Move, value: float, speed: float) -> AxisOrder:
        scale = abs(self.units)
        limits = (nearest_units(limit * scale) for limit in (speed, self.acceleration, self.deceleration))
        return AxisOrder(1, move, nearest_units(value * self.units), *limits)

    # ---- the end of a pipe

    def attach(self, mode: Mode, period_s: float) -> Input:
        return self.join(mode, period_s)

    def join(self, mode: Mode, period_s: float, stop_all: Callable[[], None] | None = None) -> PipeInput:
        """A pipe drives the axis from now on; without a step of the mode if another one did before (G-45)."""
        known = self.pipe
        if known is not None and known.mode != mode:
            self.detach()
            known = None
        pipe = PIPE_INPUTS[mode](self, period_s, stop_all)
        if known is not None:
            pipe.go_on_from(known)
        elif mode == "POSITION":
            self._own = 0.0
        self.pipe = pipe
        if known is None:
            self.site.joined(self.name)
        return pipe

    def detach(self) -> None:
        """The pipe has ended: its part of the position becomes the axis's own (PAML-406)."""
        if self.pipe is not None:
            mode = SetPointMode[self.pipe.mode]
            self._own, self.pipe = self.position, None
            self.node.send(EndOfPipe(mode))
            self.site.joined(self.name)


_ORDERS: Final[Mapping[str, Callable[..., AxisOrder]]] = {
    "absolute_move": Axis._absolute_move,
    "relative_move": Axis._relative_move,
    "run": Axis._run,
    "power_on": Axis._power_on,
    "power_off": Axis._power_off,
    "stop": Axis._stop,
    "halt": Axis._halt,
    "position": Axis._position,
    "update_status": Axis._update_status,
}
"""The executive functions, and `halt`, which only the PAM itself uses."""
