"""OPC UA, the debugger and Modbus over a telephone line, with both ends of IP."""

import asyncio
import signal
import subprocess
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

import pytest
from asyncua import Client
from dialled import Dialled, dialled
from network_namespace import network_namespace, why_not
from patience import PATIENCE_S
from pymodbus.client import ModbusTcpClient
from running_rig import AskedRig, until

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

OFFLINE = 6  # Com1UserState
OPC_UA, MODBUS, ENGINEERING = 4840, 502, 7447
"""Ports of the controller."""
LOGIN = ("--user", "service", "--password", "pacdrive")
RIG = """
time: real
buses:
  com1: {{kind: serial.line, baud: 115200, process: modems}}
  caller: {{kind: serial.pty, path: modem, baud: 115200, process: modems}}
  telephone: {{kind: telephone.exchange, numbers: {{machine: "4711", laptop: "4712"}}, process: modems}}
  ua: {{kind: opcua.server, listen: "127.0.0.1:{ua}"}}
  modbus: {{kind: modbus.tcp, listen: "127.0.0.1:{modbus}"}}
  relay:
    kind: ip.relay
    ip: {ip}
    services: {{4840: "127.0.0.1:{ua}", 502: "127.0.0.1:{modbus}"}}
devices:
  max4:
    kind: max4
    links: {{com1: com1, relay: relay, opcua: ua, modbus: [modbus]}}
    com1: {{modem: Modem, baud: 115200}}
    parameters: {{MAx-4.Com1User: 1, Modem.UserName: service, Modem.Password: pacdrive}}
    program: [count.st]
    autostart: true
  machine: {{kind: modem, links: {{line: com1, telephone: telephone}}, baud: 115200, process: modems}}
  laptop: {{kind: modem, links: {{line: caller, telephone: telephone}}, baud: 115200, process: modems}}
"""
PROGRAM = """
PROGRAM PLC_PRG
VAR
    count : DINT;
    setpoint : REAL := 1.5;
END_VAR
count := count + 1;
END_PROGRAM
"""


class Served(AskedRig):
    """The rig, whose control service is a service of the controller as well."""

    def start_up(self, file: Path, *options: str, folder: Path | None = None) -> "subprocess.Popen[bytes]":
        control = self.endpoint.removeprefix("tcp/")
        return super().start_up(file, "--set", f"buses.relay.services.{ENGINEERING}={control}", *options, folder=folder)


@pytest.fixture(
    scope="module",
    params=[
        "own",
        pytest.param("kernel", marks=pytest.mark.skipif(bool(why_not()), reason=why_not())),
    ],
)
def rig(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[AskedRig]:
    ip, folder = request.param, tmp_path_factory.mktemp("line")
    (folder / "count.st").write_text(PROGRAM)
    with nullcontext() if ip == "own" else network_namespace():
        file = folder / "lab.yaml"
        file.write_text(RIG.format(ip=ip, ua=free_port(), modbus=free_port()))
        with Served(file, None) as rig:
            rig.until_ready()
            yield rig


@pytest.fixture(scope="module")
def forwarded(rig: AskedRig) -> Iterator[dict[int, int]]:
    """The local ports of a call, by the ports of the controller."""
    until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
    ports = {port: free_port() for port in (OPC_UA, MODBUS, ENGINEERING)}
    ways = [word for port, local in ports.items() for word in ("--forward", f"{local}:{port}")]
    with dialled(str(rig.folder / "run/lab/modem"), *LOGIN, "--baud", "115200", *ways) as dial:
        dial.until("Ctrl-C hangs up.")
        yield ports
        end(dial)


def end(dial: Dialled) -> None:
    dial.process.send_signal(signal.SIGINT)
    code, said = dial.end()
    assert code == 0, said


def test_opc_ua_browses_and_reads(forwarded: dict[int, int]) -> None:
    async def visit() -> tuple[set[str], float, bool]:
        url = f"opc.tcp://127.0.0.1:{forwarded[OPC_UA]}"
        async with Client(url, timeout=PATIENCE_S) as client:
            program = client.get_node("ns=2;s=PLC_PRG")
            names = {(await node.read_browse_name()).Name for node in await program.get_children()}
            setpoint = await client.get_node("ns=2;s=PLC_PRG.setpoint").read_value()
            count = client.get_node("ns=2;s=PLC_PRG.count")
            return names, setpoint, await count.read_value() < await count.read_value()

    assert asyncio.run(visit()) == ({"count", "setpoint"}, 1.5, True)


def test_the_debugger_answers(rig: AskedRig, forwarded: dict[int, int]) -> None:
    done = subprocess.run(
        [*FIELDRIG, "debug", "max4", "--control", f"tcp/127.0.0.1:{forwarded[ENGINEERING]}"],
        input="print PLC_PRG.setpoint\nquit\n",
        env=rig.environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "1.5" in done.stdout


def test_modbus_reads_the_map(forwarded: dict[int, int]) -> None:
    with ModbusTcpClient("127.0.0.1", port=forwarded[MODBUS], timeout=PATIENCE_S, retries=0) as client:
        assert client.read_holding_registers(0, count=1).registers == [0x4D34]
