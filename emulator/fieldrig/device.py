"""The interface of a device to the rig.

A device is built with its clock and links, then only reacts: no socket, thread, sleep, loop, `time` or `random`
of its own.  The rig builds it by the names of its constructor's parameters:

    clock: Clock              always there
    name: str                 its name in the rig file
    settings: MySettings      a `Settings` model of the keys its `kind` has in the rig file
    store: Store              its non-volatile memory
    random: Random            seeded from the rig's seed and the device's name
    background: Background    for work that takes longer than a reaction may

Every other parameter is a link, `can: Link[CanFrame]`, and is named under `links:` in the rig file; with the
default None it may be left out, as `list[Link[M]]` it takes one bus or several.  A device asks for what it uses.
"""

import shlex
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from fieldrig.bus import Bus
from fieldrig.front import Front
from fieldrig.text.nearest import closest

if TYPE_CHECKING:
    from fieldrig.faults.injected import InjectedFaults

Value = bool | int | float | str
"""The value of a point."""

POWER_OFF = "power_off"
"""The fault that every device can have: it has no power."""
FAULTS_KEY = "faults"
"""The key of a rig file with the faults that a device has from the start."""

NO_FAULTS = "this device takes no faults\n`fieldrig devices KIND` shows the faults of a kind"


@dataclass(frozen=True, slots=True)
class Point:
    """A value of a device that users and programs may read, and write if `write` is given.

    `read` returns the value at the clock's present instant and changes nothing, so a rig that is read gives the same
    trace.  `write` raises ValueError, saying what was expected, for a value that it refuses.
    """

    read: Callable[[], Value]
    write: Callable[[Value], None] | None = None
    unit: str = ""
    about: str = ""
    states: Sequence[str] = ()
    """All texts that the point can have, if it is a state with a name; empty for other points."""
    type: str = ""
    """Its data type in the words of the device, such as UNSIGNED16; empty if the value says it all."""
    low: float | None = None
    """The smallest value that a write takes; None if there is no limit, or if it is not known."""
    high: float | None = None


RUN = "{run}"


class WayIn(NamedTuple):
    """A way into a bus from outside the rig."""

    protocol: str
    """The protocol that a client speaks there, such as `Modbus TCP`; a few words."""
    address: str
    """The place where it connects: host:port, a URL, a path or a network device."""


class Tool(NamedTuple):
    """A line to copy that reaches a device or a bus with a foreign tool.  `RUN` in it is replaced by the run folder."""

    label: str
    line: str


def python_line(code: str) -> str:
    """Return a shell line that runs `code`, with double quotes where they are enough."""
    return f"python -c {shlex.quote(code)}" if set(code) & set('"$`\\!') else f'python -c "{code}"'


class Device:
    """Base of all devices.  A subclass connects its handlers in `__init__` and acts from `start` on."""

    about: ClassVar[str] = ""
    """One line for `fieldrig devices`."""
    kind: str = ""
    """The kind that the rig file gives it.  The rig sets it when it builds the device."""
    fault_models: ClassVar[Mapping[str, type[Any]]] = {}
    """Settings models of the faults that it takes while the rig runs, by their `what`, beside the loss of power."""
    no_faults: ClassVar[str] = ""
    """Why nothing but its power can fail, for a kind without further faults."""
    trouble_keys: ClassVar[Collection[str]] = ()
    """Keys of points by which the device itself reports that something is wrong; 0, False and "" are no trouble."""
    diagnosis_keys: ClassVar[Collection[str]] = ()
    """Further keys of points that show or list numbers or names of diagnoses; a * matches any characters."""
    log_keys: ClassVar[Collection[str]] = ()
    """Keys of points that have a message in each line, such as a message logger; the page shows them."""
    has_cycle: ClassVar[bool] = False
    """True if the device works in cycles, and calls `end_of_cycle` in each of them."""
    end_of_cycle: Callable[[], None] | None = None
    """Set while the device is recorded.  A device with a cycle calls it last in each of its cycles, at the instant of
    the cycle; it reads points, and changes nothing."""
    injected: "InjectedFaults[Any] | None" = None
    """The faults of this device.  A device with `fault_models` sets it in its constructor."""
    look: Callable[[], None] | None = None
    """Set while points of the device are watched.  A device whose points change several times in one reaction, such as
    one that runs a program, calls it after each change; it reads points, and changes nothing."""

    def start(self) -> None:
        """Power on.  Called once, when every link is up."""

    def stop(self) -> None:
        """End in order with the rig.  A killed process never gets here, so nothing may depend on it."""

    def points(self) -> Mapping[str, Point]:
        """Return the points for `fieldrig get`, `set` and `watch`, by key."""
        return {}

    def front(self) -> Front:
        """Return what a person sees and operates in front of the device.

        By default it is made from the points.  A front names points and never values, and stays as it is.
        """
        return Front.of_points(self.points())

    def front_words(self) -> dict[str, Any]:
        """Return the front in values that JSON has, with the kind of the device and the units of its points."""
        return self.front().words(self.kind, self.about, self.points())

    def further_point(self, key: str) -> Point | None:
        """Return a point that `points` does not list, such as `program:Main.count`; None if there is none of this key.

        Recordings find them by their keys, as a program may have more variables than anyone wants to list.
        """
        return None

    def troubles(self) -> Mapping[str, Value]:
        """Return what the device itself reports as wrong now, by the key of the point that shows it.

        A late host may be the cause, so the process says beside such a value how late the host was (`troubles`).  The
        process asks twice a second.  A value of 0, False or "" is no trouble.
        """
        if not self.trouble_keys:
            return {}
        points = self.points()
        return {key: points[key].read() for key in self.trouble_keys if key in points}

    def limits_reached(self) -> Mapping[str, float]:
        """Return how often clients that the device itself serves, such as callers by modem, reached each limit.

        `fieldrig status` shows them (`outside.limits.Reached`).  The ports of buses count their clients themselves.
        """
        return {}

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        """Add a fault that begins now, in the words of the device, and return its number.

        Values may be texts, as people type them.  ValueError: its first line says what is wrong, further lines say
        what was expected.
        """
        what = fault.get("what")
        if isinstance(what, str) and (self.injected is None or (self.fault_models and what not in self.fault_models)):
            raise ValueError(f"there is no fault {what!r}\n{closest(what, [*self.fault_models, POWER_OFF])}")
        if self.injected is None:
            raise ValueError(NO_FAULTS)
        return self.injected.add_fault(fault)

    def clear_fault(self, number: int) -> None:
        """Remove a fault.  ValueError if there is none with this number."""
        if self.injected is None:
            raise ValueError(NO_FAULTS)
        self.injected.clear_fault(number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults that were added and not cleared, by number."""
        return {} if self.injected is None else self.injected.faults()

    def answer(self, question: str, message: Any) -> Any:
        """Answer a question that only this kind of device understands, such as `debug`, in values that JSON has.

        `message` comes from outside.  ValueError: its first line says what is wrong, further lines what was expected.
        """
        raise ValueError(f"this device cannot answer {question}\nother kinds do, such as those with a program")

    @classmethod
    def tools(cls, name: str, settings: Any, links: Mapping[str, Bus[Any]]) -> list[Tool]:
        """Return lines that reach this device from outside; `links` holds its buses by the names of its parameters."""
        return []
