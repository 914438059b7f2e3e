"""The work of a service engineer with pppd, chat, curl and pymodbus; only inside user-mode Linux, as root."""

import re
import subprocess
from pathlib import Path

from asyncua.sync import Client as OpcUaClient
from pppd import ECHO_REQUEST, echo_message, ping_socket, reply_in
from pppd_call import pppd_call
from pymodbus.client import ModbusTcpClient
from running_rig import AskedRig, until

CONTROLLER = "190.200.100.100"
USER, PASSWORD = "service", "pacdrive"
TERMINATED = 5  # pppd(8), EXIT STATUS
OFFLINE, ONLINE = 6, 7  # Com1UserState
MAP_IDENTIFIER = 0x4D34  # register 0
PING = bytes.fromhex("1234 0001") + bytes(range(256))
PAGE = '<html><body>Cycle <pac value="MAx-4.Com1UserState">.</body></html>\n'
PATIENCE_S = "200"


def curl(*arguments: str) -> str:
    done = subprocess.run(
        ["curl", "-sS", "--max-time", PATIENCE_S, *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def put(file: Path, host: str) -> None:
    curl("--user", f"{USER}:{PASSWORD}", "-T", str(file), f"ftp://{host}/")


def reach_every_service(rig: AskedRig, folder: Path) -> None:
    """Call, ping, fetch a page, replace one by FTP and see it served, read Modbus and OPC UA, and hang up."""
    until(
        lambda: rig.get("max4/booted") is True
    )  # a controller that boots is silent to Modbus, and the line is up before
    mine = folder / "MINE.HTM"
    mine.write_text(PAGE)
    with pppd_call(folder) as call:
        call.until_up()
        assert f"remote IP address {CONTROLLER}" in call.output()
        assert "local  IP address 190.200.100.101" in call.output()
        assert rig.get("max4/Com1UserState") == ONLINE
        with ping_socket(CONTROLLER) as raw:
            raw.send(echo_message(ECHO_REQUEST, PING))
            until(lambda: reply_in(raw) == PING)
        agreed = re.findall(r"(sent|rcvd) \[IPCP ConfAck id=\w+ <compress VJ 0f 01>", call.output())
        assert set(agreed) == {"sent", "rcvd"}, "headers are compressed in both directions (PD-260)"
        page = curl(f"http://{CONTROLLER}/AXES.HTM")
        assert [axis for axis in ("infeed", "film", "jaw", "outfeed") if f">{axis}</td>" not in page] == []
        put(mine, CONTROLLER)
        assert f"Cycle {ONLINE}." in curl(f"http://{CONTROLLER}/MINE.HTM")
        with ModbusTcpClient(CONTROLLER, port=502, timeout=60, retries=0) as client:
            assert client.read_holding_registers(0, count=1).registers == [MAP_IDENTIFIER]
        with OpcUaClient(f"opc.tcp://{CONTROLLER}:4840", timeout=60) as visitor:
            state = visitor.get_node("ns=2;s=infeed.AxisState")
            until(lambda: state.read_value() == rig.get("max4/infeed.AxisState"))
        assert call.hang_up() == TERMINATED, call.output()
