"""The faults of a card: its memory, its encoder inputs, and its program.

Source: manual 5 (error codes); digest chapter 10: E03 for a memory that fails, E11 for a program that stops, and E16 by
which an axis says that it has lost its encoder.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.faults.faults import Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults


class MemoryLost(Timed):
    """The flash can be neither read nor written: each access is E03 (103)."""

    what: Literal["memory"]


class EncoderSignal(Timed):
    """No signal of an encoder reaches the card: its counter stays, and the counts that it misses are lost."""

    what: Literal["encoder_signal"]
    axis: Literal[1, 2] = Field(description="axis of the encoder")


class ProgramStopped(Timed):
    """The program stops anomalously: E11 (111), which blocks the card until Enable is opened and closed."""

    what: Literal["program_stopped"]


ArpFault = Annotated[MemoryLost | EncoderSignal | ProgramStopped, Field(discriminator="what")]
MODELS: Final[Mapping[str, type[Any]]] = models_of(ArpFault)


class ArpFaults(InjectedFaults[Fault[Any]]):
    """The faults of one card."""

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock, MODELS, Faults(Fault))
        self._held: dict[int, int] = {}
        """The counts at which the signals of encoders were lost, by axis."""
        self._missed = [0, 0, 0]

    @property
    def has_memory(self) -> bool:
        return self.first(MemoryLost) is None

    @property
    def stops_program(self) -> bool:
        return self.first(ProgramStopped) is not None

    def counted(self, counts: Sequence[int | None]) -> Sequence[int | None]:
        """Return the encoder counts by axis that the card counts, of those that the encoders have."""
        if not self.given:
            return counts
        lost = {fault.axis for fault in self.active(EncoderSignal)}
        return [None, *(self._of_axis(axis, counts[axis], axis in lost) for axis in (1, 2))]

    def _of_axis(self, axis: int, count: int | None, is_lost: bool) -> int | None:
        if count is None:
            return None
        if is_lost:
            return self._held.setdefault(axis, count - self._missed[axis])
        if axis in self._held:
            self._missed[axis] = count - self._held.pop(axis)
        return count - self._missed[axis]
