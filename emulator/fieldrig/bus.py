"""The interface of a bus to the rig.

Two sorts.  A **model bus** is a passive model of the medium: messages go in with their instants, deliveries come out
with theirs.  Under virtual time the rig runs the model; under real time a hub does, in a process that the devices
attach to, and there outsiders come in by the bus's ports.  A **direct bus** is a medium that exists outside
(SocketCAN, UDP, Zenoh); each device's process has its own end of it, under real time only.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, NamedTuple, Protocol, TypeVar, runtime_checkable

from fieldrig.clock import Clock
from fieldrig.link import Link

if TYPE_CHECKING:
    from fieldrig.control.subject import WaitingSubject
    from fieldrig.device import Tool, WayIn
    from fieldrig.loop.pace import Pace

M = TypeVar("M")
Time = Literal["real", "virtual"]

MOST_WORDS = 16_384
"""Longest interest, in words."""

NO_FAULTS = "this bus takes no faults\nkinds that do have a key `faults`: see `fieldrig devices KIND`"


class Delivery(NamedTuple, Generic[M]):
    """One message that reached its receivers at one instant.  Every delivery is a line of the trace."""

    time_ns: int
    sender: str
    message: M
    receivers: Sequence[str]
    """The members whose interest matched, in the order of joining.  It may be empty."""


class Reading(NamedTuple):
    """The value of a signal that a message carries, such as that of a wire."""

    name: str
    value: bool | int | float | str
    unit: str


class Refusal(NamedTuple):
    """New connections of outside clients are refused from now on, or no longer."""

    is_on: bool
    service: str | None = None
    """The only service that it concerns; None for all."""


class CutOff(NamedTuple):
    """The connections of outside clients are closed now."""


Doors = Refusal | CutOff
"""The effect of a fault on the ports of a bus, which the model cannot have itself."""


class BusModel(ABC, Generic[M]):
    """The medium as a function of time.  It reads no clock, and the same calls give the same deliveries.

    Instants given to `submit` may be earlier than those given before, because a member's process may be late, but never
    earlier than a delivery that was already collected.  A message that would be due before that is sent as soon as
    possible.
    """

    def begin(self, now_ns: int, random: Random) -> None:
        """Begin at `now_ns`, before any other call.  `random` is the model's only source of chance."""

    @abstractmethod
    def join(self, member: str) -> None:
        """Add a member.  It receives nothing until it listens."""

    @abstractmethod
    def leave(self, member: str) -> None:
        """Remove a member, with its messages that are not yet sent."""

    def power_lost(self, now_ns: int, member: str) -> None:
        """Remove a member whose device has lost its power.  It joins again when power is back."""
        self.leave(member)

    @abstractmethod
    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """Deliver the messages that match `interest` to the member from now on; None matches all."""

    @abstractmethod
    def submit(self, now_ns: int, member: str, message: M) -> None:
        """Queue `message`, which the member asked to send at `now_ns`."""

    @abstractmethod
    def next_ns(self) -> int | None:
        """Return the instant of the next arrival, or None while nothing is being sent."""

    @abstractmethod
    def collect(self, now_ns: int) -> list[Delivery[M]]:
        """Return every delivery up to and including `now_ns` that was not collected yet, in order of time."""

    def waiting(self, member: str) -> int:
        """Return how many messages of a member wait to be sent; 0 on a medium where none has to wait."""
        return 0

    def statistics(self, now_ns: int) -> dict[str, float]:
        """Return the counters for `fieldrig status` as of `now_ns`, by name with unit."""
        return {}

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        """Add a fault from now on, and return its number.  Values may be texts, as users type them.

        ValueError: its first line says what is wrong, further lines say what was expected.
        """
        raise ValueError(NO_FAULTS)

    def begin_fault(self, now_ns: int, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""
        raise ValueError(NO_FAULTS)

    def clear_fault(self, now_ns: int, number: int) -> None:
        """Remove a fault.  ValueError if there is none of this number."""
        raise ValueError(NO_FAULTS)

    def all_faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults that were added and not cleared, by number."""
        return {}

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        """Return the states that are reported to a person, such as an open ring: a text for each, by name."""
        return {}

    def standing(self) -> Mapping[str, M]:
        """Return the messages that stand until the next one of the same signal, as those on wires do, by its name."""
        return {}

    def on_doors(self, call: Callable[[Doors], None]) -> None:
        """Call `call` with the effects of faults on the ports, beginning with those that are on."""


class Hub(Protocol):
    """A hub as the ports of its model bus see it, in real time."""

    @property
    def clock(self) -> Clock: ...

    def join(self, member: str) -> Link[Any]:
        """Add a member in this process.  ValueError if the name is taken."""

    def leave(self, member: str) -> None: ...

    @property
    def pace(self) -> "Pace | None":
        """The pace at which this process reads what outsiders send; None without one."""

    def waiting(self, member: str) -> int:
        """Return how many messages of a member wait on the medium, so that its client may have to wait too."""

    def on_doors(self, call: Callable[[Doors], None]) -> None:
        """Call `call` with the effects of faults on the ports of this bus, as events of their own."""

    def path(self, name: str) -> Path:
        """Return a path in the rig's run folder, and make its folder."""


@runtime_checkable
class TerminalHub(Protocol):
    """A hub that has serial ports of its own for programs, as in virtual time, instead of ptys of the system."""

    def terminal(self, name: str) -> Any:
        """Return the serial port at a path in the rig's run folder."""


@runtime_checkable
class ProgramBus(Protocol):
    """A serial line that programs in virtual time open by its name."""

    def program_port(self, url: str) -> "Port":
        """Return the port of a program that opens this URL."""


class Port(ABC):
    """An access for outside clients to a model bus: a TCP protocol, a pty, or a physical interface."""

    @abstractmethod
    async def open(self, hub: Hub) -> None:
        """Open the port; it is reachable when this returns.

        BusError, with its remedy, if the address is not available.
        """

    @abstractmethod
    async def close(self) -> None:
        """Close the port, and leave no socket, pty link or task behind."""

    def hold(self, is_held: bool) -> None:  # noqa: B027  a port without clients that can be stopped does nothing
        """Read nothing from outside, or go on: the devices of the bus have more to read than they manage."""

    def statistics(self) -> dict[str, float]:
        """Return how often each limit of the port was reached, by name."""
        return {}


class Attachment(Protocol):
    """The surroundings of one device's end of a direct bus, in real time."""

    @property
    def clock(self) -> Clock: ...

    @property
    def member(self) -> str: ...

    @property
    def process(self) -> str:
        """The process of this member, for a bus with one connection for all members of a process."""

    @property
    def members(self) -> Mapping[str, str]:
        """Every device that is linked to this bus, with its process, in the order of the rig file."""

    @property
    def rig(self) -> str:
        """The rig's name, to keep the traffic of two rigs apart."""

    @property
    def seed(self) -> int:
        """The rig's seed, for everything that depends on chance."""

    def path(self, name: str) -> Path:
        """Return a path in the rig's run folder."""

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        """Call `handler(message)` as an event of its own that happened at `instant_ns`; None is now."""

    def heard(self, sender: str, message: Any) -> None:
        """Add a message to the trace.  Call it for messages that this member sends, so that each is traced once."""

    def note_late(self, late_ns: int) -> None:
        """Note that the host made another process of the bus late by this time, for the log of this process."""

    def session(self) -> Any:
        """Return the open Zenoh session of this process."""

    def serve(self, subject: "WaitingSubject") -> None:
        """Answer for the whole bus from now on, when its status or its faults are asked for."""


@runtime_checkable
class Attachable(Protocol):
    """Settings of a model bus whose hub can be reached by TCP."""

    @property
    def attach(self) -> str | None:
        """`tcp://host:port` where the hub listens for device processes."""

    @property
    def connect(self) -> str | None:
        """`tcp://host:port` of the hub, as device processes see it."""


@runtime_checkable
class RealtimeOption(Protocol):
    """Settings of a bus with a key `realtime`."""

    @property
    def realtime(self) -> bool:
        """True to ask the system for real-time scheduling of each process with an end of the bus."""


class Bus(ABC, Generic[M]):
    """One bus of a rig, made from its name and settings.  Making it opens nothing."""

    about: ClassVar[str] = ""
    """One line for `fieldrig devices`."""
    fault_models: ClassVar[Mapping[str, type[Any]]] = {}
    """The settings models of the faults that can be added while the rig runs, by their `what`."""
    no_faults: ClassVar[str] = ""
    """Why there is nothing that can fail, for a kind without faults."""
    times: ClassVar[frozenset[Time]]
    notes_faults: ClassVar[bool] = False
    """True if its trace can have the faults of its members: `encode`, `decode` and `show` know `faults.note`."""
    virtual_kind: ClassVar[str | None] = None
    """The kind that models this medium with `time: virtual`, where this kind has no model; it takes the same keys."""
    family: ClassVar[str]
    """The kind of its messages in traces: can, modbus, serial, wires, ring."""
    environment: ClassVar[Mapping[str, str]] = {}
    """Environment variables of each process with an end of this bus; those that the user has set take precedence."""
    has_cycle: ClassVar[bool] = False
    """True if an end of it has a cycle to keep: outsiders get only a share of the time of its process (`pace`)."""
    serves_outsiders: ClassVar[bool] = False
    """True if its messages are requests of clients outside the rig: a device reads them at the pace of its process."""
    has_threads: ClassVar[bool] = False
    """True if its ends start threads of the event loop; a process with such an end runs a `ThreadedLoop`."""
    exchange_ns: ClassVar[int] = 0
    """Processor time that each process with an end of it takes in every cycle of its master; 0 without cycles."""
    messages: ClassVar[tuple[type, ...]]
    """The types of message that its links carry; `fieldrig check` compares them with a device's parameters."""

    def __init__(self, name: str, settings: Any) -> None:
        self.name = name
        self.settings = settings

    @property
    def realtime(self) -> bool:
        """True if each process with an end of this bus asks the system for real-time scheduling."""
        return isinstance(self.settings, RealtimeOption) and self.settings.realtime

    @abstractmethod
    def encode(self, message: M) -> bytes:
        """Return the message as bytes, for other processes and traces."""

    @abstractmethod
    def decode(self, data: bytes) -> M:
        """Return the message of `encode`'s bytes.  ValueError for anything else."""

    @abstractmethod
    def show(self, message: M) -> str:
        """Return the message as one short line for a user."""

    def reading(self, message: Any, now_ns: int) -> Reading | None:
        """Return the value of the signal that a message carries at `now_ns`; None for a message that carries none."""
        return None

    def signals(self, standing: Mapping[str, Any], now_ns: int) -> dict[str, dict[str, Any]]:
        """Return the unit and the present value of the signals that these standing messages carry, by name."""
        readings = (self.reading(message, now_ns) for message in standing.values())
        return {found.name: {"unit": found.unit, "value": found.value} for found in readings if found is not None}

    def check(self, message: Any) -> None:
        """Check a message before a member sends it.

        TypeError for another type, or a field of another type; ValueError for a value that the medium cannot carry.
        """
        if not isinstance(message, self.messages):
            names = ", ".join(kind.__name__ for kind in self.messages)
            raise TypeError(f"expected a message of {names}, found {type(message).__name__}")

    def check_interest(self, interest: Any) -> None:
        """Check an interest, which may come from another process as JSON.

        ValueError or TypeError for anything but an interest of this bus; by default None, or a sequence of texts and
        integers.
        """
        for word in words_of(interest):
            if type(word) not in (str, int):
                raise ValueError(f"expected a text or an integer, found {word!r}")

    def ways_in(self, run: Path) -> "list[WayIn]":
        """Return the ways into this bus from outside, one for each port or device file; `run` is the run folder."""
        return []

    def tools(self, run: Path) -> "list[Tool]":
        """Return lines to copy that reach this bus with foreign tools; `run` is the rig's run folder."""
        return []


def words_of(interest: Any) -> Sequence[Any]:
    """Return the words of an interest, none for None.

    TypeError for anything but a sequence, ValueError for a very long one.
    """
    if interest is None:
        return ()
    if not isinstance(interest, Sequence) or isinstance(interest, str | bytes | bytearray):
        raise TypeError(f"expected None or a list, found {type(interest).__name__}")
    if len(interest) > MOST_WORDS:
        raise ValueError(f"{len(interest)} words, expected at most {MOST_WORDS}")
    return interest


class ModelBus(Bus[M]):
    """A bus whose medium is a model."""

    @abstractmethod
    def model(self) -> BusModel[M]:
        """Return a new model without traffic."""

    def effects(self) -> Any:
        """Return the `faults.disturbed.Effects` of the faults on messages of this bus.

        None if its model has its own faults, or none.
        """
        return None

    def ports(self) -> Sequence[Port]:
        """Return the ports for outside clients that the settings ask for.  Real time only."""
        return ()

    own_process: ClassVar[bool] = False
    """True if its hub needs a process of its own, even where all of its devices share one."""

    standing_of: Callable[[M], Hashable] | None = None
    """Returns the subject of a message whose value stands until the next message on it, as all do on wires; or None.

    When a hub is lost and comes back, a member repeats its standing messages, as the new hub does not know them.
    """

    @property
    def awake_ns(self) -> int:
        """How long the hub polls for the next message before it sleeps, in nanoseconds.

        Polling takes a core under traffic.
        """
        return 0

    @property
    def attach(self) -> str | None:
        """The `tcp://host:port` where the hub also listens for device processes; None if its Unix socket is enough."""
        return self.settings.attach if isinstance(self.settings, Attachable) else None

    @property
    def connect(self) -> str | None:
        """The hub's `tcp://host:port` as device processes see it; None for the Unix socket, or else `attach`."""
        return self.settings.connect if isinstance(self.settings, Attachable) else None


class DirectBus(Bus[M]):
    """A bus whose medium exists outside the rig."""

    @abstractmethod
    async def open(self, at: Attachment) -> Link[M]:
        """Open one device's end.  BusError, with its remedy, if the medium is not available."""

    @abstractmethod
    async def close(self, member: str) -> None: ...
