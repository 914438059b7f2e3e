"""Does the actions of a scenario, in virtual time and in real time alike."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, Protocol

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig_devices.scenarios.act import Act, RefusedActError


class Operated(Protocol):
    """A rig in either time."""

    def add_fault(self, where: str, fault: Mapping[str, Any]) -> int: ...

    def clear_fault(self, where: str, number: int) -> None: ...

    def faults(self, where: str) -> Mapping[int, Mapping[str, Any]]: ...

    def restart(self, name: str, /) -> None: ...


class Held(NamedTuple):
    """A place that `press` has written."""

    end_ns: int
    """The instant at which the last `press` of it ends."""
    before: Value
    """The value before the first of them."""


class Hands:
    """Does actions, and knows whether a fault is left."""

    def __init__(
        self,
        rig: Operated,
        read: Callable[[str], Value],
        write: Callable[[str, Value], None],
        send: Callable[[str, str], None],
        has_power: Callable[[str], bool],
    ) -> None:
        """`read` and `write` take places, `send` a bus with the text of a message, `has_power` a bus or device."""
        self._rig, self._read, self._write, self._send, self._has_power = rig, read, write, send, has_power
        self._faulty: dict[str, None] = {}
        """The buses and devices that have been given faults."""
        self._held: dict[str, Held] = {}
        """The places of `press`: one that comes while another one holds does not leave the key pressed forever."""

    def do(self, act: Act) -> Act | None:
        """Do an action, and return the one that ends it, if there is one.  RefusedActError if the rig refuses it.

        A key of a device without power does nothing.
        """
        try:
            return self._do(act)
        except ControlError as wrong:
            raise RefusedActError(wrong.what, wrong.remedy, act) from wrong

    def _do(self, act: Act) -> Act | None:
        rig = self._rig
        if act.verb in ("set", "press", "restart") and not self._has_power(act.where.partition("/")[0]):
            return None
        match act.verb:
            case "set":
                self._write(act.where, _value(act))
            case "press":
                held = self._held.get(act.where)
                is_held = held is not None and act.at_ns < held.end_ns  # else its end has been written
                before = held.before if held is not None and is_held else self._read(act.where)
                self._held[act.where] = Held(max(act.end_ns, held.end_ns) if held is not None else act.end_ns, before)
                self._write(act.where, _value(act))
                return Act(act.end_ns, "set", act.where, before)
            case "fault":
                assert isinstance(act.value, Mapping)
                rig.add_fault(act.where, act.value)
                self._faulty[act.where] = None
            case "clear":
                for number in list(rig.faults(act.where)):
                    rig.clear_fault(act.where, number)
            case "restart":
                rig.restart(act.where)
            case "send":
                self._send(act.where, str(act.value))
        return None

    def has_faults(self) -> bool:
        """True if a fault of an action acts, or may still begin."""
        return any(True for _ in self._active())

    def faults_end(self) -> bool:
        """True if there are faults, all of which end by themselves."""
        active = list(self._active())
        return bool(active) and all("duration_ms" in one and one.get("state") == "on" for one in active)

    def _active(self) -> Iterator[Mapping[str, Any]]:
        found = (fault for where in self._faulty for fault in self._rig.faults(where).values())
        return (fault for fault in found if fault.get("state") != "over")


def _value(act: Act) -> Value:
    assert isinstance(act.value, bool | int | float | str)
    return act.value
