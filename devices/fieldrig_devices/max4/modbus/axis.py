"""The registers of one axis: its commands, set values and state, as a Modbus client accesses them.

The map is ours (docs/devices/pacdrive/max4-modbus.md; the manual names the library ModBus.lib without its content,
digest PD-306).  Set values take effect with a command, whose register follows theirs, so that one request can write
both.  Positions wrap around at 32 bits; a target position means the nearest position that is shown as this value.
"""

from collections.abc import Callable, Iterator
from enum import IntEnum, IntFlag
from typing import Final

from fieldrig.device import Value
from fieldrig_devices.cia402.objects import NO_POSITION_LIMITS
from fieldrig_devices.cia402.units import BITS_32
from fieldrig_devices.max4.axes.axis import Axis, Mode
from fieldrig_devices.max4.axes.positioning import Positioner
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.motion.travel import NEGATIVE, POSITIVE, Switches, Travel
from fieldrig_devices.registers.live import Entry, whole

FIRST: Final = 1000
SIZE: Final = 100
"""Number of registers of one axis."""


class Command(IntEnum):
    NOTHING = 0
    START = 1
    START_RELATIVE = 2
    STOP = 3
    JOG_FORWARD = 4
    JOG_BACKWARD = 5
    QUIT = 6


class Operation(IntEnum):
    """Kinds of motion that START begins."""

    POSITION = 0
    VELOCITY = 1
    TORQUE = 2


class Status(IntFlag):
    OPERATING = 0x0001
    ENABLED = 0x0002
    CONTROLLED = 0x0004
    MOVING = 0x0008
    REACHED = 0x0010
    ERROR = 0x0020
    SIMULATED = 0x0040
    FOREIGN = 0x0080
    NEGATIVE_LIMIT = 0x0100
    """The negative limit switch is on."""
    POSITIVE_LIMIT = 0x0200
    """The positive limit switch is on."""
    LIMITED = 0x0400
    """A limit ends the motion before its target."""


class AxisRegisters:
    """The registers of axis `number`, counted from 0.  A unit of length is `per_unit` increments."""

    def __init__(
        self,
        number: int,
        axis: Axis,
        per_unit: int,
        cycle_ns: int,
        switches: Switches,
        software_limits: tuple[int, int],
    ) -> None:
        self.axis, self._per_unit, self._switches = axis, per_unit, switches
        self.positioner = Positioner(axis, cycle_ns, Travel(switches))
        self._base = FIRST + number * SIZE
        self._values: dict[str, int] = {
            "operation": Operation.POSITION,
            "target_position": 0,
            "speed": 1000,
            "acceleration": 10_000,
            "deceleration": 10_000,
            "target_velocity": 0,
            "target_torque": 0,
            "command": Command.NOTHING,
            "min_position": software_limits[0],
            "max_position": software_limits[1],
        }
        self._limit()

    def entries(self) -> Iterator[Entry]:
        return whole([*self._set_values(), *self._state()], SIZE)

    def halt(self) -> None:
        """Stop a motion that a Modbus client has started."""
        if self.positioner.is_moving:
            self.positioner.stop(self._limits)

    # ---- registers

    def _set_values(self) -> Iterator[Entry]:
        axis, base = self.axis, self._base
        yield Entry(
            base, "enable", "u16", lambda: axis.is_enabled, lambda value: axis.enable(bool(value)), up_to(1),
            about="ControllerEnable",
        )  # fmt: skip
        yield self._kept(1, "operation", "u16", self._check_operation, about="kind of motion that start begins")
        yield self._kept(2, "target_position", "s32", unit="units")
        yield self._kept(4, "speed", "u32", _above_0, unit="units/s", about="for positions and jogging")
        yield self._kept(6, "acceleration", "u32", _above_0, unit="units/s2")
        yield self._kept(8, "deceleration", "u32", _above_0, unit="units/s2")
        yield self._kept(10, "target_velocity", "s32", unit="units/s")
        yield self._kept(12, "target_torque", "s16", unit="0.1 %", about="of the motor's rated torque")
        command = self._values
        yield Entry(
            base + 13, "command", "u16", lambda: command["command"], self._command, self._check_command,
            about="acts on each write",
        )  # fmt: skip
        yield self._kept(14, "min_position", "s32", unit="units", about="software limit", then=self._limit)
        yield self._kept(16, "max_position", "s32", unit="units", about="software limit", then=self._limit)

    def _state(self) -> Iterator[Entry]:
        axis = self.axis
        shown: tuple[tuple[int, str, str, Callable[[], Value], str, str], ...] = (
            (20, "AxisState", "u16", lambda: axis.axis_state.value, "", ""),
            (21, "MC4State", "u16", lambda: axis.mc4_state, "", "state as the drive shows it"),
            (22, "DiagCode", "u16", lambda: axis.diag_code, "", "0: no diagnosis is pending"),
            (23, "status", "u16", self._status, "", "bits"),
            (24, "position", "s32", lambda: self._wrapped(axis.position), "units", "actual"),
            (26, "velocity", "s32", lambda: round(axis.velocity / self._per_unit), "units/s", "actual"),
            (28, "torque", "s16", lambda: axis.torque, "0.1 %", "actual, of the rated torque"),
            (29, "following_error", "s32", lambda: round(axis.following_error / self._per_unit), "units", ""),
            (
                31,
                "set_position",
                "s32",
                self._set_position,
                "units",
                "last sent to the drive; actual position in torque mode",
            ),
            (33, "RealTimeBusAdr", "u16", lambda: axis.ring_address, "", "address on the ring"),
            (34, "logAdr", "u32", lambda: axis.log_adr, "", "logical address"),
            (36, "drive_status", "u16", lambda: axis.status_word, "", "S-0-0135, without the service channel"),
            (40, "DiagMsg", "string[80]", lambda: axis.diag_msg, "", "Latin-1"),
            (80, "name", "string[32]", lambda: axis.name, "", "symbolic name"),
        )
        for offset, name, type, read, unit, about in shown:
            yield Entry(self._base + offset, name, type, read, unit=unit, about=about)

    def _kept(
        self,
        offset: int,
        name: str,
        type: str,
        check: Callable[[Value], None] | None = None,
        unit: str = "",
        about: str = "",
        then: Callable[[], None] = lambda: None,
    ) -> Entry:
        values = self._values

        def write(value: Value) -> None:
            values[name] = int(value)
            then()

        entry = Entry(self._base + offset, name, type, lambda: values[name], write, unit=unit, about=about)
        return entry if check is None else entry.checked_by(check)

    # ---- commands

    def _check_operation(self, value: Value) -> None:
        Operation(int(value))
        if int(value) == Operation.TORQUE and Mode.TORQUE not in self.axis.modes:
            raise ValueError("operation: expected 0 or 1, because the telegram of the drive has no torque")

    def _check_command(self, value: Value) -> None:
        moves = Command(int(value)) not in (Command.NOTHING, Command.QUIT, Command.STOP)
        if moves and not self.axis.is_controlled:
            raise ValueError("the axis is not under control: enable it before this command")

    def _command(self, value: Value) -> None:
        command = Command(int(value))
        self._values["command"] = command
        limits, positioner, values = self._limits, self.positioner, self._values
        match command:
            case Command.START:
                self._start()
            case Command.START_RELATIVE:
                positioner.move_by(values["target_position"] * self._per_unit, limits)
            case Command.JOG_FORWARD:
                positioner.run(limits.speed, limits)
            case Command.JOG_BACKWARD:
                positioner.run(-limits.speed, limits)
            case Command.STOP if self.axis.is_controlled:
                positioner.stop(limits)
            case Command.QUIT:
                self.axis.quit_errors()

    def _start(self) -> None:
        limits, values = self._limits, self._values
        match values["operation"]:
            case Operation.POSITION:
                self.positioner.move_to(self._nearest(values["target_position"]) * self._per_unit, limits)
            case Operation.VELOCITY:
                self.positioner.run(values["target_velocity"] * self._per_unit, limits)
            case Operation.TORQUE:
                self.positioner.push(values["target_torque"], limits)

    def _limit(self) -> None:
        """Apply the software limits.  As in 607Dh, the ends of 32 bits limit nothing, nor does a minimum not below the
        maximum."""
        low, high = self._values["min_position"], self._values["max_position"]
        are_there = low < high and (low, high) != NO_POSITION_LIMITS
        self.positioner.travel.range = (low * self._per_unit, high * self._per_unit) if are_there else None

    @property
    def _limits(self) -> Limits:
        speed, acceleration, deceleration = (
            float(self._values[name] * self._per_unit) for name in ("speed", "acceleration", "deceleration")
        )
        return Limits(speed, acceleration, deceleration)

    # ---- what is shown

    def _status(self) -> int:
        axis, positioner = self.axis, self.positioner
        is_ours = axis.set_values is positioner
        bits = {
            Status.OPERATING: axis.is_operating,
            Status.ENABLED: axis.is_enabled,
            Status.CONTROLLED: axis.is_controlled,
            Status.MOVING: is_ours and positioner.is_moving,
            Status.REACHED: is_ours and positioner.has_arrived,
            Status.ERROR: axis.is_in_error,
            Status.SIMULATED: axis.is_simulated,
            Status.FOREIGN: axis.set_values is not None and not is_ours,
            Status.NEGATIVE_LIMIT: bool(self._switches.inputs & NEGATIVE),
            Status.POSITIVE_LIMIT: bool(self._switches.inputs & POSITIVE),
            Status.LIMITED: is_ours and positioner.travel.is_held_back,
        }
        return sum(bit for bit, is_on in bits.items() if is_on)

    def _set_position(self) -> int:
        axis = self.axis
        is_position = axis.mode is Mode.POSITION and axis.is_controlled
        return self._wrapped(axis.set_value if is_position else axis.position)

    def _wrapped(self, increments: float) -> int:
        """The position in units, wrapped to 32 bits."""
        return BITS_32.shown(round(increments / self._per_unit))

    def _nearest(self, shown: int) -> int:
        """The position in units that is shown as `shown` and is nearest to the axis."""
        here = round(self.axis.position / self._per_unit)
        return here + BITS_32.shown(shown - here)


def up_to(most: int) -> Callable[[Value], None]:
    """A check that accepts 0 to `most`."""

    def check(value: Value) -> None:
        if not 0 <= int(value) <= most:
            raise ValueError(f"expected 0 to {most}, got {value}")

    return check


def _above_0(value: Value) -> None:
    if int(value) <= 0:
        raise ValueError(f"expected more than 0, got {value}")
