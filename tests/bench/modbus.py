"""Modbus TCP, function 3 of 10 registers: our server, pymodbus' asyncio server, libmodbus' C server; one load for all.

Ours is the real thing: kind, hub and device, with every check of the specification on, turnaround 0.  The servers take
turns, several rounds, and the best of each counts: what else runs on the machine only ever takes away.  pymodbus runs
as its users run it, and on uvloop too, as ours does.
"""

import asyncio
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from operator import attrgetter
from pathlib import Path
from shutil import which
from typing import NamedTuple

import uvloop
from report import Report, progress

HERE = Path(__file__).parent
CLIENTS = (1, 8, 32)
ROUNDS = 5
SECONDS = 0.4
TABLE = "holding_registers: [{address: 0, name: value, count: 1000}]"
LIVING_TABLE = """
holding_registers:
  - {address: 0, name: value, count: 1000, source: {kind: sine, low: 0, high: 9999, period_ms: 60000}}
"""
OURS, LIVING = "fieldrig", "fieldrig, 1,000 living values"
PYMODBUS, PYMODBUS_UVLOOP, LIBMODBUS = "pymodbus", "pymodbus on uvloop", "libmodbus (C)"


class Measured(NamedTuple):
    answers: float
    per_s: float
    p50_us: float
    p99_us: float
    cpu_us: float
    """CPU time of the server per answer."""


async def serve_fieldrig(table_text: str) -> None:
    from fieldrig.hub.hub import LocalHub
    from fieldrig.loop.real_clock import RealClock
    from fieldrig.storage.store import MemoryStore
    from fieldrig_bus.modbus.tcp import ModbusTcp, ModbusTcpSettings, TcpPort
    from fieldrig_devices.modbus.device import ModbusDevice, ModbusDeviceSettings

    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "table.yaml"
        table.write_text(table_text)
        clock = RealClock(asyncio.get_running_loop())
        settings = ModbusTcpSettings(listen="127.0.0.1:0")
        hub = LocalHub(ModbusTcp("mb", settings), clock, Path(folder))
        device = ModbusDevice(
            clock, ModbusDeviceSettings(table=table, turnaround_ms=0), [hub.join("device")], MemoryStore()
        )
        port = TcpPort(settings)
        await port.open(hub)
        device.start()
        announce(port.number)
        await asyncio.Event().wait()


async def serve_pymodbus() -> None:
    from pymodbus.server import ModbusTcpServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    device = SimDevice(1, simdata=[SimData(0, count=100, values=0, datatype=DataType.REGISTERS)])
    with socket.socket() as probe:  # it doesn't say which port it was given
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    server = ModbusTcpServer(device, address=("127.0.0.1", port))
    await server.serve_forever(background=True)
    announce(port)
    await asyncio.Event().wait()


def announce(port: int) -> None:
    print(port, flush=True)


@contextmanager
def serving(command: list[str]) -> Iterator[tuple[int, int]]:
    """The server's port and process id."""
    # pymodbus complains at length on stderr of every client that leaves.
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        try:
            assert server.stdout is not None
            yield int(server.stdout.readline()), server.pid
        finally:
            server.terminate()


def compiled(folder: Path, name: str, *libraries: str) -> str | None:
    """The program made from `name`.c; None without a compiler or a library."""
    program = folder / name
    command = ["gcc", "-O2", "-o", str(program), str(HERE / f"{name}.c"), *libraries]
    if which("gcc") is None or subprocess.run(command, capture_output=True).returncode != 0:
        return None
    return str(program)


def measure(load: list[str], port: int, pid: int, clients: int) -> Measured:
    before_ns = cpu_ns(pid)
    command = [*load, str(port), str(clients), str(SECONDS)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, timeout=60)
    answers, per_s, p50_us, p99_us = map(float, done.stdout.split())
    return Measured(answers, per_s, p50_us, p99_us, (cpu_ns(pid) - before_ns) / 1e3 / answers)


def cpu_ns(pid: int) -> int:
    """CPU time of a process with one thread, user and system."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text(encoding="utf-8").split()[0])
    except OSError:  # Linux only
        return 0


def run() -> Report:
    report = Report(
        "Modbus TCP",
        f"This table compares Modbus servers: function 3 with 10 registers, one outstanding request per client, best"
        f" of {ROUNDS} rounds of {SECONDS:g} s.",
        ("server", *(f"{clients} clients" if clients > 1 else "1 client" for clients in CLIENTS), "CPU per request"),
    )
    with tempfile.TemporaryDirectory() as folder:
        program = compiled(Path(folder), "modbus_load")
        load = [program] if program is not None else [sys.executable, str(HERE / "modbus_load.py")]
        if program is None:
            report.notes.append(
                "there is no C compiler on this host: a Python client made the load and limits the result"
            )
        commands = {
            name: [sys.executable, __file__, "--serve", name] for name in (OURS, LIVING, PYMODBUS, PYMODBUS_UVLOOP)
        }
        libmodbus = compiled(Path(folder), "modbus_libmodbus", "-lmodbus")
        if libmodbus is None:
            report.notes.append("libmodbus was not measured: it needs gcc and libmodbus-dev (Debian)")
        else:
            commands[LIBMODBUS] = [libmodbus]
        results: dict[tuple[str, int], list[Measured]] = {}
        for round_ in range(ROUNDS):
            for name, command in commands.items():
                progress(f"Modbus TCP: {name}, round {round_ + 1} of {ROUNDS}")
                with serving(command) as (port, pid):
                    for clients in CLIENTS:
                        results.setdefault((name, clients), []).append(measure(load, port, pid, clients))
    fill(report, list(commands), {key: max(several, key=attrgetter("per_s")) for key, several in results.items()})
    return report


def fill(report: Report, names: list[str], results: dict[tuple[str, int], Measured]) -> None:
    most = CLIENTS[-1]
    for name in names:
        cells = [f"{row.per_s:,.0f}/s ({row.p50_us:.0f}/{row.p99_us:.0f} us)" for row in
                 (results[name, clients] for clients in CLIENTS)]  # fmt: skip
        report.add(name, *cells, f"{results[name, most].cpu_us:.1f} us")
    for name in names[1:]:
        ratios = [f"{results[OURS, clients].per_s / results[name, clients].per_s:.2f}" for clients in CLIENTS]
        report.add(f"{OURS} : {name}", *ratios, f"{results[OURS, most].cpu_us / results[name, most].cpu_us:.2f}")
    report.notes.append(
        f"in brackets: p50/p99 of the round trip; the CPU time is that of the server with {most} clients"
    )


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--serve", name] if name == OURS:
            uvloop.run(serve_fieldrig(TABLE))
        case ["--serve", name] if name == LIVING:
            uvloop.run(serve_fieldrig(LIVING_TABLE))
        case ["--serve", name] if name == PYMODBUS:
            asyncio.run(serve_pymodbus())
        case ["--serve", name] if name == PYMODBUS_UVLOOP:
            uvloop.run(serve_pymodbus())
        case _:
            print(run().markdown())
