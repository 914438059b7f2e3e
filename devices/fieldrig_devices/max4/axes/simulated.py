"""A simulated MC-4: an axis without a drive, whose actual values are its set values (manual 3875-3877, digest PD-030).

It keeps the time of the brake, and has no load, no errors and no parameters.
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import MS, S
from fieldrig_devices.max4.axes.axis import Axis, AxisState, Mode
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.idn import Code, Element, ServiceError
from fieldrig_devices.sercos.service import Done

LIFTING_NS: Final = 100 * MS  # BrakeDisconnectionTime, manual 6075
MC4_STATES: Final = {AxisState.WAITING: 0x10, AxisState.ENABLING: 0x20, AxisState.CONTROLLED: 0x21}


class SimulatedDrive:
    """The drive end of a simulated axis."""

    def __init__(self, axis: Axis, cycle_ns: int) -> None:
        self._axis, self._cycle_ns = axis, cycle_ns
        self._rest_ns = 0
        self._place = 0.0
        self._command: tuple[Mode, float] | None = None

    def start(self) -> None:
        self._axis.drive = self
        self._enter(AxisState.WAITING)

    def stop(self) -> None:
        """Leave the axis, at power-off or reset."""
        self._axis.is_enabled = False
        self._axis.drive = None
        self._axis.enter(AxisState.NO_HARDWARE_ENABLE, 0x00, is_operating=False)

    def give(self) -> None:
        """Take the set value of this cycle from the axis."""
        self._command = self._axis.ask() if self._axis.is_controlled else None

    def take(self) -> None:
        """Update the actual values from the set value of the previous cycle."""
        axis = self._axis
        if not axis.is_enabled:
            axis.velocity, axis.torque = 0.0, 0
            if axis.axis_state is not AxisState.WAITING:
                self._enter(AxisState.WAITING)
        elif axis.axis_state is AxisState.WAITING:
            self._rest_ns = LIFTING_NS
            self._enter(AxisState.ENABLING)
        elif axis.axis_state is AxisState.ENABLING:
            self._rest_ns -= self._cycle_ns
            if self._rest_ns <= 0:
                self._enter(AxisState.CONTROLLED)
        elif self._command is not None:
            self._move(*self._command)

    def _move(self, mode: Mode, value: float) -> None:
        axis = self._axis
        if mode is Mode.POSITION:
            axis.velocity = (value - axis.position) * S / self._cycle_ns
            axis.position = round(value)
            self._place = float(axis.position)
        elif mode is Mode.VELOCITY:
            axis.velocity = value
            self._place += value * self._cycle_ns / S
            axis.position = round(self._place)
        else:
            axis.velocity, axis.torque = 0.0, round(value)

    def _enter(self, state: AxisState) -> None:
        self._place = float(self._axis.position)
        self._axis.enter(state, MC4_STATES[state])

    @property
    def status(self) -> int:
        return words.IN_OPERATION if self._axis.axis_state.value >= AxisState.ENABLING.value else words.POWERED

    def read(self, idn: int, element: Element, done: Done) -> None:
        done(ServiceError(Code.NO_IDN))

    def write(self, idn: int, data: bytes, done: Done) -> None:
        done(ServiceError(Code.NO_IDN))

    def command(self, idn: int, done: Callable[[bool], None]) -> None:
        done(True)
