"""Notes on exceptions that say where they came from: the device, the bus whose message it handled, and the time."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

NOTE: Final = "in device "


def blame(fault: BaseException, device: str, bus: str | None, now_ns: int) -> None:
    """Add a note unless one was added closer to the fault.  `bus` is None if no message was being handled."""
    if not any(note.startswith(NOTE) for note in getattr(fault, "__notes__", ())):
        what = f"with a message of bus {bus}" if bus is not None else "in a timer or call of its own"
        fault.add_note(f"{NOTE}{device}, {what}, at {now_ns} ns")


@contextmanager
def blamed(device: str, now_ns: int) -> Iterator[None]:
    """Add a note to what the body raises.

    For calls outside a bus event: a device is built, started, read or written.
    """
    try:
        yield
    except Exception as fault:
        blame(fault, device, None, now_ns)
        raise
