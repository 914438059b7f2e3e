"""Frames on the ring of a PAM, as the programs at both ends mean them.

The manual names the frames only by the errors that their loss gives (section 3.1 of the digest), so their contents are
ours.  `codec` turns them into bytes.  A node's items are known by the number that the PAM gives each of them when it
configures the node.  Positions are in resolver units (RU), 2^32 to a turn of the motor; levels are electrical, before
ACTIVE gives them their meaning.  So the PAM applies ACTIVE to the bits of binary and digital inputs and outputs, of
which the lowest address is the lowest bit.  The node needs ACTIVE for the inactive level of an output, and for keys and
counters: the value of a key is true, and a pulse counts, at the active level.
"""

from dataclasses import dataclass
from enum import IntEnum

BROADCAST = 0
"""The address of all nodes."""


class NodeType(IntEnum):
    """The kind of a node on the ring of a PAM."""

    ST1 = 1
    SMART_IO = 2


# ---- from the PAM: configuration


@dataclass(frozen=True, slots=True)
class InputItem:
    """BITS consecutive binary inputs (1 for a BINARY_INPUT), accepted after `debounce` equal samples (PAML-083)."""

    item: int
    address: int
    bits: int
    is_active_high: bool
    period_ms: int
    debounce: int


@dataclass(frozen=True, slots=True)
class CounterItem:
    """Pulses of a binary input, for a DC motor (PAML-086)."""

    item: int
    address: int
    is_active_high: bool
    period_ms: int
    debounce: int


class KeyMode(IntEnum):
    ON_OFF = 0
    TOGGLE = 1
    AUTOREPEAT = 2


@dataclass(frozen=True, slots=True)
class KeyItem:
    """A key of the keyboard, or of a binary input (PAML-087 to PAML-092)."""

    item: int
    address: int
    is_on_binary_input: bool
    mode: KeyMode
    period_ms: int
    delay_ms: int = 0
    repeat_ms: int = 0
    is_active_high: bool = True
    debounce: int = 1


@dataclass(frozen=True, slots=True)
class OutputItem:
    """BITS consecutive binary outputs (1 for a BINARY_OUTPUT; PAML-101, PAML-102)."""

    item: int
    address: int
    bits: int
    is_active_high: bool


@dataclass(frozen=True, slots=True)
class AnalogItem:
    """An analog output of -10 V to +10 V; its value is in millivolts (PAML-103)."""

    item: int
    address: int


@dataclass(frozen=True, slots=True)
class LedItem:
    item: int
    address: int


@dataclass(frozen=True, slots=True)
class SevenSegmentItem:
    item: int
    address: int
    digits: int


@dataclass(frozen=True, slots=True)
class MotorItem:
    """A DC motor and the items that it consists of, which are configured before it (PAML-120 to PAML-132)."""

    item: int
    increase: int
    decrease: int
    zero: int
    counter: int
    timeout_ms: int
    braking: int
    """Pulses before the target at which the output is dropped."""


@dataclass(frozen=True, slots=True)
class AxisItem:
    """The axis of an ST1: its position at power-on, and its period, both in RU; 0 is no period."""

    item: int
    initial_position: int
    position_period: int


Configuration = (
    InputItem | CounterItem | KeyItem | OutputItem | AnalogItem | LedItem | SevenSegmentItem | MotorItem | AxisItem
)


@dataclass(frozen=True, slots=True)
class Identify:
    """The node answers with its `Identity`, and forgets the items that it was given."""


@dataclass(frozen=True, slots=True)
class Run:
    """The node begins to work with its items; sent to all nodes at once."""


# ---- from the PAM: work


@dataclass(frozen=True, slots=True)
class SetOutput:
    """An output's value: levels as bits, millivolts, or the state of an LED.

    A key takes its state as well, which stays until the key changes it (PAML-092).  It answers with its state and the
    `number` of the order, 1 to 65535, which is 0 for outputs.
    """

    item: int
    value: int
    number: int = 0


@dataclass(frozen=True, slots=True)
class Blink:
    """An LED or a display blinks, or no longer does."""

    item: int
    on: bool


@dataclass(frozen=True, slots=True)
class Display:
    """The character code that a seven-segment display shows, in the font of Appendix C."""

    item: int
    character: int


class Motor(IntEnum):
    """Orders to a DC motor; the comments give the values."""

    ABSOLUTE_MOVE = 1  # target
    RELATIVE_MOVE = 2  # distance
    RUN = 3  # 1 for INC, -1 for DEC
    STOP = 4
    POSITION = 5  # the new name of the present position
    ZERO_POSITION = 6  # 1 for INC or -1 for DEC; 1 for HIGH or 0 for LOW
    STROKE_LIMITS = 7  # lower, upper
    DISABLE_STROKE_LIMITS = 8


@dataclass(frozen=True, slots=True)
class MotorOrder:
    """An order with its `number`, 1 to 65535; those that leave `ready` alone have the number 0 (PAML-129)."""

    item: int
    order: Motor
    values: tuple[int, ...] = ()
    number: int = 0


class Move(IntEnum):
    """Orders to the axis of an ST1 (section 3 of the digest of the system)."""

    POWER_ON = 1
    POWER_OFF = 2
    ABSOLUTE_MOVE = 3
    RELATIVE_MOVE = 4
    RUN = 5
    STOP = 6
    POSITION = 7
    UPDATE_STATUS = 8


@dataclass(frozen=True, slots=True)
class AxisOrder:
    """An order with its value in RU or RU/s, and the limits of its trapezoid in RU/s and RU/s2 (0 where unused).

    The value of POWER_ON and POSITION is the new name of the position.  The node clips the limits to its own.  It
    reports an order as done by its `number`, 1 to 65535.  Orders that leave `ready` alone (POSITION, UPDATE_STATUS)
    have the number 0, which is never reported (PAML-059).  A POSITION during another order has a number: that order
    is then reported as done by it.
    """

    number: int
    move: Move
    value: int = 0
    speed: int = 0
    acceleration: int = 0
    deceleration: int = 0


class SetPointMode(IntEnum):
    POSITION = 1
    SPEED = 2
    TORQUE = 3


@dataclass(frozen=True, slots=True)
class SetPoint:
    """A new value of a pipe, which holds until the next: RU, RU/s, or the torque limit in thousandths of the largest.

    The axis has the pipe's part of its position and its own, which its orders move, and follows the sum (PAML-042).
    The first set-point of the mode POSITION makes the pipe's part its value and the axis's own part 0; within a
    position period an axis follows the set-points the shorter way round.
    A frame to a group of nodes carries one value for all of them (PAML-162).
    """

    mode: SetPointMode
    value: int


@dataclass(frozen=True, slots=True)
class EndOfPipe:
    """The end of the pipe that drove the axis in this mode (PAML-171: position holds, speed goes to zero).

    What the pipe has made of the position becomes the axis's own part.
    """

    mode: SetPointMode


@dataclass(frozen=True, slots=True)
class Group:
    """Nodes that take the set-points of one frame, sent to each of them; 0 to 15, and 0 is no group (PAML-164)."""

    number: int


@dataclass(frozen=True, slots=True)
class Read:
    """Read a register: an encoder's ADDRESS of Table 2-2, or the item of a DC motor.  `request` names the answer."""

    request: int
    register: int


Order = (
    Configuration | Identify | Run | SetOutput | Blink | Display | MotorOrder | AxisOrder | SetPoint | EndOfPipe
    | Group | Read
)  # fmt: skip

# ---- from a node


@dataclass(frozen=True, slots=True)
class Identity:
    """The answer to `Identify`: the node is initialized, and its interface is ready."""

    node_type: NodeType
    firmware: int


@dataclass(frozen=True, slots=True)
class Accepted:
    """The node has the item."""

    item: int


@dataclass(frozen=True, slots=True)
class Refused:
    """The node cannot have the item, so the PAM shows 04..E01A."""

    item: int


@dataclass(frozen=True, slots=True)
class Running:
    """The node has begun to work."""


@dataclass(frozen=True, slots=True)
class InputChanged:
    """The levels of an input as bits, the state of a key or the count of a counter after a change.

    `age_us` is the age of the change when the frame was laid into the buffer.
    Only inputs with a time stamp give an age other than 0.
    `number` is that of the last order that a key has taken, and 0 for other inputs.
    """

    item: int
    value: int
    age_us: int = 0
    number: int = 0


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a `Read`, as the register's bits with their sign; None if there is no such register."""

    request: int
    value: int | None


@dataclass(frozen=True, slots=True)
class AxisReport:
    """The state of an axis, sent when any of it has changed: bits of the tables 12-4 and 12-1.

    `number` is that of the last order that is done.
    """

    status: int
    error: int
    number: int
    set_point: int
    """The own part of the set position in RU, without what a pipe adds; exact when no order is under way."""


@dataclass(frozen=True, slots=True)
class MotorReport:
    """The state of a DC motor after a change, and after each order.

    `number` is that of the last order that the motor has taken, whose state this is.
    """

    item: int
    is_ready: bool
    error: int
    number: int = 0


class Severity(IntEnum):
    WARNING = 1
    ENDED = 2
    """The end of a warning, a K message."""
    ERROR = 3


@dataclass(frozen=True, slots=True)
class Trouble:
    """A message of a node, as the PAM shows it: 04..W00C and so on (section 14.3).

    The PAM shows three digits, so only the lowest 12 bits of `code` count.
    """

    severity: Severity
    code: int
    details: tuple[int, int] = (0, 0)
    """D2 and D3; the PAM adds the node's address as D1."""
    word: int = 0
    """The node's error word from now on."""


Report = (
    Identity | Accepted | Refused | Running | InputChanged | Answer | AxisReport | MotorReport | Trouble
)  # fmt: skip
