"""A rig in real time that runs already, asked over one connection; or one that is started because none runs."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from fieldrig.clock import S
from fieldrig.config.rig_file import RigConfig
from fieldrig.control.endpoint import NoRigError
from fieldrig.control.messages import Client
from fieldrig.errors import ControlError, UsageError
from fieldrig.real.live_rig import LiveRig

OWN: Final = ("control=", "run=")
"""The keys that a rig has for itself that is started here."""


class RunningRig(LiveRig):
    """The rig at a control endpoint.  Closing it leaves the rig running."""

    def __init__(self, endpoint: str) -> None:
        """ControlError if no rig answers there."""
        self.endpoint = endpoint
        self._client = Client(endpoint)

    @contextmanager
    def _connected(self) -> Iterator[Client]:
        """Yield the one connection, which is the same for all questions."""
        yield self._client

    def has_power(self, part: str) -> bool:
        """Return whether it is a bus, or a device that answers."""
        if part in self.status()["buses"]:
            return True
        try:
            self.ask(f"device/{part}/get", {"keys": []})
        except ControlError:
            return False
        return True

    def now_ns(self) -> int:
        """Return the instant on the clock of the host, which all processes of a rig on it have."""
        return time.monotonic_ns()

    def wait(self, ns: int) -> None:
        """Wait for a time in nanoseconds; a negative one is none."""
        time.sleep(max(ns, 0) / S)

    def wait_for_uptime(self, ns: int) -> None:
        """Wait until the rig has run for this time, in nanoseconds."""
        self.wait(ns - round(self.status()["uptime_s"] * S))

    def output(self) -> str:
        """Return where to look: what the rig prints is in the terminal that has it."""
        return "the terminal of the rig says why"

    def close(self) -> None:
        self._client.__exit__()

    def _check_lives(self, when: str) -> None:
        """ControlError if the rig has ended."""
        self.status()


@contextmanager
def running(config: RigConfig) -> Iterator[RunningRig]:
    """Yield the rig that runs at the control endpoint of `config`, or one that is started and ends with this.

    UsageError if another rig runs there.
    """
    try:
        rig = RunningRig(config.control)
    except NoRigError:
        overrides = [word for word in config.overrides if not word.startswith(OWN)]
        with LiveRig(config.path, *overrides) as live, RunningRig(live.endpoint) as started:
            yield started
        return
    with rig:
        status = rig.status()
        if status["rig"] != config.name or status["time"] != "real":
            raise UsageError(
                f"the rig at {config.control} is {status['rig']} in {status['time']} time, "
                f"not {config.name} in real time",
                "stop it with `fieldrig stop`, or name its file",
            )
        yield rig
