"""An axis of the MAx-4 as the motor of a CiA 402 axis, and the CiA 402 axis as its source of set values.

ControllerEnable is the only command of the controller to a drive, so 'disable voltage' resets it, and the drive stops
as its own options say (manual chapter 10).  A fault reset of an axis that is not on the ring acknowledges ("quits") the
diagnoses of the whole controller, because only that brings the ring up again.
"""

from collections.abc import Callable
from math import inf
from typing import Final, Protocol

from fieldrig_devices.cia402.motor import Kind
from fieldrig_devices.max4.axes.axis import INCREMENTS, Axis, AxisState, Mode
from fieldrig_devices.max4.axis_inputs import AxisInputs
from fieldrig_devices.max4.can.errors import error_of
from fieldrig_devices.max4.can.torque_limit import TorqueLimit
from fieldrig_devices.max4.configuration.tree import Parameter

MODES: Final = {Kind.POSITION: Mode.POSITION, Kind.VELOCITY: Mode.VELOCITY, Kind.TORQUE: Mode.TORQUE}
_NOT_READY: Final = (AxisState.NO_HARDWARE_ENABLE, AxisState.ERROR)


class Guide(Protocol):
    """The source of set values: a CiA 402 axis."""

    kind: Kind
    set_value: float


class AxisMotor:
    """The motor of a CiA 402 axis; without an axis of the controller it is not present."""

    def __init__(self, quit_all: Callable[[], None]) -> None:
        self._quit_all = quit_all
        self._axis: Axis | None = None
        self.guide: Guide | None = None
        self._inputs, self._has_inputs = AxisInputs({}), False
        self._outputs: dict[int, Parameter] = {}
        self._shown_outputs = 0
        self._resetting: Callable[[], None] | None = None
        self._torque_limit = TorqueLimit()
        self.mode = Mode.POSITION
        self.kind = Kind.POSITION
        """Kind of the set values of the guide, as in `mode`."""
        self.revolution = INCREMENTS
        self.is_changed = True
        """True if the state or diagnosis of the axis has changed since the last cycle of the CiA 402 axis."""
        self.is_ready = self.is_stopping = self.has_warning = False
        self.errors: tuple[int, ...] = ()

    def bind(self, axis: Axis | None, inputs: dict[int, Parameter], outputs: dict[int, Parameter]) -> None:
        """Connect to an axis after a boot, with its terminals by bits of 60FDh and 60FEh."""
        if self._axis is not None:
            self._axis.watchers.remove(self._on_change)
        self._axis, self._inputs, self._outputs = axis, AxisInputs(inputs), outputs
        self._has_inputs = bool(inputs)
        if axis is not None:
            axis.watchers.append(self._on_change)
        self._torque_limit.bind(axis)
        self._on_change()
        self._resetting = None
        self._shown_outputs = 0

    def _on_change(self) -> None:
        """Take over a change of the state or diagnosis of the axis."""
        axis = self._axis
        self.is_changed = True
        self.is_ready = axis is not None and axis.is_operating and axis.axis_state not in _NOT_READY
        self.is_stopping = axis is not None and axis.axis_state is AxisState.STOPPING
        self.errors = (error_of(axis.diag_code),) if axis is not None and axis.is_in_error else ()
        self.has_warning = axis is not None and axis.diag_code != 0 and not self.errors
        self._torque_limit.send()

    def refresh(self) -> None:
        """Finish a reset once the axis is on the ring again; called before each cycle of the CiA 402 axis."""
        axis = self._axis
        self.is_changed = False
        if self._resetting is None or axis is None or self.errors:
            return
        if axis.is_operating and axis.axis_state is not AxisState.ERROR:
            done, self._resetting = self._resetting, None
            done()

    @property
    def axis(self) -> Axis | None:
        return self._axis

    # ---- `cia402.motor.Motor`

    @property
    def kinds(self) -> frozenset[Kind]:
        axis = self._axis
        return frozenset(kind for kind, mode in MODES.items() if axis is not None and mode in axis.modes)

    @property
    def is_there(self) -> bool:
        return self._axis is not None

    @property
    def is_following(self) -> bool:
        axis = self._axis
        return axis is not None and axis.is_controlled and axis.set_values is self

    @property
    def position(self) -> int:
        return self._axis.position if self._axis is not None else 0

    @property
    def velocity(self) -> float:
        return self._axis.velocity if self._axis is not None else 0.0

    @property
    def torque(self) -> int:
        return self._axis.torque if self._axis is not None else 0

    @property
    def rated_torque_mnm(self) -> int:
        """Rated torque in mN m from the name plate, as the drive has read it."""
        return self._plate_value("RatedTorque")

    @property
    def current(self) -> int:
        """A synchronous motor has torque in proportion to its current."""
        return self.torque

    @property
    def torque_by_current(self) -> float:
        return 1.0

    @property
    def rated_current_ma(self) -> int:
        """Standstill current in mA from the name plate, which is what the motor carries all the time."""
        return self._plate_value("StandstillCurrent")

    @property
    def largest_speed(self) -> float:
        return inf

    def _plate_value(self, name: str) -> int:
        """A value of the motor in thousandths of its unit; 0 if it is unknown."""
        try:
            return round(float(self._axis.object[name].value) * 1000) if self._axis is not None else 0
        except KeyError:  # a simulated drive has no motor
            return 0

    @property
    def dc_link_mv(self) -> int:
        """Voltage of the DC link in mV; 0, because the drive does not send it."""
        return 0

    @property
    def inputs(self) -> int:
        return self._inputs.inputs if self._has_inputs else 0

    def captured(self, bit: int) -> None:
        """Return None: the controller samples its inputs."""

    def enable(self, is_on: bool) -> None:
        axis = self._axis
        if axis is None:
            return
        if is_on:
            axis.follow(self)
            axis.enable(True)
        elif axis.set_values is self:
            axis.enable(False)
            axis.follow(None)

    def limit_torque(self, most: int) -> None:
        self._torque_limit.want(most)

    def set_outputs(self, outputs: int, mask: int) -> None:
        wanted = outputs & mask
        for bit, parameter in self._outputs.items():
            if (wanted ^ self._shown_outputs) >> bit & 1:
                parameter.set(bool(wanted >> bit & 1))
        self._shown_outputs = wanted

    def reset(self, done: Callable[[], None]) -> None:
        axis = self._axis
        self._resetting = done
        if axis is None or axis.drive is None:
            self._quit_all()
        else:
            axis.quit_errors()

    # ---- `max4.axes.axis.SetValues`

    def begin(self, axis: Axis) -> None:
        self.mode, self.kind = Mode.POSITION, Kind.POSITION
        if self.guide is not None:
            self.guide.kind, self.guide.set_value = Kind.POSITION, axis.position

    def next(self) -> float:
        assert self.guide is not None
        return self.guide.set_value

    def end(self) -> None:
        pass

    def show_mode(self) -> None:
        """Take over the mode after the cycle of the CiA 402 axis, so that the drive gets it before the value."""
        assert self.guide is not None
        kind = self.kind = self.guide.kind
        self.mode = Mode.POSITION if kind is Kind.POSITION else MODES[kind]
