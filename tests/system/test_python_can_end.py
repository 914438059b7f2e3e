"""`can.Bus(interface="fieldrig", channel="can0")` beside a rig in real time, whose bus has no port."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import can
import pytest
from doc_pages import ROOT

from fieldrig.real.live_rig import LiveRig
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

RIG = f"""
time: real
buses:
  can0: {{kind: KIND}}
  wires: {{kind: wires.hub}}
devices:
  io: {{kind: canopen.node, node_id: 5, eds: {ROOT}/configs/eds/io32.eds, links: {{can: can0, wires: wires}}}}
"""
ASK = can.Message(arbitration_id=0x605, data=bytes.fromhex("40 00 10 00 00 00 00 00"), is_extended_id=False)


def opened(rig: LiveRig, monkeypatch: pytest.MonkeyPatch, channel: str = "can0") -> Any:
    monkeypatch.setenv("FIELDRIG_CONTROL", rig.endpoint)
    return can.Bus(interface="fieldrig", channel=channel)


def heard(end: Any, identifier: int) -> Any:
    while (message := end.recv(20)) is not None:
        if message.arbitration_id == identifier:
            return message
    raise AssertionError("there is no answer")


def until_lost(end: Any) -> None:
    while True:
        end.recv(20)


@pytest.mark.parametrize("kind", ["can.hub", f"can.udp, port: {free_port()}"], ids=["hub", "udp"])
def test_a_program_joins_the_bus_and_hears_an_answer(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rig.yaml").write_text(RIG.replace("KIND", kind))
    with LiveRig(tmp_path / "rig.yaml") as rig, opened(rig, monkeypatch) as bus, opened(rig, monkeypatch) as other:
        begin_s = time.time() - 1
        bus.send(ASK)
        for end in (bus, other):
            answer = heard(end, 0x585)
            assert bytes(answer.data) == bytes.fromhex("43 00 10 00 91 01 0f 00")
            assert answer.timestamp > begin_s
        with pytest.raises(can.CanOperationError):
            bus.send(can.Message(arbitration_id=0x800, is_extended_id=False, check=False))


def test_a_bus_that_is_not_there_is_named_and_one_that_goes_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rig.yaml").write_text(RIG.replace("KIND", "can.hub"))
    with LiveRig(tmp_path / "rig.yaml") as rig:
        monkeypatch.setenv("FIELDRIG_CONTROL", rig.endpoint)
        assert can.detect_available_configs("fieldrig") == [{"interface": "fieldrig", "channel": "can0"}]
        with pytest.raises(can.CanInitializationError, match="needs the channel of a bus: can0"):
            can.Bus(interface="fieldrig")
        with pytest.raises(can.CanInitializationError, match="has no bus 'can1'"):
            opened(rig, monkeypatch, "can1")
        with pytest.raises(can.CanInitializationError, match=r"wires is a bus of the kind wires\.hub"):
            opened(rig, monkeypatch, "wires")
        bus = opened(rig, monkeypatch)
    with pytest.raises(can.CanOperationError):
        until_lost(bus)
    with pytest.raises(can.CanOperationError):
        bus.send(ASK)
    bus.shutdown()
    assert can.detect_available_configs("fieldrig") == [], "the rig has gone"


def test_the_logger_of_python_can_shows_what_is_on_the_bus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rig.yaml").write_text(RIG.replace("KIND", "can.hub"))
    command = [sys.executable, "-u", "-m", "can.logger", "-i", "fieldrig", "-c", "can0"]
    with (
        LiveRig(tmp_path / "rig.yaml") as rig,
        opened(rig, monkeypatch) as bus,
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as logger,
    ):
        assert logger.stdout is not None
        assert "fieldrig can0" in logger.stdout.readline()  # it has joined the bus
        bus.send(ASK)
        seen = ""
        while "585" not in seen:
            seen += logger.stdout.readline()
        logger.send_signal(signal.SIGINT)
    assert "40 00 10 00 00 00 00 00" in seen
    assert logger.returncode == 0
