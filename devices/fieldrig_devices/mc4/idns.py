"""The operation data of an MC-4 beside those of the ring itself.

Source: digest 3.1; names, attributes and units by the public facts of IEC 61491.  Positions are increments (S-0-0076
with the resolution S-0-0079), velocities 0.0001 1/min, torques 0.1 % of the motor's continuous current at standstill
(S-0-0111).  Manufacturer parameters are numbered as we chose.  S-0-0182, manufacturer class 3 diagnostics, has
AxisState in its high byte and MC4State in its low one, so that both may be cyclic.
"""

from functools import partial
from typing import Final, NamedTuple

from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN, MotorData
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
"""Written before operation only."""
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
    Row(11, "class 1 diagnostic (C1D)", TWO, BIN, protected=READ_ONLY),
    Row(12, "class 2 diagnostic (C2D)", TWO, BIN, protected=READ_ONLY),
    Row(13, "class 3 diagnostic (C3D)", TWO, BIN, protected=READ_ONLY),
    Row(95, "diagnostic message", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(97, "mask class 2 diagnostic", TWO, BIN, value=0xFFFF),
    Row(98, "mask class 3 diagnostic", TWO, BIN, value=0),
    Row(99, "reset class 1 diagnostic", TWO, BIN),
    Row(129, "manufacturer class 1 diagnostic", TWO, BIN, protected=READ_ONLY),
    Row(182, "manufacturer class 3 diagnostic", TWO, HEX, protected=READ_ONLY),
    Row(390, "diagnostic message number", FOUR, UNS, protected=READ_ONLY),
    Row(DIAG_CODE, "DiagCode", TWO, UNS, protected=READ_ONLY),
    Row(LANGUAGE, "language of diagnostic messages: 0 German, 1 English", TWO, UNS, minimum=0, maximum=1),
    # what it is
    Row(30, "manufacturer version", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(140, "controller type", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(141, "motor type", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(142, "application type", TEXT, Format.TEXT, value="PacDrive"),
    Row(143, "system interface version", TEXT, Format.TEXT, value="SERCOS II", protected=READ_ONLY),
    Row(192, "IDN-list of backup operation data", WORDS, Format.IDN, protected=READ_ONLY),
    Row(FIRMWARE, "firmware version", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(HARDWARE, "hardware version", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(ARTICLE, "article number", TEXT, Format.TEXT, protected=READ_ONLY),
    Row(OWN_SERIAL_NUMBER, "serial number", TEXT, Format.TEXT, protected=READ_ONLY),
    # operation
    Row(32, "primary operation mode", TWO, BIN, value=0x000B, protected=LATE),
    Row(33, "secondary operation mode 1", TWO, BIN, value=0x0002, protected=LATE),
    Row(34, "secondary operation mode 2", TWO, BIN, value=0x0001, protected=LATE),
    Row(35, "secondary operation mode 3", TWO, BIN, value=0x0003, protected=LATE),
    Row(134, "master control word", TWO, BIN, protected=READ_ONLY),
    Row(135, "drive status word", TWO, BIN, protected=READ_ONLY),
    Row(MC4_STATE, "MC4State", TWO, HEX, protected=READ_ONLY),
    Row(AXIS_STATE, "AxisState", TWO, UNS, protected=READ_ONLY),
    Row(SIGNALS, "signals: 0 ready, 1 brake relay, 2 Inverter Enable, 3 torque", TWO, BIN, protected=READ_ONLY),
    Row(STOP_TIME_LIMIT, "StopTimeLim", TWO, UNS, "ms", value=1000, minimum=0, maximum=65_535),
    Row(COAST_OPTION, "CoastOption: 0 bEnableCoast, 1 bErrorCoast, 2 brake", TWO, BIN, minimum=0, maximum=7),
    Row(206, "drive on delay time (BrakeDisconnectionTime)", TWO, UNS, "ms", value=100, minimum=0, maximum=65_535),
    Row(207, "drive off delay time (BrakeCouplingTime)", TWO, UNS, "ms", value=50, minimum=0, maximum=65_535),
    # command and feedback values
    Row(36, "velocity command value", FOUR, SIG, RPM, 4, 0, -FULL, FULL),
    Row(40, "velocity feedback value", FOUR, SIG, RPM, 4, protected=READ_ONLY),
    Row(47, "position command value", FOUR, SIG, INC, 0, 0, -FULL - 1, FULL),
    Row(51, "position feedback value 1", FOUR, SIG, INC, protected=READ_ONLY),
    Row(53, "position feedback value 2", FOUR, SIG, INC, protected=READ_ONLY),
    Row(80, "torque command value", TWO, SIG, "%", 1, 0, -32_768, 32_767),
    Row(84, "torque feedback value", TWO, SIG, "%", 1, protected=READ_ONLY),
    Row(189, "following distance", FOUR, SIG, INC, protected=READ_ONLY),
    Row(OVERLOAD_POSITION, "overload position", FOUR, SIG, INC, protected=READ_ONLY),
    # scaling: rotary, parameter scaling of positions; velocities in 1/min, torques in %
    Row(44, "velocity data scaling type", TWO, BIN, value=0x0002, protected=READ_ONLY),
    Row(76, "position data scaling type", TWO, BIN, value=0x000A, protected=READ_ONLY),
    Row(79, "rotational position resolution", FOUR, UNS, INC, value=INCREMENTS_PER_TURN, protected=READ_ONLY),
    Row(86, "torque/force data scaling type", TWO, BIN, value=0x0000, protected=READ_ONLY),
    Row(116, "resolution of feedback 1", FOUR, UNS, INC, value=INCREMENTS_PER_TURN, protected=READ_ONLY),
    # probing
    Row(169, "probe control parameter", TWO, BIN, minimum=0, maximum=15),
    Row(170, "probing cycle procedure command", TWO, BIN),
    Row(130, "probe value 1 positive edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(131, "probe value 1 negative edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(132, "probe value 2 positive edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(133, "probe value 2 negative edge", FOUR, SIG, INC, protected=READ_ONLY),
    Row(179, "measured value status", TWO, BIN, protected=READ_ONLY),
    Row(401, "probe 1", TWO, BIN, protected=READ_ONLY),
    Row(402, "probe 2", TWO, BIN, protected=READ_ONLY),
    Row(405, "probe 1 enable", TWO, BIN, minimum=0, maximum=1),
    Row(406, "probe 2 enable", TWO, BIN, minimum=0, maximum=1),
    Row(409, "probe 1 positive latched", TWO, BIN, protected=READ_ONLY),
    Row(410, "probe 1 negative latched", TWO, BIN, protected=READ_ONLY),
    Row(411, "probe 2 positive latched", TWO, BIN, protected=READ_ONLY),
    Row(412, "probe 2 negative latched", TWO, BIN, protected=READ_ONLY),
    # limits
    Row(91, "bipolar velocity limit value", FOUR, UNS, RPM, 4, 0, 0, FULL),
    Row(92, "bipolar torque limit value", TWO, UNS, "%", 1, 4000, 0, 10_000),
    Row(109, "motor peak current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(110, "amplifier peak current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(111, "motor continuous stall current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(112, "amplifier rated current", FOUR, UNS, "A", 3, protected=READ_ONLY),
    Row(113, "maximum motor speed", FOUR, UNS, RPM, 4, protected=READ_ONLY),
    Row(114, "load limit of the motor", TWO, UNS, "%", 0, 100, 0, 400),
    Row(MOTOR_OVERLOAD, "overload of the motor", TWO, UNS, "%", 1, protected=READ_ONLY),
    Row(AMPLIFIER_OVERLOAD, "overload of the amplifier", TWO, UNS, "%", 1, protected=READ_ONLY),
    Row(124, "standstill window", FOUR, UNS, RPM, 4, 100_000, 0, FULL),
    Row(57, "position window", FOUR, UNS, INC, 0, 1_000, 0, FULL),
    Row(159, "monitoring window", FOUR, UNS, INC, 0, 500_000, 1, FULL),
    # loops
    Row(100, "velocity loop proportional gain", FOUR, UNS, "As/rad", 3, 0, 0, 1_000_000),
    Row(101, "velocity loop integral action time", TWO, UNS, "ms", 1, 200, 0, 65_535),
    Row(104, "position loop Kv-factor", TWO, UNS, "(m/min)/mm", 2, 360, 1, 6_000),
    Row(296, "velocity feed forward gain", TWO, UNS, "%", 1, 1000, 0, 1_000),
    Row(348, "acceleration feed forward gain", TWO, UNS, "%", 1, 1000, 0, 2_000),
    # temperatures and DC circuit
    Row(380, "DC bus voltage", TWO, SIG, "V", protected=READ_ONLY),
    Row(383, "motor temperature", TWO, SIG, "degC", 1, protected=READ_ONLY),
    Row(384, "amplifier temperature", TWO, SIG, "degC", 1, protected=READ_ONLY),
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
COMMANDS: Final = frozenset({99, 170, READ_PLATE})
BACKUP: Final = (32, 33, 34, 35, 57, 91, 92, 97, 98, 100, 101, 104, 114, 124, 142, 159, 169, 206, 207, 296, 348,
                 STOP_TIME_LIMIT, COAST_OPTION, LANGUAGE)  # fmt: skip
"""What the master should keep, for the drive doesn't."""
WITH_KEYS: Final = (206, 207, STOP_TIME_LIMIT, COAST_OPTION, LANGUAGE)
"""Those that a rig file gives by keys of their own."""
MODE_COMMANDS: Final = {1: 80, 2: 36, 3: 47}
"""The command value of each operation mode, by its low three bits; bit 3: without following error."""
LAGLESS: Final = 0x0008
MODES: Final = frozenset({0x0001, 0x0002, 0x0003, 0x000B})


def settable() -> dict[int, tuple[int, int]]:
    """Numbers that `parameters.idns` of a rig file may give, and from where to where they go."""
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
    value = BACKUP if row.idn == 192 else row.value
    datum = Datum(
        row.idn, row.name, attribute, value, unit=row.unit, minimum=row.minimum, maximum=row.maximum, largest=512
    )
    if row.idn in (32, 33, 34, 35):
        datum.minimum, datum.maximum = min(MODES), max(MODES)
        datum.writer = partial(_take_mode, datum)
    return datum


def _take_mode(datum: Datum, data: bytes) -> None:
    if datum.decoded(data)[0] not in MODES:
        raise ServiceError(Code.INVALID)
    datum.data = data


def show_motor(table: IdnTable, motor: MotorData | None) -> None:
    """What of the name plate stands in the table; without one, nothing."""
    table[141].set(motor.type if motor else "")
    table[SERIAL_NUMBER].set(motor.serial_number if motor else "")
    table[PLATE].set(_plate_text(motor) if motor else "")
    numbers = _numbers(motor) if motor else dict.fromkeys(_numbers(MotorData()), 0)
    for idn, number in numbers.items():
        table[idn].set(round(number))


def _numbers(motor: MotorData) -> dict[int, float]:
    return {
        109: motor.peak_current_a * 1e3,
        111: motor.standstill_current_a * 1e3,
        113: motor.max_speed_rpm * 1e4,
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
