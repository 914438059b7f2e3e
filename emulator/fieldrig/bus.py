"""What a bus is to the rig.

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
    from fieldrig.bus_questions import Subject
    from fieldrig.device import Tool

M = TypeVar("M")
Time = Literal["real", "virtual"]

MOST_WORDS = 16_384
"""Of one interest."""

NO_FAULTS = "this bus takes no faults\nkinds that do have a key `faults`: see `fieldrig devices KIND`"


class Delivery(NamedTuple, Generic[M]):
    """One message that reached its receivers at one instant.  Every delivery is a line of the trace."""

    time_ns: int
    sender: str
    message: M
    receivers: Sequence[str]
    """Members that were interested, in the order of joining; may be empty."""


class BusModel(ABC, Generic[M]):
    """The medium as a function of time.  Reads no clock; the same calls give the same deliveries.

    Instants given to `submit` may lie before ones given earlier (a member's process was late to tell), never
    before a delivery that was already collected; what would be earlier happens as soon as it can.
    """

    def begin(self, now_ns: int, random: Random) -> None:
        """Called once, before anything else, with the instant at which the rig starts and all the chance there is."""

    @abstractmethod
    def join(self, member: str) -> None:
        """A new end of the bus.  It hears nothing until it listens."""

    @abstractmethod
    def leave(self, member: str) -> None:
        """The member is gone, and what it had not yet sent with it."""

    @abstractmethod
    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        """From now on deliver what `interest` says (None: all) to the member."""

    @abstractmethod
    def submit(self, now_ns: int, member: str, message: M) -> None:
        """The member asked for `message` to be sent at `now_ns`."""

    @abstractmethod
    def next_ns(self) -> int | None:
        """The earliest instant at which something arrives; None while nothing is under way."""

    @abstractmethod
    def collect(self, now_ns: int) -> list[Delivery[M]]:
        """Everything that arrives at or before `now_ns` and was not collected yet, in order of time."""

    def statistics(self, now_ns: int) -> dict[str, float]:
        """Counters for `fieldrig status` as of `now_ns`, by name with unit."""
        return {}

    def add_fault(self, now_ns: int, fault: Mapping[str, Any]) -> int:
        """A fault from now on, in the words of the bus; its number.  Values may be texts, as people type them.

        ValueError: its first line is what is wrong, further ones are what would be right.
        """
        raise ValueError(NO_FAULTS)

    def clear_fault(self, now_ns: int, number: int) -> None:
        """ValueError if there is no such fault."""
        raise ValueError(NO_FAULTS)

    def all_faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        """What was added and not cleared, by number."""
        return {}


class Hub(Protocol):
    """What a port of a model bus sees of the hub that runs it (real time)."""

    @property
    def clock(self) -> Clock: ...

    def join(self, member: str) -> Link[Any]:
        """A new member in this process.  ValueError if the name is taken."""

    def leave(self, member: str) -> None: ...

    def path(self, name: str) -> Path:
        """A path in the rig's run folder, which is there."""


class Port(ABC):
    """A way for outsiders into a model bus: a TCP protocol, a pty, a real interface."""

    @abstractmethod
    async def open(self, hub: Hub) -> None:
        """Be reachable when this returns.  BusError, with its remedy, if the address can't be had."""

    @abstractmethod
    async def close(self) -> None:
        """Leave no socket, pty link or task behind."""


class Attachment(Protocol):
    """What a direct bus gets to make one device's end of itself (real time)."""

    @property
    def clock(self) -> Clock: ...

    @property
    def member(self) -> str: ...

    @property
    def process(self) -> str:
        """The process that this member lives in, for a bus that speaks once for all members of one."""

    @property
    def members(self) -> Mapping[str, str]:
        """Every device that is linked to this bus, in the order of the rig file, and the process it lives in."""

    @property
    def rig(self) -> str:
        """The rig's name, for whatever two rigs could mix up."""

    @property
    def seed(self) -> int:
        """The rig's seed, for what goes by chance."""

    def path(self, name: str) -> Path:
        """A path in the rig's run folder."""

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        """Call `handler(message)` as an event of its own, that happened at `instant_ns`; left out: now."""

    def heard(self, sender: str, message: Any) -> None:
        """Put a message into the trace.  Call it for what this member sends (each message is traced once)."""

    def session(self) -> Any:
        """This process's Zenoh session, open."""

    def serve(self, subject: "Subject") -> None:
        """From now on this process answers for the whole bus: what is asked for its status, and about its faults."""


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
    """Settings models of the faults that it takes while the rig runs, by their `what`."""
    times: ClassVar[frozenset[Time]]
    family: ClassVar[str]
    """What its messages are, for traces: can, modbus, serial, wires, ring."""
    environment: ClassVar[Mapping[str, str]] = {}
    """What a process with an end of it has in its environment, before it does anything else, unless the user set it."""
    has_threads: ClassVar[bool] = False
    """True if its ends start threads of the event loop; a process with such an end runs a `ThreadedLoop`."""
    messages: ClassVar[tuple[type, ...]]
    """The types its links carry; `fieldrig check` compares them with what a device's parameter asks for."""

    def __init__(self, name: str, settings: Any) -> None:
        self.name = name
        self.settings = settings

    @property
    def realtime(self) -> bool:
        """True if each process with an end of this bus asks the system for real-time scheduling."""
        return isinstance(self.settings, RealtimeOption) and self.settings.realtime

    @abstractmethod
    def encode(self, message: M) -> bytes:
        """The message as bytes, for other processes and traces."""

    @abstractmethod
    def decode(self, data: bytes) -> M:
        """The inverse of `encode`.  ValueError for anything else."""

    @abstractmethod
    def show(self, message: M) -> str:
        """The message as one short line for a person."""

    def check(self, message: Any) -> None:
        """Called with everything that a member sends: what can't be on the medium must not get there.

        TypeError for what is no message, or has a field of another type; ValueError for a value that can't be.
        """
        if not isinstance(message, self.messages):
            names = ", ".join(kind.__name__ for kind in self.messages)
            raise TypeError(f"expected a message of {names}, found {type(message).__name__}")

    def check_interest(self, interest: Any) -> None:
        """Called with every interest, also one that a process elsewhere sent as JSON.

        ValueError, or TypeError, for one that is not in the words of this bus; here: None, or a sequence of texts and
        integers.
        """
        for word in words_of(interest):
            if type(word) not in (str, int):
                raise ValueError(f"expected a text or an integer, found {word!r}")

    def tools(self, run: Path) -> "list[Tool]":
        """Lines to copy that reach this bus with foreign tools; `run` is the rig's run folder."""
        return []


def words_of(interest: Any) -> Sequence[Any]:
    """The words of an interest; none of None.  TypeError for what is no sequence, ValueError for one without end."""
    if interest is None:
        return ()
    if not isinstance(interest, Sequence) or isinstance(interest, str | bytes | bytearray):
        raise TypeError(f"expected None or a list, found {type(interest).__name__}")
    if len(interest) > MOST_WORDS:
        raise ValueError(f"{len(interest)} words, expected at most {MOST_WORDS}")
    return interest


class ModelBus(Bus[M]):
    """A bus whose medium is our model."""

    @abstractmethod
    def model(self) -> BusModel[M]:
        """A fresh model, with nothing under way."""

    def ports(self) -> Sequence[Port]:
        """The ways in for outsiders that the settings ask for (real time only)."""
        return ()

    own_process: ClassVar[bool] = False
    """True if its hub needs a process of its own, even where all of its devices share one."""

    standing_of: Callable[[M], Hashable] | None = None
    """On a bus where messages hold until the next of their sort (all on wires): of what sort one is; None: of none.

    A member whose hub was gone says what holds of its messages again, for the new hub knows nothing.
    """

    @property
    def awake_ns(self) -> int:
        """How long the hub looks for the next message before it sleeps.  It costs a core while there is traffic."""
        return 0

    @property
    def attach(self) -> str | None:
        """`tcp://host:port` where the hub also listens for device processes; None: the Unix socket is enough."""
        return self.settings.attach if isinstance(self.settings, Attachable) else None

    @property
    def connect(self) -> str | None:
        """The hub's `tcp://host:port` as device processes see it; None: the Unix socket, or else `attach`."""
        return self.settings.connect if isinstance(self.settings, Attachable) else None


class DirectBus(Bus[M]):
    """A bus whose medium is there without us."""

    @abstractmethod
    async def open(self, at: Attachment) -> Link[M]:
        """One device's end.  BusError, with its remedy, if the medium can't be had."""

    @abstractmethod
    async def close(self, member: str) -> None: ...
