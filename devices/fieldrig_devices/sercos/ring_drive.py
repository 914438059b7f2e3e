"""A drive as the master sees it, and the events of the ring that the master reports."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

from fieldrig_devices.sercos.service import ServiceClient
from fieldrig_devices.sercos.telegram import CODES, HEAD_BYTES, record, size


class Event(Enum):
    PHASE = auto()
    """A phase was reached: `code` is its number."""
    OPEN = auto()
    """The ring has opened."""
    CLOSED = auto()
    MISSING = auto()
    """No drive answers at `address` in CP1."""
    AT_FAILED = auto()
    """An AT did not come: `code` is the number of consecutive failures."""
    REFUSED = auto()
    """The drive refused something on the way up: `idn`, and `code` of the service channel."""
    NO_ROOM = auto()
    """The telegrams don't fit into the cycle: `code` is the time they need, in microseconds."""


@dataclass(frozen=True, slots=True)
class RingEvent:
    what: Event
    address: int = 0
    idn: int = 0
    code: int = 0


class Drive:
    """A drive as the master sees it."""

    def __init__(self, address: int, mdt: Sequence[int], at: Sequence[int]) -> None:
        """`mdt` and `at` are the IDNs of command and feedback values.  KeyError if one cannot be cyclic."""
        self.address = address
        self.mdt, self.at = tuple(mdt), tuple(at)
        self.mdt_codes, at_codes = [CODES[idn] for idn in mdt], [CODES[idn] for idn in at]
        self.values_of = record(at_codes).unpack_from
        self.at_length = 1 + HEAD_BYTES + size(at_codes)
        self.client = ServiceClient()
        self.place = 0
        """Position of its control word among the values of the MDT."""
        self.control = 0
        self.values: tuple[int, ...] = (0,) * (2 + len(self.at))
        """Values of its last AT: status word, service channel, feedback values."""
        self.missed = 0
        self.calls = 0
        self.is_here = False
        """True if it answered in CP1."""
        self.lost = 0
        """Total number of missing ATs in CP3 and CP4."""

    @property
    def status(self) -> int:
        return self.values[0]

    @property
    def info(self) -> int:
        return self.values[1]

    @property
    def feedback(self) -> tuple[int, ...]:
        return self.values[2:]
