"""The controller as CANopen master: a node of ours with the EDS of the I/O module, booted, lost, and back."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from max4_faces_bench import FacesBench

from fieldrig.errors import ConfigError
from fieldrig_bus.can.frame import CanFrame

IO32 = str(Path(__file__).parents[4] / "configs" / "eds" / "io32.eds")
LOST, BACK, EMERGENCY = 6570, 8571, 8572


def byte(name: str) -> dict[str, str]:
    return {"name": name, "type": "u8"}


NODE: dict[str, Any] = {
    "node_id": 20,
    "eds": IO32,
    "sdo": {"1800:05": 500},
    "inputs": {1: [{"name": "I_start", "type": "bool"}, {"name": "I_stop", "type": "bool"}]},
    "outputs": {1: [byte("QB0"), byte("QB1"), {"name": "QW2", "type": "u16"}]},
}
IO = {"io": {"kind": "canopen.node", "node_id": 20, "eds": IO32, "links": {"can": "can0"}}}


def bench_with(devices: dict[str, Any] | None = None, master: dict[str, Any] | None = None, **node: Any) -> FacesBench:
    can_master = {"nodes": {"io1": {**NODE, **node}}, **(master or {})}
    return FacesBench(devices=IO if devices is None else devices, can_master=can_master)


def send(bench: FacesBench, identifier: int, data: str) -> None:
    bench.outside.link("can0").send(CanFrame(identifier, bytes.fromhex(data)))
    bench.run(20)


@pytest.mark.manual("PD-004", "PD-302")
def test_a_node_is_configured_started_and_asked() -> None:
    bench = bench_with(devices={})
    bench.outside.link("can0").on_receive(lambda frame: None)
    bench.run(2)
    assert bench.take_frames() == ["000#80 14", "614#2b 00 18 05 f4 01 00 00"]
    send(bench, 0x594, "60 00 18 05 00 00 00 00")
    assert "614#2b 17 10 00 64 00 00 00" in bench.take_frames()
    send(bench, 0x594, "60 17 10 00 00 00 00 00")
    frames = bench.take_frames()
    assert frames[frames.index("000#01 14") :] == ["000#01 14", "194#R", "214#00 00 00 00"]


@pytest.mark.manual("PD-302")
def test_inputs_and_outputs_of_our_node() -> None:
    bench = bench_with().boot()
    assert bench.get("io1.IsRunning") is True
    assert bench.rig.get("io", "1800:05") == 500
    bench.rig.set("io", "6000:01", 0x01)
    bench.run(20)
    assert (bench.get("io1.I_start"), bench.get("io1.I_stop")) == (True, False)
    bench.set("io1.QB1", 0xA5).set("io1.QW2", 0x1234)
    bench.run(20)
    assert [bench.rig.get("io", f"6200:0{number}") for number in range(1, 5)] == [0, 0xA5, 0x34, 0x12]


@pytest.mark.manual("PD-307", "PD-067")
def test_data_move_with_the_io_map_update_and_not_between() -> None:
    bench = bench_with(devices={}, heartbeat_ms=0, ask=False, sdo={}).boot()
    bench.run(bench.rig.now_ns // -1_000_000 % 12)  # to where 12 ms, three cycles of 4, are over
    bench.run(1)
    bench.take_frames()
    bench.outside.link("can0").send(CanFrame(0x194, b"\x03"))
    bench.set("io1.QB0", 1).set("io1.QB1", 2)
    bench.run(8)
    assert (bench.get("io1.I_start"), bench.get("io1.I_stop")) == (False, False)
    assert bench.take_frames() == ["194#03"]
    bench.run(4)
    assert (bench.get("io1.I_start"), bench.get("io1.I_stop")) == (True, True)
    assert bench.take_frames() == ["214#01 02 00 00"]  # both in one message, once


@pytest.mark.long
def test_a_node_that_has_rebooted_was_lost_and_comes_back() -> None:
    bench = bench_with().boot()
    bench.rig.set("io", "6000:01", 0x03)
    bench.set("io1.QB0", 0x0F)
    bench.run(50)
    assert bench.get("io1.I_stop") is True
    bench.outside.link("can0").send(CanFrame(0x000, bytes.fromhex("81 14")))  # NMT, reset node: its outputs fall
    bench.run(200)
    assert bench.codes()[-2:] == [LOST, BACK]
    assert bench.get("io1.IsRunning") is True
    assert bench.rig.get("io", "6200:01") == 0x0F


def test_a_silent_node_is_lost_and_its_inputs_are_zero() -> None:
    bench = bench_with(devices={}, sdo={}, ask=False)
    answers = {"614#2b 17 10 00 64 00 00 00": (0x594, "60 17 10 00 00 00 00 00")}

    def answer(frame: CanFrame) -> None:
        reply = answers.get(f"{frame.identifier:03X}#{frame.data.hex(' ')}")
        if reply is not None:
            bench.outside.link("can0").send(CanFrame(reply[0], bytes.fromhex(reply[1])))

    bench.outside.link("can0").on_receive(answer)
    bench.run(10)
    send(bench, 0x194, "03")
    assert bench.get("io1.I_stop") is True
    for _ in range(5):
        send(bench, 0x714, "05")
        bench.run(70)
    assert bench.codes()[-1] != LOST
    bench.run(250)
    assert bench.codes()[-1] == LOST
    assert (bench.get("DiagCode"), bench.get("DiagExtCode")) == (LOST, "CAN 20")
    assert (bench.get("io1.IsRunning"), bench.get("io1.I_stop"), bench.get("io1.Losses")) == (False, False, 1)
    bench.take_frames()
    bench.run(1000)
    assert "000#80 14" in bench.take_frames()
    bench.run(50)
    assert (bench.codes()[-1], bench.get("io1.IsRunning")) == (BACK, True)


def test_inputs_of_a_lost_node_may_be_held() -> None:
    bench = bench_with(devices={}, sdo={}, ask=False, lost_inputs="hold", limit_ms=50)
    bench.outside.link("can0").on_receive(lambda frame: None)
    bench.run(5)
    send(bench, 0x594, "60 17 10 00 00 00 00 00")
    send(bench, 0x194, "03")
    bench.run(200)
    assert (bench.get("io1.IsRunning"), bench.get("io1.I_stop")) == (False, True)


def test_an_emergency_is_an_entry() -> None:
    bench = bench_with().boot()
    send(bench, 0x94, "10 82 11 00 00 00 00 00")
    entry = next(entry for _, entry in bench.max4.firmware.logger.entries() if entry.code == EMERGENCY)
    assert entry.ext == "CAN 20 8210 11"
    assert bench.get("DiagCode") == 0


def test_sync_and_heartbeat_of_the_master() -> None:
    bench = bench_with(devices={}, master={"node_id": 1, "heartbeat_ms": 100, "sync_ms": 20}).run(205)
    times = [time_ns // 1_000_000 for time_ns, frame in bench.frames if frame == "080#"]
    assert times == list(range(20, 201, 20))
    assert [frame for _, frame in bench.frames if frame.startswith("701#")] == ["701#00", "701#05", "701#05"]


def test_without_power_the_master_is_silent() -> None:
    bench = bench_with(master={"heartbeat_ms": 100, "sync_ms": 20}).boot()
    number = bench.rig.add_fault("max4", {"what": "power_off"})
    bench.run(5).take_frames()
    bench.run(2000)
    assert set(bench.take_frames()) <= {"714#05", "194#00 00 00 00"}
    bench.rig.clear_fault("max4", number)
    bench.boot()
    assert bench.get("io1.IsRunning") is True


def test_reset_takes_the_nodes_up_again() -> None:
    bench = bench_with().boot()
    bench.set("io1.QB0", 3).run(20).take_frames()
    bench.set("command", "system reset")
    bench.boot()
    frames = bench.take_frames()
    assert "000#80 14" in frames
    assert "000#01 14" in frames
    assert bench.get("io1.QB0") == 0  # an input of the tree has its first value after a boot
    assert bench.rig.get("io", "6200:01") == 0


@pytest.mark.manual("PD-302")
def test_a_download_writes_its_file() -> None:
    bench = bench_with().boot()
    bench.set("command", "download").run(8000)
    assert b'"node_id": 20' in bench.max4.firmware.disk.read("\\CANMA.CON")
    assert bench.max4.firmware.disk.read("\\CANSL.CON") == b""


@pytest.mark.parametrize(
    ("node", "wrong"),
    [
        ({"sdo": {"1800:77": 1}}, "1800:77"),
        ({"sdo": {"1800:05": 70_000}}, "1800:05"),
        ({"eds": None, "sdo": {"1800:05": 5}}, "bytes in hex"),
        ({"inputs": {1: [{"name": f"D{n}", "type": "u32"} for n in range(3)]}}, "expected at most 64 bits"),
        ({"inputs": {1: [byte("A")]}, "outputs": {1: [byte("a")]}}, "each name once"),
        ({"node_id": 127}, "expected each node-ID once"),
    ],
)
def test_wrong_settings_are_refused(node: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ConfigError, match=wrong):
        bench_with(**node)


def test_without_eds_values_are_bytes() -> None:
    bench = bench_with(eds=None, sdo={"1800:05": "f4 01"}).boot()
    assert bench.rig.get("io", "1800:05") == 500


@pytest.mark.long
@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from([0x80, 0x94, 0x194, 0x294, 0x594, 0x714]), st.binary(max_size=8)), max_size=20)
)
def test_no_frame_upsets_the_master(frames: list[tuple[int, bytes]]) -> None:
    bench = bench_with(devices={})
    bench.outside.link("can0").on_receive(lambda frame: None)
    for identifier, data in frames:
        bench.outside.link("can0").send(CanFrame(identifier, data))
        bench.run(5)
    bench.boot()
