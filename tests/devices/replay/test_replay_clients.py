"""Modbus clients of a rig: their requests are expected, and the log answers them where it has a server's place."""

from typing import Any

import pytest
from recorded_logs import MS

from fieldrig import Rig, RigConfig, from_dict
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import encode
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.replay import replay

READ, ANSWER = bytes.fromhex("03 0000 0001"), bytes.fromhex("03 02 00 2a")


@pytest.fixture(autouse=True)
def own_kinds(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.syspath_prepend(str(request.path.parent))


def rig_with(*devices: str) -> RigConfig:
    kinds: dict[str, Any] = {
        name: {"kind": f"replay_kinds:{name.title()}", "links": {"modbus": "mb"}} for name in devices
    }
    return from_dict({"time": "virtual", "buses": {"mb": {"kind": "modbus.virtual", "servers": [7]}}, "devices": kinds})


def log(delay_ms: float = 0) -> list[TraceEntry]:
    """A client that asks ten times a second, and its answers."""
    entries = []
    for number in range(10):
        at_ns = 100 * MS * number
        entries.append(TraceEntry(at_ns, "mb", "modbus", "poller", encode(ModbusRequest(7, READ, number + 1))))
        late_ns = at_ns + round(delay_ms * MS)
        entries.append(TraceEntry(late_ns, "mb", "modbus", "server", encode(ModbusResponse(7, ANSWER, 0))))
    return entries


def test_devices_that_speak_to_each_other_are_only_looked_at() -> None:
    """Nothing waits for their requests, as no player is concerned."""
    with Rig(rig_with("poller", "server")) as rig:
        result = replay(log(), rig)
    assert (result.differences, result.played, result.shift_ns) == ([], 0, 0)


@pytest.mark.parametrize("delay_ms", [0, 20])
def test_the_log_answers_a_client_of_the_rig(delay_ms: float) -> None:
    with Rig(rig_with("poller")) as rig:
        result = replay(log(delay_ms), rig, play=["unit=7"])
        assert rig.get("poller/answer") == ANSWER.hex()
    assert (result.differences, result.played) == ([], 10)


def test_a_client_that_does_not_ask_is_missed() -> None:
    with Rig(rig_with("poller")) as rig:
        rig.add_fault("poller", {"what": "power_off"})
        result = replay(log(), rig, play=["unit=7"], timeout_ns=10 * MS)
    [only] = result.differences
    assert only.words.startswith("unit 7 did not send read holding registers")
    assert "(10 of them in a row)" in only.words
