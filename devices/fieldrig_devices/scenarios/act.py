"""Actions on a rig from outside: one form for scenarios, for the schedules of a search, and for what it finds."""

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.faults.words import words_of_fault

Verb = Literal["set", "press", "fault", "clear", "restart", "send"]


class Act(NamedTuple):
    """One action."""

    at_ns: int
    """The instant from the begin of the scenario, in nanoseconds; with `when`, from the instant that it names."""
    verb: Verb
    """`press` is a value for a time, and then the one before; `clear` ends all faults of a bus or a device."""
    where: str
    """A place, such as `panel/start`; a bus for `send`; a bus or a device for `fault`, `clear` and `restart`."""
    value: Value | Mapping[str, Any] | None = None
    """The value of a place, the text of a message, or a fault in its one form."""
    hold_ns: int = 0
    """The duration of `press`."""
    when: str = ""
    """The milestone after which it comes: a condition, as of faults; empty for one that comes at an instant."""
    nth: int = 1
    """The number of times that the condition has become true then."""

    @property
    def end_ns(self) -> int:
        """The instant at which it is over; a fault may last longer."""
        return self.at_ns + self.hold_ns

    @property
    def milestone(self) -> str:
        """The milestone in words; empty without one."""
        return f"{self.when}, time {self.nth}" if self.when and self.nth > 1 else self.when

    def __hash__(self) -> int:
        """Search keeps schedules as keys; a fault is a mapping, which has no hash of its own."""
        return hash((self.at_ns, self.verb, self.where))

    def __str__(self) -> str:
        match self.verb:
            case "set":
                return f"{self.where} = {_shown(self.value)}"
            case "press":
                return f"{self.where} = {_shown(self.value)} for {self.hold_ns / 1e6:g} ms"
            case "fault":
                assert isinstance(self.value, Mapping)
                return f"fault {self.where} {words_of_fault(self.value)}"
            case "send":
                return f"send {self.where} {self.value}"
        return f"{self.verb} {self.where}"


class RefusedActError(ControlError):
    """A rig refuses an action, such as a value that the device does not take."""

    def __init__(self, what: str, remedy: str, act: Act) -> None:
        super().__init__(what, remedy)
        self.act = act

    def __reduce__(self) -> tuple[type["RefusedActError"], tuple[str, str, Act]]:
        """Cross the pipe of a branch with the action."""
        return type(self), (self.what, self.remedy, self.act)


Schedule = tuple[Act, ...]
"""Actions in the order of their instants."""


def _shown(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
