"""A drive whose mains come on after its electronics: bit 4 of its status word, "voltage enabled" (CiA 402-2, 6.3)."""

from collections.abc import Iterable
from typing import Any

from fieldrig.clock import MS
from fieldrig_devices.cia402.objects import STATUS_WORD
from fieldrig_devices.cia402.states import State
from fieldrig_devices.from_recording.drive_signs import STATE_MASK, VOLTAGE
from fieldrig_devices.from_recording.drive_words import Word


def late_mains(words: Iterable[Word], start_ns: int) -> list[dict[str, Any]]:
    """Return the fault of a drive that is switched on at `start_ns`, if bit 4 comes later in the recording.

    A drive that sets bit 4 when it is enabled says nothing of its mains.
    """
    status = [word for word in words if word.object == STATUS_WORD]
    first = next((place for place, word in enumerate(status) if word.value & VOLTAGE), 0)
    states = {word.value & STATE_MASK for word in status[: first + 1]}
    if not first or State.OPERATION_ENABLED.value in states or status[first].begin_ns <= start_ns:
        return []
    return [{"what": "mains_lost", "duration_ms": round((status[first].begin_ns - start_ns) / MS, 3)}]
