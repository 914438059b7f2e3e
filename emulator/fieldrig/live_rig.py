"""A rig in real time for the length of a test: `fieldrig up` in a process of its own, at a control endpoint of its own.

Several test processes can run rigs side by side.  A `LiveRig` is ready only when the rig that answers at its endpoint
is the process that it started, so it never takes another test's rig for its own.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from fieldrig.control import Client
from fieldrig.device import Value
from fieldrig.errors import ControlError, RigError
from fieldrig.net import ENDPOINT_VARIABLE
from fieldrig.testing import free_port

LOOK_S = 0.05
"""How often a starting rig is asked for its state."""
END_S = 30.0
"""How long a rig may take to end in order before it is killed."""


class LiveRig:
    """Use it in a `with`, or close it: the rig ends then."""

    def __init__(self, file: Path, *overrides: str) -> None:
        """Start `file` with `overrides` such as "buses.mb_tcp.listen=127.0.0.1:5021", and wait until it is ready.

        RigError, with everything that the rig printed, if it ends before that.
        """
        self._temporary = tempfile.TemporaryDirectory(prefix="rig")  # a short path, as Unix sockets need it
        folder = Path(self._temporary.name)
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        """The control endpoint, for `fieldrig --control` and `FIELDRIG_CONTROL`."""
        self.run = folder / "run"
        """The run folder, with ptys and log/."""
        self._output = folder / "output"
        settings = [f"run={self.run}", *overrides]
        command = [sys.executable, "-m", "fieldrig", "up", str(file), *(f"--set={setting}" for setting in settings)]
        with self._output.open("wb") as output:
            self.process = subprocess.Popen(
                command,
                env={**os.environ, ENDPOINT_VARIABLE: self.endpoint},
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        try:
            self._wait_until_ready()
        except BaseException:
            self.close()
            raise

    def get(self, device: str, key: str) -> Value:
        """The present value of a point.  ControlError if there is none of that name."""
        value: Value = self._ask(f"device/{device}/get", {"keys": [key]})[key]
        return value

    def set(self, device: str, key: str, value: Value) -> None:
        """Write a point.  ControlError, with what was expected, if it can't take the value."""
        self._ask(f"device/{device}/set", {"values": {key: value}})

    def status(self) -> dict[str, Any]:
        """What `fieldrig status --json` shows of the rig and its processes."""
        status: dict[str, Any] = self._ask("rig/status")
        return status

    def output(self) -> str:
        """Everything that `fieldrig up` has printed so far."""
        return self._output.read_text(encoding="utf-8")

    def close(self) -> None:
        """End the rig in order, or by force after `END_S`.  Closing twice does no harm."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(END_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._temporary.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    def _wait_until_ready(self) -> None:
        """For as long as it lives; a rig that doesn't get ready ends by its own `start_timeout_s`."""
        while not self._is_ready():
            if (code := self.process.poll()) is not None:
                raise RigError(f"the rig ended with exit code {code} before it was ready:\n{self.output()}")
            time.sleep(LOOK_S)

    def _is_ready(self) -> bool:
        try:
            status = self.status()
        except ControlError:
            return False
        return bool(status["pid"] == self.process.pid and status["state"] == "ready")

    def _ask(self, path: str, message: Any = None) -> Any:
        with Client(self.endpoint) as client:
            return client.ask(path, message)
