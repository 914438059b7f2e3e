"""Wires: named signals with units between devices and plants.

A wire has one driver and any number of listeners; it keeps its value, so whoever listens later hears the present one.
A signal arrives at the instant at which it was driven.  A device's interest is the names it listens to.  What moves
steadily, an encoder or a train of pulses, is told as a `Motion`, when its course changes, and not edge by edge.
"""

import json
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, ClassVar, Final

from fieldrig.bus import BusModel, Delivery, ModelBus, Time
from fieldrig.clock import S
from fieldrig.settings import Settings
from fieldrig.values import show_number
from fieldrig_bus.net import HubSettings

log = logging.getLogger(__name__)

_LATEST_NS = (1 << 63) - 1
MOST_OF_A_MEMBER: Final = 4_096
MOST_WIRES: Final = 65_536
LONGEST_NAME: Final = 1_000
"""Characters."""


@dataclass(frozen=True, slots=True)
class Signal:
    """The present value of one wire: digital as bool, analog as a number in `unit` (SI or %, "" for a digital one)."""

    name: str
    value: bool | int | float
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Motion(Signal):
    """A signal that moves on by itself until the next one is told: `value` is where it was at `time_ns`.

    Who knows nothing of motions takes it for a signal with that value.
    """

    time_ns: int = 0
    speed: float = 0.0
    """Units per second, at `time_ns`."""
    acceleration: float = 0.0
    """Units per second squared."""

    def at(self, now_ns: int) -> float:
        seconds = (now_ns - self.time_ns) / S
        return self.value + (self.speed + self.acceleration / 2 * seconds) * seconds

    def speed_at(self, now_ns: int) -> float:
        return self.speed + self.acceleration * (now_ns - self.time_ns) / S


def encode(signal: Signal) -> bytes:
    fields = [signal.name, signal.value, signal.unit]
    if isinstance(signal, Motion):
        fields += [signal.time_ns, signal.speed, signal.acceleration]
    return json.dumps(fields, separators=(",", ":"), allow_nan=False).encode()


def decode(data: bytes) -> Signal:
    """ValueError for anything that `encode` doesn't write."""
    try:
        signal = _read(json.loads(data))
    except (OverflowError, RecursionError):  # an integer beyond all floats, brackets without end
        signal = None
    if signal is None:
        raise ValueError(f"not a signal: {data[:80]!r}")
    return signal


def _read(fields: Any) -> Signal | None:
    match fields:
        case [str(name), bool() | int() | float() as value, str(unit)] if isfinite(value):
            return Signal(name, value, unit)
        case [str(name), int() | float() as value, str(unit), int(time_ns), int() | float() as speed, course] if (
            isinstance(course, int | float)
            and all(map(isfinite, (value, speed, course)))
            and abs(time_ns) <= _LATEST_NS
        ):
            return Motion(name, value, unit, time_ns, speed, course)
    return None


def show(signal: Signal) -> str:
    """With all digits that the value has."""
    course = f", {show_number(signal.speed)} {signal.unit}/s" if isinstance(signal, Motion) else ""
    return f"{signal.name} = {show_number(signal.value)} {signal.unit}".rstrip() + course


class WiresModel(BusModel[Signal]):
    """Keeps the value of each wire, but not of more than there can be: what is beyond is dropped, and told once.

    A member may drive `MOST_OF_A_MEMBER` wires.  Where there are `MOST_WIRES`, a new one takes the place of the oldest
    wire whose driver is gone.
    """

    def __init__(self) -> None:
        self._interests: dict[str, frozenset[str] | None] = {}  # None: every name
        self._present: dict[str, tuple[str, Signal]] = {}  # name: driver and value
        self._driven: dict[str, dict[str, None]] = {}  # the names of a driver that is there, in the order of coming
        self._orphans: dict[str, None] = {}  # the names of drivers that are gone, the same
        self._told_full: set[str] = set()
        self._due: list[Delivery[Signal]] = []

    def join(self, member: str) -> None:
        self._interests[member] = frozenset()

    def leave(self, member: str) -> None:
        self._interests.pop(member, None)
        self._told_full.discard(member)
        self._orphans |= self._driven.pop(member, {})

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        names = None if interest is None else frozenset(map(str, interest))
        self._interests[member] = names
        for name, (driver, signal) in self._present.items():
            if driver != member and (names is None or name in names):
                self._due.append(Delivery(now_ns, driver, signal, (member,)))

    def submit(self, now_ns: int, member: str, message: Signal) -> None:
        driven = self._driven.get(member)
        if (driven is None or message.name not in driven) and not self._is_taken_on(message.name, member):
            return
        self._present[message.name] = (member, message)
        receivers = [
            name
            for name, names in self._interests.items()
            if name != member and (names is None or message.name in names)
        ]
        self._due.append(Delivery(now_ns, member, message, receivers))

    def _is_taken_on(self, name: str, member: str) -> bool:
        """Whether there is room for this wire among those of its new driver."""
        driven, present = self._driven.setdefault(member, {}), self._present.get(name)
        if present is None and len(self._present) >= MOST_WIRES and self._orphans:
            oldest = next(iter(self._orphans))
            del self._orphans[oldest], self._present[oldest]
        is_full = present is None and len(self._present) >= MOST_WIRES
        if is_full or len(driven) >= MOST_OF_A_MEMBER or len(name) > LONGEST_NAME:
            if member not in self._told_full:
                self._told_full.add(member)
                log.warning("%s drives more wires than are kept, or one with too long a name: %.80s", member, name)
            return False
        if present is not None:
            self._driven.get(present[0], {}).pop(name, None)
            self._orphans.pop(name, None)
        driven[name] = None
        return True

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[Signal]]:
        due, self._due = self._due, []
        return due

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {"wires": float(len(self._present))}


class WiresSettings(Settings):
    pass


class WiresHubSettings(HubSettings):
    pass


class _Wires(ModelBus[Signal]):
    family: ClassVar[str] = "wires"
    messages: ClassVar[tuple[type, ...]] = (Signal,)

    def encode(self, message: Signal) -> bytes:
        return encode(message)

    def decode(self, data: bytes) -> Signal:
        return decode(data)

    def show(self, message: Signal) -> str:
        return show(message)

    def model(self) -> WiresModel:
        return WiresModel()

    @staticmethod
    def standing_of(message: Signal) -> str:
        """A wire keeps its value."""
        return message.name


class WiresVirtual(_Wires):
    about: ClassVar[str] = "signals between devices and plants, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: WiresSettings) -> None:
        super().__init__(name, settings)


class WiresHub(_Wires):
    about: ClassVar[str] = "signals between devices and plants, in real time through a hub"
    times: ClassVar[frozenset[Time]] = frozenset({"real"})

    def __init__(self, name: str, settings: WiresHubSettings) -> None:
        super().__init__(name, settings)
