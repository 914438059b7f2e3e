"""A rig in real time for the length of a test: `fieldrig up` in a process of its own, at a control endpoint of its own.

Several test processes can run rigs side by side.  A `LiveRig` is ready only when the rig that answers at its endpoint
is the process that it started, so it never mistakes another test's rig for its own.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self, overload

from fieldrig.control.fault_asking import about_faults, ask
from fieldrig.control.messages import Client
from fieldrig.device import Value
from fieldrig.errors import ArgumentError, ControlError, RigError
from fieldrig.outside.addresses import ENDPOINT_VARIABLE
from fieldrig.outside.page_seat import NO_PAGE_VARIABLE
from fieldrig.outside.untrusted import shown
from fieldrig.points.names import split_point, written_point
from fieldrig.real.this_system import check_system
from fieldrig.recording.signals import Rhythm, wish_of
from fieldrig.testing import free_port

if TYPE_CHECKING:
    from fieldrig.recording.recording import Recording

FIELDRIG: Final = (sys.executable, "-m", "fieldrig")
POLL_S: Final = 0.05
"""Time between two questions to a rig that starts."""
END_S: Final = 30.0
"""Longest time for an orderly end; then the rig is killed."""


class UpProcess:
    """A process with `fieldrig up`, with a temporary folder and a control endpoint of its own."""

    process: subprocess.Popen[bytes]
    """The process, from when a subclass has started it with `start_up`."""
    longest_end_s = END_S
    """Longest time for an orderly end, in seconds."""

    def __init__(self, environment: Mapping[str, str] | None = None) -> None:
        """Choose folder and endpoint.  `environment` is added to that of this process."""
        self._temporary = tempfile.TemporaryDirectory(prefix="rig")
        self.folder = Path(self._temporary.name)
        """The temporary folder.  Its path is short, as Unix sockets require."""
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        """The control endpoint, for `fieldrig --control` and `FIELDRIG_CONTROL`."""
        self.environment = {
            **os.environ,
            ENDPOINT_VARIABLE: self.endpoint,
            NO_PAGE_VARIABLE: "1",  # tests pay for no page
            **(environment or {}),
        }
        self._output = self.folder / "up.out"

    def start_up(self, file: Path, *options: str, folder: Path | None = None) -> subprocess.Popen[bytes]:
        """Start `fieldrig up` in `folder`, or in the current folder.  What it prints is added to `output`."""
        with self._output.open("ab") as output:
            return subprocess.Popen(
                [*FIELDRIG, "up", str(file), *options],
                cwd=folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    def ask(self, path: str, message: Any = None) -> Any:
        """Return the answer of the control service.  ControlError if nothing answers, or it refuses."""
        with self._connected() as client:
            return client.ask(path, message)

    @contextmanager
    def _connected(self) -> Iterator[Client]:
        """Yield a connection to the control service."""
        with Client(self.endpoint) as client:
            yield client

    def status(self) -> dict[str, Any]:
        """Return what `fieldrig status --json` shows of the rig and its processes."""
        status: dict[str, Any] = self.ask("rig/status")
        return status

    def output(self) -> str:
        """Return everything that `fieldrig up` has printed so far."""
        return self._output.read_text(encoding="utf-8")

    def close(self) -> None:
        """End the rig in order, or kill it after `longest_end_s`.  Closing twice does no harm."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(self.longest_end_s)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._temporary.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, fault_type: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None
    ) -> None:
        self.close()


class LiveRig(UpProcess):
    """A rig that is ready.  Use it in a `with` statement, or close it, to end the rig."""

    def __init__(self, file: str | Path, *overrides: str) -> None:
        """Start `file` with `overrides` such as "buses.mb_tcp.listen=127.0.0.1:5021", and wait until it is ready.

        RigError, with everything that the rig printed, if it ends before that.
        """
        if not isinstance(file, str | Path) or not all(isinstance(setting, str) for setting in overrides):
            given = ", ".join(map(shown, (file, *overrides)))
            raise ArgumentError(f"a rig cannot be started from {given}", "expected a path, and overrides as texts")
        check_system()
        super().__init__()
        self.run = self.folder / "run"
        """The run folder, with ptys and log/."""
        self.process = self.start_up(Path(file), *(f"--set={setting}" for setting in (f"run={self.run}", *overrides)))
        try:
            self._wait_until_ready()
        except BaseException:
            self.close()
            raise

    def get(self, point: str, key: str | None = None) -> Value:
        """Return the present value of a point: `get("tank/level")`, or `get("tank", "level")`.

        ControlError if there is none of that name.
        """
        device, key = split_point(point, key)
        value: Value = self.ask(f"device/{device}/get", {"keys": [key]})[key]
        return value

    @overload
    def set(self, point: str, value: Value, /) -> None: ...

    @overload
    def set(self, device: str, key: str, value: Value, /) -> None: ...

    def set(self, point: str, *key_and_value: Value) -> None:
        """Write a point: `set("tank/level", 1.25)`, or `set("tank", "level", 1.25)`.

        ControlError, with what was expected, if it refuses the value.
        """
        device, key, value = written_point(point, *key_and_value)
        self.ask(f"device/{device}/set", {"values": {key: value}})

    def record(self, signals: str | Sequence[str], rhythm: Rhythm = "cycle") -> "Recording":
        """Record signals from now on, as `Rig.record` does, until the recording or the rig ends.

        What the host was too late for is missing, and counted in `lost`.
        """
        from fieldrig.recording.recording import LiveRecording  # only those who record need its formats

        return LiveRecording(self.endpoint, self.status()["rig"], *wish_of(signals, rhythm))

    def restart(self, name: str) -> None:
        """Switch a device off and on again; it keeps its non-volatile memory and its faults.

        The name of a bus or a process, or a device that hangs, starts its process again, and this waits until that is
        ready.  ControlError for any other name, and for a device that a fault has switched off; RigError if the process
        or the rig ends instead.
        """
        status = self.status()
        restarted = self.ask("rig/restart", {"name": name})
        while "process" in restarted and not self._has_restarted(name, status["processes"]):
            self._check_lives(f"while {name} was restarted")
            time.sleep(POLL_S)

    def _has_restarted(self, name: str, before: Mapping[str, Any]) -> bool:
        try:
            now = self.status()["processes"]
        except ControlError:  # the rig ends
            return False
        for process, entry in now.items():
            if name in (process, *entry["devices"], *entry["buses"]):
                if entry["state"] == "gone":
                    raise RigError(f"{name} has not started again:\n{self.output()}")
                if entry["restarts"] == before[process]["restarts"]:
                    return False
        return all(entry["state"] in ("ready", "gone") for entry in now.values())

    def add_fault(self, where: str, fault: Mapping[str, Any]) -> int:
        """Add a fault of a bus or a device from now on, and return its number.

        ControlError for one that it refuses.
        """
        number: int = self._about_faults(where, "add_fault", {"fault": dict(fault)})["number"]
        return number

    def clear_fault(self, where: str, number: int) -> None:
        """Remove a fault of a bus or a device.  ControlError if there is none of this number."""
        self._about_faults(where, "clear_fault", {"number": number})

    def faults(self, where: str) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults of a bus or a device that were added and not cleared, by number."""
        found: Mapping[str, Mapping[str, Any]] = self._about_faults(where, "faults")
        return {int(number): fault for number, fault in found.items()}

    def _about_faults(self, where: str, verb: str, message: Any = None) -> Any:
        with self._connected() as client:
            return ask(client, about_faults(where, verb, message))

    def _wait_until_ready(self) -> None:
        """Wait as long as the process lives; a rig that cannot start ends by its own `start_timeout_s`."""
        while not self._is_ready():
            self._check_lives("before it was ready")
            time.sleep(POLL_S)

    def _check_lives(self, when: str) -> None:
        if (code := self.process.poll()) is not None:
            raise RigError(f"the rig ended with exit code {code} {when}:\n{self.output()}")

    def _is_ready(self) -> bool:
        try:
            status = self.status()
        except ControlError:
            return False
        return bool(status["pid"] == self.process.pid and status["state"] == "ready")
