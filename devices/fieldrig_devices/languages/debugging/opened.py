"""The rig of a scenario file that `fieldrig scenario open` keeps, for the length of a session of a debugger."""

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any, Final, NamedTuple

from fieldrig.control.messages import Client
from fieldrig.errors import ControlError, RigError, UsageError
from fieldrig.text.nearest import closest

SUFFIXES: Final = (".yaml", ".yml")
END_S: Final = 10.0

Moments = Callable[[float | None], Iterator[object]]


class Opened(NamedTuple):
    """A rig that stands where its scenario ends."""

    endpoint: str
    device: str
    """The device whose program is debugged."""
    told: Sequence[str]
    """The property that does not hold, and the changes before that, as lines."""


@contextmanager
def opened(file: str, device: str | None, endpoint: str, moments: Moments) -> Iterator[Opened]:
    """Play a scenario, and keep its rig at the endpoint.  UsageError without a device that has a program.

    RigError if the rig ends before; what it has printed says why.
    """
    command = [sys.executable, "-m", "fieldrig", "scenario", "open", file]
    options = ["--control", endpoint, "--no-ui", "--quiet"]
    process = subprocess.Popen([*command, *options], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        with _client(process, endpoint, moments) as client:
            timeline = _played(process, client, moments)
            yield Opened(endpoint, _chosen(client, device, timeline), list(_told(timeline)))
    finally:
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(END_S)
        process.kill()
        process.wait()


def _client(process: "subprocess.Popen[bytes]", endpoint: str, moments: Moments) -> Client:
    for _ in moments(None):
        with suppress(ControlError):
            return Client(endpoint)
        _check(process)
    raise AssertionError("moments without a limit do not end")


def _played(process: "subprocess.Popen[bytes]", client: Client, moments: Moments) -> Mapping[str, Any]:
    """Wait until the rig is where its scenario ends; return its time line."""
    for _ in moments(None):
        with suppress(ControlError):  # it does not answer while it plays in a branch
            timeline: Mapping[str, Any] = client.ask("prelude/timeline")
            if timeline["is_there"]:
                return timeline
        _check(process)
    raise AssertionError("moments without a limit do not end")


def _check(process: "subprocess.Popen[bytes]") -> None:
    if process.poll() is not None:
        raise RigError("the scenario cannot be opened", "what is printed above says why")


def _chosen(client: Client, device: str | None, timeline: Mapping[str, Any]) -> str:
    """Return the device that is asked for, or the one with a program; of several the one that the scenario names."""
    devices = list(client.ask("rig/status")["devices"])
    if device is not None and device not in devices:
        raise UsageError(f"the rig has no device {device}", closest(device, devices))
    programs = [name for name in devices if _has_program(client, name)]
    named = {signal["place"].partition("/")[0] for signal in timeline["signals"]}
    found = [device] if device else [name for name in programs if name in named] or programs
    if not found:
        raise UsageError("no device of this rig has a program", "`fieldrig scenario open` and `fieldrig back` go back")
    return str(found[0])


def _has_program(client: Client, device: str) -> bool:
    try:
        return bool(client.ask(f"device/{device}/debug", {"command": "state"})["threads"])
    except ControlError:
        return False


def _told(timeline: Mapping[str, Any]) -> Iterator[str]:
    for one in timeline["violations"][:1]:
        first, *others = one["told"]
        yield f"{one['property']}: {first}"
        yield from others
