"""Things that a log expects and a rig cannot give are differences, unless the user leaves them out or plays them."""

from typing import Any

import pytest
from recorded_logs import MS, frame

from fieldrig import RigConfig, from_dict
from fieldrig.clock import S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import encode
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.replay import ReplayResult, replay

READ, ANSWER = bytes.fromhex("04 0000 0001"), bytes.fromhex("04 02 01f4")
IO = "configs/eds/io32.eds"
TYPE_OF_5 = [frame(100, 0x605, "40 00 10 00 00 00 00 00"), frame(101, 0x585, "43 00 10 00 91 01 0F 00")]
NODE_7 = [frame(200, 0x607, "40 00 10 00 00 00 00 00"), frame(201, 0x587, "43 00 10 00 91 01 0F 00")]
LEFT_OUT = ["heartbeat"]


def rig(**buses: dict[str, Any]) -> RigConfig:
    node = {"kind": "canopen.node", "node_id": 5, "eds": IO, "links": {"can": "can0"}}
    unit = {
        "kind": "modbus.device",
        "unit_id": 1,
        "table": "configs/registers/pump-drive.yaml",
        "links": {"modbus": "mb"},
    }
    found = {"can0": {"kind": "can.hub"}, "mb": {"kind": "modbus.tcp", "listen": "127.0.0.1:5020"}} | buses
    return from_dict({"time": "virtual", "buses": found, "devices": {"io": node, "drive": unit}})


def exchange(at_ms: int, unit: int, response: bytes, bus: str = "mb", **ends: str) -> list[TraceEntry]:
    """A client at `client` asks the server at `server`."""
    asked, answered = encode(ModbusRequest(unit, READ, at_ms)), encode(ModbusResponse(unit, response, at_ms))
    return [
        TraceEntry(at_ms * MS, bus, "modbus", ends.get("client", "10.0.0.7:40000"), asked),
        TraceEntry(at_ms * MS + 2 * MS, bus, "modbus", ends.get("server", "10.0.0.9:502"), answered),
    ]


def words_of(result: ReplayResult) -> list[str]:
    return [each.words for each in result.differences]


def test_a_node_that_the_rig_does_not_have_is_a_difference() -> None:
    log = [*TYPE_OF_5, *NODE_7]
    assert words_of(replay(log, rig(), leave_out=LEFT_OUT)) == [
        "the rig has no node 7, so the log played 1 message of it"
    ]
    assert replay(log, rig(), leave_out=[*LEFT_OUT, "node 7"]).is_same
    assert replay(log, rig(), leave_out=LEFT_OUT, play=["master", "node=7"]).is_same


def test_a_heartbeat_alone_may_be_that_of_the_master() -> None:
    result = replay([*TYPE_OF_5, frame(300, 0x77F, "05")], rig(), leave_out=LEFT_OUT)
    assert words_of(result) == []
    assert "the rig has no node 127, so the log played 1 message of it" in result.notes


def test_a_unit_that_the_rig_does_not_have_is_a_difference() -> None:
    log = [*exchange(100, 1, ANSWER), *exchange(200, 3, ANSWER)]
    values = ["level"]
    assert words_of(replay(log, rig(), leave_out=values)) == ["the rig has no unit 3: 2 messages from and to it"]
    assert replay(log, rig(), leave_out=[*values, "unit 3"]).is_same


def test_a_unit_that_no_gateway_reached_was_not_there_either() -> None:
    log = [*exchange(100, 1, ANSWER), *exchange(200, 3, bytes.fromhex("84 0b"))]
    assert replay(log, rig(), leave_out=["level"]).is_same


def test_a_bus_that_the_rig_does_not_have_is_a_difference() -> None:
    other = [frame(300, 0x585, "43 00 10 00 91 01 0F 00", bus="can1")]
    log = [*TYPE_OF_5, *other]
    result = replay(log, rig(), leave_out=LEFT_OUT)
    assert words_of(result) == ["the rig has no bus that can1 is (--bus): 1 message"]
    assert replay(log, rig(), leave_out=[*LEFT_OUT, "can1"]).is_same


def test_two_buses_of_a_log_are_never_one_of_the_rig() -> None:
    """Their nodes have the same numbers; the bus of the right name is found, although the other one comes first."""
    other = [
        frame(50, 0x605, "40 00 10 00 00 00 00 00", bus="can1"),
        frame(51, 0x585, "43 00 10 00 01 02 03 04", bus="can1"),
    ]
    result = replay([*other, *TYPE_OF_5], rig(), leave_out=[*LEFT_OUT, "can1"])
    assert (result.differences, result.compared) == ([], 1)


@pytest.mark.parametrize("play", [["client=10.0.0.7"], ["client=10.0.0.7:40000"], ["client=10.0.0.*"]])
def test_a_client_is_chosen_by_its_address(play: list[str]) -> None:
    log = [*exchange(100, 1, ANSWER), *exchange(200, 1, ANSWER, client="10.0.1.8:40000")]
    result = replay(log, rig(), play=play, leave_out=["level"])
    assert (result.played, result.differences) == (1, [])


def test_the_servers_of_a_network_are_buses_of_their_own() -> None:
    """Unit 1 of one server is no unit 1 of the other; `--bus` takes the address of a server."""
    refused = {"client": "10.0.0.7:40001", "server": "10.0.0.10:502"}
    log = [*exchange(100, 1, ANSWER, "eth0"), *exchange(200, 1, bytes.fromhex("84 02"), "eth0", **refused)]
    config = rig(mb2={"kind": "modbus.tcp", "listen": "127.0.0.1:5021"})
    result = replay(log, config, buses={"10.0.0.9": "mb"}, leave_out=["level"])
    assert (result.played, words_of(result)) == (1, ["the rig has no bus that eth0 is (--bus): 2 messages"])


# 6.4 for unit 1 on a serial line: request and response with the checksums of pymodbus
LINE = [("01 04 00 00 00 01 31 CA", 0), ("01 04 02 01 F4 B9 27", 20)]


def test_a_serial_capture_of_rtu_is_played_to_a_bus_of_modbus() -> None:
    log = [
        TraceEntry(second * S + after_ms * MS, "ttyS0", "serial", "", b"\0" + bytes.fromhex(data))
        for second in range(1, 5)
        for data, after_ms in LINE
    ]
    result = replay(log, rig(), leave_out=["level"])
    assert (result.played, result.compared) == (4, 4)
