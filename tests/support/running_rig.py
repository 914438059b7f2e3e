"""`fieldrig up` as a user runs it: a process of its own, in a folder and at a control endpoint of its own."""

import json
import re
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

import forked_cli
from patience import PATIENCE_S

from fieldrig.control.messages import Client
from fieldrig.errors import ControlError
from fieldrig.real.live_rig import UpProcess

CPU = Path("/proc/cpuinfo")
IN_GUEST = CPU.exists() and "User Mode Linux" in CPU.read_text(encoding="utf-8")


class RunningRig(UpProcess):
    """A rig in a folder of its own, which is also the current folder of its tools.  It need not be ready."""

    longest_end_s = PATIENCE_S

    def __init__(
        self, rig: str | Path, kinds: Path | None, *options: str, environment: dict[str, str] | None = None
    ) -> None:
        """`rig` is a rig file or its text; `kinds` is a module with the rig file's own kinds."""
        super().__init__(environment)
        self.file = rig if isinstance(rig, Path) else self.folder / "lab.yaml"
        if isinstance(rig, str):
            self.file.write_text(rig)
        if kinds is not None:
            (self.folder / kinds.name).symlink_to(kinds)
        self.process = self.up(*options)

    def up(self, *options: str) -> subprocess.Popen[bytes]:
        """Start another `fieldrig up` with the same file; the first is `process`."""
        return self.start_up(self.file, *options, folder=self.folder)

    def start_up(self, file: Path, *options: str, folder: Path | None = None) -> subprocess.Popen[bytes]:
        """Start `fieldrig up` in a fork: a rig is what it is after it has imported its modules.

        In user-mode Linux it is a program: the process to fork has more modules than the rig needs, and without byte
        code they take two minutes there, those of the rig one.
        """
        if IN_GUEST:
            return super().start_up(file, *options, folder=folder)
        with self._output.open("ab") as output:
            return forked_cli.start(("up", str(file), *options), folder, self.environment, output.fileno())

    @property
    def run(self) -> Path:
        return self.folder / "run/lab"

    def log(self, process: str) -> str:
        return (self.run / f"log/{process}.log").read_text()

    def tool(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run another command to its end."""
        return forked_cli.run(arguments, self.folder, self.environment, limit_s=PATIENCE_S)

    def lines(self) -> dict[str, str]:
        """Return the lines that `help` prints to be copied, by part and label, such as "io start it"."""
        status = self.status()
        return {
            f"{part} {label}": line
            for part in (*status["buses"], *status["devices"])
            for label, line in re.findall(r"^  (\S.*)\n      (.*)$", self.tool("help", part).stdout, re.MULTILINE)
        }

    def json(self, *arguments: str) -> Any:
        done = self.tool(*arguments, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

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
        """Wait until the control service answers; processes may still be starting."""
        until(lambda: self._state() != "")

    def _state(self) -> str:
        try:
            return str(self.status()["state"])
        except ControlError:
            return ""

    def until_back(self, process: str, restarts: int = 1) -> None:
        """Wait until the process was restarted so often and is ready."""

        def is_back() -> bool:
            now = self.status()["processes"][process]
            return bool(now["restarts"] >= restarts and now["state"] == "ready")

        until(is_back)

    def ended(self) -> int:
        """Wait for the end, and return the exit code."""
        return self.process.wait(PATIENCE_S)

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        self.process.send_signal(number)
        return self.ended()


class AskedRig(RunningRig):
    """A running rig with one session for many questions; each run of `fieldrig` would take 0.2 s."""

    _client: Client | None = None

    def get(self, point: str) -> Any:
        device, _, key = point.partition("/")
        return self.control.ask(f"device/{device}/get", {"keys": [key]}, PATIENCE_S)[key]

    def set(self, point: str, value: bool | int | float | str) -> None:
        device, _, key = point.partition("/")
        self.control.ask(f"device/{device}/set", {"values": {key: value}}, PATIENCE_S)

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
    """Wait until the condition holds, and fail after `PATIENCE_S`."""
    give_up_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < give_up_s, "the condition never became true"
        time.sleep(0.02)


def is_running(pid: int) -> bool:
    """Return whether the process runs; a zombie does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
