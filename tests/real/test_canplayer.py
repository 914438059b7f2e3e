"""Logs that we write, played by canplayer of can-utils."""

import subprocess
from pathlib import Path

import can
import pytest

from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import CanFrame

pytestmark = [pytest.mark.real, pytest.mark.vcan]

FRAMES = [
    CanFrame(0x605, bytes.fromhex("40 00 10 00 00 00 00 00")),
    CanFrame(0x1ABCDEF0, b"\x01\x02", is_extended=True),
    CanFrame(0x123, is_remote=True, remote_length=4),
    CanFrame(0x7FF),
]


def test_canplayer_plays_what_we_write(tmp_path: Path) -> None:
    log = tmp_path / "x.log"
    entries = [TraceEntry(n * 1_000_000, "vcan0", "can", "", encode(frame)) for n, frame in enumerate(FRAMES)]
    write(entries, log)
    with can.Bus("vcan0", "socketcan") as bus:
        subprocess.run(["canplayer", "-I", str(log)], check=True, timeout=30)
        heard = [bus.recv(5) for _ in FRAMES]
    assert [(one.arbitration_id, bytes(one.data), one.is_remote_frame) for one in heard if one is not None] == [
        (frame.identifier, frame.data, frame.is_remote) for frame in FRAMES
    ]
