"""The faults of wires: their settings, and what they do to the values that receivers get.

The driver of a wire does not notice: its value stays, and receivers get it again when the fault ends.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from random import Random
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.bus import Delivery
from fieldrig.clock import MS
from fieldrig.faults import faults
from fieldrig.faults.chance import derived
from fieldrig.faults.disturbed import Effects, Struck
from fieldrig.faults.faults import LONGEST_MS, Fault, Repeated, Timed
from fieldrig.settings import WIRE
from fieldrig.text.nearest import is_mistyped
from fieldrig_bus.signals.codec import LONGEST_NAME
from fieldrig_bus.signals.signal import Signal

if TYPE_CHECKING:
    from fieldrig_bus.wires import WiresModel

Number = Annotated[float, Field(allow_inf_nan=False)]


class OfWire(Timed):
    """The wire that a fault concerns."""

    names: ClassVar[Mapping[str, str]] = {"wire": WIRE}

    wire: str = Field(min_length=1, max_length=LONGEST_NAME, description="name of the wire")


class Stuck(OfWire):
    """Receivers get one value, whatever the driver does."""

    what: Literal["stuck"]
    value: bool | int | Number | None = Field(default=None, description="the value; left out: that of the begin")


class Offset(OfWire):
    """Receivers get a value that is wrong by a constant and by a factor."""

    what: Literal["offset"]
    offset: Number = Field(default=0.0, description="added to the value, in its unit")
    factor: Number = Field(default=1.0, description="the value is multiplied by it first")

    @model_validator(mode="after")
    def _check_there_is_one(self) -> Self:
        if self.offset == 0 and self.factor == 1:
            raise ValueError("expected offset, factor or both")
        return self


class Noise(OfWire):
    """A random part is added to an analog value again and again."""

    what: Literal["noise"]
    amplitude: Number = Field(gt=0, description="largest deviation, in the unit of the wire")
    period_ms: float = Field(default=10.0, ge=0.1, le=LONGEST_MS, description="time between two values")


class DropOut(OfWire):
    """The wire is broken: receivers get false or 0."""

    what: Literal["drop_out"]


class Bounce(OfWire, Repeated):
    """A digital value bounces after each change, as a contact does."""

    what: Literal["bounce"]
    length_ms: float = Field(default=5.0, gt=0, le=LONGEST_MS, description="time until it is at rest")
    pulses: int = Field(default=3, ge=1, le=1000, description="number of times that it goes back meanwhile")


class Swapped(OfWire):
    """Two wires are exchanged: the receivers of each get the value of the other."""

    names: ClassVar[Mapping[str, str]] = {"wire": WIRE, "other": WIRE}

    what: Literal["swapped"]
    other: str = Field(min_length=1, max_length=LONGEST_NAME, description="name of the other wire")


WireFault = Annotated[Stuck | Offset | Noise | DropOut | Bounce | Swapped, Field(discriminator="what")]
MODELS: Final = faults.models_of(WireFault)


class WireEffects(Effects[Signal]):
    models = MODELS
    medium: "WiresModel"
    knows_all: ClassVar[bool] = True
    """True if the medium knows the wires of all members."""

    def begin(self, medium: Any, random: Random) -> None:
        super().begin(medium, random)
        self._random = derived(random)
        self._held: dict[int, Signal] = {}
        self._noise: dict[int, float] = {}
        self._level: dict[str, bool] = {}

    def check(self, settings: Any, members: Iterable[str]) -> None:
        if isinstance(settings, Swapped) and settings.wire == settings.other:
            raise ValueError(f"other: {settings.other!r} is the wire itself\nexpected another wire")
        known = self.medium.known() if self.knows_all else ()
        for key in settings.names:
            name = getattr(settings, key)
            near = None if name in known else next((other for other in known if is_mistyped(name, other)), None)
            if near is not None:  # any other name may come, from a test or a program outside
                raise ValueError(f"{key}: nothing drives or reads the wire {name!r}\ndid you mean {near}?")

    def fits(self, settings: Any, delivery: Delivery[Signal]) -> bool:
        name, value = delivery.message.name, delivery.message.value
        match settings:
            case Swapped():
                return name in (settings.wire, settings.other)
            case Bounce():
                return name == settings.wire and type(value) is bool and self._is_new(name, value)
            case Offset() | Noise():
                return name == settings.wire and type(value) is not bool
        return bool(name == settings.wire)

    def strike(self, fault: Fault[Any], delivery: Delivery[Signal]) -> Struck[Signal]:
        settings, signal = fault.settings, delivery.message
        match settings:
            case Stuck(value=value):
                held = self._held.setdefault(fault.number, _at(signal, delivery.time_ns))
                stuck = held.value if value is None else value
                return _as(delivery, Signal(signal.name, stuck, signal.unit), f"stuck at {stuck}")
            case DropOut():
                none: bool | int = False if type(signal.value) is bool else 0
                return _as(delivery, Signal(signal.name, none, signal.unit), "dropped out")
            case Offset(offset=offset, factor=factor):
                return _as(delivery, _moved(signal, factor, offset), "off")
            case Noise():
                return _as(delivery, _moved(signal, 1.0, self._noise.get(fault.number, 0.0)), "noise")
            case Bounce():
                return Struck(list(_bounces(settings, delivery)), "bounces")
            case Swapped():
                return self._swapped(settings, delivery)
        raise AssertionError(f"no effect of {settings}")

    def turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[Signal]]:
        settings = fault.settings
        if isinstance(settings, Noise):
            self._noise[fault.number] = self._random.uniform(-settings.amplitude, settings.amplitude)
        if isinstance(settings, Bounce):
            return []
        if not is_on:
            self._held.pop(fault.number, None)
        names = (settings.wire, settings.other) if isinstance(settings, Swapped) else (settings.wire,)
        return [delivery for name in names if (delivery := self.medium.present(now_ns, name)) is not None]

    def period_ns(self, settings: Any) -> int:
        return round(settings.period_ms * MS) if isinstance(settings, Noise) else 0

    def _is_new(self, name: str, value: bool) -> bool:
        """Return whether a digital wire changes with this value, and note it."""
        before, self._level[name] = self._level.get(name), value
        return before is not None and before is not value

    def _swapped(self, settings: Swapped, delivery: Delivery[Signal]) -> Struck[Signal]:
        """The value of this wire goes to those who hear the other one."""
        signal = delivery.message
        name = settings.other if signal.name == settings.wire else settings.wire
        receivers = self.medium.receivers_of(name, delivery.sender)
        return Struck(
            [delivery._replace(message=replace(signal, name=name), receivers=receivers)], f"swapped with {name}"
        )


def _as(delivery: Delivery[Signal], signal: Signal, what: str) -> Struck[Signal]:
    return Struck([delivery._replace(message=signal)], what)


def _at(signal: Signal, now_ns: int) -> Signal:
    """The signal as it stands now, without a motion."""
    return Signal(signal.name, signal.at(now_ns), signal.unit)


def _moved(signal: Signal, factor: float, offset: float) -> Signal:
    """The signal with another value; a motion keeps moving, and a signal of another kind keeps its edges."""
    if type(signal) is Signal:
        return Signal(signal.name, signal.value * factor + offset, signal.unit)
    return replace(signal, value=signal.value * factor + offset)


def _bounces(settings: Bounce, delivery: Delivery[Signal]) -> Iterator[Delivery[Signal]]:
    """The new value, then back and forth at equal distances until the length is over."""
    signal, steps = delivery.message, 2 * settings.pulses
    length_ns = round(settings.length_ms * MS)
    for step in range(steps + 1):
        value = bool(signal.value) is (step % 2 == 0)
        when_ns = delivery.time_ns + length_ns * step // steps
        yield delivery._replace(time_ns=when_ns, message=Signal(signal.name, value, signal.unit))
