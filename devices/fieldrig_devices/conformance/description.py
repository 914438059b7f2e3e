"""The node according to its EDS, read by the reader of the emulated nodes, so that the suite accepts the same files.

Source: CiA 306-1 4.6, CiA 301 table 44 (data types).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from fieldrig.errors import UsageError
from fieldrig_devices.canopen.datatypes import DATA_TYPES, DataType, Integer
from fieldrig_devices.canopen.eds.reader import Description as Described
from fieldrig_devices.canopen.eds.reader import describe
from fieldrig_devices.canopen.eds.text import EdsError
from fieldrig_devices.canopen.variable import Variable

BOOLEAN, DOMAIN = 0x01, 0x0F
TIMES = (0x0C, 0x0D)
"""TIME_OF_DAY and TIME_DIFFERENCE, which are not treated as numbers."""
NUMBERS = {data_type: number for number, data_type in DATA_TYPES.items()}
"""Numbers of the data types of CiA 301."""

LAST_OF_COMMUNICATION = 0x1FFF
FIRST_SERVER = {"1200:01": 0x600, "1200:02": 0x580}
"""COB-IDs of the first SDO server without the node-ID, which is always added (CiA 301 7.5.2.33)."""
READABLE, WRITABLE = ("ro", "rw", "rwr", "rww", "const"), ("wo", "rw", "rwr", "rww")


@dataclass(frozen=True, slots=True)
class Entry:
    """One sub-index as the EDS describes it."""

    index: int
    sub: int
    name: str
    type: int
    access: str
    default: bytes | None
    """Default value as on the bus; None if the EDS has none that can be read."""
    low: int | None
    high: int | None
    is_mappable: bool

    @property
    def key(self) -> str:
        return f"{self.index:04X}h:{self.sub:02X}h"

    @property
    def size(self) -> int | None:
        """Size in bytes; None for any length."""
        return DATA_TYPES[self.type].size

    @property
    def pdo_bits(self) -> int:
        """Length in a PDO in bits; 0 if the data type has none."""
        return DATA_TYPES[self.type].bits or 0

    @property
    def is_integer(self) -> bool:
        """True for integer data types and BOOLEAN."""
        return self.type == BOOLEAN or (isinstance(DATA_TYPES[self.type], Integer) and self.type not in TIMES)

    @property
    def is_readable(self) -> bool:
        return self.access in READABLE

    @property
    def is_writable(self) -> bool:
        return self.access in WRITABLE

    @property
    def range(self) -> tuple[int, int]:
        """Lowest and highest value of an integer type; a BOOLEAN counts as a byte."""
        data_type = DATA_TYPES[self.type]
        return (data_type.low, data_type.high) if isinstance(data_type, Integer) else (0, 0xFF)

    @property
    def is_signed(self) -> bool:
        data_type = DATA_TYPES[self.type]
        return isinstance(data_type, Integer) and data_type.is_signed

    def encode(self, value: int) -> bytes:
        return value.to_bytes(self.size or 4, "little", signed=self.is_signed)

    def allows(self, data: bytes) -> bool:
        """True if a value is within the limits, as far as there are any."""
        if not self.is_integer:
            return True
        value = int.from_bytes(data, "little", signed=self.is_signed)
        return (self.low is None or value >= self.low) and (self.high is None or value <= self.high)


class Description:
    """The description of a node to test: its EDS or DCF file, with a node-ID."""

    def __init__(self, path: Path, node_id: int) -> None:
        """Read the file.  Raises UsageError if it is refused."""
        self.path, self.node_id = path, node_id
        try:
            described = describe(path, node_id)
        except (OSError, EdsError) as cause:
            raise UsageError(f"{path} cannot be used as an EDS: {cause}", "`fieldrig eds check` has details") from cause
        self.entries = {
            (variable.index, variable.subindex): _entry(described, variable) for variable in described.variables
        }
        for key, cob_id in FIRST_SERVER.items():
            self.set_default(key, cob_id + node_id)
        self.dummies = described.dummies
        """Length in bits of the data types that an RPDO may map as a dummy, by index."""

    def set_default(self, key: str, value: bool | int | float | str) -> None:
        """Set the default of an entry such as `1017:00`; ignored if there is no such entry."""
        index, _, sub = key.partition(":")
        entry = self.entries.get((int(index, 16), int(sub, 16)))
        if entry is not None:
            data = entry.encode(value) if isinstance(value, int) and entry.is_integer else None
            self.entries[entry.index, entry.sub] = replace(entry, default=data)

    def __contains__(self, index: int) -> bool:
        return any(entry.index == index for entry in self.entries.values())

    def __iter__(self) -> Iterator[Entry]:
        """Iterate over the entries in order of index and sub-index."""
        return iter([self.entries[key] for key in sorted(self.entries)])

    def get(self, index: int, sub: int = 0) -> Entry | None:
        return self.entries.get((index, sub))

    def members(self, index: int) -> list[Entry]:
        """Return the entries of an object from sub-index 1 on, without the description of its structure (FFh)."""
        return [entry for entry in self if entry.index == index and 0 < entry.sub < 0xFF]

    def indices(self, first: int, last: int) -> list[int]:
        return sorted({index for index, _ in self.entries if first <= index <= last})


def _entry(described: Described, variable: Variable) -> Entry:
    data_type = variable.type
    has_default = (variable.index, variable.subindex) in described.given
    return Entry(
        variable.index,
        variable.subindex,
        variable.name,
        NUMBERS[data_type],
        variable.access.value,
        variable.start if has_default else None,
        _limit(data_type, variable.low),
        _limit(data_type, variable.high),
        variable.is_mappable,
    )


def _limit(data_type: DataType, limit: float | None) -> int | None:
    """Return the limit of an integer type, or None."""
    return int(limit) if isinstance(data_type, Integer) and limit is not None else None
