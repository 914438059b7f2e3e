"""Wires: named signals with units between devices and plants.

A wire has one driver and any number of listeners.  It keeps its value, so a device that listens later gets the present
one.  A signal arrives at the instant at which it was driven.  A device's interest is the names that it listens to.
What moves steadily is published when its speed changes, and not step by step: an encoder as a `Motion`, a pulse output
as a `PulseTrain` or a `Pwm` (`fieldrig_bus.signals`).
"""

import logging
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Final

from pydantic import Field

from fieldrig.bus import Bus, BusModel, Delivery, ModelBus, Reading, Time, words_of
from fieldrig.settings import WIRE, Settings
from fieldrig_bus.net import HubSettings
from fieldrig_bus.signals import traced
from fieldrig_bus.signals.codec import LONGEST_NAME, check_sent, check_text
from fieldrig_bus.signals.faults import MODELS, WireEffects, WireFault
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.signals.signal import Motion, Signal

__all__ = ["Motion", "PulseTrain", "Pwm", "Signal"]
"""The public names; buses of this module are named by their kind."""

log = logging.getLogger(__name__)

MOST_OF_A_MEMBER: Final = 4_096
MOST_WIRES: Final = 65_536


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for an interest that is not a list of names of wires."""
    for name in words_of(interest):
        check_text("name", name, LONGEST_NAME)


class WiresModel(BusModel[Signal]):
    """Keeps the value of each wire, up to a limit.  Wires beyond the limit are dropped, and reported once.

    A member may drive `MOST_OF_A_MEMBER` wires.  When there are `MOST_WIRES`, a new wire replaces the oldest one whose
    driver is gone.
    """

    def __init__(self, alarms: "Mapping[str, Alarm] | None" = None) -> None:
        self._alarms = dict(alarms or {})
        self._interests: dict[str, frozenset[str] | None] = {}  # None: every name
        self._present: dict[str, tuple[str, Signal]] = {}  # name: driver and value
        self._standing: dict[str, Signal] = {}
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

    def power_lost(self, now_ns: int, member: str) -> None:
        """Switch its digital outputs off; everything else keeps its value."""
        for name in list(self._driven.get(member, ())):
            signal = self._present[name][1]
            if signal.value is True:
                self.submit(now_ns, member, Signal(name, False, signal.unit))
        self.leave(member)

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
        self._standing[message.name] = message
        self._due.append(Delivery(now_ns, member, message, self.receivers_of(message.name, member)))

    def receivers_of(self, wire: str, driver: str) -> list[str]:
        """Return the members that listen to a wire, in the order of joining."""
        return [name for name, names in self._interests.items() if name != driver and (names is None or wire in names)]

    def present(self, now_ns: int, wire: str) -> Delivery[Signal] | None:
        """Return the present value of a wire as a delivery to all that listen to it; None if nothing drives it."""
        if wire not in self._present:
            return None
        driver, signal = self._present[wire]
        return Delivery(now_ns, driver, signal, self.receivers_of(wire, driver))

    def known(self) -> Collection[str]:
        """Return the names of all wires that a member drives or reads by name, in the order of appearance."""
        return dict.fromkeys(
            [*self._present, *(name for names in self._interests.values() for name in sorted(names or ()))]
        )

    def _is_taken_on(self, name: str, member: str) -> bool:
        """True if there is room for this wire among those of its new driver."""
        driven, present = self._driven.setdefault(member, {}), self._present.get(name)
        if present is None and len(self._present) >= MOST_WIRES and self._orphans:
            oldest = next(iter(self._orphans))
            del self._orphans[oldest], self._present[oldest], self._standing[oldest]
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

    def conditions(self, now_ns: int) -> dict[str, str]:
        signals = {name: self._present[name][1] for name in self._alarms if name in self._present}
        return raised(self._alarms, signals, now_ns)

    def standing(self) -> Mapping[str, Signal]:
        return self._standing

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {"wires": float(len(self._present))}


class Alarm(Settings):
    """A state of a wire that `fieldrig up` tells of."""

    when: bool | float = Field(default=True, description="value of the wire in this state")
    text: str = Field(min_length=1, max_length=100, description="words for it, such as emergency stop")


ALARMS: Final = "states of wires that `fieldrig up` tells of, such as an emergency stop"


def raised(alarms: Mapping[str, Alarm], signals: Mapping[str, Signal], now_ns: int) -> dict[str, str]:
    """Return the texts of alarms whose wires have the value that each is for; a wire that nothing drives has none."""
    return {
        name: alarm.text for name, alarm in alarms.items() if name in signals and signals[name].at(now_ns) == alarm.when
    }


def alarms_of(alarms: Mapping[str, Alarm]) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
    """Yield the wires that alarms name (`Settings.offers`)."""
    for name in alarms:
        yield ("alarms", name), WIRE, name


FAULTS: Final = "faults from the start"


class WiresSettings(Settings):
    faults: list[WireFault] = Field(default_factory=list, description=FAULTS)
    alarms: dict[str, Alarm] = Field(default_factory=dict, description=ALARMS)

    def offers(self) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
        yield from alarms_of(self.alarms)


class WiresHubSettings(HubSettings):
    faults: list[WireFault] = Field(default_factory=list, description=FAULTS)
    alarms: dict[str, Alarm] = Field(default_factory=dict, description=ALARMS)

    def offers(self) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
        yield from alarms_of(self.alarms)


class WiresFamily(Bus[Signal]):
    """Wires of any kind."""

    family: ClassVar[str] = "wires"
    notes_faults: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (Signal,)

    encode = staticmethod(traced.encode)
    decode = staticmethod(traced.decode)
    show = staticmethod(traced.show)
    check = staticmethod(check_sent)
    check_interest = staticmethod(check_interest)

    def reading(self, message: Any, now_ns: int) -> Reading | None:
        if not isinstance(message, Signal):
            return None
        return Reading(message.name, message.at(now_ns), message.unit)


class _Wires(WiresFamily, ModelBus[Signal]):
    fault_models = MODELS

    def model(self) -> WiresModel:
        return WiresModel(self.settings.alarms)

    def effects(self) -> WireEffects:
        return WireEffects(self.settings.faults)

    @staticmethod
    def standing_of(message: Any) -> str | None:
        """The name of the wire, as every wire keeps its value; None for the note of a fault."""
        return message.name if isinstance(message, Signal) else None


class WiresVirtual(_Wires):
    about: ClassVar[str] = "signals between devices and plants, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: WiresSettings) -> None:
        super().__init__(name, settings)


class WiresHub(_Wires):
    about: ClassVar[str] = "signals between devices and plants, in real time through a hub"
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})

    def __init__(self, name: str, settings: WiresHubSettings) -> None:
        super().__init__(name, settings)
