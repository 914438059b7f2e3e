"""CAN networks as DBC, read by cantools, which others wrote; frames are those of CiA 301, CiA 402 and CiA 401."""

import re
from pathlib import Path
from typing import Any

import cantools
import pytest
from cantools.database.can import Database
from shipped import CONFIGS, RIGS

from fieldrig.config.rig_file import from_dict, load
from fieldrig_devices.export.can_networks import networks
from fieldrig_devices.export.dbc import ENCODING, text_of

C_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def databases(source: Path | dict[str, Any]) -> dict[str, Database]:
    """The networks of a rig by the names of their buses, as cantools reads them: overlapping signals are an error."""
    config = load(source) if isinstance(source, Path) else from_dict(source, CONFIGS)
    found = {}
    for network in networks(config):
        database = cantools.database.load_string(text_of(network).decode(ENCODING), "dbc")
        assert isinstance(database, Database)
        found[network.name] = database
    return found


def rig(**devices: dict[str, Any]) -> dict[str, Any]:
    buses = {"can0": {"kind": "can.virtual"}, "wires": {"kind": "wires.virtual"}}
    return {"time": "virtual", "buses": buses, "devices": devices}


def io(node_id: int, **settings: Any) -> dict[str, Any]:
    links = {"can": "can0"} | ({"wires": "wires"} if "signals" in settings else {})
    return {"kind": "canopen.node", "node_id": node_id, "eds": "eds/io32.eds", "links": links, **settings}


def drive(node_id: int, **settings: Any) -> dict[str, Any]:
    return {"kind": "cia402.drive", "node_id": node_id, "links": {"can": "can0"}, **settings}


@pytest.fixture(scope="module")
def lab() -> Database:
    return databases(CONFIGS / "lab.yaml")["can0"]


@pytest.fixture(scope="module")
def axis() -> Database:
    return databases(rig(axis=drive(3)))["can0"]


def decoded(database: Database, identifier: int, data: str) -> dict[str, Any]:
    """The name of a message, and its values: a text where the number has a name."""
    message = database.get_message_by_frame_id(identifier)
    values = message.decode(bytes.fromhex(data))
    assert isinstance(values, dict)
    return {"message": message.name, **{name: str(of) if hasattr(of, "name") else of for name, of in values.items()}}


@pytest.mark.parametrize(
    ("identifier", "data", "expected"),
    [
        (0x000, "81 05", {"message": "NMT", "command": "reset node", "node": "io"}),
        (0x000, "01 00", {"message": "NMT", "command": "start", "node": "all nodes"}),
        (0x080, "", {"message": "SYNC"}),
        (0x705, "00", {"message": "io_heartbeat", "state": "boot-up", "toggle": 0}),
        (0x706, "85", {"message": "sensor_heartbeat", "state": "operational", "toggle": 1}),
        (0x085, "30 81 11 00 00 00 00 00", {"error_code": "life guard or heartbeat error", "generic": 1, "current": 0}),
        (0x085, "00 00 00 00 00 00 00 00", {"message": "io_EMCY", "error_code": "error reset or no error"}),
        (0x605, "40 01 64 02 00 00 00 00", {"service": "SDO read", "read_index": "6401h Analogue input"}),
        (0x585, "43 18 10 01 78 56 34 12", {"service": "SDO value", "value_index": "1018h", "value_value": 0x12345678}),
        (0x605, "2b 11 64 03 e8 03 00 00", {"service": "SDO write", "write_subindex": 3, "write_value": 1000}),
        (0x585, "80 00 20 00 00 00 02 06", {"service": "SDO abort", "abort_code": "no object", "abort_index": 0x2000}),
        (0x585, "00 41 42 43 44 45 46 47", {"service": "SDO segment", "segment_data": 0x47464544434241}),
        (0x7E5, "5e 00 00 00 00 00 00 00", {"message": "LSS_request", "service": "inquire node-ID"}),
    ],
)
def test_services_are_messages(lab: Database, identifier: int, data: str, expected: dict[str, Any]) -> None:
    assert decoded(lab, identifier, data).items() >= expected.items()


def test_pdos_have_the_names_of_objects_wires_and_units(lab: Database) -> None:
    inputs = decoded(lab, 0x185, "02 ff 00 00")
    assert (inputs["tank_high"], inputs["tank_low"], inputs["Read_inputs_byte_2"]) == (0, 1, 255)
    level = lab.get_message_by_name("io_TPDO2").get_signal_by_name("tank_level")
    assert (level.scale, level.unit, level.is_signed) == (0.0001, "m", True)
    assert level.comment == "6401h:01 Analogue input 1"
    assert decoded(lab, 0x285, "10 27 00 00 00 00 f0 d8")["tank_level"] == 1.0
    assert decoded(lab, 0x285, "10 27 00 00 00 00 f0 d8")["Analogue_input_4"] == -10_000
    outlet = lab.get_message_by_name("io_RPDO2").get_signal_by_name("tank_outlet")
    assert (outlet.scale, outlet.unit, outlet.receivers) == (0.01, "%", ["io"])
    assert lab.get_message_by_name("sensor_heartbeat").cycle_time == 1000


@pytest.mark.parametrize(
    ("word", "state", "bits"),
    [
        ("40 02", "switch on disabled", {"remote": 1}),
        ("31 02", "ready to switch on", {"remote": 1, "target_reached": 0}),
        ("33 02", "switched on", {}),
        ("37 06", "operation enabled", {"target_reached": 1, "internal_limit_active": 0}),
        ("17 0a", "quick stop active", {"internal_limit_active": 1}),
        ("1f 02", "fault reaction active", {}),
        ("b8 02", "fault", {"warning": 1}),
        ("00 00", "not ready to switch on", {"remote": 0}),
    ],
)
def test_a_status_word_is_its_state_and_its_bits(axis: Database, word: str, state: str, bits: dict[str, int]) -> None:
    """CiA 402-2, table of the states: bit 4 is a part of none, bit 5 only of those behind 'ready to switch on'."""
    values = decoded(axis, 0x183, word)
    assert values["Statusword_state"] == state
    assert values.items() >= bits.items()


@pytest.mark.parametrize(
    ("word", "command", "bits"),
    [
        ("06 00", "shutdown", {"halt": 0}),
        ("07 00", "switch on", {}),
        ("0f 01", "enable operation", {"halt": 1}),
        ("02 00", "quick stop", {}),
        ("80 00", "disable voltage", {"fault_reset": 1}),
    ],
)
def test_a_control_word_is_its_command_and_its_bits(
    axis: Database, word: str, command: str, bits: dict[str, int]
) -> None:
    values = decoded(axis, 0x203, word)
    assert values["Controlword_command"] == command
    assert values.items() >= bits.items()


def test_a_mode_is_named_and_a_torque_is_in_percent() -> None:
    mapped = {"1A01:00": 3, "1A01:01": 0x60410010, "1A01:02": 0x60610008, "1A01:03": 0x60770010}
    axis = databases(rig(axis=drive(3, objects=mapped)))["can0"]
    values = decoded(axis, 0x283, "37 02 08 e7 03")
    assert values["Modes_of_operation_display"] == "cyclic synchronous position"
    [torque] = [signal for signal in axis.get_message_by_frame_id(0x283).signals if signal.unit == "%"]
    assert (torque.start, values[torque.name]) == (24, pytest.approx(99.9))


@pytest.mark.long
@pytest.mark.parametrize("file", RIGS)
def test_networks_of_all_shipped_rigs_are_read(file: str) -> None:
    for database in databases(CONFIGS / file).values():
        names = [message.name for message in database.messages]
        assert len({name.lower() for name in names}) == len(names)
        every = [*names, *(signal.name for message in database.messages for signal in message.signals)]
        assert [name for name in every if not C_NAME.fullmatch(name)] == []
        assert {sender for message in database.messages for sender in message.senders} <= {
            node.name for node in database.nodes
        }


@pytest.mark.parametrize(
    ("type", "words"),
    [
        (0, "sent with SYNC after an event"),
        (1, "sent with each SYNC"),
        (240, "sent with each SYNC of 240"),
        (253, "sent on request"),
        (254, "sent after an event"),
        (255, "sent after an event"),
    ],
)
def test_a_pdo_says_when_it_is_sent(type: int, words: str) -> None:
    """CiA 301, 7.5.2.37, table of transmission types."""
    node = databases(rig(node=io(1, objects={"1800:02": type, "1400:02": 1})))["can0"]
    assert node.get_message_by_name("node_TPDO1").comment == f"TPDO 1 of node, {words}"
    assert node.get_message_by_name("node_RPDO1").comment == "RPDO 1 of node, acts at the next SYNC"


@pytest.mark.parametrize("entry", [0x6000_0100, 0x6000_01FF, 0x6000_0103, 0x0005_0008, 0x9999_0108, 0])
def test_a_mapping_that_fits_no_object_is_a_message_still(entry: int) -> None:
    """No bits, too many, other ones than the object has, a dummy, an object that does not exist, nothing."""
    node = databases(rig(node=io(1, objects={"1A00:01": entry})))["can0"]
    assert node.get_message_by_frame_id(0x181).name == "node_TPDO1"


def test_a_pdo_between_two_nodes_is_one_message_of_its_producer() -> None:
    inner = databases(rig(first=io(1), second=io(2, objects={"1400:01": 0x181})))["can0"]
    message = inner.get_message_by_frame_id(0x181)
    assert (message.name, message.senders, sorted(message.receivers)) == ("first_TPDO1", ["first"], ["second"])


@pytest.mark.parametrize(("cob_id", "identifier"), [(0x2001_2345, 0x1_2345), (0xA0, 0xA0), (0x8000_00A0, 0x85)])
def test_an_emergency_has_the_identifier_that_the_node_has_for_it(cob_id: int, identifier: int) -> None:
    """CiA 301, 7.5.2.17: bit 29 is a frame with 29 bits; bit 31 switches EMCY off, and it is 80h + node-ID then."""
    node = databases(rig(node=io(5, objects={"1014:00": cob_id})))["can0"]
    assert node.get_message_by_name("node_EMCY").frame_id == identifier
    assert node.get_message_by_name("node_EMCY").is_extended_frame == (identifier > 0x7FF)


def test_cards_that_exchange_words_have_a_message_for_each_channel() -> None:
    """docs/devices/arp/arp-can.md: channel 1 is TPDO 5, 240h + node-ID; `line` is node 11, `unwinder` is node 12."""
    cell = databases(CONFIGS / "arp-cell.yaml")["can0"]
    channel = cell.get_message_by_frame_id(0x24B)
    assert (channel.name, channel.senders) == ("line_TPDO5", ["line"])
    found = [(signal.name, signal.start, signal.length, signal.scale) for signal in channel.signals]
    assert found == [("V2", 0, 32, 0.001), ("FLAG3", 32, 32, 1)]
    assert {receiver for signal in channel.signals for receiver in signal.receivers} == {"unwinder"}


def test_a_pdo_that_does_not_exist_and_one_with_29_bits() -> None:
    objects = {"1800:01": 0x8000_0181, "1801:01": 0x2000_0000 | 0x1234_5678}
    node = databases(rig(node=io(1, objects=objects)))["can0"]
    found = {message.name: message for message in node.messages}
    assert "node_TPDO1" not in found
    assert (found["node_TPDO2"].frame_id, found["node_TPDO2"].is_extended_frame) == (0x1234_5678, True)


def test_a_master_of_the_rig_sends_what_a_master_sends() -> None:
    """Its own node has no EDS, so it has no PDOs."""
    nodes = {"io": {"node_id": 5}}
    controller = {"kind": "hmiscu", "can_master": {"node_id": 100, "nodes": nodes}, "links": {"can": "can0"}}
    network = databases(rig(press=controller, io=io(5)))["can0"]
    assert [(node.name, node.comment) for node in network.nodes] == [
        ("press", "node-ID 100, without an EDS"), ("io", "node-ID 5"),
    ]  # fmt: skip
    sent = {message.name for message in network.messages if message.senders == ["press"]}
    assert sent >= {"NMT", "SYNC", "io_RPDO1", "io_SDO_request", "press_heartbeat"}
    assert not [message.name for message in network.messages if re.match("press_.PDO", message.name)]


def test_a_slave_outside_has_what_its_master_declares() -> None:
    slave = {
        "node_id": 9,
        "inputs": {1: [{"name": "Main.ready", "type": "bool"}, {"name": "Main.t", "type": "s16"}]},
        "outputs": {2: [{"name": "Main.set", "type": "f32"}]},
    }
    controller = {"kind": "hmiscu", "can_master": {"node_id": 100, "nodes": {"oven": slave}}, "links": {"can": "can0"}}
    network = databases(rig(press=controller))["can0"]
    assert decoded(network, 0x189, "03 ff 01") == {"message": "oven_TPDO1", "Main_ready": 1, "Main_t": -127}
    assert decoded(network, 0x309, "00 00 c0 3f") == {"message": "oven_RPDO2", "Main_set": 1.5}
    assert network.get_message_by_name("oven_RPDO2").senders == ["press"]
    assert network.get_message_by_name("oven_heartbeat").frame_id == 0x709


def test_what_a_master_maps_at_the_start_is_mapped() -> None:
    mapping = {"1A00:00": "00", "1A00:01": "10010164", "1A00:02": "10020164"}
    sdo = {**mapping, "1A00:00": "02"}
    nodes = {"io": {"node_id": 5, "sdo": sdo}}
    controller = {"kind": "hmiscu", "can_master": {"node_id": 100, "nodes": nodes}, "links": {"can": "can0"}}
    network = databases(rig(press=controller, io=io(5)))["can0"]
    names = [signal.name for signal in network.get_message_by_name("io_TPDO1").signals]
    assert names == ["Analogue_input_1", "Analogue_input_2"]


def test_a_slave_has_the_names_of_its_points() -> None:
    feeder = databases(CONFIGS / "feeder.yaml")["can3"]
    keys = [f"panel_key{number}" for number in range(1, 9)]
    assert [signal.name for signal in feeder.get_message_by_name("sealer_TPDO1").signals][16:] == keys
    assert feeder.get_message_by_name("sealer_RPDO2").get_signal_by_name("AQ1").start == 16


def test_names_of_devices_become_names_of_c_that_differ() -> None:
    database = databases(rig(**{"a-b": io(1), "a_b": io(2), "master": io(3)}))["can0"]
    assert [node.name for node in database.nodes] == ["master", "a_b", "a_b_2", "master_2"]
    assert database.get_message_by_frame_id(0x181).senders == ["a_b"]
    assert database.get_message_by_frame_id(0x183).senders == ["master_2"]


def test_a_long_name_is_kept_and_shortened() -> None:
    """DBC has names of 32 characters, and the attribute SystemSignalLongSymbol for the whole one."""
    name = "the-transmitter-of-the-third-tank-behind-the-second-pump"
    [network] = networks(from_dict(rig(**{name: io(1)}), CONFIGS))
    text = text_of(network).decode(ENCODING)
    assert all(len(word) <= 32 for word in re.findall(r"^(?:BO_ \d+| SG_) (\w+)", text, re.MULTILINE))
    read = cantools.database.load_string(text, "dbc")
    assert read.get_message_by_frame_id(0x181).name == f"{name.replace('-', '_')}_TPDO1"  # type: ignore[union-attr]
