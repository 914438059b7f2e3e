"""Parameters in an MC-4, which the controller reads and writes when the ring comes up.

Source: PacDrive manual 6066-6171 (BrakeDisconnectionTime and up), 513-538 (name plate); IDNs of `mc4.idns`.  They use
the service channel and are slow (digest PD-028, PD-137): a read returns the value that was last received.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

from fieldrig.clock import MS, Clock, S
from fieldrig.device import Value
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.configuration.tree import Access, Object, Parameter, Type
from fieldrig_devices.mc4 import idns
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.idn import ServiceError

VERSION_IDN: Final = std.MANUFACTURER_VERSION
MOTOR: Final = "Motor"
MOTOR_WAIT_NS: Final = 30 * S
"""Longest time to wait until a drive has read the name plate of its motor after power-on."""
MOTOR_RETRY_NS: Final = 250 * MS
"""Time between two requests for the name plate."""


class Row(NamedTuple):
    """One parameter and its IDN."""

    group: str
    name: str
    idn: int
    type: Type
    decimals: int = 0
    unit: str = ""
    is_writable: bool = False


ROWS: Final = (
    Row("Versions", "FirmwareVersion", VERSION_IDN, Type.STRING),
    Row("Versions", "ControllerType", std.CONTROLLER_TYPE, Type.STRING),
    Row(MOTOR, "MotorType", std.MOTOR_TYPE, Type.STRING),
    Row(MOTOR, "MotorSerialNumber", idns.SERIAL_NUMBER, Type.STRING),
    Row(MOTOR, "RatedTorque", idns.RATED_TORQUE, Type.LREAL, 3, "Nm"),
    Row(MOTOR, "RatedSpeed", idns.RATED_SPEED, Type.LREAL, 4, "1/min"),
    Row(MOTOR, "MaxSpeed", std.MAXIMUM_MOTOR_SPEED, Type.LREAL, 4, "1/min"),
    Row(MOTOR, "StandstillCurrent", std.MOTOR_STALL_CURRENT, Type.LREAL, 3, "A"),
    Row(MOTOR, "PeakCurrent", std.MOTOR_PEAK_CURRENT, Type.LREAL, 3, "A"),
    Row(MOTOR, "Inertia", idns.INERTIA, Type.LREAL, 3, "kgcm2"),
    Row("Stop", "BrakeDisconnectionTime", std.DRIVE_ON_DELAY, Type.UINT, 0, "ms", is_writable=True),
    Row("Stop", "BrakeCouplingTime", std.DRIVE_OFF_DELAY, Type.UINT, 0, "ms", is_writable=True),
    Row("Stop", "StopTimeLim", idns.STOP_TIME_LIMIT, Type.UINT, 0, "ms", is_writable=True),
    Row("Stop", "CoastOption", idns.COAST_OPTION, Type.UINT, is_writable=True),
    Row("Loops", "MaxFollowingError", std.MONITORING_WINDOW, Type.UDINT, 0, "incr", is_writable=True),
    Row("Loops", "TorqueLimit", std.TORQUE_LIMIT, Type.UINT, 0, "0.1%", is_writable=True),
    Row("Loops", "PositionGain", std.KV_FACTOR, Type.UINT, is_writable=True),
    Row("Versions", "HardwareVersion", idns.HARDWARE, Type.STRING),
    Row("Versions", "ArticleNumber", idns.ARTICLE, Type.STRING),
    Row("Versions", "SerialNumber", idns.OWN_SERIAL_NUMBER, Type.STRING),
)


class DriveParameters:
    """The parameters of one drive."""

    def __init__(self, clock: Clock, axis: Axis, node: Object) -> None:
        self._clock, self._axis = clock, axis
        self._until_ns = 0
        self.start_values: dict[str, Value] = {}
        """Values from the parameter file, which are written whenever the drive joins the ring."""
        self._parameters: dict[str, Parameter] = {}
        for row in ROWS:
            access = Access.SLOW if row.is_writable else Access.OUTPUT
            write = self._writer(row) if row.is_writable else None
            parameter = Parameter(row.name, row.type, access, unit=row.unit, write=write)
            self._parameters[row.name] = node.group(row.group).add(parameter)

    def exchange(self, on_done: Callable[[], None]) -> None:
        """Write the start values and read the others, then call `on_done` when all are answered or refused."""
        waiting = len(ROWS)
        self._until_ns = self._clock.now_ns() + MOTOR_WAIT_NS

        def answered() -> None:
            nonlocal waiting
            waiting -= 1
            if not waiting:
                self._look_for_motor()
                on_done()

        for row in ROWS:
            if row.name in self.start_values:
                self._send(row, self.start_values[row.name], answered)
            else:
                self._fetch(row, answered)

    def read(self, name: str, on_done: Callable[[Value], None]) -> None:
        """Read a parameter from the drive; `on_done` receives its value, or the last one if the drive refuses."""
        row = _row(name)
        self._fetch(row, lambda: on_done(self._parameters[row.name].value))

    def write(self, name: str, value: Value, on_done: Callable[[], None]) -> None:
        """Write a parameter, as `Parameter.set` does, and call `on_done` when the drive has answered."""
        row = _row(name)
        self._send(row, self._parameters[row.name].checked(value), on_done)

    def _look_for_motor(self) -> None:
        """Read the name plate of the motor, repeatedly until the drive has it."""
        now_ns = self._clock.now_ns()
        if self._parameters["MotorType"].value:
            for row in ROWS:
                if row.group == MOTOR:
                    self._fetch(row, lambda: None)
        elif self._axis.is_operating and now_ns < self._until_ns:
            row = next(row for row in ROWS if row.name == "MotorType")
            self._clock.call_at(now_ns + MOTOR_RETRY_NS, lambda: self._fetch(row, self._look_for_motor))

    def _fetch(self, row: Row, answered: Callable[[], None]) -> None:
        def done(outcome: bytes | ServiceError) -> None:
            if not isinstance(outcome, ServiceError):
                self._parameters[row.name].put(_value(row, outcome))
            answered()

        self._axis.read(row.idn, done)

    def _send(self, row: Row, value: Value, answered: Callable[[], None]) -> None:
        def done(outcome: bytes | ServiceError) -> None:
            if not isinstance(outcome, ServiceError):
                self._parameters[row.name].put(value)
            answered()

        self._axis.write(row.idn, int(value).to_bytes(4 if row.type is Type.UDINT else 2, "little"), done)

    def _writer(self, row: Row) -> Callable[[Value], None]:
        def write(value: Value) -> None:
            parameter = self._parameters[row.name]
            parameter.underway = value

            def answered() -> None:
                if parameter.underway == value:  # not another one, written since
                    parameter.underway = None

            self._send(row, value, answered)

        return write


def _row(name: str) -> Row:
    return next(row for row in ROWS if row.name == name)


def _value(row: Row, data: bytes) -> Value:
    if row.type is Type.STRING:
        return data.decode("latin-1").rstrip("\0")[: row.type.high]
    number = int.from_bytes(data, "little")
    return number / 10**row.decimals if row.type is Type.LREAL else number
