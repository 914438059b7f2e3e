"""A controller that is flooded: the cycles of its ring while one of its faces gets more than it can answer.

The rig is `configs/conveyor.yaml` with every face that a MAx-4 has.  Clients flood one face after another with valid
requests, at a lower priority than the rig, as a flood comes from another machine.  What the ring keeps is compared with
its cycles without a flood, before and after it in the same run.  Beside it, a client that asks now and then measures
how long it waits for its answers.
"""

import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory
from typing import Any

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import Report, percentile, progress  # noqa: E402  found beside this file
from running_rig import AskedRig  # noqa: E402

from fieldrig.testing import free_port  # noqa: E402

CONVEYOR = HERE.parents[1] / "configs/conveyor.yaml"
SECONDS = 5.0
CYCLE_S = 0.004
SETTLING_S = 5.0
"""After its start the ring makes up for cycles that the start has cost."""
CLIENTS = 30
POLITE_S = 0.05
READ = bytes.fromhex("0001 0000 0006 01 03 0000 000a")  # ten registers
HELLO = bytes.fromhex("48454c46 20000000 00000000 ffff0000 ffff0000 00000000 00000000 ffffffff")
FACES = """
extends: {conveyor}
control: {control}
buses:
  can0: {{socketcand: "127.0.0.1:{socketcand}", slcan: {{listen: "127.0.0.1:{lawicel}"}}}}
  modbus: {{listen: "127.0.0.1:{modbus}"}}
  lan: {{kind: tcp.server, listen: {{http: "127.0.0.1:{http}", ftp: "127.0.0.1:{ftp}"}}}}
  opcua: {{kind: opcua.server, listen: "127.0.0.1:{opcua}"}}
devices:
  max4:
    links: {{tcp: lan, opcua: opcua}}
    ftp: {{user_name: service, password: plc}}
"""


@dataclass(frozen=True)
class Face:
    """A port, what opens a connection to it, and what it is flooded with."""

    name: str
    port: str
    opening: bytes
    flood: bytes


FLOODED = (
    Face("Modbus TCP, FC 3", "modbus", b"", READ),
    Face("HTTP, GET of a page", "http", b"", b"GET / HTTP/1.1\r\nHost: plc\r\n\r\n"),
    Face("FTP, NOOP", "ftp", b"USER service\r\nPASS plc\r\n", b"NOOP\r\n"),
    Face("OPC UA, HEL", "opcua", b"", HELLO),
    Face("socketcand, send", "socketcand", b"< open can0 >", b"< send 7a0 8 1 2 3 4 5 6 7 8 >"),
    Face("Lawicel, t", "lawicel", b"O\r", b"t7a081122334455667788\r"),
)
CONTROL = "control endpoint, get"

# Runs in a process of its own: what it takes of the host must not be the bench's.
CLIENT = """
import os, socket, sys, threading, time
os.nice(10)
port, clients, seconds = int(sys.argv[1]), int(sys.argv[4]), float(sys.argv[5])
opening, flood = map(bytes.fromhex, sys.argv[2:4])
end_s = time.monotonic() + seconds
def read(client):
    try:
        while client.recv(1 << 16):
            pass
    except OSError:
        pass
def run():
    while time.monotonic() < end_s:
        try:
            client = socket.create_connection(("127.0.0.1", port))
            client.settimeout(1.0)
            threading.Thread(target=read, args=(client,), daemon=True).start()
            client.sendall(opening)
            rest = b""
            while time.monotonic() < end_s:
                rest = rest or flood * (1 + 4096 // len(flood))
                try:
                    rest = rest[client.send(rest):]
                except TimeoutError:
                    pass
        except OSError:
            time.sleep(0.05)
for _ in range(clients):
    threading.Thread(target=run, daemon=True).start()
time.sleep(max(0.0, end_s - time.monotonic()))
os._exit(0)
"""
ASKER = """
import os, sys, time
os.nice(10)
from fieldrig.control.messages import Client, key
end_s = time.monotonic() + float(sys.argv[2])
with Client(sys.argv[1]) as client:
    while time.monotonic() < end_s:
        waiting = [client.session.get(key("*", "device/max4/get"), payload='{"keys": ["plc/state"]}', timeout=1.0)
                   for _ in range(200)]
        for replies in waiting:
            for _ in replies:
                pass
os._exit(0)
"""


class FloodedRig(AskedRig):
    """The rig, and what its ring keeps."""

    def __init__(self, folder: Path) -> None:
        names = ("control", "socketcand", "lawicel", "modbus", "http", "ftp", "opcua")
        self.ports = {name: free_port() for name in names}
        file = folder / "flooded.yaml"
        control = f"tcp/127.0.0.1:{self.ports.pop('control')}"
        file.write_text(FACES.format(conveyor=CONVEYOR, control=control, **self.ports))
        super().__init__(file, None)
        self.until_ready()
        time.sleep(SETTLING_S)

    def figures(self) -> dict[str, dict[str, Any]]:
        """Return the status of all processes."""
        return self.control.ask_all("process/*/status", timeout_s=20.0)

    def cycles(self) -> tuple[float, float]:
        """Return the cycles of the ring so far, and the time."""
        statistics = self.control.ask("bus/ring/status", timeout_s=20.0)
        return float(statistics["cycles"]), time.monotonic()

    def kept_percent(self, seconds: float) -> float:
        """Return the share of its cycles that the ring keeps in this time."""
        before, began_s = self.cycles()
        time.sleep(seconds)
        after, ended_s = self.cycles()
        return 100 * (after - before) * CYCLE_S / (ended_s - began_s)

    def memory_mb(self) -> float:
        """Return the memory of the largest process."""
        return max(float(figures["memory_mb"]) for figures in self.figures().values())


def waits_ms(port: int, stop: threading.Event) -> Iterator[float]:
    """Yield how long a client of Modbus waits for an answer that it asks for now and then."""
    with socket.create_connection(("127.0.0.1", port)) as client:
        client.settimeout(30.0)
        while not stop.wait(POLITE_S):
            began_s = time.monotonic()
            client.sendall(READ)
            client.recv(64)
            yield 1000 * (time.monotonic() - began_s)


@contextmanager
def polite(port: int) -> Iterator[list[float]]:
    """Collect the waits of such a client."""
    stop, waits = threading.Event(), list[float]()
    asking = threading.Thread(target=lambda: waits.extend(waits_ms(port, stop)))
    asking.start()
    try:
        yield waits
    finally:
        stop.set()
        asking.join()


def flooding(face: Face, port: int) -> list[str]:
    parts = (face.opening.hex(), face.flood.hex(), str(CLIENTS), str(SECONDS + 2))
    return [sys.executable, "-c", CLIENT, str(port), *parts]


def measure(rig: FloodedRig, name: str, command: list[str], report: Report) -> None:
    quiet = rig.kept_percent(SECONDS / 2)
    flood = subprocess.Popen(command)
    time.sleep(1.0)
    with polite(rig.ports["modbus"]) as waits:
        flooded = rig.kept_percent(SECONDS)
    flood.wait()
    quiet = mean((quiet, rig.kept_percent(SECONDS / 2)))
    waited = f"{percentile(waits, 50):.1f} / {percentile(waits, 99):.0f} ms"
    report.add(name, f"{flooded:.1f} %", f"{quiet:.1f} %", flooded / quiet, waited, f"{rig.memory_mb():.0f} MB")


def run() -> Report:
    report = Report(
        "A flooded controller",
        f"`configs/conveyor.yaml`, a MAx-4 with four drives at 4 ms. {CLIENTS} clients flood one of its faces with "
        "valid requests, without waiting for answers. The aim is 0.95 of the cycles that the quiet ring keeps.",
        ("face", "cycles kept", "quiet ring", "ratio", "another Modbus client waits (p50 / p99)", "largest process"),
    )
    with TemporaryDirectory(prefix="flood") as folder, FloodedRig(Path(folder)) as rig:
        cases = {face.name: flooding(face, rig.ports[face.port]) for face in FLOODED}
        cases[CONTROL] = [sys.executable, "-c", ASKER, rig.endpoint, str(SECONDS + 2)]
        for name, command in cases.items():
            progress(f"flood of {name}")
            measure(rig, name, command, report)
        reached = {
            f"{bus}: {limit} {count:.0f}"
            for figures in rig.figures().values()
            for bus, counters in figures["buses"].items()
            for limit, count in counters.items()
            if limit.startswith(("clients", "times", "connections"))
        }
    report.notes.append(f"Limits that were reached, as `fieldrig status` shows them: {', '.join(sorted(reached))}.")
    return report


if __name__ == "__main__":
    print(run().markdown())
