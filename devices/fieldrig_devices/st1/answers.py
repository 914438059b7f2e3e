"""The reports of an axis: its words, the last order that is done, and its own part (PAML-059, PAMS-055)."""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.pamring.axis_words import Status
from fieldrig_devices.pamring.frames import AxisReport
from fieldrig_devices.pamring.registers import rolled
from fieldrig_devices.st1.set_position import Doing, SetPosition

DOING: Final = {Doing.NOTHING: 0, Doing.MOVE: Status.IN_MOVE, Doing.RUN: Status.IN_RUN, Doing.STOP: 0}

SET_POINT_BITS: Final = 64
"""Bits of the own part in a report."""


def status_of(setting: SetPosition, *, is_powered: bool, needs_stop: bool) -> int:
    """Return the status word of an axis, table 12-4; with `needs_stop` only a stop sets STOPPED."""
    pipe, doing = setting.pipe, setting.doing
    is_driven = pipe.mode is not None and not pipe.is_ending
    status = DOING[doing] | (Status.SYNCHRONISED if is_driven else 0) | (0 if is_powered else Status.POWER_OFF)
    is_stopped = doing is Doing.NOTHING and pipe.mode is None and (setting.was_stopped or not needs_stop)
    return int(status | (Status.STOPPED if is_stopped else 0))


class Answers:
    def __init__(self, send: Callable[[AxisReport], None]) -> None:
        self._send = send
        self.forget()

    def forget(self) -> None:
        """Report nothing until the axis is configured again."""
        self.is_axis = self.waits = False
        """True if the axis is configured; true while the last order is not done."""
        self.done = self._latest = 0
        self._last: AxisReport | None = None

    def begin(self, number: int) -> None:
        """Take an order; those with the number 0 are not reported."""
        self._latest = number or self._latest

    def repeat(self) -> None:
        """Report also what has not changed."""
        self._last = None

    def report(self, status: int, error: int, own: int, *, is_moving: bool) -> None:
        """Report the axis if any of it has changed; the own part of an axis that moves changes all the time."""
        if not self.waits:
            self.done = self._latest
        if not self.is_axis:
            return
        last = self._last
        if last is not None and is_moving:
            own = last.set_point
        report = AxisReport(status, error, self.done, rolled(own, SET_POINT_BITS))
        if report != last:
            self._last = report
            self._send(report)
