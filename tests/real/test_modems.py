"""pyserial, plain sockets and a Telnet client at the modems of a running rig."""

import os
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest
import serial
from running_rig import RunningRig, until

from fieldrig.testing import free_port

pytestmark = [
    pytest.mark.real,
    pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning"),  # in pyserial's RFC 2217
]

PATIENCE_S = 60
EVERY_BYTE = bytes(range(256))


class ModemRig(RunningRig):
    """Two modems on ptys, one on RFC 2217, and ways in and out for programs."""

    def __init__(self) -> None:
        self.com, self.way_in = (f"127.0.0.1:{free_port()}" for _ in range(2))
        self.program = socket.create_server(("127.0.0.1", 0))
        self.program.settimeout(PATIENCE_S)
        dial = f"127.0.0.1:{self.program.getsockname()[1]}"
        text = f"""
time: real
buses:
  com1: {{kind: serial.pty, baud: 38400}}
  com2: {{kind: serial.pty, baud: 38400}}
  com3: {{kind: serial.rfc2217, baud: 38400, listen: "{self.com}"}}
  net:
    kind: telephone.exchange
    numbers: {{one: "100", two: "200", three: "300"}}
    incoming: [{{listen: "{self.way_in}", number: "300"}}]
    outgoing: [{{number: "400", dial: "{dial}"}}]
devices:
  one: {{kind: modem, training_ms: 100, links: {{line: com1, telephone: net}}}}
  two: {{kind: modem, training_ms: 100, on_exit: restart, links: {{line: com2, telephone: net}}}}
  three: {{kind: modem, training_ms: 100, links: {{line: com3, telephone: net}}}}
"""
        super().__init__(text, None)

    def open(self, line: str) -> Any:
        url = f"rfc2217://{self.com}" if line == "com3" else str(self.run / "serial" / line)
        opened: Any = serial.serial_for_url
        return opened(url, baudrate=38_400, timeout=PATIENCE_S)


@pytest.fixture(scope="module")
def rig() -> Iterator[ModemRig]:
    with ModemRig() as rig:
        yield rig.until_ready()
        rig.program.close()


def ask(port: Any, command: str, answer: bytes = b"OK\r\n") -> bytes:
    port.write(command.encode() + b"\r")
    heard: bytes = port.read_until(answer)
    assert heard.endswith(answer), heard
    return heard


def hang_up(port: Any, other: Any) -> None:
    """Leave a call by the escape sequence of a modem without guard time; `other` is the port of the other end."""
    port.write(b"+++")
    assert port.read_until(b"OK\r\n").endswith(b"OK\r\n")
    ask(port, "ATH")
    heard = other.read_until(b"NO CARRIER\r\n")
    assert heard.endswith(b"+++\r\nNO CARRIER\r\n"), heard


def test_a_serial_program_dials_over_a_pty_from_modem_to_modem(rig: ModemRig) -> None:
    with rig.open("com1") as one, rig.open("com2") as two:
        ask(two, "AT&F E0 Q0 V1 &S0 &C1 &R0 S0=1")
        ask(one, "ATE0S12=0")  # no guard time, so that nothing waits
        ask(one, "ATDT 200", b"CONNECT 33600\r\n")
        assert two.read_until(b"CONNECT 33600\r\n") == b"\r\nRING\r\n\r\nCONNECT 33600\r\n"
        one.write(EVERY_BYTE * 8)
        two.write(EVERY_BYTE[::-1] * 8)
        assert two.read(256 * 8) == EVERY_BYTE * 8
        assert one.read(256 * 8) == EVERY_BYTE[::-1] * 8
        hang_up(one, two)


def test_an_rfc_2217_client_sees_dcd_and_ri(rig: ModemRig) -> None:
    with rig.open("com1") as one, rig.open("com3") as three:
        ask(three, "ATE0")
        until(lambda: (three.dsr, three.cts, three.cd, three.ri) == (True, True, False, False))
        ask(one, "ATE0")
        one.write(b"ATDT300\r")
        until(lambda: three.ri)
        ask(three, "ATA", b"CONNECT 33600\r\n")
        until(lambda: three.cd)
        assert one.read_until(b"CONNECT 33600\r\n").endswith(b"CONNECT 33600\r\n")
        three.dtr = False
        assert one.read_until(b"NO CARRIER\r\n").endswith(b"NO CARRIER\r\n")
        until(lambda: not three.cd)


def test_a_program_calls_in_and_is_called(rig: ModemRig) -> None:
    host, _, port = rig.way_in.partition(":")
    with rig.open("com3") as three, socket.create_connection((host, int(port)), PATIENCE_S) as caller:
        ask(three, "ATE0S0=1", b"CONNECT 33600\r\n")
        caller.sendall(EVERY_BYTE)
        assert three.read(256) == EVERY_BYTE
        three.write(EVERY_BYTE)
        heard = b""
        while len(heard) < 256:
            heard += caller.recv(256)
        assert heard == EVERY_BYTE
        caller.close()
        assert three.read_until(b"NO CARRIER\r\n") == b"\r\nNO CARRIER\r\n"
        three.write(b"ATDT400\r")
        called, _ = rig.program.accept()
        with called:
            assert three.read_until(b"CONNECT 33600\r\n") == b"\r\nCONNECT 33600\r\n"
            three.write(b"Hello")
            assert called.recv(5, socket.MSG_WAITALL) == b"Hello"
        assert three.read_until(b"NO CARRIER\r\n") == b"\r\nNO CARRIER\r\n"


def test_a_killed_modem_ends_the_call_and_keeps_its_profile(rig: ModemRig) -> None:
    with rig.open("com1") as one:
        with rig.open("com2") as two:
            ask(two, "AT&F E0 S0=1 S7=77 &W")
            ask(one, "ATE0")
            ask(one, "ATDT200", b"CONNECT 33600\r\n")
            os.kill(rig.pid("two"), signal.SIGKILL)
        assert one.read_until(b"NO CARRIER\r\n") == b"\r\nNO CARRIER\r\n"
        rig.until_back("two")
        with rig.open("com2") as two:  # the pty of its line was in the same process
            assert ask(two, "ATS7?").strip() == b"077\r\n\r\nOK"
            ask(one, "ATS12=0DT200", b"CONNECT 33600\r\n")
            hang_up(one, two)


def test_a_killed_exchange_ends_the_call_and_carries_the_next_one(rig: ModemRig) -> None:
    with rig.open("com1") as one, rig.open("com2") as two:
        ask(two, "AT&F E0 S0=1")
        ask(one, "ATE0")
        ask(one, "ATDT200", b"CONNECT 33600\r\n")
        assert two.read_until(b"CONNECT 33600\r\n").endswith(b"CONNECT 33600\r\n")
        os.kill(rig.pid("net"), signal.SIGKILL)
        rig.until_back("net")
        assert one.read_until(b"NO CARRIER\r\n") == b"\r\nNO CARRIER\r\n"
        assert two.read_until(b"NO CARRIER\r\n") == b"\r\nNO CARRIER\r\n"
        ask(one, "ATS12=0DT200", b"CONNECT 33600\r\n")
        hang_up(one, two)


def test_faults_of_the_line_are_heard(rig: ModemRig) -> None:
    with rig.open("com1") as one:
        ask(one, "ATE0")
        assert rig.tool("fault", "net", "busy", "line=two").returncode == 0
        ask(one, "ATDT200", b"BUSY\r\n")
        assert rig.tool("fault", "net", "no_dial_tone").returncode == 0
        ask(one, "ATDT200", b"NO DIALTONE\r\n")
        assert rig.tool("fault", "net", "--clear", "all").returncode == 0


@pytest.mark.skipif(shutil.which("chat") is None, reason="chat is not there: apt-get install ppp")
def test_chat_dials_as_it_does_for_pppd(rig: ModemRig) -> None:
    script = ["ABORT", "BUSY", "ABORT", "NO CARRIER", "ABORT", "NO DIALTONE", "TIMEOUT", "30"]
    script += ["", "ATZ", "OK", "AT&F&C1&D2S7=30", "OK", "ATDT200", "CONNECT"]
    with rig.open("com2") as two:
        ask(two, "AT&F E0 S0=1 S12=0")
        with (rig.run / "serial/com1").open("r+b", buffering=0) as one:
            done = subprocess.run(["chat", "-V", *script], stdin=one, stdout=one, timeout=60, check=False)
            assert done.returncode == 0
            assert two.read_until(b"CONNECT 33600\r\n").endswith(b"CONNECT 33600\r\n")
            with rig.open("com1") as port:
                hang_up(two, port)


def test_the_end_of_a_program_at_a_pty_ends_its_call(rig: ModemRig) -> None:
    with rig.open("com2") as two:
        ask(two, "AT&F E0 S0=1")
        with rig.open("com1") as one:
            ask(one, "AT&FE0DT200", b"CONNECT 33600\r\n")
            assert two.read_until(b"CONNECT 33600\r\n").endswith(b"CONNECT 33600\r\n")
        assert two.read_until(b"NO CARRIER\r\n").endswith(b"NO CARRIER\r\n")
        with rig.open("com1") as one:
            assert ask(one, "AT") == b"\r\nOK\r\n"  # in the command state, without echo as before
