"""What can be wrong with a controller, in the one form of `fieldrig.faults`."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final, Literal, TypeVar

from pydantic import Field

from fieldrig import faults
from fieldrig.clock import Clock
from fieldrig.faults import Fault, Faults, Timed


class PowerOff(Timed):
    """The controller has no power; when it is over, it boots."""

    what: Literal["power_off"]
    days: float = Field(default=0.0, ge=0, description="that the controller takes it for; buffered memory lasts 7")


class MemoryLost(Timed):
    """Buffered memory loses what it holds, at once and at every power-on."""

    what: Literal["memory_lost"]


class Overrun(Timed):
    """The real-time process takes longer."""

    what: Literal["overrun"]
    us: int = Field(ge=1, le=1_000_000, description="by so much in every cycle")


Max4Fault = Annotated[PowerOff | MemoryLost | Overrun, Field(discriminator="what")]
MODELS: Final = faults.models_of(Max4Fault)
TEXTS: Final = frozenset({"what"})

F = TypeVar("F", bound=Timed)


class Max4Faults:
    def __init__(self, clock: Clock, on_change: Callable[[], None]) -> None:
        """`on_change` is called when one has begun, is over, or was cleared."""
        self._clock, self._on_change = clock, on_change
        self._faults: Faults[Fault[Any]] = Faults(Fault)

    def add(self, given: Mapping[str, Any]) -> int:
        """ValueError: what is wrong, and what would be right."""
        now_ns = self._clock.now_ns()
        fault = self._faults.add(now_ns, faults.fault_of(given, MODELS, TEXTS))
        for when_ns in (fault.start_ns, fault.until_ns):
            if when_ns is not None and when_ns > now_ns:
                self._clock.call_at(when_ns, self._on_change)
        self._on_change()
        return fault.number

    def clear(self, number: int) -> None:
        self._faults.clear(number)
        self._on_change()

    def find(self, kind: type[F]) -> F | None:
        """The first of this kind that is on."""
        now_ns = self._clock.now_ns()
        return next((one.settings for one in self._faults.of(kind) if one.is_on(now_ns)), None)

    def about(self) -> dict[int, dict[str, Any]]:
        return self._faults.about(self._clock.now_ns())
