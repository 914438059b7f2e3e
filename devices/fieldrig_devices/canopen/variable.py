"""One variable of the object dictionary: its value as bytes, and the rules for accessing it.

Source: CiA 301 chapter 7.4, CiA 306-1 4.6.3 (access types).  The value is stored as on the bus, so that SDO and PDO
only copy bytes; the application sees decoded values.  A service that has to act on an access installs itself as
`writer` or `reader` of the variable, or as a watcher.
"""

from collections.abc import Callable
from enum import Enum

from fieldrig.points.checks import number_in
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.datatypes import DOMAIN, DataType, Integer, Real, Value, clamp

MAX_SIZE = 1 << 20
"""Most bytes that a variable of variable length can hold."""

FIRST_APPLICATION_INDEX = 0x2000


class Access(Enum):
    """Access types of CiA 306, which also say into which PDOs a variable can be mapped."""

    RO = "ro"
    WO = "wo"
    RW = "rw"
    RWR = "rwr"
    RWW = "rww"
    CONST = "const"

    @property
    def is_readable(self) -> bool:
        return self is not Access.WO

    @property
    def is_writable(self) -> bool:
        return self not in (Access.RO, Access.CONST)

    @property
    def is_transmitted(self) -> bool:
        return self not in (Access.WO, Access.RWW)

    @property
    def is_received(self) -> bool:
        return self in (Access.WO, Access.RW, Access.RWW)


class Variable:
    """One sub-index: type, limits, access, and its present value as bytes."""

    __slots__ = (
        "access",
        "data",
        "events",
        "gate",
        "high",
        "index",
        "is_command",
        "is_mappable",
        "is_parameter",
        "live",
        "low",
        "name",
        "reader",
        "start",
        "subindex",
        "type",
        "watchers",
        "writer",
    )

    def __init__(
        self,
        index: int,
        subindex: int,
        name: str,
        data_type: DataType,
        access: Access,
        *,
        start: bytes,
        low: float | None = None,
        high: float | None = None,
        is_mappable: bool = False,
    ) -> None:
        self.index, self.subindex, self.name = index, subindex, name
        self.type, self.access, self.is_mappable = data_type, access, is_mappable
        self.low, self.high = low, high
        self.start = start
        """Value after power-on."""
        self.data = start
        self.is_parameter: bool | None = None
        """True for a parameter and False for a set-point, or None if only the access type says which it is."""
        self.is_command = False
        """True if writing triggers an action that uses other variables; an RPDO writes such a variable last."""
        self.writer: Callable[[bytes], None] | None = None
        """Called instead of `set` with a value that the network writes, if it is within the limits; may raise Abort."""
        self.reader: Callable[[], bytes] | None = None
        """Called to provide the value that the network reads, instead of `data`; may raise Abort."""
        self.live: Callable[[], bytes] | None = None
        """Returns the present value while it follows a moving signal; `data` is the last sample then."""
        self.watchers: list[Callable[[], None]] = []
        """Called after each change."""
        self.events: list[Callable[[], None]] = []
        """Event handlers of the TPDOs that carry the variable, called after a change if `gate` agrees."""
        self.gate: Callable[[], bool] | None = None

    def fresh(self) -> "Variable":
        """Return a new variable of the same description with its power-on value, without readers or watchers."""
        return Variable(
            self.index,
            self.subindex,
            self.name,
            self.type,
            self.access,
            start=self.start,
            low=self.low,
            high=self.high,
            is_mappable=self.is_mappable,
        )

    @property
    def key(self) -> str:
        return f"{self.index:04X}:{self.subindex:02X}"

    @property
    def value(self) -> Value:
        return self.type.decode(self.data)

    @property
    def present(self) -> Value:
        """The value at this instant, as the network would read it; `value` may be an older sample."""
        read = self.live or self.reader
        if read is None or self.type is DOMAIN:  # a domain is a stream, too long to show
            return self.value
        try:
            return self.type.decode(read())
        except Abort:  # the network cannot read it at present
            return self.value

    @property
    def number(self) -> int:
        """The value of an unsigned variable."""
        return int.from_bytes(self.data, "little")

    @property
    def is_process_input(self) -> bool:
        """True if the device, not a master, determines the value."""
        is_input = self.access is Access.RO or (self.access is Access.RWR and self.is_parameter is None)
        return self.is_mappable and is_input and self.index >= FIRST_APPLICATION_INDEX

    @property
    def is_process_output(self) -> bool:
        """True if a master writes it again and again, so that it is none of the parameters of the device."""
        if self.is_parameter is None:
            return self.is_mappable and self.access in (Access.RWW, Access.WO)
        return not self.is_parameter

    @property
    def is_plain(self) -> bool:
        """True if the network may write any bytes of the right size."""
        return self.writer is None and self.low is None and self.high is None and self.type.bits != 1

    def put(self, value: Value) -> None:
        """Set the value from the application, regardless of the access type.  Raises ValueError if it doesn't fit."""
        self.set(self._fitting(value))

    def order(self, value: Value) -> None:
        """Do what a master's write does, such as the order of a control word, where a master can write; else put.

        Raises ValueError if the value doesn't fit, is refused at present, or comes from the device in each read.
        """
        data = self._fitting(value)
        if self.writer is None or not self.access.is_writable:
            if self.live is not None or self.reader is not None:
                raise ValueError(
                    f"the device determines {self.key}, {self.name}\nexpected an object that can be written"
                )
            self.set(data)
            return
        try:
            self.writer(data)
        except Abort as refused:
            raise ValueError(f"refused with {refused}") from refused

    def _fitting(self, value: Value) -> bytes:
        data = self.type.encode(value)
        if self.refusal(data) is not None:
            number_in(value, self.low, self.high, name=self.key)
        return data

    def nearest(self, number: float) -> int | float:
        """Return the number that a variable of a number can hold nearest to this one, within its limits."""
        type = self.type
        assert isinstance(type, Integer | Real), "the variable holds a number"
        low = type.low if self.low is None else self.low
        high = type.high if self.high is None else self.high
        limited = clamp(number, low, high)
        return round(limited) if isinstance(type, Integer) else limited

    def set(self, data: bytes) -> None:
        """Set `data`, whose size and value must be valid, and notify watchers and TPDOs of a change."""
        if data == self.data:
            return
        self.data = data
        for watcher in self.watchers:
            watcher()
        if self.events and (self.gate is None or self.gate()):
            for event in self.events:
                event()

    def read(self) -> bytes:
        """Read the value for the network.  Raises Abort if it isn't readable."""
        if not self.access.is_readable:
            raise Abort(Code.WRITE_ONLY)
        read = self.live or self.reader
        return self.data if read is None else read()

    def sample(self) -> None:
        """Update `data` if the value follows a moving signal."""
        if self.live is not None:
            self.set(self.live())

    def check_writable(self, size: int | None) -> None:
        """Raise Abort if the network must not write `size` bytes here; None checks the access only."""
        if not self.access.is_writable:
            raise Abort(Code.READ_ONLY)
        if size is None:
            return
        self.check_room(size)
        if self.type.size is not None and size < self.type.size:
            raise Abort(Code.LENGTH_TOO_LOW)

    def check_room(self, size: int) -> None:
        """Raise Abort if `size` bytes are too many."""
        if self.type.size is not None and size > self.type.size:
            raise Abort(Code.LENGTH_TOO_HIGH)
        if size > MAX_SIZE:
            raise Abort(Code.OUT_OF_MEMORY)

    def write(self, data: bytes) -> None:
        """Write a value from the network.  Raises Abort if it is refused."""
        self.check_writable(len(data))
        refusal = None if self.is_plain else self.refusal(data)
        if refusal is not None:
            raise Abort(refusal)
        if self.writer is None:
            self.set(data)
        else:
            self.writer(data)

    def refusal(self, data: bytes) -> Code | None:
        """Return the abort code for a value beyond its limits, or None."""
        if self.type.bits == 1:
            return Code.VALUE_TOO_HIGH if data[0] > 1 else None
        if self.low is None and self.high is None:
            return None
        value = self.type.decode(data)
        if isinstance(value, str):
            return None
        # The comparisons are negated so that not-a-number is beyond every limit.
        if self.high is not None and not value <= self.high:
            return Code.VALUE_TOO_HIGH
        if self.low is not None and not value >= self.low:
            return Code.VALUE_TOO_LOW
        return None
