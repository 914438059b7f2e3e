"""Wires: named signals with units between devices and plants.

A wire has one driver and any number of listeners.  It keeps its value, so a device that listens later gets the present
one.  A signal arrives at the instant at which it was driven.  A device's interest is the names that it listens to.
What moves steadily, such as an encoder or a pulse train, is published as a `Motion` whenever its speed or acceleration
changes, and not edge by edge.
"""

import json
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, ClassVar, Final

from fieldrig.bus import Bus, BusModel, Delivery, ModelBus, Time, words_of
from fieldrig.clock import S
from fieldrig.settings import Settings
from fieldrig.untrusted import WIDEST, read_json
from fieldrig.values import show_number
from fieldrig_bus.net import HubSettings

log = logging.getLogger(__name__)

LONGEST_NAME: Final = 256
"""Longest name or unit, in characters."""
LONGEST_UNIT: Final = 32
LONGEST_SIGNAL: Final = 4096
"""Largest encoded signal, in bytes."""
_LATEST_NS = (1 << 63) - 1
MOST_OF_A_MEMBER: Final = 4_096
MOST_WIRES: Final = 65_536


@dataclass(frozen=True, slots=True)
class Signal:
    """The present value of one wire: digital as bool, analog as a number in `unit` (SI or %, "" for a digital one)."""

    name: str
    value: bool | int | float
    unit: str = ""

    @property
    def is_moving(self) -> bool:
        """True if `at` returns different values at different instants."""
        return False

    def at(self, now_ns: int) -> bool | int | float:
        """The value of the wire at `now_ns`, which is the same for every device that has received this signal."""
        return self.value

    def speed_at(self, now_ns: int) -> float:
        """The speed in units per second at `now_ns`."""
        return 0.0


@dataclass(frozen=True, slots=True)
class Motion(Signal):
    """A signal that moves by itself until the next one is published: `value` is its position at `time_ns`.

    A receiver that does not handle motions treats it as a signal with that value.
    """

    time_ns: int = 0
    speed: float = 0.0
    """Speed in units per second at `time_ns`."""
    acceleration: float = 0.0
    """Acceleration in units per second squared."""

    @property
    def is_moving(self) -> bool:
        return bool(self.speed or self.acceleration)

    def at(self, now_ns: int) -> float:
        seconds = (now_ns - self.time_ns) / S
        return self.value + (self.speed + self.acceleration / 2 * seconds) * seconds

    def speed_at(self, now_ns: int) -> float:
        return self.speed + self.acceleration * (now_ns - self.time_ns) / S


def encode(message: Signal) -> bytes:
    """A signal as JSON."""
    fields = [message.name, message.value, message.unit]
    if isinstance(message, Motion):
        fields += [message.time_ns, message.speed, message.acceleration]
    return json.dumps(fields, separators=(",", ":"), allow_nan=False).encode()


def decode(data: bytes) -> Signal:
    """The inverse of `encode`.  ValueError for anything else."""
    signal = _read(read_json(data, LONGEST_SIGNAL, deepest=1))
    if signal is None:
        raise ValueError(f"not a signal: {data[:80]!r}")
    check_sent(signal)
    return signal


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that can't be on a wire."""
    if not isinstance(message, Signal):
        raise TypeError(f"expected a Signal, found {type(message).__name__}")
    _check_text("name", message.name, LONGEST_NAME)
    _check_text("unit", message.unit, LONGEST_UNIT)
    value = message.value
    if type(value) is float:
        if not isfinite(value):
            raise ValueError(f"value {value}: expected a finite number")
    else:
        _check_number("value", value)
    if isinstance(message, Motion):
        if isinstance(value, bool):
            raise TypeError("value: expected a number, found bool: a digital signal does not move")
        _check_number("speed", message.speed)
        _check_number("acceleration", message.acceleration)
        if type(message.time_ns) is not int:
            raise TypeError(f"time_ns: expected int, found {type(message.time_ns).__name__}")
        if abs(message.time_ns) > _LATEST_NS:
            raise ValueError(f"time_ns {message.time_ns}: expected an instant of 64 bits")


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for an interest that is not a list of names of wires."""
    for name in words_of(interest):
        _check_text("name", name, LONGEST_NAME)


def _check_text(what: str, text: Any, longest: int) -> None:
    if type(text) is not str:
        raise TypeError(f"{what}: expected str, found {type(text).__name__}")
    if len(text) > longest:
        raise ValueError(f"{what} of {len(text)} characters: expected at most {longest}")
    if not text.isascii():
        text.encode()  # ValueError for half of a surrogate pair, which is not text


def _check_number(what: str, value: Any) -> None:
    if not isinstance(value, bool | int | float):
        raise TypeError(f"{what}: expected bool, int or float, found {type(value).__name__}")
    if isinstance(value, float):
        if not isfinite(value):
            raise ValueError(f"{what} {value}: expected a finite number")
    elif not WIDEST[0] <= value <= WIDEST[1]:
        raise ValueError(f"{what}: expected an integer of 64 bits")


def _read(fields: Any) -> Signal | None:
    match fields:
        case [str(name), bool() | int() | float() as value, str(unit)]:
            return Signal(name, value, unit)
        case [str(name), int() | float() as value, str(unit), int(time_ns), int() | float() as speed, acceleration] if (
            isinstance(acceleration, int | float)
        ):
            return Motion(name, value, unit, time_ns, speed, acceleration)
    return None


def show(message: Signal) -> str:
    """A signal as one line, with all digits of its value."""
    speed = f", {show_number(message.speed)} {message.unit}/s" if isinstance(message, Motion) else ""
    return f"{message.name} = {show_number(message.value)} {message.unit}".rstrip() + speed


class WiresModel(BusModel[Signal]):
    """Keeps the value of each wire, up to a limit.  Wires beyond the limit are dropped, and reported once.

    A member may drive `MOST_OF_A_MEMBER` wires.  When there are `MOST_WIRES`, a new wire replaces the oldest one whose
    driver is gone.
    """

    def __init__(self) -> None:
        self._interests: dict[str, frozenset[str] | None] = {}  # None: every name
        self._present: dict[str, tuple[str, Signal]] = {}  # name: driver and value
        self._driven: dict[
            str, dict[str, None]
        ] = {}  # the wires of each driver that is there, in the order of appearance
        self._orphans: dict[str, None] = {}  # the wires of drivers that are gone, in the same order
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
        """True if there is room for this wire among those of its new driver."""
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


class WiresFamily(Bus[Signal]):
    """Wires of any kind."""

    family: ClassVar[str] = "wires"
    messages: ClassVar[tuple[type, ...]] = (Signal,)

    encode = staticmethod(encode)
    decode = staticmethod(decode)
    show = staticmethod(show)
    check = staticmethod(check_sent)
    check_interest = staticmethod(check_interest)


class _Wires(WiresFamily, ModelBus[Signal]):
    def model(self) -> WiresModel:
        return WiresModel()

    @staticmethod
    def standing_of(message: Signal) -> str:
        """The name of the wire, as every wire keeps its value."""
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
