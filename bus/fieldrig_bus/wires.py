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
from typing import Any, ClassVar

from fieldrig.bus import BusModel, Delivery, ModelBus, Time, words_of
from fieldrig.clock import S
from fieldrig.settings import Settings
from fieldrig.untrusted import WIDEST, read_json
from fieldrig_bus.net import HubSettings

log = logging.getLogger(__name__)

LONGEST_NAME = 256
LONGEST_UNIT = 32
LONGEST_SIGNAL = 4096
"""Bytes of an encoded one."""
MOST_WIRES = 65_536
"""Of one bus; nobody drives more."""
_LATEST_NS = (1 << 63) - 1


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
    signal = _read(read_json(data, LONGEST_SIGNAL, deepest=1))
    if signal is None:
        raise ValueError(f"not a signal: {data[:80]!r}")
    check_sent(signal)
    return signal


def check_sent(message: Any) -> None:
    """TypeError or ValueError for what can't be on a wire."""
    if not isinstance(message, Signal):
        raise TypeError(f"expected a Signal, found {type(message).__name__}")
    _check_text("name", message.name, LONGEST_NAME)
    _check_text("unit", message.unit, LONGEST_UNIT)
    value = message.value
    if type(value) is float:
        if not isfinite(value):
            raise ValueError(f"value {value}: expected a number that is finite")
    else:
        _check_number("value", value)
    if isinstance(message, Motion):
        if isinstance(value, bool):
            raise TypeError("value: expected a number, found bool: what is on or off doesn't move")
        _check_number("speed", message.speed)
        _check_number("acceleration", message.acceleration)
        if type(message.time_ns) is not int:
            raise TypeError(f"time_ns: expected int, found {type(message.time_ns).__name__}")
        if abs(message.time_ns) > _LATEST_NS:
            raise ValueError(f"time_ns {message.time_ns}: expected an instant of 64 bits")


def check_interest(interest: Any) -> None:
    """TypeError or ValueError for what is not names of wires."""
    for name in words_of(interest):
        _check_text("name", name, LONGEST_NAME)


def _check_text(what: str, text: Any, longest: int) -> None:
    if type(text) is not str:
        raise TypeError(f"{what}: expected str, found {type(text).__name__}")
    if len(text) > longest:
        raise ValueError(f"{what} of {len(text)} characters: expected at most {longest}")
    if not text.isascii():
        text.encode()  # ValueError for half of a surrogate pair, which is no text


def _check_number(what: str, value: Any) -> None:
    if not isinstance(value, bool | int | float):
        raise TypeError(f"{what}: expected bool, int or float, found {type(value).__name__}")
    if isinstance(value, float):
        if not isfinite(value):
            raise ValueError(f"{what} {value}: expected a number that is finite")
    elif not WIDEST[0] <= value <= WIDEST[1]:
        raise ValueError(f"{what}: expected an integer of 64 bits")


def _read(fields: Any) -> Signal | None:
    match fields:
        case [str(name), bool() | int() | float() as value, str(unit)]:
            return Signal(name, value, unit)
        case [str(name), int() | float() as value, str(unit), int(time_ns), int() | float() as speed, course] if (
            isinstance(course, int | float)
        ):
            return Motion(name, value, unit, time_ns, speed, course)
    return None


def show(signal: Signal) -> str:
    value = signal.value
    text = str(value) if isinstance(value, bool | int) else f"{value:.6g}"
    course = f", {signal.speed:.6g} {signal.unit}/s" if isinstance(signal, Motion) else ""
    return f"{signal.name} = {text} {signal.unit}".rstrip() + course


class WiresModel(BusModel[Signal]):
    def __init__(self) -> None:
        self._interests: dict[str, frozenset[str] | None] = {}  # None: every name
        self._present: dict[str, tuple[str, Signal]] = {}  # name: driver and value
        self._due: list[Delivery[Signal]] = []

    def join(self, member: str) -> None:
        self._interests[member] = frozenset()

    def leave(self, member: str) -> None:
        self._interests.pop(member, None)

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        names = None if interest is None else frozenset(map(str, interest))
        self._interests[member] = names
        for name, (driver, signal) in self._present.items():
            if driver != member and (names is None or name in names):
                self._due.append(Delivery(now_ns, driver, signal, (member,)))

    def submit(self, now_ns: int, member: str, message: Signal) -> None:
        if message.name not in self._present and len(self._present) >= MOST_WIRES:
            log.debug("%s drives a wire too many: %s", member, message.name)
            return
        self._present[message.name] = (member, message)
        receivers = [
            name
            for name, names in self._interests.items()
            if name != member and (names is None or message.name in names)
        ]
        self._due.append(Delivery(now_ns, member, message, receivers))

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

    check = staticmethod(check_sent)
    check_interest = staticmethod(check_interest)

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
