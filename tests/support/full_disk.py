"""Run on a small disk that is full for a while: `python full_disk.py KIND FOLDER`, where FOLDER is that disk.

KIND is a kind of device that stores, or `rig`: then a whole rig runs there, as a user runs it.
"""

import socket
import sys
import tempfile
from pathlib import Path

from running_rig import RunningRig, until
from storing_devices import KINDS, TABLE, disk_test

from fieldrig.storage.store import FileStore
from fieldrig.testing import free_port

RIG = """
time: real
buses: {{mb: {{kind: modbus.tcp, listen: "127.0.0.1:{port}"}}}}
devices: {{drive: {{kind: modbus.device, table: {table}, turnaround_ms: 0, links: {{modbus: mb}}}}}}
"""


class Disk:
    def __init__(self, folder: Path) -> None:
        self._filler = folder / "filler"

    def fill(self, is_full: bool) -> None:
        """Fill the disk to its last byte."""
        if not is_full:
            self._filler.unlink()
            return
        with self._filler.open("wb", buffering=0) as file:
            for size in (65_536, 4_096, 1):
                try:
                    while True:
                        file.write(bytes(size))
                except OSError:
                    continue


def run_device(kind: str, folder: Path) -> None:
    disk, path = Disk(folder), folder / "state" / "device.bin"
    with disk_test(kind, lambda: FileStore(path, kind), disk.fill):
        assert FileStore(path, kind).load() is not None
    disk.fill(True)
    first = folder / "state" / "first.bin"
    device = KINDS[kind](FileStore(first, kind))  # its first start; a RAM in a hole of the disk would be SIGBUS
    answer = device.write(1)
    assert answer.startswith(device.refused), answer
    disk.fill(False)
    answer = device.write(2)
    assert answer.startswith(device.accepted), answer
    assert KINDS[kind](FileStore(first, kind)).read() == 2


class Master:
    def __init__(self, port: int) -> None:
        self._end = socket.create_connection(("127.0.0.1", port))
        self._end.settimeout(30)

    def ask(self, pdu: str) -> str:
        body = bytes.fromhex(pdu)
        self._end.sendall(bytes((0, 1, 0, 0, 0, 1 + len(body), 1)) + body)
        head = self._receive(7)
        return self._receive(int.from_bytes(head[4:6], "big") - 1).hex()

    def _receive(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            more = self._end.recv(size - len(data))
            assert more, "the connection was closed"
            data += more
        return data


def run_rig(folder: Path) -> None:
    tempfile.tempdir = str(folder)  # where the rig has its folder, its logs and its trace
    disk, port = Disk(folder), free_port()
    table = folder / "table.yaml"
    table.write_text(TABLE)
    with RunningRig(RIG.format(port=port, table=table), None, "--trace", "all.jsonl") as rig:
        rig.until_ready()
        master = Master(port)
        assert master.ask("06 0000 0001") == "0600000001"
        disk.fill(True)
        for _ in range(200):  # more than a page of the trace
            assert master.ask("06 0000 0002") == "8604"
            assert master.ask("03 0000 0001") == "03020001"
        assert (rig.json("status")["state"], rig.json("status")["stores"]) == (
            "degraded",
            {"drive": "No space left on device"},
        )
        assert "drive cannot store anything: No space left on device" in rig.tool("status").stdout
        assert rig.log("drive").count("cannot be stored") == 1, rig.log("drive")
        disk.fill(False)
        assert rig.json("status")["state"] == "ready"
        assert master.ask("06 0000 0003") == "0600000003"
        assert rig.log("drive").count("can be stored again") == 1, rig.log("drive")
        until(lambda: "writing continues" in rig.output())
        assert master.ask("06 0000 0004") == "0600000004"
        assert rig.tool("stop").returncode == 0
        assert rig.process.wait(60) == 0, rig.output()
        assert "are missing: No space left on device" in rig.output()
        assert "Traceback" not in rig.output() + "".join(log.read_text() for log in (rig.run / "log").iterdir())
        shown = rig.tool("trace", "show", "all.jsonl")
        assert (shown.returncode, len(shown.stdout.splitlines()) > 4) == (0, True), shown.stderr


if __name__ == "__main__":
    if sys.argv[1] == "rig":
        run_rig(Path(sys.argv[2]))
    else:
        run_device(sys.argv[1], Path(sys.argv[2]))
