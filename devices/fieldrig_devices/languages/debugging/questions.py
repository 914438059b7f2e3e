"""Questions to the debugging service of a device in a running rig."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final

from fieldrig.cli.names import Parts, check_name
from fieldrig.control.messages import Client
from fieldrig.recording.live_reader import LiveReader
from fieldrig.recording.reader import OnRows
from fieldrig.recording.signals import CYCLE
from fieldrig_devices.languages.debugging.adapter import Ask
from fieldrig_devices.languages.debugging.traces import Begin
from fieldrig_devices.languages.debugging.travel import Travel

LONGEST_WAY_S: Final = 600.0
"""Time limit for a way back, in seconds."""
LARGEST_PART: Final = 100_000
"""Characters in a part of a download: as JSON at most 600 kB, and a question may have 1 MB."""


def asker(client: Client, device: str) -> Ask:
    """Return a function that puts a question to the service.  ControlError if the device refuses or is not there."""

    parts = Parts(client)
    check_name(device, parts.devices, f"{parts.rig} has no device")

    def ask(message: Mapping[str, Any]) -> dict[str, Any]:
        answer: dict[str, Any] = parts.ask_device(device, "debug", message)
        return answer

    return ask


def recorder_of(client: Client, endpoint: str, device: str) -> Begin:
    """Return a function that records keys of a device in each of its cycles."""

    def begin(keys: Sequence[str], on_rows: OnRows) -> LiveReader:
        signals = [f"{device}/{key}" for key in keys]
        return LiveReader(endpoint, Parts(client).rig, signals, CYCLE, on_rows)

    return begin


def travel_of(client: Client, device: str, ask: Ask) -> Travel:
    """Return the way back of the rig of a device."""

    def ask_rig(verb: str, message: Any) -> dict[str, Any]:
        answer: dict[str, Any] = client.ask(f"rig/{verb}", message, LONGEST_WAY_S)
        return answer

    return Travel(device, ask, ask_rig)


def download(
    ask: Ask,
    files: Mapping[str, str],
    moments: Iterator[object],
    on_progress: Callable[[str], None],
    *,
    is_online: bool,
) -> str:
    """Load a program, and wait until the device has compiled it.  Return its mistakes, one a line; empty if it loaded.

    TimeoutError if it still compiles after all moments.
    """
    ask({"command": "part"})
    for name, text in files.items():
        for at in range(0, len(text) or 1, LARGEST_PART):
            ask({"command": "part", "file": name, "text": text[at : at + LARGEST_PART], "is_first": at == 0})
    ask({"command": "download", "online": is_online})
    return str(settled(ask, moments, on_progress)["problem"])


def settled(ask: Ask, moments: Iterator[object], on_progress: Callable[[str], None]) -> dict[str, Any]:
    """Wait until the device has done its work in progress, and return its state.

    TimeoutError if it still works after all moments.
    """
    for _ in moments:
        state = ask({"command": "state"})
        on_progress(state["progress"])
        if not state["progress"]:
            return state
    raise TimeoutError("the device still compiles the program")
