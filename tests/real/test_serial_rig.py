"""pyserial and pymodbus at the serial lines of a running rig: RFC 2217, TCP, ptys, and Modbus ASCII."""

import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import serial
from running_rig import RunningRig, until
from terminal import Terminal

from fieldrig.testing import free_port

pytestmark = [
    pytest.mark.real,
    pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning"),  # in pyserial's RFC 2217
]

TABLE = Path(__file__).parents[2] / "configs" / "registers" / "pump-drive.yaml"
PATIENCE_S = 30


class SerialRig(RunningRig):
    def __init__(self) -> None:
        self.com1, self.com2 = f"127.0.0.1:{free_port()}", f"127.0.0.1:{free_port()}"
        parrot = "kind: 'serial_kinds:Parrot', links: "
        text = f"""
time: real
buses:
  com1: {{kind: serial.rfc2217, listen: "{self.com1}"}}
  com2: {{kind: serial.tcp, listen: "{self.com2}"}}
  com3: {{kind: serial.pty}}
  mb: {{kind: modbus.ascii, pty: ascii}}
devices:
  one: {{{parrot} {{line: com1}}}}
  two: {{{parrot} {{line: com2}}}}
  three: {{{parrot} {{line: com3}}}}
  drive: {{kind: modbus.device, table: {TABLE}, links: {{modbus: mb}}}}
"""
        super().__init__(text, Path(__file__).with_name("serial_kinds.py"))

    def url(self, line: str) -> str:
        urls = {"com1": f"rfc2217://{self.com1}", "com2": f"socket://{self.com2}"}
        return urls.get(line, str(self.run / "serial" / line))


@pytest.fixture(scope="module")
def rig() -> Iterator[SerialRig]:
    with SerialRig() as rig:
        yield rig.until_ready()


def opened(url: str, baud: int = 19200) -> Any:
    open_port: Any = serial.serial_for_url  # which has no types
    return open_port(url, baudrate=baud, timeout=PATIENCE_S)


@pytest.fixture
def port(rig: SerialRig) -> Iterator[Any]:
    """pyserial's RFC 2217 client."""
    with opened(rig.url("com1")) as port:
        yield port


@pytest.mark.parametrize("line", ["com1", "com2", "com3"])
def test_bytes_go_there_and_come_back(rig: SerialRig, line: str) -> None:
    every_byte = bytes(range(256))  # 255 is the escape of telnet
    with opened(rig.url(line), baud=38400) as port:
        port.write(every_byte)
        assert port.read(len(every_byte)) == every_byte


def test_the_device_sees_the_clients_settings(rig: SerialRig, port: Any) -> None:
    until(lambda: rig.value("one/format") == "19200 8N1")
    port.baudrate, port.bytesize, port.parity, port.stopbits = 1200, 7, serial.PARITY_EVEN, 2
    until(lambda: rig.value("one/format") == "1200 7E2")


def test_the_device_sees_the_clients_control_lines(rig: SerialRig, port: Any) -> None:
    until(lambda: rig.value("one/dtr") and rig.value("one/rts"))
    port.dtr = False
    until(lambda: rig.value("one/dtr") is False)
    assert rig.value("one/rts") is True
    port.rts = False
    until(lambda: rig.value("one/rts") is False)


@pytest.mark.parametrize(("key", "line"), [("ring", "ri"), ("carrier", "cd"), ("ready", "cts")])
def test_the_client_sees_the_devices_control_lines(rig: SerialRig, port: Any, key: str, line: str) -> None:
    assert port.dsr is True
    was_on = rig.value(f"one/{key}")
    assert rig.tool("set", f"one/{key}={str(not was_on).lower()}").returncode == 0
    until(lambda: getattr(port, line) is not was_on)
    assert rig.tool("set", f"one/{key}={str(was_on).lower()}").returncode == 0
    until(lambda: getattr(port, line) is was_on)


def test_a_break_arrives(rig: SerialRig, port: Any) -> None:
    port.send_break(0.3)
    until(lambda: 250 <= rig.value("one/break_ms") < 2000)


def test_xon_xoff_is_granted_and_its_characters_are_not_data(rig: SerialRig, port: Any) -> None:
    port.xonxoff = True  # pyserial raises if the server refuses it
    port.write(b"a\x13\x11b")
    assert port.read(2) == b"ab"
    port.xonxoff = False
    port.write(b"\x13\x11")
    assert port.read(2) == b"\x13\x11"


def test_hanging_up_takes_the_lines_away(rig: SerialRig) -> None:
    with opened(rig.url("com1")):
        until(lambda: rig.value("one/dtr") is True)
    until(lambda: rig.value("one/dtr") is False)
    with opened(rig.url("com1")) as again:
        again.write(b"again")
        assert again.read(5) == b"again"


@pytest.mark.parametrize("line", ["com1", "com2", "com3"])
def test_printed_terminal_works(rig: SerialRig, line: str) -> None:
    with Terminal(rig.lines()[f"{line} terminal"], rig.folder) as terminal:
        terminal.until_shown("Quit")
        terminal.type("parrot")
        terminal.until_shown("parrot")
        assert terminal.press("\x1d") == 0


def test_printed_line_shows_the_inputs(rig: SerialRig) -> None:
    line = rig.lines()["com1 DCD, DSR, CTS, RI"]
    done = subprocess.run(["bash", "-c", line], cwd=rig.folder, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "True True True False\n"


def test_printed_pymodbus_line_speaks_ascii(rig: SerialRig) -> None:
    for _ in range(2):  # the second time the pty is as the first client has left it
        done = subprocess.run(
            ["bash", "-c", rig.lines()["drive all registers with pymodbus"]],
            cwd=rig.folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert "ReadCoilsResponse" in done.stdout, done.stderr
