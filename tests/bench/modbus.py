"""Modbus TCP, function 3 of 10 registers: our server, pymodbus' asyncio server, libmodbus' C server; one load for all.

Ours is the real thing: kind, hub and device, with every check of the specification on, turnaround 0.  The servers take
turns, several rounds, and the median counts: a shared machine changes its mind from second to second.
"""

import asyncio
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from statistics import median
from typing import NamedTuple

import uvloop
from report import Report, progress

HERE = Path(__file__).parent
CLIENTS = (1, 8, 32)
ROUNDS = 3
SECONDS = 0.7
TABLE = "holding_registers: [{address: 0, name: value, count: 100}]"
OURS, PYMODBUS, LIBMODBUS = "fieldrig", "pymodbus", "libmodbus (C)"


class Measured(NamedTuple):
    per_s: float
    p50_us: float
    p99_us: float


async def serve_fieldrig() -> None:
    from fieldrig.hub import LocalHub
    from fieldrig.real_clock import RealClock
    from fieldrig.store import MemoryStore
    from fieldrig_bus.modbus.tcp import ModbusTcp, ModbusTcpSettings, TcpPort
    from fieldrig_devices.modbus_device import ModbusDevice, ModbusDeviceSettings

    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "table.yaml"
        table.write_text(TABLE)
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
    server = ModbusTcpServer(device, address=("127.0.0.1", 0))
    await server.serve_forever(background=True)
    announce(server.transport.sockets[0].getsockname()[1])
    await asyncio.Event().wait()


def announce(port: int) -> None:
    print(port, flush=True)


@contextmanager
def serving(command: list[str]) -> Iterator[tuple[int, int]]:
    """The server's port and process id."""
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        yield int(server.stdout.readline()), server.pid
    finally:
        server.terminate()
        server.wait()
        assert server.stdout is not None
        server.stdout.close()


def compiled(folder: Path, name: str, *libraries: str) -> str | None:
    """The program made from `name`.c; None without a compiler or a library."""
    program = folder / name
    command = ["gcc", "-O2", "-o", str(program), str(HERE / f"{name}.c"), *libraries]
    if which("gcc") is None or subprocess.run(command, capture_output=True).returncode != 0:
        return None
    return str(program)


def measure(load: list[str], port: int, clients: int) -> Measured:
    done = subprocess.run(
        [*load, str(port), str(clients), str(SECONDS)], stdout=subprocess.PIPE, text=True, check=True, timeout=60
    )
    return Measured(*map(float, done.stdout.split()))


def cpu_s(pid: int) -> float:
    """CPU time of a process, user and system (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100  # USER_HZ is 100 wherever Python runs on Linux


def run() -> Report:
    report = Report(
        "Modbus TCP",
        f"Function 3 of 10 registers, one outstanding request per client, median of {ROUNDS} rounds of {SECONDS:g} s.",
        ("server", *(f"{clients} clients" if clients > 1 else "1 client" for clients in CLIENTS), "CPU a request"),
    )
    with tempfile.TemporaryDirectory() as folder:
        program = compiled(Path(folder), "modbus_load")
        load = [program] if program is not None else [sys.executable, str(HERE / "modbus_load.py")]
        if program is None:
            report.notes.append("there is no C compiler here: the load came from Python, and limits what is measured")
        commands = {name: [sys.executable, __file__, "--serve", name] for name in (OURS, PYMODBUS)}
        libmodbus = compiled(Path(folder), "modbus_libmodbus", "-lmodbus")
        if libmodbus is None:
            report.notes.append("libmodbus was not measured: it takes gcc and libmodbus-dev (Debian)")
        else:
            commands[LIBMODBUS] = [libmodbus]
        results: dict[tuple[str, int], list[Measured]] = {}
        cpu_us: dict[str, float] = {}
        for name, command in commands.items():
            cpu_us[name] = 0.0
        for round_ in range(ROUNDS):
            for name, command in commands.items():
                progress(f"Modbus TCP: {name}, round {round_ + 1} of {ROUNDS}")
                with serving(command) as (port, pid):
                    for clients in CLIENTS:
                        before_s = cpu_s(pid)
                        measured = measure(load, port, clients)
                        results.setdefault((name, clients), []).append(measured)
                        cpu_us[name] = 1e6 * (cpu_s(pid) - before_s) / (measured.per_s * (SECONDS + 0.2))
    fill(report, list(commands), results, cpu_us)
    return report


def fill(
    report: Report, names: list[str], results: dict[tuple[str, int], list[Measured]], cpu_us: dict[str, float]
) -> None:
    rates = {key: median(measured.per_s for measured in several) for key, several in results.items()}
    for name in names:
        cells = []
        for clients in CLIENTS:
            p50 = median(measured.p50_us for measured in results[name, clients])
            p99 = median(measured.p99_us for measured in results[name, clients])
            cells.append(f"{rates[name, clients]:,.0f}/s ({p50:.0f}/{p99:.0f} us)")
        report.add(name, *cells, f"{cpu_us[name]:.1f} us")
    for name in names[1:]:
        ratios = [f"{rates[OURS, clients] / rates[name, clients]:.2f}" for clients in CLIENTS]
        report.add(f"{OURS} : {name}", *ratios, f"{cpu_us[OURS] / cpu_us[name]:.2f}")
    report.notes.append("in brackets p50/p99 of the round trip; the CPU is the server's, at 32 clients")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--serve", "fieldrig"]:
            uvloop.run(serve_fieldrig())
        case ["--serve", "pymodbus"]:
            uvloop.run(serve_pymodbus())
        case _:
            print(run().markdown())
