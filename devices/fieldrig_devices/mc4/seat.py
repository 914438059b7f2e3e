"""A drive's part in a convoy: the drives of a process that only follow their set positions are moved together.

They stay apart all the same.  A ride ends as soon as anybody asks for the axis, and before a cycle in which anything
but following is to be done; then drive and axis are as if they had gone alone.  So what a drive sends doesn't depend on
who shares its process.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Final, NamedTuple

from fieldrig.clock import Clock
from fieldrig_bus.ring.message import Cycle
from fieldrig_bus.wires import Motion
from fieldrig_devices.mc4.machine import Machine
from fieldrig_devices.sercos.slave import SercosSlave

if TYPE_CHECKING:
    from fieldrig_devices.mc4.convoy import Convoy

FEWEST: Final = 24
"""Drives for which a convoy pays; measured."""


class Course(NamedTuple):
    """What others were told of where the load of an axis is, and goes."""

    told: Motion
    tolerance: float
    """Rad by which it may be elsewhere before they are told anew."""
    gear_ratio: float
    offset: float
    """Increments from the axis to the shaft."""


class Telling(NamedTuple):
    """How others are told of it."""

    tell: Callable[[], None]
    course: Callable[[], Course]
    """What they were told last."""


class Shape(NamedTuple):
    """What the drives of a convoy have in common."""

    cycle_us: int
    mdt_length: int
    """With the address."""
    place: int
    """Bytes from the beginning of the record to the set position."""
    at_length: int
    """With the head."""
    moving: tuple[int, ...]
    """IDNs of the first values in the AT, those that change with every cycle."""
    codes: str
    """Theirs, for `struct`."""


class Group:
    """All of one shape."""

    def __init__(self, shape: Shape) -> None:
        self.shape = shape
        self.seats: list[Seat] = []
        self._convoy: Convoy | None = None

    def add(self, seat: "Seat") -> int:
        """Its place, for good."""
        if self._convoy is not None:
            self._convoy.dissolve()
            self._convoy = None
        self.seats.append(seat)
        return len(self.seats) - 1

    def convoy(self) -> "Convoy":
        if self._convoy is None:
            from fieldrig_devices.mc4.convoy import Convoy  # numpy: not for the process of a single drive

            self._convoy = Convoy(self.shape, self.seats)
        return self._convoy


class Groups:
    """Of one process on one ring; see `fieldrig.link.shared`."""

    def __init__(self) -> None:
        self._groups: dict[Shape, Group] = {}

    def of(self, shape: Shape) -> Group:
        return self._groups.get(shape) or self._groups.setdefault(shape, Group(shape))


class Seat:
    __slots__ = (
        "_clock", "_group", "_look", "_telling", "at", "convoy", "due_ns", "gathers", "is_astray",
        "lead_ns", "machine", "most_error", "number", "offset", "slave", "template",
    )  # fmt: skip

    def __init__(
        self, group: Group, clock: Clock, machine: Machine, slave: SercosSlave, look: Callable[[], bool],
        telling: Telling | None,
    ) -> None:  # fmt: skip
        """`look` sees to what is slow, and tells whether the drive only follows as before."""
        self._group, self._clock, self.machine, self.slave, self._look = group, clock, machine, slave, look
        self.offset, self._telling = slave.layout.position, telling
        """The first is that of the drive's record in the MDT."""
        self.gathers = False
        self.most_error = 0.0
        self.due_ns = self.lead_ns = 0
        """When `look` is; how far the drive's time is before the convoy's."""
        self.template = b""
        """The AT of the last cycle that it went alone, if nothing has changed since."""
        self.convoy: Convoy | None = None
        """In which it rides."""
        self.at: bytes | None = None
        """Of the present cycle, until it is taken."""
        self.is_astray = False
        """It has to tell its course anew."""
        self.number = group.add(self)

    def offer(self, is_willing: bool, most_error: float) -> None:
        """Whether the drive only follows its set position now; at an `e` of `most_error`, in rad, it doesn't."""
        self.most_error, self.template = most_error, b""
        self.gathers = is_willing and len(self._group.seats) >= FEWEST

    def gather(self, at: bytes, cycle: Cycle) -> None:
        """After a cycle that it went alone, in which it has left `at`."""
        self.template = at
        self._group.convoy().gather(self, cycle, self._clock.now_ns())

    @property
    def course(self) -> Course | None:
        return None if self._telling is None else self._telling.course()

    def begin(self, convoy: "Convoy", lead_ns: int) -> None:
        self.convoy, self.lead_ns, self.due_ns = convoy, lead_ns, self.machine.next_slow_ns
        self.at = None
        self.is_astray = False
        self.machine.ride = self.slave.stand_in = self

    def take(self, cycle: Cycle) -> bytes | None:
        """The AT of this cycle; None if the ride is over, before it."""
        convoy = self.convoy
        if convoy is None:
            return None
        if self.at is None:
            if not convoy.go(cycle, self._clock.now_ns()):
                self.end()
        elif cycle is not convoy.cycle:
            self.end()
        if self.at is not None and convoy.now_ns >= self.due_ns:
            self._look_before(convoy)
        at, self.at = self.at, None
        if at is not None and self.is_astray and self._telling is not None:
            self._tell(convoy, self._telling)
        return at

    def _tell(self, convoy: "Convoy", telling: Telling) -> None:
        self.is_astray = False
        convoy.axes.give(self.number, self.machine.axis_alone)
        self.machine.ride = None  # the axis is asked for, and goes on riding
        telling.tell()
        self.machine.ride = self
        convoy.axes.tell(self.number, telling.course())

    def _look_before(self, convoy: "Convoy") -> None:
        """See to what is slow, as the drive does before it goes a cycle."""
        convoy.axes.give(self.number, self.machine.axis_alone, before=True)
        convoy.axes.take_sums(self.number)
        self.machine.ride = None
        if self._look():
            self.machine.ride, self.due_ns = self, self.machine.next_slow_ns
        else:
            self.end()

    def end(self) -> None:
        """Drive and axis as if they had gone alone; one that hasn't taken its AT is where it was before."""
        convoy = self.convoy
        if convoy is None:
            return
        self.convoy = self.machine.ride = self.slave.stand_in = None
        convoy.leave(self)
        self.at = None
