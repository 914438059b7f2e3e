"""`fieldrig nameplate`, and encoders that run: on a pty and a socket, by pyserial alone, over SIGKILL, with faults."""

import json
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import serial
from hiperface_bench import PLATE, telegram
from patience import PATIENCE_S
from running_rig import RunningRig

from fieldrig.system.exits import Exit
from fieldrig.testing import free_port
from fieldrig_devices.hiperface.plate_file import load_plate, save_plate

pytestmark = pytest.mark.system

SAMPLES = Path(__file__).parents[2] / "configs" / "plates"
RIG = """
time: real
buses:
  one: {{kind: serial.pty, parity: E}}
  two: {{kind: serial.tcp, listen: "127.0.0.1:{port}", parity: E}}
devices:
  first: {{kind: sm.encoder, name_plate: {first}, links: {{line: one}}}}
  second: {{kind: sm.encoder, name_plate: {second}, links: {{line: two}}}}
"""


class EncoderRig(RunningRig):
    def __init__(self) -> None:
        port = free_port()
        text = RIG.format(port=port, first=SAMPLES / "sm-100-30-080.yaml", second=SAMPLES / "sm-140-30-200-brake.yaml")
        super().__init__(text, None)
        self.pty = str(self.run / "serial" / "one")
        self.socket = f"socket://127.0.0.1:{port}"


@pytest.fixture(scope="module")
def rig() -> Iterator[EncoderRig]:
    with EncoderRig() as rig:
        yield rig.until_ready()


def opened(url: str) -> Any:
    open_port: Any = serial.serial_for_url  # which has no types
    return open_port(url, 9600, timeout=1)


def asked(port: Any, request: bytes, wanted: bytes) -> None:
    """Repeat a question that a busy host has disturbed."""
    give_up_s = time.monotonic() + PATIENCE_S
    answer = b""
    while answer != wanted:
        assert time.monotonic() < give_up_s, answer.hex(" ")
        time.sleep(0.05)  # silence, so that what was broken has ended
        port.reset_input_buffer()
        port.write(request)
        port.timeout = 1.0
        answer = port.read(len(wanted))


@pytest.mark.manual("PD-170", "PD-173")
def test_pyserial_reads_an_encoder(rig: EncoderRig) -> None:
    rig.ask("device/first/set", {"values": {"turns": 1.25}})
    with opened(rig.pty) as port:
        asked(port, telegram("52"), telegram("52 e4 27 80 00"))
        asked(port, telegram("42"), telegram("42 00 00 a0 00"))
        asked(port, telegram("4a 00 00 06 55"), telegram("4a 00 00 06 46 52 4e 50 01 64"))
        asked(port, telegram("4a 00 00 06 54"), telegram("50 0f"))


@pytest.mark.manual("PD-171")
def test_what_was_answered_survives_a_kill(rig: EncoderRig) -> None:
    with opened(rig.pty) as port:
        asked(port, telegram("4b 00 70 04 55 de ad be ef"), telegram("4b 00 70 04"))
    restarts = rig.status()["processes"]["first"]["restarts"]
    os.kill(rig.pid("first"), signal.SIGKILL)
    rig.until_back("first", restarts + 1)
    with opened(rig.pty) as port:
        asked(port, telegram("4a 00 70 04 55"), telegram("4a 00 70 04 de ad be ef"))


@pytest.mark.parametrize("line", ["pty", "socket"])
def test_a_plate_is_read_written_and_edited_in_an_encoder(rig: EncoderRig, line: str) -> None:
    port = ("--port", getattr(rig, line))
    save_plate(PLATE, rig.folder / "other.yaml")
    done = rig.tool("nameplate", "write", "other.yaml", *port)
    assert done.stdout == "other.yaml: SM-100/30/080, 17-0001 is in the encoder\n", done.stderr
    done = rig.tool("nameplate", "edit", *port, "--set", "rated_current_a=4.2", "--set", "serial_number=17-0004")
    assert done.stdout == "rated_current_a: 3.94 -> 4.2\nserial_number: 17-0001 -> 17-0004\n", done.stderr
    done = rig.tool("nameplate", "read", *port, "--json", "--out", "there.yaml")
    values = json.loads(done.stdout)
    assert (values["rated_current_a"], values["serial_number"]) == (4.2, "17-0004")
    assert (values["encoder_type"], values["encoder_serial_number"]) == ("27h", "FR0000001")
    wanted = PLATE.model_copy(update={"rated_current_a": 4.2, "serial_number": "17-0004"})
    assert load_plate(rig.folder / "there.yaml") == wanted
    done = rig.tool("nameplate", "edit", *port, "--set", "peak_torque_nm=1")
    assert done.returncode == Exit.WRONG
    assert "above peak_torque_nm" in done.stderr
    assert rig.json("nameplate", "read", *port)["peak_torque_nm"] == 32.0


def test_rig_prints_the_line_that_reads_the_plate(rig: EncoderRig) -> None:
    lines = [line for label, line in rig.lines().items() if label.endswith(" name plate")]
    assert any(line.endswith(f"fieldrig nameplate read --port {rig.socket} --address 40") for line in lines)
    assert [rig.tool(*line.split()[1:]).returncode for line in lines] == [Exit.OK] * 2  # the other one is on a pty


def test_what_is_wrong_is_said(rig: EncoderRig) -> None:
    number = rig.tool("fault", "second", "memory").stdout.strip()
    done = rig.tool("nameplate", "read", "--port", rig.socket)
    assert (done.returncode, done.stdout) == (Exit.REFUSED, "")
    assert "the encoder's memory cannot be read" in done.stderr
    rig.tool("fault", "second", "--clear", number)
    done = rig.tool("nameplate", "read", "--port", rig.socket, "--code", "12")
    assert (done.returncode, "wrong access code" in done.stderr) == (Exit.REFUSED, True)
    done = rig.tool("nameplate", "read", "--port", rig.socket, "--address", "41")
    assert (done.returncode, "no answer to 52h" in done.stderr) == (Exit.CANNOT_START, True)
    done = rig.tool("nameplate", "read", "--port", rig.socket, "--address", "FF")
    assert done.returncode == Exit.OK
    done = rig.tool("nameplate", "read", "--port", "no/such/port")
    assert (done.returncode, "cannot open no/such/port" in done.stderr) == (Exit.CANNOT_START, True)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["read"], "no encoder is given"),
        (["read", "--port", "x", "--address", "140"], "not a byte"),
        (["edit", "motor.yaml"], "no change is given"),
        (["edit", "motor.yaml", "--set", "rated_current_a"], "KEY=VALUE"),
        (["edit", "motor.yaml", "--set", "colour=red"], "there is no such key"),
        (["show", "no.yaml"], "cannot be read"),
        (["write", "no.yaml", "--port", "x"], "cannot be read"),
    ],
)
def test_wrong_usage_is_explained(rig: EncoderRig, words: list[str], says: str) -> None:
    save_plate(PLATE, rig.folder / "motor.yaml")
    done = rig.tool("nameplate", *words)
    assert done.returncode == Exit.WRONG
    assert says in done.stderr
    assert load_plate(rig.folder / "motor.yaml") == PLATE


def test_a_file_is_edited_and_shown(rig: EncoderRig) -> None:
    save_plate(PLATE, rig.folder / "motor.yaml")
    assert rig.tool("nameplate", "edit", "motor.yaml", "--set", "pole_pairs=5").stdout == "pole_pairs: 4 -> 5\n"
    values = rig.json("nameplate", "show", "motor.yaml")
    assert (values["pole_pairs"], values["acceleration_time_ms"]) == (5, 4.12)
    assert "inertia_kgcm2" in rig.tool("nameplate", "show", "motor.yaml").stdout
