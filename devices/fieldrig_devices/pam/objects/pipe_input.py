"""The inputs of an axis for a pipe, one for each mode of the converter (section 2.22 of the language's digest)."""

import math
from collections.abc import Callable, Mapping
from typing import Final, Protocol

from fieldrig_devices.pam.objects.site import ApplicationNode, Site
from fieldrig_devices.pam.objects.whole import LARGEST_UNITS
from fieldrig_devices.pam.pipes.block import is_same, nearest
from fieldrig_devices.pam.pipes.converter import Mode
from fieldrig_devices.pamring.frames import SetPoint, SetPointMode


class PipedAxis(Protocol):
    """An axis as its input for a pipe knows it."""

    name: str
    site: Site
    node: ApplicationNode
    units: float
    """Resolver units in a unit of length."""
    period: float | None
    """POSITION_PERIOD."""
    pipe: "PipeInput | None"
    """The pipe that drives the axis."""

    @property
    def position(self) -> float: ...


class PipeInput:
    """The input of an axis for the positions of a pipe; a set-point is sent only when it changes."""

    mode: Mode = "POSITION"
    set_point_mode = SetPointMode.POSITION

    def __init__(self, axis: PipedAxis, period_s: float, stop_all: Callable[[], None] | None) -> None:
        self._axis, self._period_s, self.stop_all = axis, period_s, stop_all
        self._units, self._site, self._send, self._name = axis.units, axis.site, axis.node.send, axis.name
        self._period, self._half = axis.period, (axis.period or math.inf) / 2
        self._passed = 0.0
        """The periods that the flow has passed; set-points go on, so no rounding of a period adds up (PAML-047)."""
        self.part = self.last = axis.position
        """The pipe's part of the position, now and one value before."""
        self.sent: int | None = None
        self.changed_in = -1
        """The basic cycle in which the pipe changed the position last."""

    @property
    def speed(self) -> float:
        return nearest(self.part - self.last, self._period) / self._period_s

    def go_on_from(self, known: "PipeInput") -> None:
        self.part, self.last, self.sent, self.changed_in = known.part, known.last, known.sent, known.changed_in
        self._passed = known._passed

    def take(self, value: float) -> None:
        """Take a value of the flow, and send it to the node.  OverflowError for one that no frame can carry."""
        set_point = self.follow(value)
        if set_point != self.sent and self._axis.pipe is self:
            self.note(set_point)
            if not -LARGEST_UNITS <= set_point <= LARGEST_UNITS:
                raise OverflowError("no frame can carry this set-point")
            self._send(SetPoint(self.set_point_mode, set_point))

    @property
    def is_at_rest(self) -> bool:
        """True if the last value of the flow, taken once more, would change nothing."""
        return is_same(self.last, self.part)

    def follow(self, value: float) -> int:
        """Take a position in units of the axis, and return the set-point."""
        last = self.part if self.sent is not None else value
        self.last, self.part = last, value
        step = value - last
        if self._period is not None and not -self._half <= step <= self._half:
            self._passed += nearest(step, self._period) - step
        return round((value + self._passed) * self._units)

    def note(self, set_point: int) -> None:
        """Note a set-point as sent; the pipe changes the position in this cycle."""
        site = self._site
        self.sent, self.changed_in = set_point, site.cycle
        site.moved.add(self._name)


class SpeedInput(PipeInput):
    """Set-points in mode SPEED; `part` is the way of the pipe since its beginning."""

    mode: Mode = "SPEED"
    set_point_mode = SetPointMode.SPEED

    def __init__(self, axis: PipedAxis, period_s: float, stop_all: Callable[[], None] | None) -> None:
        super().__init__(axis, period_s, stop_all)
        self.part = self.last = 0.0

    @property
    def speed(self) -> float:
        return self.last

    @property
    def is_at_rest(self) -> bool:
        """True unless the position is the integral of a speed."""
        return self.last == 0

    def follow(self, value: float) -> int:
        self.last = value
        if value:
            self.part += value * self._period_s
            self.changed_in = self._site.cycle
            self._site.moved.add(self._name)
        return round(value * self._units)


class TorqueInput(SpeedInput):
    """Torque limits in mode TORQUE."""

    mode: Mode = "TORQUE"
    set_point_mode = SetPointMode.TORQUE

    is_at_rest = True

    def follow(self, value: float) -> int:
        """Take a torque limit in Nm (PAML-484)."""
        return min(round(abs(value) / self._axis.site.readings.largest_torque_nm * 1000), 1000)


PIPE_INPUTS: Final[Mapping[str, type[PipeInput]]] = {
    "POSITION": PipeInput,
    "SPEED": SpeedInput,
    "TORQUE": TorqueInput,
}
