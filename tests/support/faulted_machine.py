"""The knowledge of a shipped rig for tests of faults: how it works, what is safe in it, and its documented way back."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import partial
from typing import ClassVar, Final, NamedTuple

from fault_choices import CONFIGS, Injected
from rig_hands import CanMaster

from fieldrig.clock import S
from fieldrig.config.rig_file import load
from fieldrig.device import Value
from fieldrig.virtual.rig import Rig


class Effect(Enum):
    """The effect of a fault on the work of a machine."""

    STOPS = "it is safe at once, and when the fault is over it waits for a person"
    WAITS = "it is safe as long as the fault lasts, and then goes on by itself, as its page says"
    GOES_ON = "its work goes on; only what its page names is missing"
    MAY_STOP = "it goes on, or it stops as above: which of them depends on the instant at which the fault begins"


class Sign(NamedTuple):
    """A point that says so while the fault is there; `{where}` is the device that has it."""

    device: str
    point: str
    value: Value

    def is_seen(self, machine: "Machine", where: str) -> bool:
        return machine.get(self.device.format(where=where), self.point) == self.value

    def __str__(self) -> str:
        return f"{self.device}/{self.point} = {self.value}"


class Expected(NamedTuple):
    """The expected effect of a fault, and the signs of it."""

    effect: Effect
    signs: tuple[Sign, ...] = ()


def stops(*signs: Sign) -> Expected:
    return Expected(Effect.STOPS, signs)


def waits(*signs: Sign) -> Expected:
    return Expected(Effect.WAITS, signs)


def goes_on(*signs: Sign) -> Expected:
    return Expected(Effect.GOES_ON, signs)


def may_stop(*signs: Sign) -> Expected:
    return Expected(Effect.MAY_STOP, signs)


Table = Mapping[str, Expected]
"""The expectations by the words of a fault: its kind, `what`, and choices of its keys, or the first of these words."""

CAN_STAYS_ASIDE: Final[Table] = {
    f"can {what}": goes_on()
    for what in (
        *("drop", "delay", "duplicate", "replace", "corrupt"),
        *("error_frame", "short", "wrong_bit_rate", "babble"),
    )
}
"""In a rig whose programs do not use the CAN bus, which is there for masters from outside."""


class Machine(ABC):
    """One shipped rig that works."""

    file: ClassVar[str]
    table: ClassVar[Table]
    wheres: ClassVar[Sequence[str] | None] = None
    """The buses and devices whose faults are tried in this rig, the others in their own; None is all."""
    overrides: ClassVar[Sequence[str]] = ()
    safe_within_s: ClassVar[float] = 3.0
    """Time after which it is safe, or has proven that it goes on."""
    can_nodes: ClassVar[Mapping[str, int]] = {}
    """A node on each CAN bus, which a master from outside reads."""
    felt: ClassVar[Mapping[str, Mapping[str, object]]] = {}
    """Values of the keys of a fault with which this machine feels it."""
    looks: ClassVar[int] = 5
    """How often it is looked at again while the fault lasts, and each time is 0.1 s later."""
    back_within_s: ClassVar[float] = 60.0
    """Time after which it has come back."""

    def __init__(self) -> None:
        self.rig = Rig(load(CONFIGS / self.file, (*self.overrides, "time=virtual")))
        self.masters = {bus: CanMaster(self.rig, bus, f"master_of_{bus}") for bus in self.can_nodes}
        self.begin()

    @abstractmethod
    def begin(self) -> None:
        """Bring the machine from its power-on to its work, as its page says."""

    @abstractmethod
    def works(self) -> bool:
        """Return whether it works; time may pass."""

    def is_whole(self) -> bool:
        """Return whether it works, and nothing is left of a fault that is over."""
        return self.works()

    def provoke(self) -> None:  # noqa: B027  most machines feel a fault wherever they are
        """Bring the machine to where it feels a fault, such as into the middle of a motion."""

    @abstractmethod
    def is_safe(self, where: str) -> bool:
        """Return whether it is safe at this instant, with a fault at `where`."""

    @abstractmethod
    def come_back(self, injected: Injected, effect: Effect) -> None:
        """Go the way that its page says after a fault that is over."""

    def wait_for_power(self) -> None:
        """Wait until each controller that has lost its power has started again; no hand has touched anything yet."""
        self.wait(3)

    # ---- helpers

    def get(self, device: str, point: str) -> Value:
        return self.rig.get(device, point)

    def set(self, device: str, point: str, value: Value) -> None:
        self.rig.set(device, point, value)

    def wait(self, seconds: float) -> None:
        self.rig.run_until(self.rig.now_ns + round(seconds * S))

    def until(self, is_so: Callable[[], object], seconds: float, step_s: float = 0.1, what: object = "it") -> None:
        end_ns = self.rig.now_ns + round(seconds * S)
        while not is_so():
            assert self.rig.now_ns < end_ns, f"{what} is not so within {seconds} s"
            self.wait(step_s)

    def press(self, device: str, point: str, seconds: float = 0.3) -> None:
        for level in (True, False):
            self.set(device, point, level)
            self.wait(seconds)


def expected_of(table: Table, injected: Injected) -> Expected | None:
    """Return the entry of a fault, the one with the most words first; None without one."""
    words = injected.words
    return next((table[key] for key in keys_of(words) if key in table), None)


def keys_of(words: Sequence[str]) -> list[str]:
    return [" ".join(words[:count]) for count in range(len(words), 1, -1)]


def try_fault(machine: Machine, injected: Injected, expected: Expected) -> None:
    """Inject a fault into a machine that works, see that it is safe, clear the fault, and bring it back."""
    where, _, fault = injected
    effect, signs = expected
    machine.provoke()
    number = machine.rig.add_fault(where, {**fault, **machine.felt.get(fault["what"], {})})
    if effect is Effect.MAY_STOP:
        machine.wait(0.6)
        effect = Effect.GOES_ON if machine.works() else Effect.STOPS
    if effect is Effect.GOES_ON:
        machine.wait(0.5)
        assert machine.works(), "it does not go on"
    else:
        machine.until(partial(machine.is_safe, where), machine.safe_within_s, what="safe")
        for _ in range(machine.looks):
            machine.wait(0.1)
            assert machine.is_safe(where), "it does not stay safe while the fault lasts"
    for sign in signs:
        machine.until(partial(sign.is_seen, machine, where), machine.safe_within_s, what=sign)
    machine.rig.clear_fault(where, number)
    assert not machine.rig.faults(where)
    if effect is Effect.STOPS:
        _stays_safe(machine, where)
    machine.come_back(injected, effect)
    assert machine.is_whole(), "it does not come back"
    if where in machine.masters:
        machine.wait(1)
        assert machine.masters[where].read(machine.can_nodes[where], 0x1000)


def _stays_safe(machine: Machine, where: str) -> None:
    for _ in range(20):
        machine.wait(0.1)
        assert machine.is_safe(where), "it starts by itself when the fault is over"
    machine.wait_for_power()
    assert machine.is_safe(where), "it starts by itself when everything has power again"
