"""No bytes from masters and no levels on wires upset the controller, and no pulse is lost or out of its band."""

from itertools import pairwise

import pytest
from hmiscu_device_bench import PTO, DeviceBench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.signals.pulse_train import PulseTrain

MOST_HZ = 50_000
PINS = (0, 2, 4, 6, 10, 12, 14, 18, 22)
"""Holding registers of pins with a DWORD."""

pins = st.builds(
    lambda address, value: bytes([16]) + address.to_bytes(2, "big") + b"\0\2\4" + value.to_bytes(2, "big") + b"\0\0",
    st.sampled_from(PINS),
    st.integers(0, 0xFFFF),
)
coils = st.builds(
    lambda address, is_on: bytes([5]) + address.to_bytes(2, "big") + (b"\xff\0" if is_on else b"\0\0"),
    st.integers(0, 7),
    st.booleans(),
)
requests = st.one_of(pins, coils, st.binary(min_size=1, max_size=30)).map(lambda pdu: ("request", pdu))
frames = st.tuples(st.sampled_from([0x000, 0x080, 0x205, 0x305, 0x605]).map(str), st.binary(max_size=8))
levels = st.booleans().map(lambda level: ("ready", bytes([level])))
waits = st.integers(1, 400).map(lambda time_ms: ("wait", time_ms.to_bytes(2, "big")))


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.lists(st.one_of(requests, frames, levels, waits), max_size=60))
def test_the_controller_stays_in_its_states_whatever_arrives(events: list[tuple[str, bytes]]) -> None:
    bench = DeviceBench(channel_0=PTO | {"aux": "drive_ready"}, can_slave={"node_id": 5})
    for block in ("MoveRelative", "MoveVelocity"):  # recipes that would move, until they are overwritten
        for pin, value in {"Velocity": 20_000, "Acceleration": 100, "Deceleration": 100}.items():
            bench.set(f"{block}.{pin}", value)
    bench.set("MoveRelative.Distance", 5_000)
    bench.wire("drive.ready", True)
    for number, (kind, data) in enumerate(events):
        match kind:
            case "request":
                bench.modbus.deliver(ModbusRequest(1, data, number))
            case "ready":
                bench.wire("drive.ready", bool(data[0]))
            case "wait":
                bench.run(int.from_bytes(data, "big"))
            case identifier:
                bench.can.deliver(CanFrame(int(identifier), data))
        assert bench.get("PTO00.State") in range(5)
        assert bench.get("plc/state") == "run"
    trains = [signal for signal in bench.driven("pulse") if isinstance(signal, PulseTrain)]
    for before, train in pairwise(trains):
        assert 0 <= train.frequency <= MOST_HZ
        assert train.sent == before.sent_at(train.start_ns - 1)
        assert train.start_ns >= before.start_ns
