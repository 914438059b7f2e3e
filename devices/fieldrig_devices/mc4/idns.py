"""The operation data of an MC-4, apart from those of the ring itself.

Source: digest 3.1; IEC 61491 by its public facts for names, attributes and units.  Positions are increments (S-0-0076
with the resolution S-0-0079), velocities 0.0001 1/min, torques 0.1 % of the motor's continuous current at standstill
(S-0-0111).  Manufacturer parameters are numbered as we chose.  S-0-0182, manufacturer class 3 diagnostics, has
AxisState in its high byte and MC4State in its low one, so that both may be cyclic.
"""

from functools import partial
from typing import Final, NamedTuple

from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN, MotorData
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import READ_ONLY, Attribute, Code, Format, Length, ServiceError, p

MC4_STATE: Final = p(1)
AXIS_STATE: Final = p(2)
STOP_TIME_LIMIT: Final = p(3)
COAST_OPTION: Final = p(4)
MOTOR_OVERLOAD: Final = p(5)
AMPLIFIER_OVERLOAD: Final = p(6)
OVERLOAD_POSITION: Final = p(7)
SIGNALS: Final = p(8)
READ_PLATE: Final = p(9)
PLATE: Final = p(10)
SERIAL_NUMBER: Final = p(11)
RATED_SPEED: Final = p(12)
RATED_TORQUE: Final = p(13)
STANDSTILL_TORQUE: Final = p(14)
PEAK_TORQUE: Final = p(15)
TORQUE_CONSTANT: Final = p(16)
INERTIA: Final = p(17)
POLE_PAIRS: Final = p(18)
BRAKE_TORQUE: Final = p(19)
TURNS: Final = p(20)
WINDING_LIMIT: Final = p(21)
FIRMWARE: Final = p(30)
HARDWARE: Final = p(31)
DIAG_CODE: Final = p(32)
LANGUAGE: Final = p(33)
ARTICLE: Final = p(34)
OWN_SERIAL_NUMBER: Final = p(35)

LATE: Final = (4,)
"""Phases in which these data are write-protected: operation."""
TWO, FOUR, TEXT, WORDS = Length.TWO, Length.FOUR, Length.LIST_OF_BYTES, Length.LIST_OF_WORDS
BIN, UNS, SIG, HEX = Format.BINARY, Format.UNSIGNED, Format.SIGNED, Format.HEX
FULL: Final = 2**31 - 1
INC: Final = "incr"
RPM: Final = "1/min"


class Row(NamedTuple):
    idn: int
    name: str
    length: Length
    format: Format = UNS
    unit: str = ""
    decimals: int = 0
    value: int | str = 0
    minimum: int | None = None
    maximum: int | None = None
    protected: tuple[int, ...] = ()


ROWS: Final = (
    # diagnosis
    Row(std.CLASS_1_DIAGNOSTIC, "class 1 diagnostic (C1D)", TWO, BIN, protected=READ_ONLY),
    Row(std.CLASS_2_DIAGNOSTIC, "class 2 diagnostic (C2D)", TWO, BIN, protected=READ_ONLY),
    Row(std.CLASS_3_DIAGNOSTIC, "class 3 diagnostic (C3D)", TWO, BIN, protected=READ_ONLY),
    Row(std.DIAGNOSTIC_MESSAGE, "diagnostic message", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(std.CLASS_2_MASK, "mask class 2 diagnostic", TWO, BIN, value=0xFFFF),
    Row(std.CLASS_3_MASK, "mask class 3 diagnostic", TWO, BIN, value=0),
    Row(std.RESET_CLASS_1, "reset class 1 diagnostic", TWO, BIN),
    Row(std.MANUFACTURER_CLASS_1, "manufacturer class 1 diagnostic", TWO, BIN, protected=READ_ONLY),
    Row(std.MANUFACTURER_CLASS_3, "manufacturer class 3 diagnostic", TWO, HEX, protected=READ_ONLY),
    Row(std.DIAGNOSTIC_NUMBER, "diagnostic message number", FOUR, UNS, protected=READ_ONLY),
    Row(DIAG_CODE, "DiagCode", TWO, UNS, protected=READ_ONLY),
    Row(LANGUAGE, "language of diagnostic messages: 0 German, 1 English", TWO, UNS, minimum=0, maximum=1),
    # identification
    Row(std.MANUFACTURER_VERSION, "manufacturer version", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(std.CONTROLLER_TYPE, "controller type", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(std.MOTOR_TYPE, "motor type", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(std.APPLICATION_TYPE, "application type", TEXT, Format.TEXT, value="PacDrive"),
    Row(std.INTERFACE_VERSION, "system interface version", TEXT, Format.TEXT, value="SERCOS II", protected=READ_ONLY),
    Row(std.BACKUP_IDNS, "IDN-list of backup operation data", WORDS, Format.IDN, protected=READ_ONLY),
    Row(FIRMWARE, "firmware version", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(HARDWARE, "hardware version", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(ARTICLE, "article number", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(OWN_SERIAL_NUMBER, "serial number", TEXT, Format.TEXT, protected=READ_ONLY),
    # operation
    Row(std.PRIMARY_MODE, "primary operation mode", TWO, BIN, value=0x000B, protected=LATE),
    Row(std.SECONDARY_MODE_1, "secondary operation mode 1", TWO, BIN, value=0x0002, protected=LATE),
    Row(std.SECONDARY_MODE_2, "secondary operation mode 2", TWO, BIN, value=0x0001, protected=LATE),
    Row(std.SECONDARY_MODE_3, "secondary operation mode 3", TWO, BIN, value=0x0003, protected=LATE),
    Row(std.MASTER_CONTROL, "master control word", TWO, BIN, protected=READ_ONLY),
    Row(std.DRIVE_STATUS, "drive status word", TWO, BIN, protected=READ_ONLY),
    Row(MC4_STATE, "MC4State", TWO, HEX, protected=READ_ONLY),
    Row(AXIS_STATE, "AxisState", TWO, UNS, protected=READ_ONLY),
    Row(SIGNALS, "signals: 0 ready, 1 brake relay, 2 Inverter Enable, 3 torque", TWO, BIN, protected=READ_ONLY),
    Row(STOP_TIME_LIMIT, "StopTimeLim", TWO, UNS, "ms", value=1000, minimum=0, maximum=65_535),
    Row(COAST_OPTION, "CoastOption: 0 bEnableCoast, 1 bErrorCoast, 2 brake", TWO, BIN, minimum=0, maximum=7),
    Row(
        std.DRIVE_ON_DELAY,
        "drive on delay time (BrakeDisconnectionTime)",
        TWO,
        UNS,
        "ms",
        value=100,
        minimum=0,
        maximum=65_535,
    ),
    Row(
        std.DRIVE_OFF_DELAY,
        "drive off delay time (BrakeCouplingTime)",
        TWO,
        UNS,
        "ms",
        value=50,
        minimum=0,
        maximum=65_535,
    ),
    # command and feedback values
    Row(std.VELOCITY_COMMAND, "velocity command value", FOUR, SIG, RPM, 4, 0, -FULL, FULL),
    Row(std.VELOCITY_FEEDBACK, "velocity feedback value", FOUR, SIG, RPM, 4, protected=READ_ONLY),
    Row(std.POSITION_COMMAND, "position command value", FOUR, SIG, INC, 0, 0, -FULL - 1, FULL),
    Row(std.POSITION_FEEDBACK_1, "position feedback value 1", FOUR, SIG, INC, protected=READ_ONLY),
    Row(std.POSITION_FEEDBACK_2, "position feedback value 2", FOUR, SIG, INC, protected=READ_ONLY),
    Row(std.TORQUE_COMMAND, "torque command value", TWO, SIG, "%", 1, 0, -32_768, 32_767),
    Row(std.TORQUE_FEEDBACK, "torque feedback value", TWO, SIG, "%", 1, protected=READ_ONLY),
    Row(std.FOLLOWING_DISTANCE, "following distance", FOUR, SIG, INC, protected=READ_ONLY),
    Row(OVERLOAD_POSITION, "overload position", FOUR, SIG, INC, protected=READ_ONLY),
    # scaling: rotary, parameter scaling of positions; velocities in 1/min, torques in %
    Row(std.VELOCITY_SCALING, "velocity data scaling type", TWO, BIN, value=0x0002, protected=READ_ONLY),
    Row(std.POSITION_SCALING, "position data scaling type", TWO, BIN, value=0x000A, protected=READ_ONLY),
    Row(
        std.POSITION_RESOLUTION,
        "rotational position resolution",
        FOUR,
        UNS,
        INC,
        value=INCREMENTS_PER_TURN,
        protected=READ_ONLY,
    ),
    Row(std.TORQUE_SCALING, "torque/force data scaling type", TWO, BIN, value=0x0000, protected=READ_ONLY),
    Row(
        std.FEEDBACK_1_RESOLUTION,
        "resolution of feedback 1",
        FOUR,
        UNS,
        INC,
        value=INCREMENTS_PER_TURN,
        protected=READ_ONLY,
    ),
    # probing
    Row(std.PROBE_CONTROL, "probe control parameter", TWO, BIN, minimum=0, maximum=15),
    Row(std.PROBING_COMMAND, "probing cycle procedure command", TWO, BIN),
    Row(std.PROBE_1_POSITIVE, "probe value 1 positive edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(std.PROBE_1_NEGATIVE, "probe value 1 negative edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(std.PROBE_2_POSITIVE, "probe value 2 positive edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(std.PROBE_2_NEGATIVE, "probe value 2 negative edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(std.MEASURED_STATUS, "measured value status", TWO, BIN, protected=READ_ONLY),
    Row(std.PROBE_1, "probe 1", TWO, BIN, protected=READ_ONLY),
    Row(std.PROBE_2, "probe 2", TWO, BIN, protected=READ_ONLY),
    Row(std.PROBE_1_ENABLE, "probe 1 enable", TWO, BIN, minimum=0, maximum=1),
    Row(std.PROBE_2_ENABLE, "probe 2 enable", TWO, BIN, minimum=0, maximum=1),
    Row(std.PROBE_1_POSITIVE_LATCHED, "probe 1 positive latched", TWO, BIN, protected=READ_ONLY),
    Row(std.PROBE_1_NEGATIVE_LATCHED, "probe 1 negative latched", TWO, BIN, protected=READ_ONLY),
    Row(std.PROBE_2_POSITIVE_LATCHED, "probe 2 positive latched", TWO, BIN, protected=READ_ONLY),
    Row(std.PROBE_2_NEGATIVE_LATCHED, "probe 2 negative latched", TWO, BIN, protected=READ_ONLY),
    # limits
    Row(std.VELOCITY_LIMIT, "bipolar velocity limit value", FOUR, UNS, RPM, 4, 0, 0, FULL),
    Row(std.TORQUE_LIMIT, "bipolar torque limit value", TWO, UNS, "%", 1, 4000, 0, 10_000),
    Row(std.MOTOR_PEAK_CURRENT, "motor peak current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(std.AMPLIFIER_PEAK_CURRENT, "amplifier peak current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(std.MOTOR_STALL_CURRENT, "motor continuous stall current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(std.AMPLIFIER_RATED_CURRENT, "amplifier rated current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(std.MAXIMUM_MOTOR_SPEED, "maximum motor speed", FOUR, UNS, RPM, 4, protected=READ_ONLY),
    Row(std.LOAD_LIMIT, "load limit of the motor", TWO, UNS, "%", 0, 100, 0, 400),
    Row(MOTOR_OVERLOAD, "overload of the motor", TWO, UNS, "%", 1, protected=READ_ONLY),
    Row(AMPLIFIER_OVERLOAD, "overload of the amplifier", TWO, UNS, "%", 1, protected=READ_ONLY),
    Row(std.STANDSTILL_WINDOW, "standstill window", FOUR, UNS, RPM, 4, 100_000, 0, FULL),
    Row(std.POSITION_WINDOW, "position window", FOUR, UNS, INC, 0, 1_000, 0, FULL),
    Row(std.MONITORING_WINDOW, "monitoring window", FOUR, UNS, INC, 0, 500_000, 1, FULL),
    # loops
    Row(std.VELOCITY_LOOP_GAIN, "velocity loop proportional gain", FOUR, UNS, "As/rad", 3, 0, 0, 1_000_000),
    Row(std.VELOCITY_LOOP_ACTION_TIME, "velocity loop integral action time", TWO, UNS, "ms", 1, 200, 0, 65_535),
    Row(std.KV_FACTOR, "position loop Kv-factor", TWO, UNS, "(m/min)/mm", 2, 360, 1, 6_000),
    Row(std.VELOCITY_FEED_FORWARD, "velocity feed forward gain", TWO, UNS, "%", 1, 1000, 0, 1_000),
    Row(std.ACCELERATION_FEED_FORWARD, "acceleration feed forward gain", TWO, UNS, "%", 1, 1000, 0, 2_000),
    # temperatures and DC circuit
    Row(std.DC_BUS_VOLTAGE, "DC bus voltage", TWO, SIG, "V", protected=READ_ONLY),
    Row(std.MOTOR_TEMPERATURE, "motor temperature", TWO, SIG, "degC", 1, protected=READ_ONLY),
    Row(std.AMPLIFIER_TEMPERATURE, "amplifier temperature", TWO, SIG, "degC", 1, protected=READ_ONLY),
    # the name plate
    Row(READ_PLATE, "read the name plate", TWO, BIN),
    Row(PLATE, "name plate", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(SERIAL_NUMBER, "motor serial number", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(RATED_SPEED, "rated speed", FOUR, UNS, RPM, 4, protected=READ_ONLY),
    Row(RATED_TORQUE, "rated torque", FOUR, UNS, "Nm", 3, protected=READ_ONLY),
    Row(STANDSTILL_TORQUE, "standstill torque", FOUR, UNS, "Nm", 3, protected=READ_ONLY),
    Row(PEAK_TORQUE, "peak torque", FOUR, UNS, "Nm", 3, protected=READ_ONLY),
    Row(TORQUE_CONSTANT, "torque constant", FOUR, UNS, "Nm/A", 4, protected=READ_ONLY),
    Row(INERTIA, "moment of inertia", FOUR, UNS, "kgcm2", 3, protected=READ_ONLY),
    Row(POLE_PAIRS, "pole pairs", TWO, UNS, protected=READ_ONLY),
    Row(BRAKE_TORQUE, "torque of the holding brake; 0: none", FOUR, UNS, "Nm", 3, protected=READ_ONLY),
    Row(TURNS, "turns that the encoder tells apart", TWO, UNS, protected=READ_ONLY),
    Row(WINDING_LIMIT, "limit temperature of the winding", TWO, SIG, "degC", 1, protected=READ_ONLY),
)
COMMANDS: Final = frozenset({std.RESET_CLASS_1, std.PROBING_COMMAND, READ_PLATE})
BACKUP: Final = (
    std.PRIMARY_MODE,
    std.SECONDARY_MODE_1,
    std.SECONDARY_MODE_2,
    std.SECONDARY_MODE_3,
    std.POSITION_WINDOW,
    std.VELOCITY_LIMIT,
    std.TORQUE_LIMIT,
    std.CLASS_2_MASK,
    std.CLASS_3_MASK,
    std.VELOCITY_LOOP_GAIN,
    std.VELOCITY_LOOP_ACTION_TIME,
    std.KV_FACTOR,
    std.LOAD_LIMIT,
    std.STANDSTILL_WINDOW,
    std.APPLICATION_TYPE,
    std.MONITORING_WINDOW,
    std.PROBE_CONTROL,
    std.DRIVE_ON_DELAY,
    std.DRIVE_OFF_DELAY,
    std.VELOCITY_FEED_FORWARD,
    std.ACCELERATION_FEED_FORWARD,
    STOP_TIME_LIMIT,
    COAST_OPTION,
    LANGUAGE,
)
"""Data that the master has to store, because the drive does not."""
WITH_KEYS: Final = (std.DRIVE_ON_DELAY, std.DRIVE_OFF_DELAY, STOP_TIME_LIMIT, COAST_OPTION, LANGUAGE)
"""Data that have keys of their own in a rig file."""
MODE_COMMANDS: Final = {1: std.TORQUE_COMMAND, 2: std.VELOCITY_COMMAND, 3: std.POSITION_COMMAND}
"""Command value of each operation mode, by its low three bits; bit 3 means without following error."""
LAGLESS: Final = 0x0008
MODES: Final = frozenset({0x0001, 0x0002, 0x0003, 0x000B})


def settable() -> dict[int, tuple[int, int]]:
    """Return the IDNs that `parameters.idns` of a rig file may set, with their ranges."""
    others = {*COMMANDS, *MODE_COMMANDS.values(), *WITH_KEYS}
    numbers = (row for row in sorted(ROWS) if not row.length.is_list and row.protected != READ_ONLY)
    full = {TWO: 0xFFFF, FOUR: FULL}
    return {
        row.idn: (row.minimum or 0, full[row.length] if row.maximum is None else row.maximum)
        for row in numbers
        if row.idn not in others
    }


def idn_table() -> IdnTable:
    return IdnTable(_datum(row) for row in ROWS)


def _datum(row: Row) -> Datum:
    attribute = Attribute(row.length, row.format, row.decimals, is_command=row.idn in COMMANDS, protected=row.protected)
    value = BACKUP if row.idn == std.BACKUP_IDNS else row.value
    datum = Datum(
        row.idn, row.name, attribute, value, unit=row.unit, minimum=row.minimum, maximum=row.maximum, largest=512
    )
    if row.idn in (std.PRIMARY_MODE, std.SECONDARY_MODE_1, std.SECONDARY_MODE_2, std.SECONDARY_MODE_3):
        datum.minimum, datum.maximum = min(MODES), max(MODES)
        datum.writer = partial(_take_mode, datum)
    return datum


def _take_mode(datum: Datum, data: bytes) -> None:
    if datum.decoded(data)[0] not in MODES:
        raise ServiceError(Code.INVALID)
    datum.data = data


def show_motor(table: IdnTable, motor: MotorData | None) -> None:
    """Show the name plate in the table, or clear its data without one."""
    table[std.MOTOR_TYPE].set(motor.type if motor else "")
    table[SERIAL_NUMBER].set(motor.serial_number if motor else "")
    table[PLATE].set(_plate_text(motor) if motor else "")
    numbers = _numbers(motor) if motor else dict.fromkeys(_numbers(MotorData()), 0)
    for idn, number in numbers.items():
        table[idn].set(round(number))


def _numbers(motor: MotorData) -> dict[int, float]:
    return {
        std.MOTOR_PEAK_CURRENT: motor.peak_current_a * 1e3,
        std.MOTOR_STALL_CURRENT: motor.standstill_current_a * 1e3,
        std.MAXIMUM_MOTOR_SPEED: motor.max_speed_rpm * 1e4,
        RATED_SPEED: motor.rated_speed_rpm * 1e4,
        RATED_TORQUE: motor.rated_torque_nm * 1e3,
        STANDSTILL_TORQUE: motor.standstill_torque_nm * 1e3,
        PEAK_TORQUE: motor.peak_torque_nm * 1e3,
        TORQUE_CONSTANT: motor.torque_constant_nm_per_a * 1e4,
        INERTIA: motor.inertia_kgcm2 * 1e3,
        POLE_PAIRS: motor.pole_pairs,
        BRAKE_TORQUE: motor.brake_torque_nm * 1e3,
        TURNS: motor.range_turns,
        WINDING_LIMIT: motor.winding_limit_c * 10,
    }


def _plate_text(motor: MotorData) -> str:
    return "; ".join(f"{name}={getattr(motor, name)}" for name in motor.__slots__)
