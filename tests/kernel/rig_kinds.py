"""Small devices on wires, for the tests of the rig; a module of its own so that other processes can import it."""

from collections.abc import Mapping
from random import Random
from typing import Any, Literal

from fieldrig.clock import MS, NEVER_NS, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.errors import RigError
from fieldrig.faults.faults import Fault, Faults, Timed
from fieldrig.faults.injected import InjectedFaults
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig.storage.store import Store
from fieldrig_bus.wires import Signal


class DiceSettings(Settings):
    period_ms: int = 10


class Loaded(Timed):
    """A fault that makes every throw a six."""

    what: Literal["loaded"]


class Dice(Device):
    """Throws a number every period, and counts over a power cycle."""

    def __init__(
        self, clock: Clock, name: str, settings: DiceSettings, store: Store, random: Random, wires: Link[Signal]
    ) -> None:
        self._clock, self._name, self._settings, self._wires = clock, name, settings, wires
        self._store, self._random = store, random
        self._throws = int.from_bytes(store.load() or b"", "little")
        self._faults = self.injected = InjectedFaults[Fault[Loaded]](clock, {"loaded": Loaded}, Faults(Fault, random))

    def start(self) -> None:
        self._throw()

    def points(self) -> Mapping[str, Point]:
        return {"throws": Point(lambda: self._throws, self._set_throws, unit="1")}

    def answer(self, question: str, message: Any) -> Any:
        match question, message:
            case "rethrow", {"times": int(times)}:
                self._throws += times
                return {"throws": self._throws, "now_ns": self._clock.now_ns()}
            case "rethrow", _:
                raise ValueError("nothing to throw\nexpected a number of times")
        return super().answer(question, message)

    def _set_throws(self, value: Value) -> None:
        if not isinstance(value, int) or value < 0:
            raise ValueError("throws are counted from 0")
        self._throws = value
        self._wires.send(Signal(f"{self._name}.throws", value))

    def _throw(self) -> None:
        self._throws += 1
        self._store.save(self._throws.to_bytes(4, "little"))
        thrown = self._random.randint(1, 6)
        if self._faults.first(Loaded) is not None:
            thrown = 6
        self.thrown = thrown
        self._wires.send(Signal(f"{self._name}.thrown", thrown))
        self._clock.call_at(self._clock.now_ns() + self._settings.period_ms * MS, self._throw)


class Counted(Dice):
    """Dice that know when a number was thrown last, for searches of the past."""

    wanted = number = 0
    at_ns = NEVER_NS
    stop_at: int | None = None
    is_there = False

    def answer(self, question: str, message: Any) -> Any:
        match question, message:
            case "thrown", {"wanted": int(self.wanted)}:
                self.number, self.at_ns, self.stop_at, self.is_there = 0, NEVER_NS, message.get("stop_at"), False
                return {}
            case "thrown", _:
                return {"number": self.number, "at_ns": self.at_ns, "is_there": self.is_there}
        return super().answer(question, message)

    def _throw(self) -> None:
        super()._throw()
        if self.thrown == self.wanted:
            self.number, self.at_ns = self.number + 1, self._clock.now_ns()
            self.is_there |= self.number == self.stop_at


class Unbuildable(Device):
    """A device that refuses its settings."""

    def __init__(self, wires: Link[Signal]) -> None:
        raise RigError("there is no such thing", "expected another one")


class Adder(Device):
    """Adds up what is thrown anywhere, and says so at the same instant."""

    def __init__(self, wires: Link[Signal]) -> None:
        self._wires, self._sum = wires, 0
        wires.on_receive(self._on_signal, ["one.thrown", "two.thrown"])

    def _on_signal(self, signal: Signal) -> None:
        self._sum += int(signal.value)
        self._wires.send(Signal("adder.sum", self._sum))


class Squabbler(Device):
    """Answers every message of the other device at once, without end."""

    def __init__(self, name: str, wires: Link[Signal]) -> None:
        self._name, self._wires = name, wires
        wires.on_receive(self._on_signal)

    def start(self) -> None:
        self._wires.send(Signal(self._name, 0))

    def _on_signal(self, signal: Signal) -> None:
        self._wires.send(Signal(self._name, signal.value + 1))


class Brittle(Device):
    """A device with a fault in its code; a wire selects whether it appears at once or later."""

    def __init__(self, clock: Clock, wires: Link[Signal]) -> None:
        self._clock = clock
        wires.on_receive(self._on_signal, ["hammer", "fuse"])

    def _on_signal(self, signal: Signal) -> None:
        if signal.name == "hammer":
            self._break()
        self._clock.call_at(self._clock.now_ns() + 3 * MS, self._break)

    def _break(self) -> None:
        raise RuntimeError("it broke")


class Endless(Device):
    """Computes without end after 3 ms."""

    def __init__(self, clock: Clock, wires: Link[Signal]) -> None:
        self._clock = clock

    def start(self) -> None:
        self._clock.call_at(self._clock.now_ns() + 3 * MS, self._compute)

    def _compute(self) -> None:
        while True:
            pass


class Hasty(Endless):
    """Calls itself again after a nanosecond, without end."""

    def _compute(self) -> None:
        self._clock.call_at(self._clock.now_ns() + 1, self._compute)


class Ticker(Device):
    """Counts 20 times in a millisecond, and says so once in 10 ms."""

    PERIOD_NS = MS // 20
    EACH = 200

    def __init__(self, clock: Clock, wires: Link[Signal]) -> None:
        self._clock, self._wires, self._ticks = clock, wires, 0

    def start(self) -> None:
        self._tick()

    def points(self) -> Mapping[str, Point]:
        return {"ticks": Point(lambda: self._ticks)}

    def _tick(self) -> None:
        self._ticks += 1
        if self._ticks % self.EACH == 0:
            self._wires.send(Signal("ticker.ticks", self._ticks))
        self._clock.call_at(self._clock.now_ns() + self.PERIOD_NS, self._tick)
