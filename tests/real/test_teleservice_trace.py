"""A call to the wrapper of configs/teleservice.yaml, recorded on the controller's line, in the hands of tshark."""

import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import pytest
from dialled import dialled
from patience import PATIENCE_S
from pymodbus.client import ModbusTcpClient
from ring_process import RingProcess
from running_rig import until
from tests.driver import needs

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(not needs.TSHARK.is_met(), reason=f"tshark is missing: {needs.TSHARK.remedy}"),
]

OFFLINE = 6  # Com1UserState
LOGIN = ("--user", "service", "--password", "pacdrive")
MAP_IDENTIFIER = 0x4D34  # register 0
CHECKSUMS = ("-o", "tcp.check_checksum:TRUE", "-o", "ip.check_checksum:TRUE")
WRONG = "_ws.malformed || ip.checksum.status == 0 || tcp.checksum.status == 0 || ppp.fcs.status == 0"


@pytest.fixture(scope="module")
def rig() -> Iterator[RingProcess]:
    modbus = free_port()
    places = {
        "buses.lan.listen.http": f"127.0.0.1:{free_port()}",
        "buses.lan.listen.ftp": f"127.0.0.1:{free_port()}",
        "buses.modbus.listen": f"127.0.0.1:{modbus}",
        "buses.relay.services.502": f"127.0.0.1:{modbus}",
    }
    sets = [word for key, place in places.items() for word in ("--set", f"{key}={place}")]
    with RingProcess("teleservice.yaml", *sets) as rig:
        rig.until_ready()
        until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
        yield rig


@contextmanager
def recorded(rig: RingProcess, file: Path, bus: str) -> Iterator[None]:
    """Record a bus with `fieldrig trace record` until Ctrl-C."""
    command = [*FIELDRIG, "trace", "record", str(file), bus]
    with subprocess.Popen(command, env=rig.environment, stderr=subprocess.DEVNULL) as recorder:
        try:
            until(file.exists)
            yield
            recorder.send_signal(signal.SIGINT)
            assert recorder.wait(PATIENCE_S) == 0
        finally:
            recorder.kill()


def tshark(file: Path, wanted: str, *fields: str) -> list[list[str]]:
    """Return these fields of the packets that the display filter selects."""
    columns = [word for field in fields for word in ("-e", field)]
    command = ["tshark", "-r", str(file), *CHECKSUMS, "-Y", wanted, "-T", "fields", *columns]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=PATIENCE_S)
    return [line.split("\t") for line in done.stdout.splitlines()]


def call(rig: RingProcess) -> bytes:
    """Dial, fetch a page, read a register, and hang up.  Returns the page."""
    pages, registers = free_port(), free_port()
    forwards = ("--forward", f"{pages}:80", "--forward", f"{registers}:502")
    with dialled(str(rig.run / "modem"), *LOGIN, *forwards) as dial:
        dial.until("Ctrl-C hangs up.")
        with urlopen(f"http://127.0.0.1:{pages}/AXES.HTM", timeout=PATIENCE_S) as answer:
            page: bytes = answer.read()
        with ModbusTcpClient("127.0.0.1", port=registers, timeout=PATIENCE_S, retries=0) as client:
            assert client.read_holding_registers(0, count=1).registers == [MAP_IDENTIFIER]
        dial.process.send_signal(signal.SIGINT)
        assert dial.end()[0] == 0
    return page


def test_tshark_decodes_a_recorded_call_down_to_http(rig: RingProcess, tmp_path: Path) -> None:
    trace, capture = tmp_path / "call.jsonl", tmp_path / "call.pcapng"
    with recorded(rig, trace, "com1"):
        page = call(rig)
    assert b">infeed</td>" in page
    assert rig.tool("trace", "convert", str(trace), str(capture)).returncode == 0
    assert tshark(capture, WRONG, "frame.number", "_ws.col.Info") == []
    protocols = {name for (name,) in tshark(capture, "ppp", "_ws.col.Protocol")}
    assert {"PPP LCP", "PPP PAP", "PPP IPCP", "TCP", "HTTP", "Modbus/TCP"} <= protocols
    assert tshark(capture, "http.request", "ip.dst", "http.request.uri") == [["190.200.100.100", "/AXES.HTM"]]
    answers = tshark(capture, "http.response", "http.response.code", "http.content_length")
    assert answers == [["200", str(len(page))]]
    assert tshark(capture, "modbus.regval_uint16", "modbus.regval_uint16") == [[str(MAP_IDENTIFIER)]]
