# ruff: noqa: E501  rows of messages are a table
"""Our own messages in tshark, by the dissector that ships with the package."""

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.faults.note import FaultNote
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.dualport import message as dualport
from fieldrig_bus.ring.pam import message as pam
from fieldrig_bus.ring.sercos import message as sercos
from fieldrig_bus.serial import codec as serial
from fieldrig_bus.serial.message import ControlLines, Format
from fieldrig_bus.signals import codec as wires
from fieldrig_bus.telephone import codec as telephone
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Ready, Ring, Tone
from fieldrig_bus.wires import Signal

pytestmark = pytest.mark.real

MST = bytes.fromhex("ff 03")
AT = bytes.fromhex("05 0140 0200 11223344")
MESSAGES: list[tuple[str, bytes, str, str]] = [
    ("ring", sercos.encode(sercos.Mst(7, MST)), "SERCOS", "7 MST phase 3"),
    ("ring", sercos.encode(sercos.Mdt(b"\xff\x00\x80")), "SERCOS", "MDT of 3 bytes"),
    ("ring", sercos.encode(AT), "SERCOS", "AT 5"),
    ("ring", sercos.encode(sercos.Cycle(7, MST, b"\xff\x01")), "SERCOS", "7 MST phase 3, MDT of 2 bytes"),
    ("ring", sercos.encode(sercos.Cycle(8, b"", b"")), "SERCOS", "8 MST failed, no MDT"),
    ("ring", sercos.encode(sercos.Answers(7, (AT, b"\x06"), False, 1, 2)), "SERCOS", "7 AT 5, AT 6, ring open"),
    ("ring", sercos.encode(FaultNote(3, "MST failed")), "fieldrig ring", "fault 3: MST failed"),
    ("pamring", pam.encode(pam.Frames(9, ((0, b"\x01"), (4, b"\x04\x01")))), "PAM ring", "9 to all: Identify; to 4: SetOutput"),
    ("pamring", pam.encode(pam.Cycle(9, ((pam.GROUP + 2, b"\x02"),))), "PAM ring", "9 to group 2: Run"),
    ("pamring", pam.encode(pam.Reports(9, ((4, b"\x02\x84\x00\x01\x84"),), (4, 5))), "PAM ring", "9 from 4: Running, Running"),
    ("pamring", pam.encode(b"\x03\x82\x01\x00"), "PAM ring", "report Accepted"),
    ("dualport", dualport.encode(dualport.Words(10, (0xAB, 0x1234))), "DualPort", "word 10: 00AB 1234"),
    ("telephone", telephone.encode(Hook(True)), "Telephone", "off hook"),
    ("telephone", telephone.encode(Dial("0612")), "Telephone", "dials 0612"),
    ("telephone", telephone.encode(Ring(True, "0613")), "Telephone", "ring on, from 0613"),
    ("telephone", telephone.encode(Heard(Tone.BUSY)), "Telephone", "tone: busy"),
    ("telephone", telephone.encode(Carrier(9600, True, False)), "Telephone", "carrier 9600 bit/s"),
    ("telephone", telephone.encode(Ready(True)), "Telephone", "ready"),
    ("telephone", telephone.encode(b"AT"), "Telephone", "2 bytes: 4154"),
    ("serial", serial.encode(b"OK"), "Serial", "2 bytes: 4F4B"),
    ("serial", serial.encode(ControlLines(dtr=True, rts=False, ri=False)), "Serial", "DTR=1 RTS=0 RI=0"),
    ("serial", serial.encode(Format(9600, 7, "E", 1)), "Serial", "9600 7E1"),
    ("wires", wires.encode(Signal("tank.level", 0.5, "m")), "Wires", '["tank.level",0.5,"m"]'),
]  # fmt: skip


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    path = tmp_path / "own.pcapng"
    write([TraceEntry(10**18 + n, family, family, "x", data) for n, (family, data, _, _) in enumerate(MESSAGES)], path)
    return path


def tshark(capture: Path, *arguments: str) -> str:
    script = CliRunner().invoke(app, ["trace", "dissector"]).stdout.strip()
    command = ["tshark", "-X", f"lua_script:{script}", "-r", str(capture), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert "Lua" not in done.stderr
    return done.stdout


def test_wireshark_shows_every_message_of_our_own(capture: Path) -> None:
    columns = [word for field in ("protocol", "info") for word in ("-e", f"_ws.col.{field.capitalize()}")]
    rows = [tuple(line.split("\t")) for line in tshark(capture, "-T", "fields", *columns).splitlines()]
    assert rows == [(protocol, info) for _, _, protocol, info in MESSAGES]
    assert tshark(capture, "-Y", "_ws.malformed || _ws.lua.error") == ""


def test_fields_can_be_filtered(capture: Path) -> None:
    packets: Any = json.loads(tshark(capture, "-Y", "fieldrig.sercos.address == 5", "-T", "json"))
    assert len(packets) == 2
    assert "0x4001" in json.dumps(packets[0])  # the status of the drive, little endian
    assert tshark(capture, "-Y", "fieldrig.dualport.word == 0x1234").count("\n") == 1
    assert tshark(capture, "-Y", "fieldrig.pamring.frame == 0x84").count("\n") == 1


def test_bytes_that_are_cut_short_are_no_fault_of_the_dissector(tmp_path: Path) -> None:
    path = tmp_path / "cut.pcapng"
    cut = [(family, data[:size]) for family, data, _, _ in MESSAGES for size in range(len(data))]
    write([TraceEntry(10**18, family, family, "x", data) for family, data in cut], path)
    assert len(list(read(path))) == len(cut)
    assert "Lua Error" not in tshark(path, "-V")


def test_the_dissector_is_installed_where_wireshark_looks(tmp_path: Path) -> None:
    folder = tmp_path / "plugins"
    done = CliRunner().invoke(app, ["trace", "dissector", "--install", str(folder)])
    assert done.exit_code == 0
    assert (folder / "fieldrig.lua").read_text(encoding="utf-8").startswith("-- The messages of fieldrig's buses")
