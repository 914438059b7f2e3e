"""A drive whose mains come after its electronics or not at all: bit 4 of its status word (CiA 402-2, 6.3)."""

from collections.abc import Iterable
from typing import Any, Final

from fieldrig.clock import MS
from fieldrig_devices.cia402.objects import STATUS_WORD
from fieldrig_devices.drive_profile.states import State
from fieldrig_devices.from_recording.drive_signs import FEWEST_WORDS, STATE_MASK, VOLTAGE
from fieldrig_devices.from_recording.drive_words import Word

RESTING: Final = frozenset({State.NOT_READY_TO_SWITCH_ON.value, State.SWITCH_ON_DISABLED.value})
"""States in which a drive may be without mains for as long as one looks."""


def mains_lost(words: Iterable[Word], start_ns: int) -> list[dict[str, Any]]:
    """Return the fault of a drive that is switched on at `start_ns`: until bit 4 comes in the log, or permanently.

    A drive that sets bit 4 when it is enabled says nothing of its mains.
    """
    status = [word for word in words if word.object == STATUS_WORD]
    first = next((place for place, word in enumerate(status) if word.value & VOLTAGE), None)
    states = {word.value & STATE_MASK for word in status[: len(status) if first is None else first + 1]}
    if first is None:
        return [{"what": "mains_lost"}] if len(status) >= FEWEST_WORDS and states <= RESTING else []
    if not first or State.OPERATION_ENABLED.value in states or status[first].begin_ns <= start_ns:
        return []
    return [{"what": "mains_lost", "duration_ms": round((status[first].begin_ns - start_ns) / MS, 3)}]
