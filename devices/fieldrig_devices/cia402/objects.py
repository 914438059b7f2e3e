"""The objects of the first axis of a node; those of axis n have indices that are higher by n x 800h.

Source: CiA 402-2 and CiA 402-3 (indices, types, access, PDO mapping).  The start values are ours, for a motor with
1 000 000 increments per revolution and user units that are increments.  Objects that a master writes in every cycle are
`rww`, so that they are not stored with the parameters.  60C4h sub-index 6 starts at 1, so that a master that does not
know the buffer can use it.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.cia402.homing_methods import METHODS

AXES: Final = 8
PDO_STEP: Final = 64
"""The PDO numbers of axis n are higher by n x 64."""

I8, I16, I32, U8, U16, U32 = range(2, 8)
"""Data types of CiA 301."""

ABORT_CONNECTION: Final = 0x6007
ERROR_CODE: Final = 0x603F
CONTROL_WORD: Final = 0x6040
STATUS_WORD: Final = 0x6041
QUICK_STOP_OPTION: Final = 0x605A
SHUTDOWN_OPTION: Final = 0x605B
DISABLE_OPTION: Final = 0x605C
HALT_OPTION: Final = 0x605D
FAULT_OPTION: Final = 0x605E
VL_TARGET: Final = 0x6042
VL_DEMAND: Final = 0x6043
VL_ACTUAL: Final = 0x6044
VL_AMOUNT: Final = 0x6046
VL_ACCELERATION: Final = 0x6048
VL_DECELERATION: Final = 0x6049
VL_QUICK_STOP: Final = 0x604A
VL_SET_POINT_FACTOR: Final = 0x604B
VL_DIMENSION_FACTOR: Final = 0x604C
MODE: Final = 0x6060
MODE_DISPLAY: Final = 0x6061
POSITION_DEMAND: Final = 0x6062
POSITION_INTERNAL: Final = 0x6063
POSITION_ACTUAL: Final = 0x6064
FOLLOWING_WINDOW: Final = 0x6065
FOLLOWING_TIME: Final = 0x6066
POSITION_WINDOW: Final = 0x6067
POSITION_TIME: Final = 0x6068
VELOCITY_SENSOR: Final = 0x6069
VELOCITY_DEMAND: Final = 0x606B
VELOCITY_ACTUAL: Final = 0x606C
VELOCITY_WINDOW: Final = 0x606D
VELOCITY_TIME: Final = 0x606E
THRESHOLD: Final = 0x606F
THRESHOLD_TIME: Final = 0x6070
TARGET_TORQUE: Final = 0x6071
MAX_TORQUE: Final = 0x6072
MAX_CURRENT: Final = 0x6073
TORQUE_DEMAND: Final = 0x6074
RATED_CURRENT: Final = 0x6075
RATED_TORQUE: Final = 0x6076
TORQUE_ACTUAL: Final = 0x6077
CURRENT_ACTUAL: Final = 0x6078
DC_LINK: Final = 0x6079
TARGET_POSITION: Final = 0x607A
POSITION_RANGE: Final = 0x607B
HOME_OFFSET: Final = 0x607C
POSITION_LIMIT: Final = 0x607D
POLARITY: Final = 0x607E
MAX_VELOCITY: Final = 0x607F
MAX_MOTOR_SPEED: Final = 0x6080
PROFILE_VELOCITY: Final = 0x6081
PROFILE_ACCELERATION: Final = 0x6083
PROFILE_DECELERATION: Final = 0x6084
QUICK_STOP_DECELERATION: Final = 0x6085
PROFILE_TYPE: Final = 0x6086
TORQUE_SLOPE: Final = 0x6087
TORQUE_PROFILE: Final = 0x6088
ENCODER_RESOLUTION: Final = 0x608F
VELOCITY_RESOLUTION: Final = 0x6090
GEAR_RATIO: Final = 0x6091
FEED_CONSTANT: Final = 0x6092
HOMING_METHOD: Final = 0x6098
HOMING_SPEED: Final = 0x6099
HOMING_ACCELERATION: Final = 0x609A
JERK_USE: Final = 0x60A3
PROFILE_JERK: Final = 0x60A4
POSITION_OFFSET: Final = 0x60B0
VELOCITY_OFFSET: Final = 0x60B1
TORQUE_OFFSET: Final = 0x60B2
PROBE_FUNCTION: Final = 0x60B8
PROBE_STATUS: Final = 0x60B9
PROBE_1_RISING: Final = 0x60BA
PROBE_1_FALLING: Final = 0x60BB
PROBE_2_RISING: Final = 0x60BC
PROBE_2_FALLING: Final = 0x60BD
PROBE_VALUES: Final = (PROBE_1_RISING, PROBE_1_FALLING, PROBE_2_RISING, PROBE_2_FALLING)
PROBE_SOURCE: Final = 0x60D0
PROBE_TIMES: Final = (0x60D1, 0x60D2, 0x60D3, 0x60D4)
"""Time stamps of rising and falling edge of probe 1, then of probe 2."""
PROBE_COUNTERS: Final = (0x60D5, 0x60D6, 0x60D7, 0x60D8)
"""Counters of the same edges."""
SUB_MODE: Final = 0x60C0
DATA_RECORD: Final = 0x60C1
INTERPOLATION_TIME: Final = 0x60C2
SYNC_DEFINITION: Final = 0x60C3
BUFFER: Final = 0x60C4
MAX_ACCELERATION: Final = 0x60C5
MAX_DECELERATION: Final = 0x60C6
HOMING_METHODS: Final = 0x60E3
POSITIONING_OPTION: Final = 0x60F2
FOLLOWING_ERROR: Final = 0x60F4
DEMAND_INTERNAL: Final = 0x60FC
INPUTS: Final = 0x60FD
OUTPUTS: Final = 0x60FE
TARGET_VELOCITY: Final = 0x60FF
SUPPORTED_MODES: Final = 0x6502
DEVICE_TYPE: Final = 0x67FF

SERVO_DRIVE: Final = 0x0002_0192
"""Value of 67FFh: device profile 402, type servo drive."""
NO_POSITION_LIMITS: Final = (-0x8000_0000, 0x7FFF_FFFF)
"""Minimum and maximum of 607Bh and 607Dh that limit nothing."""
NO_WINDOW: Final = 0xFFFF_FFFF
"""Value of 6065h and 6067h that turns monitoring off."""
FULL_TORQUE: Final = 4_000
"""Start value of 6072h, in 0.1 % of the rated torque."""
NO_CURRENT_LIMIT: Final = 0xFFFF
"""Value of 6073h that limits nothing."""
NO_SPEED_LIMIT: Final = 0xFFFF_FFFF
"""Value of 6080h that limits nothing."""
BUFFER_SIZE: Final = 64


@dataclass(frozen=True, slots=True)
class Row:
    index: int
    subindex: int | None
    """Sub-index, or None if the object is a variable."""
    name: str
    type: int
    access: str
    start: int | str = 0
    """Start value; a text if it begins with $NODEID, and an empty text if there is none."""
    is_mappable: bool = False
    low: int | None = None
    high: int | None = None


def _array(index: int, name: str, type: int, access: str, entries: tuple[tuple[str, int], ...]) -> list[Row]:
    return [
        Row(index, subindex, f"{name}, {entry}", type, access, start)
        for subindex, (entry, start) in enumerate(entries, 1)
    ]


NAMES: Final = {
    VL_AMOUNT: "vl velocity min max amount",
    VL_ACCELERATION: "vl velocity acceleration",
    VL_DECELERATION: "vl velocity deceleration",
    VL_QUICK_STOP: "vl velocity quick stop",
    VL_SET_POINT_FACTOR: "vl set-point factor",
    VL_DIMENSION_FACTOR: "vl dimension factor",
    POSITION_RANGE: "Position range limit",
    POSITION_LIMIT: "Software position limit",
    ENCODER_RESOLUTION: "Position encoder resolution",
    VELOCITY_RESOLUTION: "Velocity encoder resolution",
    GEAR_RATIO: "Gear ratio",
    FEED_CONSTANT: "Feed constant",
    HOMING_SPEED: "Homing speeds",
    PROFILE_JERK: "Profile jerk",
    PROBE_SOURCE: "Touch probe source",
    DATA_RECORD: "Interpolation data record",
    INTERPOLATION_TIME: "Interpolation time period",
    SYNC_DEFINITION: "Interpolation sync definition",
    BUFFER: "Interpolation data configuration",
    HOMING_METHODS: "Supported homing methods",
    OUTPUTS: "Digital outputs",
}
"""Names of the objects with sub-indices."""
ARRAYS: Final = frozenset(NAMES) - {
    INTERPOLATION_TIME, BUFFER, VL_ACCELERATION, VL_DECELERATION, VL_QUICK_STOP,
}  # fmt: skip
"""Objects with sub-indices that are arrays; the others are records."""


def _ramp(index: int, name: str, delta_speed: int) -> list[Row]:
    """The two elements of a ramp of velocity mode: a change of speed, and the time that it takes in seconds."""
    return [
        Row(index, 1, f"{name}, delta speed", U32, "rw", delta_speed),
        Row(index, 2, f"{name}, delta time", U16, "rw", 1, low=1),
    ]


_LIMITS: Final = (("min", NO_POSITION_LIMITS[0]), ("max", NO_POSITION_LIMITS[1]))


def _probe_rows(indices: tuple[int, ...], what: str, type: int) -> list[Row]:
    edges = ("1 positive edge", "1 negative edge", "2 positive edge", "2 negative edge")
    return [
        Row(index, None, f"Touch probe {edge} {what}", type, "ro", is_mappable=True)
        for index, edge in zip(indices, edges, strict=True)
    ]


ROWS: Final = [
    Row(ABORT_CONNECTION, None, "Abort connection option code", I16, "rw", 1, low=0, high=3),
    Row(ERROR_CODE, None, "Error code", U16, "ro", is_mappable=True),
    Row(CONTROL_WORD, None, "Controlword", U16, "rww", is_mappable=True),
    Row(STATUS_WORD, None, "Statusword", U16, "ro", is_mappable=True),
    Row(QUICK_STOP_OPTION, None, "Quick stop option code", I16, "rw", 2, low=0, high=8),
    Row(SHUTDOWN_OPTION, None, "Shutdown option code", I16, "rw", 0, low=0, high=1),
    Row(DISABLE_OPTION, None, "Disable operation option code", I16, "rw", 1, low=0, high=1),
    Row(HALT_OPTION, None, "Halt option code", I16, "rw", 1, low=1, high=4),
    Row(FAULT_OPTION, None, "Fault reaction option code", I16, "rw", 2, low=0, high=4),
    Row(VL_TARGET, None, "vl target velocity", I16, "rww", is_mappable=True),
    Row(VL_DEMAND, None, "vl velocity demand", I16, "ro", is_mappable=True),
    Row(VL_ACTUAL, None, "vl velocity actual value", I16, "ro", is_mappable=True),
    *_array(VL_AMOUNT, "vl velocity min max amount", U32, "rw", (("min amount", 0), ("max amount", 6_000))),
    *_ramp(VL_ACCELERATION, "vl velocity acceleration", 600),
    *_ramp(VL_DECELERATION, "vl velocity deceleration", 600),
    *_ramp(VL_QUICK_STOP, "vl velocity quick stop", 6_000),
    *_array(VL_SET_POINT_FACTOR, "vl set-point factor", I16, "rw", (("numerator", 1), ("denominator", 1))),
    *_array(VL_DIMENSION_FACTOR, "vl dimension factor", I32, "rw", (("numerator", 1), ("denominator", 1))),
    Row(MODE, None, "Modes of operation", I8, "rww", is_mappable=True),
    Row(MODE_DISPLAY, None, "Modes of operation display", I8, "ro", is_mappable=True),
    Row(POSITION_DEMAND, None, "Position demand value", I32, "ro", is_mappable=True),
    Row(POSITION_INTERNAL, None, "Position actual internal value", I32, "ro", is_mappable=True),
    Row(POSITION_ACTUAL, None, "Position actual value", I32, "ro", is_mappable=True),
    Row(FOLLOWING_WINDOW, None, "Following error window", U32, "rw", NO_WINDOW),
    Row(FOLLOWING_TIME, None, "Following error time out", U16, "rw"),
    Row(POSITION_WINDOW, None, "Position window", U32, "rw", 1_000),
    Row(POSITION_TIME, None, "Position window time", U16, "rw"),
    Row(VELOCITY_DEMAND, None, "Velocity demand value", I32, "ro", is_mappable=True),
    Row(VELOCITY_ACTUAL, None, "Velocity actual value", I32, "ro", is_mappable=True),
    Row(VELOCITY_WINDOW, None, "Velocity window", U16, "rw", 10_000),
    Row(VELOCITY_TIME, None, "Velocity window time", U16, "rw"),
    Row(THRESHOLD, None, "Velocity threshold", U16, "rw", 10_000),
    Row(THRESHOLD_TIME, None, "Velocity threshold time", U16, "rw"),
    Row(TARGET_TORQUE, None, "Target torque", I16, "rww", is_mappable=True),
    Row(MAX_TORQUE, None, "Max torque", U16, "rw", FULL_TORQUE, is_mappable=True),
    Row(MAX_CURRENT, None, "Max current", U16, "rw", NO_CURRENT_LIMIT),
    Row(TORQUE_DEMAND, None, "Torque demand", I16, "ro", is_mappable=True),
    Row(RATED_CURRENT, None, "Motor rated current", U32, "ro"),
    Row(RATED_TORQUE, None, "Motor rated torque", U32, "ro"),
    Row(TORQUE_ACTUAL, None, "Torque actual value", I16, "ro", is_mappable=True),
    Row(CURRENT_ACTUAL, None, "Current actual value", I16, "ro", is_mappable=True),
    Row(DC_LINK, None, "DC link circuit voltage", U32, "ro", is_mappable=True),
    Row(TARGET_POSITION, None, "Target position", I32, "rww", is_mappable=True),
    *_array(POSITION_RANGE, "Position range limit", I32, "rw", _LIMITS),
    Row(HOME_OFFSET, None, "Home offset", I32, "rw"),
    *_array(POSITION_LIMIT, "Software position limit", I32, "rw", _LIMITS),
    Row(POLARITY, None, "Polarity", U8, "rw"),
    Row(MAX_VELOCITY, None, "Max profile velocity", U32, "rw", 100_000_000),
    Row(MAX_MOTOR_SPEED, None, "Max motor speed", U32, "rw", NO_SPEED_LIMIT),
    Row(PROFILE_VELOCITY, None, "Profile velocity", U32, "rw", 1_000_000, is_mappable=True),
    Row(PROFILE_ACCELERATION, None, "Profile acceleration", U32, "rw", 10_000_000, is_mappable=True, low=1),
    Row(PROFILE_DECELERATION, None, "Profile deceleration", U32, "rw", 10_000_000, is_mappable=True, low=1),
    Row(QUICK_STOP_DECELERATION, None, "Quick stop deceleration", U32, "rw", 100_000_000, low=1),
    Row(PROFILE_TYPE, None, "Motion profile type", I16, "rw", low=0, high=3),
    Row(TORQUE_SLOPE, None, "Torque slope", U32, "rw", 1_000, low=1),
    Row(TORQUE_PROFILE, None, "Torque profile type", I16, "rw", low=0, high=0),
    *_array(
        ENCODER_RESOLUTION, "Position encoder resolution", U32, "rw",
        (("encoder increments", 1_000_000), ("motor revolutions", 1)),
    ),
    *_array(GEAR_RATIO, "Gear ratio", U32, "rw", (("motor revolutions", 1), ("shaft revolutions", 1))),
    *_array(FEED_CONSTANT, "Feed constant", U32, "rw", (("feed", 1_000_000), ("shaft revolutions", 1))),
    Row(HOMING_METHOD, None, "Homing method", I8, "rw", 35),
    *_array(
        HOMING_SPEED, "Homing speeds", U32, "rw",
        (("speed during search for switch", 500_000), ("speed during search for zero", 50_000)),
    ),
    Row(HOMING_ACCELERATION, None, "Homing acceleration", U32, "rw", 5_000_000, low=1),
    Row(JERK_USE, None, "Profile jerk use", U8, "rw", 1, low=1, high=1),
    Row(PROFILE_JERK, 1, "Profile jerk, profile jerk 1", U32, "rw", 100_000_000, low=1),
    Row(POSITION_OFFSET, None, "Position offset", I32, "rww", is_mappable=True),
    Row(VELOCITY_OFFSET, None, "Velocity offset", I32, "rww", is_mappable=True),
    Row(TORQUE_OFFSET, None, "Torque offset", I16, "rww", is_mappable=True),
    Row(PROBE_FUNCTION, None, "Touch probe function", U16, "rww", is_mappable=True),
    Row(PROBE_STATUS, None, "Touch probe status", U16, "ro", is_mappable=True),
    Row(PROBE_1_RISING, None, "Touch probe 1 positive edge", I32, "ro", is_mappable=True),
    Row(PROBE_1_FALLING, None, "Touch probe 1 negative edge", I32, "ro", is_mappable=True),
    Row(PROBE_2_RISING, None, "Touch probe 2 positive edge", I32, "ro", is_mappable=True),
    Row(PROBE_2_FALLING, None, "Touch probe 2 negative edge", I32, "ro", is_mappable=True),
    *_array(PROBE_SOURCE, "Touch probe source", I16, "rw", (("probe 1", 1), ("probe 2", 2))),
    *_probe_rows(PROBE_TIMES, "time stamp", U32),
    *_probe_rows(PROBE_COUNTERS, "counter", U16),
    Row(SUB_MODE, None, "Interpolation sub mode select", I16, "rw", low=0, high=0),
    Row(DATA_RECORD, 1, "Interpolation data record, set-point", I32, "rww", is_mappable=True),
    Row(INTERPOLATION_TIME, 1, "Interpolation time period value", U8, "rw", 4, low=1),
    Row(INTERPOLATION_TIME, 2, "Interpolation time index", I8, "rw", -3, low=-6, high=0),
    Row(SYNC_DEFINITION, 1, "Synchronise on group", U8, "rw"),
    Row(SYNC_DEFINITION, 2, "Interpolation sync every n events", U8, "rw", 1),
    Row(BUFFER, 1, "Maximum buffer size", U32, "ro", BUFFER_SIZE),
    Row(BUFFER, 2, "Actual buffer size", U32, "rw", BUFFER_SIZE, low=1, high=BUFFER_SIZE),
    Row(BUFFER, 3, "Buffer organisation", U8, "rw", low=0, high=0),
    Row(BUFFER, 4, "Buffer position", U16, "ro"),
    Row(BUFFER, 5, "Size of data record", U8, "rw", 4, low=4, high=4),
    Row(BUFFER, 6, "Buffer clear", U8, "rw", 1, low=0, high=1),
    Row(MAX_ACCELERATION, None, "Max acceleration", U32, "rw", 1_000_000_000, low=1),
    Row(MAX_DECELERATION, None, "Max deceleration", U32, "rw", 1_000_000_000, low=1),
    *_array(
        HOMING_METHODS, "Supported homing methods", I8, "ro",
        tuple((f"method {place}", method) for place, method in enumerate(sorted(METHODS), 1)),
    ),
    Row(POSITIONING_OPTION, None, "Positioning option code", U16, "rw", low=0, high=0xC2),
    Row(FOLLOWING_ERROR, None, "Following error actual value", I32, "ro", is_mappable=True),
    Row(DEMAND_INTERNAL, None, "Position demand internal value", I32, "ro", is_mappable=True),
    Row(INPUTS, None, "Digital inputs", U32, "ro", is_mappable=True),
    Row(OUTPUTS, 1, "Digital outputs, physical outputs", U32, "rww", is_mappable=True),
    Row(OUTPUTS, 2, "Digital outputs, bit mask", U32, "rw"),
    Row(TARGET_VELOCITY, None, "Target velocity", I32, "rww", is_mappable=True),
    Row(SUPPORTED_MODES, None, "Supported drive modes", U32, "ro"),
    Row(DEVICE_TYPE, None, "Single device type", U32, "ro"),
]  # fmt: skip

RECEIVED: Final = (
    (CONTROL_WORD,),
    (CONTROL_WORD, MODE),
    (CONTROL_WORD, TARGET_POSITION),
    (CONTROL_WORD, TARGET_VELOCITY),
)
TRANSMITTED: Final = (
    (STATUS_WORD,),
    (STATUS_WORD, MODE_DISPLAY),
    (STATUS_WORD, POSITION_ACTUAL),
    (STATUS_WORD, VELOCITY_ACTUAL),
)
"""Default mapping of PDOs 1 to 4 of an axis (CiA 402-3); PDO 5 of each axis is empty and free for a master."""
SYNCHRONOUS: Final = (2, 3)
"""Positions in `TRANSMITTED` of the PDOs that answer each SYNC; the others are sent when they change."""
EVENT_TIMER_MS: Final = 100
"""Event timer of the PDOs that are sent when they change, so that no master waits for the next one in vain."""
EMPTY_PDOS: Final = 1
