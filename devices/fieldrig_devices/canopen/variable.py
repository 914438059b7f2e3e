"""One variable of the object dictionary: its value as bytes, and the rules of access to it.

Source: CiA 301 chapter 7.4, CiA 306-1 4.6.3 (access types).  Bytes are kept as they go over the bus, so that SDO and
PDO only copy them; the application sees values.  What a service makes of an access is the service's affair: it
puts itself in as `writer` or `reader` of its parameters, or watches them.
"""

from collections.abc import Callable
from enum import Enum

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.datatypes import DOMAIN, DataType, Value

MAX_SIZE = 1 << 20
"""Bytes that a variable without a size of its own can hold."""

FIRST_APPLICATION_INDEX = 0x2000


class Access(Enum):
    """Access types of CiA 306: who may do what, and into which PDO a mappable variable may go."""

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
        """What it holds after power-on."""
        self.data = start
        self.is_command = False
        """It acts with what other variables hold, so of an RPDO that carries them too it is written last."""
        self.writer: Callable[[bytes], None] | None = None
        """Takes what the network writes, within limits, in place of `set`; may raise Abort."""
        self.reader: Callable[[], bytes] | None = None
        """Gives what the network reads in place of `data`; may raise Abort."""
        self.live: Callable[[], bytes] | None = None
        """Gives the present bytes while the machine moves the value on; `data` is what was sampled last."""
        self.watchers: list[Callable[[], None]] = []
        """Called after each change."""
        self.events: list[Callable[[], None]] = []
        """TPDOs that carry it: called after a change that `gate` lets pass."""
        self.gate: Callable[[], bool] | None = None

    def fresh(self) -> "Variable":
        """Another one of the same description, at its power-on value, that nobody uses yet."""
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
        """The value at this instant, which the network would read; `value` may be an older sample."""
        read = self.live or self.reader
        if read is None or self.type is DOMAIN:  # a domain is a stream, and for people too long
            return self.value
        try:
            return self.type.decode(read())
        except Abort:  # the network gets no value at present
            return self.value

    @property
    def number(self) -> int:
        """The value of an unsigned variable."""
        return int.from_bytes(self.data, "little")

    @property
    def is_process_input(self) -> bool:
        """Whether its value comes from the machine and not from a master."""
        return self.is_mappable and self.access in (Access.RO, Access.RWR) and self.index >= FIRST_APPLICATION_INDEX

    @property
    def is_plain(self) -> bool:
        """Whether the network may put any bytes of the right size into it."""
        return self.writer is None and self.low is None and self.high is None and self.type.bits != 1

    def put(self, value: Value) -> None:
        """Set by the application, which may write what the network may not.  ValueError for what it can't hold."""
        data = self.type.encode(value)
        refusal = self.refusal(data)
        if refusal is not None:
            raise ValueError(f"{value!r} is beyond the limits of {self.key}: {self.low} to {self.high}")
        self.set(data)

    def set(self, data: bytes) -> None:
        """Take bytes of the right size and value, and tell who watches."""
        if data == self.data:
            return
        self.data = data
        for watcher in self.watchers:
            watcher()
        if self.events and (self.gate is None or self.gate()):
            for event in self.events:
                event()

    def read(self) -> bytes:
        """By the network."""
        if not self.access.is_readable:
            raise Abort(Code.WRITE_ONLY)
        read = self.live or self.reader
        return self.data if read is None else read()

    def sample(self) -> None:
        """Bring `data` to the present, if the machine moves it on."""
        if self.live is not None:
            self.set(self.live())

    def check_writable(self, size: int | None) -> None:
        """Abort if the network may not write here, or not `size` bytes (None: not known yet)."""
        if not self.access.is_writable:
            raise Abort(Code.READ_ONLY)
        if size is None:
            return
        self.check_room(size)
        if self.type.size is not None and size < self.type.size:
            raise Abort(Code.LENGTH_TOO_LOW)

    def check_room(self, size: int) -> None:
        """Abort if `size` bytes are more than fit."""
        if self.type.size is not None and size > self.type.size:
            raise Abort(Code.LENGTH_TOO_HIGH)
        if size > MAX_SIZE:
            raise Abort(Code.OUT_OF_MEMORY)

    def write(self, data: bytes) -> None:
        """By the network; Abort if it may not."""
        self.check_writable(len(data))
        refusal = None if self.is_plain else self.refusal(data)
        if refusal is not None:
            raise Abort(refusal)
        if self.writer is None:
            self.set(data)
        else:
            self.writer(data)

    def refusal(self, data: bytes) -> Code | None:
        """Which limit the value in `data` breaks."""
        if self.type.bits == 1:
            return Code.VALUE_TOO_HIGH if data[0] > 1 else None
        if self.low is None and self.high is None:
            return None
        value = self.type.decode(data)
        if isinstance(value, str):
            return None
        # Written so that not-a-number is within no limits.
        if self.high is not None and not value <= self.high:
            return Code.VALUE_TOO_HIGH
        if self.low is not None and not value >= self.low:
            return Code.VALUE_TOO_LOW
        return None
