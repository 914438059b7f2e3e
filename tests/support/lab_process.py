"""The lab as a user has it: `fieldrig up configs/lab.yaml` in a process of its own, on ports that are free."""

import socket
import stat
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

from patience import PATIENCE_S
from running_rig import AskedRig, is_running, until

from fieldrig.errors import ControlError
from fieldrig.testing import free_port

CONFIGS = Path(__file__).parents[2] / "configs"
LAB, LAB_ON_VCAN = CONFIGS / "lab.yaml", CONFIGS / "lab-vcan.yaml"
IO32, LEVEL_SENSOR = CONFIGS / "eds" / "io32.eds", CONFIGS / "eds" / "level-sensor.eds"

# What every test finds: 0.5 m in the tank, nothing that moves it, and the drive as its table has it.
AT_REST: dict[str, bool | int | float] = {
    "drive/run": False,
    "drive/speed_set": 0.0,
    "drive/ramp_time": 5.0,
    "drive/level_limit": 1.8,
    "io/6411:01": 0,
    "tank/level": 0.5,
}


class LabProcess(AskedRig):
    def __init__(self, file: Path = LAB, can0: str | None = None, **more: object) -> None:
        """`can0` is a CAN bus that replaces the lab's hub; `more` are keys of the rig file and their values."""
        self.modbus_port, self.socketcand_port, self.slcan_port = free_port(), free_port(), free_port()
        places = {"buses.mb_tcp.listen": f"127.0.0.1:{self.modbus_port}", **more}
        if can0 is not None:
            places["buses.can0"] = can0
        elif file == LAB:
            places["buses.can0.socketcand"] = f"127.0.0.1:{self.socketcand_port}"
            places["buses.can0.slcan"] = f'{{path: slcan, listen: "127.0.0.1:{self.slcan_port}"}}'
        sets = [word for key, place in places.items() for word in ("--set", f"{key}={place}")]
        super().__init__(file, None, *sets)

    @property
    def run(self) -> Path:
        return self.folder / "run" / self.file.stem

    @property
    def modbus_pty(self) -> Path:
        return self.run / "modbus-rtu"

    @property
    def slcan_pty(self) -> Path:
        return self.run / "slcan"

    def until_ready(self) -> Self:
        """Wait for the line that tells a user that the rig is ready."""
        until(lambda: self.process.poll() is not None or "\nready in " in self.output())
        assert self.process.poll() is None, self.output()
        return self

    def do(self, line: str) -> str:
        """Return the output of a shell in the lab's folder for a line, which must succeed."""
        done = subprocess.run(
            ["bash", "-c", line], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout.strip()

    def rest(self) -> None:
        until(lambda: all(process["state"] == "ready" for process in self._processes().values()))
        for point, value in AT_REST.items():
            self.set(point, value)

    def pids(self) -> dict[str, int]:
        return {name: process["pid"] for name, process in self._processes().items()}

    def restarts(self, process: str) -> int:
        restarts: int = self._processes()[process]["restarts"]
        return restarts

    def until_back(self, process: str, restarts: int = 1) -> None:
        def is_back() -> bool:
            now = self._processes()[process]
            return bool(now["restarts"] >= restarts and now["state"] == "ready")

        until(is_back)

    def until_true(self, condition: Callable[[], bool]) -> None:
        """Wait as `until` does, while the rig may be busy, or a device absent."""

        def is_true() -> bool:
            try:
                return condition()
            except ControlError:
                return False

        until(is_true)

    def left_behind(self, pids: dict[str, int]) -> list[str]:
        """Return what an ended lab should have removed: processes, sockets, links to ptys, ports."""
        files = [path for path in self.run.rglob("*") if path.is_symlink() or stat.S_ISSOCK(path.lstat().st_mode)]
        ports = (self.modbus_port, self.socketcand_port, self.slcan_port, int(self.endpoint.rpartition(":")[2]))
        return [
            *(name for name, pid in pids.items() if is_running(pid)),
            *map(str, files),
            *(f"port {port}" for port in ports if _is_listened_at(port)),
        ]

    def _processes(self) -> dict[str, dict[str, Any]]:
        processes: dict[str, dict[str, Any]] = self.control.ask("rig/status")["processes"]
        return processes


def _is_listened_at(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
