"""`fieldrig up` as a user runs it: a process of its own, in a folder and at a control endpoint of its own."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from fieldrig.control import Client
from fieldrig.errors import ControlError
from fieldrig.testing import free_port

FIELDRIG = [sys.executable, "-m", "fieldrig"]
PATIENCE_S = 120.0


class RunningRig:
    """Its folder is short, as Unix sockets ask for, and is where its tools run too."""

    def __init__(
        self, rig: str | Path, kinds: Path | None, *options: str, environment: dict[str, str] | None = None
    ) -> None:
        """`rig` is a rig file or its text; `kinds` is a module that the rig file's own kinds come from."""
        self._temporary = tempfile.TemporaryDirectory(prefix="rig")
        self.folder = Path(self._temporary.name)
        self.file = rig if isinstance(rig, Path) else self.folder / "lab.yaml"
        if isinstance(rig, str):
            self.file.write_text(rig)
        if kinds is not None:
            (self.folder / kinds.name).symlink_to(kinds)
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.environment = {**os.environ, "FIELDRIG_CONTROL": self.endpoint, **(environment or {})}
        self._output = self.folder / "up.out"
        self.process = self.up(*options)

    def up(self, *options: str) -> subprocess.Popen[bytes]:
        """Another `fieldrig up` on the same file; the first one is `process`."""
        with self._output.open("ab") as output:
            return subprocess.Popen(
                [*FIELDRIG, "up", str(self.file), *options],
                cwd=self.folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def run(self) -> Path:
        return self.folder / "run/lab"

    def output(self) -> str:
        """What all `up` printed so far."""
        return self._output.read_text()

    def log(self, process: str) -> str:
        return (self.run / f"log/{process}.log").read_text()

    def tool(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """One other command, to its end."""
        return subprocess.run(
            [*FIELDRIG, *arguments],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )

    def json(self, *arguments: str) -> Any:
        done = self.tool(*arguments, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    def ask(self, path: str, message: Any = None) -> Any:
        """What a tool asks, without the start of a process for it."""
        with Client(self.endpoint) as client:
            return client.ask(path, message)

    def status(self) -> dict[str, Any]:
        status: dict[str, Any] = self.ask("rig/status")
        return status

    def pid(self, process: str) -> int:
        pid: int = self.status()["processes"][process]["pid"]
        return pid

    def value(self, point: str) -> Any:
        device, _, key = point.partition("/")
        return self.ask(f"device/{device}/get", {"keys": [key]})[key]

    def until_ready(self) -> Self:
        until(lambda: self.process.poll() is not None or self._state() == "ready")
        assert self.process.poll() is None, self.output()
        return self

    def until_there(self) -> None:
        """Its control service answers; its processes may be starting."""
        until(lambda: self._state() != "")

    def _state(self) -> str:
        try:
            return str(self.status()["state"])
        except ControlError:
            return ""

    def until_back(self, process: str, restarts: int = 1) -> None:
        """Started again so many times, and ready."""

        def is_back() -> bool:
            now = self.status()["processes"][process]
            return bool(now["restarts"] >= restarts and now["state"] == "ready")

        until(is_back)

    def ended(self) -> int:
        """The exit code, when it comes."""
        return self.process.wait(PATIENCE_S)

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        self.process.send_signal(number)
        return self.ended()

    def close(self) -> None:
        if self.process.poll() is None:
            self.end()
        self._temporary.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()


class AskedRig(RunningRig):
    """With one session for the many small questions of a test; a `fieldrig` each would take 0.2 s."""

    _client: Client | None = None

    def get(self, point: str) -> Any:
        device, _, key = point.partition("/")
        return self.control.ask(f"device/{device}/get", {"keys": [key]})[key]

    def set(self, point: str, value: bool | int | float | str) -> None:
        device, _, key = point.partition("/")
        self.control.ask(f"device/{device}/set", {"values": {key: value}})

    @property
    def control(self) -> Client:
        if self._client is None:
            self._client = Client(self.endpoint)
        return self._client

    def close(self) -> None:
        if self._client is not None:
            self._client.__exit__()
            self._client = None
        super().close()


def until(condition: Callable[[], bool]) -> None:
    """Wait for it, and fail if it doesn't come in a generous time."""
    give_up_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < give_up_s, "it did not come"
        time.sleep(0.02)


def is_running(pid: int) -> bool:
    """Dead processes that nobody has waited for yet don't count."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
