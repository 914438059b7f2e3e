"""What can be wrong with a drive and its motor, in the one form of `fieldrig.faults`."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final, Literal, TypeVar

from pydantic import Field

from fieldrig import faults
from fieldrig.clock import Clock
from fieldrig.faults import Fault, Faults, Timed


class EnableLost(Timed):
    """The input Inverter Enable is open."""

    what: Literal["enable_lost"]


class Overtemperature(Timed):
    """The thermo contact of the motor opens, or the heat sink is too hot."""

    what: Literal["overtemperature"]
    of: Literal["motor", "amplifier"] = "motor"


class Overload(Timed):
    """The overload model says to switch off."""

    what: Literal["overload"]


class DcBus(Timed):
    """Of the DC circuit."""

    what: Literal["dc_bus"]
    sort: Literal["communication", "undervoltage", "overvoltage", "phase"] = Field(
        default="communication", description="with its controller; or its voltage; or a mains phase is missing"
    )


class EncoderMemory(Timed):
    """The name plate can't be read."""

    what: Literal["encoder_memory"]


class EncoderSignal(Timed):
    """Sine and cosine are gone."""

    what: Literal["encoder_signal"]


class WrongMotor(Timed):
    """Another motor is at the cable: its plate is none that this drive can use."""

    what: Literal["wrong_motor"]


class StuckBrake(Timed):
    """The holding brake stays on, or off, whatever its relay does."""

    what: Literal["stuck_brake"]
    stays: Literal["on", "off"] = "on"


class Supply24V(Timed):
    """The external 24 V supply is too low."""

    what: Literal["supply_24v"]


DriveFault = Annotated[
    EnableLost
    | Overtemperature
    | Overload
    | DcBus
    | EncoderMemory
    | EncoderSignal
    | WrongMotor
    | StuckBrake
    | Supply24V,
    Field(discriminator="what"),
]
MODELS: Final = faults.models_of(DriveFault)
TEXTS: Final = frozenset({"what", "of", "sort", "stays"})

F = TypeVar("F", bound=Timed)


class DriveFaults:
    def __init__(self, clock: Clock, on_change: Callable[[], None]) -> None:
        """`on_change` is called when one has begun, is over, or was cleared."""
        self._clock, self._on_change = clock, on_change
        self._faults: Faults[Fault[Any]] = Faults(Fault)

    def add(self, settings: Timed) -> int:
        now_ns = self._clock.now_ns()
        fault = self._faults.add(now_ns, settings)
        for when_ns in (fault.start_ns, fault.until_ns):
            if when_ns is not None and when_ns > now_ns:
                self._clock.call_at(when_ns, self._on_change)
        self._on_change()
        return fault.number

    def add_given(self, given: Mapping[str, Any]) -> int:
        return self.add(faults.fault_of(given, MODELS, TEXTS))

    def clear(self, number: int) -> None:
        self._faults.clear(number)
        self._on_change()

    def find(self, kind: type[F]) -> F | None:
        """The first of this kind that is on."""
        now_ns = self._clock.now_ns()
        return next((one.settings for one in self._faults.of(kind) if one.is_on(now_ns)), None)

    def all(self, kind: type[F]) -> list[F]:
        now_ns = self._clock.now_ns()
        return [one.settings for one in self._faults.of(kind) if one.is_on(now_ns)]

    def about(self) -> dict[int, dict[str, Any]]:
        return self._faults.about(self._clock.now_ns())
