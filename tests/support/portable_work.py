"""The work that needs no POSIX: `python portable_work.py SYSTEM SEEN FOLDER` writes its results to FOLDER as JSON.

SYSTEM is linux, win32 or darwin, and SEEN is `sys.platform` as our packages see it (`without_posix`).
"""

import _thread
import contextlib
import importlib
import io
import json
import os
import pkgutil
import re
import shutil
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import without_posix

CONFIGS: Final = Path(__file__).parents[2] / "configs"
POSIX_MODULES: Final = {
    "fieldrig.master_time.terminal_calls",
    "fieldrig.real.forked_child",
    "fieldrig.virtual.forked",
    "fieldrig_bus.can.socketcan_end",
    "fieldrig_bus.pty",
    "fieldrig_bus.ring.transport.shm",
}
"""The modules that only Linux, or POSIX, can import; others import them where they are needed."""

FIRST: Final = ("serial", "can.interfaces.socketcand", "pymodbus.client", "typer", "asyncua", "canopen", "distributed")
"""Foreign packages, which choose their code for the system when they are imported."""

FORMATS: Final = ("lab.pcapng", "lab.pcap", "lab.log", "lab.asc", "lab.blf", "lab.trc", "lab.csv", "lab.db", "lab.vcd")
OF_TRACES: Final = (
    "trace stats lab.jsonl",
    "trace show lab.blf --eds 5=eds/io32.eds",
    "diff lab.jsonl lab.jsonl",
    "replay lab.jsonl --rig lab.yaml --set time=virtual --play master",
    "new --from lab.log made/recorded",
)
PATIENCE_S: Final = 60.0
REAL_TIME: Final = re.compile(r"in [0-9.]+ s$", re.MULTILINE)

MASTER: Final = """\
import asyncio
import threading
import time

from pymodbus.client import AsyncModbusTcpClient, ModbusTcpClient

read = []

def poll():
    with ModbusTcpClient("127.0.0.1", port=5020) as drive:
        for _ in range(5):
            read.append(drive.read_input_registers(0).registers[0])
            time.sleep(1)

with ModbusTcpClient("127.0.0.1", port=5020) as drive:
    drive.write_register(0, 1000)
    drive.write_coil(0, True)
    poller = threading.Thread(target=poll)
    poller.start()
    poller.join()

async def again():
    async with AsyncModbusTcpClient("127.0.0.1", port=5020) as drive:
        return (await drive.read_input_registers(0)).registers

print(read, asyncio.run(again()), f"{time.monotonic():.6f}")
"""
CAN_MASTER: Final = """\
import canopen, time
network = canopen.Network()
network.connect(interface="socketcand", host="127.0.0.1", port=29536, channel="can0")
node = network.add_node(5, "eds/io32.eds")
print(hex(node.sdo.upload(0x1000, 0)[0]), f"{time.monotonic():.6f}")
network.disconnect()
"""
SERIAL_MASTER: Final = """\
import serial
import time

with serial.serial_for_url("fieldrig://com", 38400, timeout=1) as port:
    time.sleep(0.1)
    seen = [(port.cts, port.dsr, port.ri, port.cd)]
    port.write(b"AT&C0\\r")
    seen.append(port.read(11))
    seen.append(port.cd)
    port.write(b"AT&D2E0\\r")
    port.dtr = False
    port.send_break()
    time.sleep(0.5)
    port.dtr = True
    print(seen, port.read(100))
"""
SERIAL_RIG: Final = """\
buses:
  com: {kind: serial.virtual, baud: 38400}
  telephone: {kind: telephone.virtual, numbers: {office: "100"}}
devices:
  office: {kind: modem, links: {line: com, telephone: telephone}}
"""
PROGRAM: Final = """\
FUNCTION Twice : INT
VAR_INPUT
    x : INT;
END_VAR
Twice := 2 * x;
END_FUNCTION

PROGRAM Main
VAR
    n : INT;
END_VAR
n := Twice(n + 1);
END_PROGRAM

TEST 'it doubles' ASSERT_EQ(Twice(2), 4); END_TEST
"""
PLUGIN_TEST: Final = """\
import socket
import time

def test_a_rig(fieldrig_rig):
    rig = fieldrig_rig("lab.yaml")
    rig.set("drive/run", True)
    rig.run_until(10_000_000_000)
    assert rig.get("tank/level") > 0

def test_a_master(fieldrig_master):
    rig = fieldrig_master("lab.yaml")
    with socket.create_connection(("127.0.0.1", 5020)) as line:
        line.sendall(bytes.fromhex("0001 0000 0006 01 04 0000 0001"))
        assert line.recv(260).hex().startswith("000100000005010402")
    time.sleep(3600)
    assert rig.now_ns >= 3600_000_000_000
"""


def imported() -> list[str]:
    """Return the modules of the product that cannot be imported."""
    failed = []
    for package in map(importlib.import_module, without_posix.OURS):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                try:
                    importlib.import_module(module.name)
                except (ImportError, AssertionError):
                    failed.append(module.name)
    return failed


def rigs() -> dict[str, Any]:
    """Return the hash of the messages of each shipped rig."""
    from shipped import RIGS, in_virtual_time

    from fieldrig.virtual.rig import Rig

    found = {}
    for name in RIGS:
        with Rig(in_virtual_time(name)) as rig:
            rig.trace_hash()
            rig.run_until(500_000_000)
            found[name] = rig.trace_hash()
    return found


def command(*arguments: str) -> list[Any]:
    """Return the exit code of `fieldrig`, and what it has printed."""
    from fieldrig.cli import app, outcome

    sys.argv = ["fieldrig", *arguments]
    written = io.BytesIO()
    out = io.TextIOWrapper(written, encoding="utf-8")
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        code = outcome._run(app.app)
    out.flush()
    said = written.getvalue().decode()
    return [code, REAL_TIME.sub("...", said)]


def commands() -> dict[str, Any]:
    """Return what commands say that need no running rig; the current folder is a copy of `configs`."""
    lines = (
        "check lab.yaml arp-cell.yaml pam-machine.yaml",
        "devices max4",
        "eds check eds/io32.eds",
        "iec check made/main.st",
        "iec run made/main.st --for 100ms",
        "iec test made/main.st",
        "pam check programs/labeller.pam",
        "pam run programs/labeller.pam --for 100ms",
        "arp compile programs/line.I01",
        "new energy-meter made/meter",
        "draw --rig lab.yaml lab.svg",
        "conform --rig lab.yaml --set time=virtual --bus can0 --node 5 --only SDO*",
        "iec test made/main.st --coverage",
        "iec mutate made/main.st -j 1",
        "scenario run scenarios/feeder-trip.yaml",
        "editor problems lab.yaml",
        "editor pack --out made/fieldrig.vsix",
        "export lab.yaml --dbc made/lab.dbc --csv made/pump.csv --markdown made/registers.md",
        "search run searches/feeder.yaml",
        "check nothing.yaml",
    )
    Path("made").mkdir()
    Path("made/main.st").write_text(PROGRAM, encoding="utf-8")
    return {line: command(*line.split()) for line in lines}


def masters() -> dict[str, Any]:
    """Return what unchanged masters print in virtual time."""
    Path("master.py").write_text(MASTER, encoding="utf-8")
    Path("can_master.py").write_text(CAN_MASTER, encoding="utf-8")
    Path("serial_master.py").write_text(SERIAL_MASTER, encoding="utf-8")
    Path("line.yaml").write_text(SERIAL_RIG, encoding="utf-8")
    played = (("lab.yaml", "master.py"), ("lab.yaml", "can_master.py"), ("line.yaml", "serial_master.py"))
    return {name: command("exec", rig, "--", name) for rig, name in played}


def traces() -> dict[str, Any]:
    """Return what a rig in virtual time under `fieldrig up` answers, and its trace in all formats."""
    from fieldrig.testing import free_port

    endpoint = f"tcp/127.0.0.1:{free_port()}"
    answers: dict[str, Any] = {}
    asking = threading.Thread(target=_ask, args=(endpoint, answers))
    asking.start()
    up = "up", "lab.yaml", "--no-ui", "--set", "time=virtual", "--control", endpoint, "--trace", "lab.jsonl"
    answers["up"] = command(*up, "--set", "speed=max")[0]
    asking.join()
    entries = Path("lab.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
    answers["is_traced"] = len(entries) > 100
    Path("lab.jsonl").write_text("".join(entries[:100]), encoding="utf-8", newline="\n")
    for name in FORMATS:
        answers[name] = command("trace", "convert", "lab.jsonl", name)[0], Path(name).stat().st_size > 0
    answers["codes"] = [command(*line.split())[0] for line in OF_TRACES]
    answers["show"] = command("trace", "show", "lab.jsonl", "--rig", "lab.yaml")
    return answers


def _ask(endpoint: str, answers: dict[str, Any]) -> None:
    """Ask the rig, and end it by Ctrl-C."""
    from fieldrig import RigError

    try:
        answers["set"] = _run_pump(endpoint)
    except RigError as wrong:
        answers["set"] = str(wrong)
    finally:
        _thread.interrupt_main()


def _run_pump(endpoint: str) -> Any:
    from fieldrig.control.messages import Client
    from fieldrig.errors import ControlError

    give_up_s = time.monotonic() + PATIENCE_S
    while True:
        try:
            with Client(endpoint) as rig:
                answer = rig.ask("device/drive/set", {"values": {"run": True}})
                while rig.ask("rig/status")["now_ns"] < 20_000_000_000:
                    time.sleep(0.01)
                return answer
        except ControlError:  # it is still starting
            if time.monotonic() > give_up_s:
                raise


def plugin() -> int:
    """Return the exit code of pytest for a test with the fixtures of the plugin."""
    import pytest

    file = Path("test_plugin.py")
    file.write_text(PLUGIN_TEST, encoding="utf-8")
    # Plugins of this environment need POSIX.  -s, as pytest takes its output with a call of Linux.
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    options = ("-q", "-s", "-p", "fieldrig.pytest_plugin", "-p", "no:cacheprovider", "-c", os.devnull)
    return int(pytest.main([*options, str(file)]))


def refusals() -> dict[str, Any]:
    """Return what a rig in real time, a pty and a branch say on a system that has none of them."""
    from shipped import in_virtual_time

    from fieldrig import RigError
    from fieldrig.virtual.rig import Rig
    from fieldrig_bus.terminal import terminal

    def said(call: Callable[[], Any]) -> str:
        try:
            call()
        except RigError as wrong:
            return str(wrong)
        return "nothing"

    hub: Any = object()
    with Rig(in_virtual_time("lab.yaml")) as rig:
        return {
            "up": command("up", "lab.yaml", "--no-ui"),
            "only": command("up", "lab.yaml", "--only", "io"),
            "pty": said(lambda: terminal(hub, "modbus-rtu")),
            "branch": said(rig.branch),
        }


def foreign() -> list[str]:
    """Return the modules that only a system with uvloop and POSIX has, and that were imported nevertheless."""
    return [name for name in ("uvloop",) if name in sys.modules]


WORK: Final[dict[str, Callable[[], Any]]] = {
    "rigs": rigs,
    "commands": commands,
    "masters": masters,
    "traces": traces,
    "plugin": plugin,
    "refusals": refusals,
    "imported": imported,
    "foreign": foreign,
}


def main(system: str, seen: str, folder: Path, *parts: str) -> None:
    for name in FIRST:
        importlib.import_module(name)
    if system != "linux":
        without_posix.become(system, seen)  # type: ignore[arg-type]
    shutil.copytree(CONFIGS, folder, dirs_exist_ok=True)
    os.chdir(folder)
    results: dict[str, Any] = {}
    for part in parts or WORK:
        try:
            results[part] = WORK[part]()
        except BaseException:  # noqa: BLE001  the test shows it
            results[part] = traceback.format_exc()
    Path("results.json").write_text(json.dumps(results, default=str), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), *sys.argv[4:])
