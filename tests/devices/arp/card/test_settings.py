"""Valid and invalid settings of a card in a rig file, and the mistakes that `fieldrig check` reports."""

import re
from pathlib import Path
from typing import Any, cast

import pytest

from fieldrig.config.build import try_devices
from fieldrig.config.rig_file import from_dict, look_through
from fieldrig.errors import ConfigError
from fieldrig_devices.arp.card.card import ArpCard
from fieldrig_devices.arp.card.settings import ArpSettings
from fieldrig_devices.arp.language import files
from fieldrig_devices.arp.language.compiler import compile_text

GOOD = "BEG MAIN\nLOOP:\nGOTO LOOP\nEND\n"
OBJECT_OF_2 = files.encode(compile_text(GOOD), "winder", 2)


def rig(**settings: Any) -> dict[str, Any]:
    buses = {"wires": {"kind": "wires.virtual"}, "can0": {"kind": "can.virtual"}, "user1": {"kind": "serial.virtual"}}
    links = {"wires": "wires", "can": "can0", "user": "user1"}
    return {"time": "virtual", "buses": buses, "devices": {"card1": {"kind": "arp", "links": links, **settings}}}


def wrong(folder: Path, **settings: Any) -> list[str]:
    """Mistakes that check finds."""
    try:
        config = from_dict(rig(**settings), folder)
    except ConfigError as cause:
        return [str(mistake) for mistake in cause.mistakes]
    return [str(mistake) for mistake in try_devices(config.devices.values())]


def test_a_card_needs_nothing_at_all(tmp_path: Path) -> None:
    config = from_dict({"time": "virtual", "devices": {"card1": {"kind": "arp"}}}, tmp_path)
    assert try_devices(config.devices.values()) == []


def test_a_card_with_everything(tmp_path: Path) -> None:
    (tmp_path / "winder.I03").write_text(GOOD)
    settings = {
        "number": 3,
        "program": "winder.I03",
        "parameters": {"general": {1: 1, 16: 20}, "axis1": {1: 96, 4: 2}, "axis2": {7: 0.5}},
        "inputs": {"I108": True, "adc1": 0.005, "encoder1": -5},
        "signals": {"encoder1": "spindle.encoder", "O104": "brake"},
        "latch1": "I107",
        "io_nodes": [1, None],
        "terminal": True,
        "readings": {"pst_join": "through"},
        "costs": {"instruction_us": 20},
        "exchange": {"send": [{"channel": 1, "words": ["V1", "POS1"]}]},
    }
    assert wrong(tmp_path, **settings) == []


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"parameters": {"general": {1: 0}}}, r"@Par\[1\] .*cannot be 0; expected a whole number from 1 to 10 ms"),
        ({"parameters": {"general": {1: 1.5}}}, r"@Par\[1\] .*cannot be 1.5; expected"),
        ({"parameters": {"general": {6: 300}}}, r"@Par\[6\] .*expected 125, 250, 500, 1000 kbaud"),
        ({"parameters": {"general": {17: 1}}}, r"there is no @Par\[17\]; expected a number from 1 to 16"),
        ({"parameters": {"axis1": {15: 60.001}}}, r"@Par1\[15\] .*0 to 60 s"),
        ({"parameters": {"axis2": {1: 0.0001}}}, r"@Par2\[1\] .*more than three decimals; expected 0.001 to"),
        ({"parameters": {"axis3": {}}}, r"parameters.axis3: there is no such key"),
        ({"inputs": {"I109": True}}, r"no terminal 'I109'"),
        ({"inputs": {"I101": 2}}, r"I101 cannot be 2; expected true or false"),
        ({"inputs": {"adc3": True}}, r"adc3 cannot be True; expected a number"),
        ({"signals": {"encoder3": "x"}}, r"no terminal 'encoder3'"),
        ({"latch1": "I109"}, r"latch1"),
        ({"number": 100}, r"from 0 to 99"),
        ({"io_nodes": [1, 2, 3]}, r"io_nodes"),
        ({"io_nodes": [4, 4]}, r"node-ID 4 .*twice"),
        ({"io_nodes": [10]}, r"node-ID 10 .*twice"),
        ({"terminal": True, "parameters": {"general": {8: 10}}}, r"node-ID 10 .*twice"),
        ({"program": "nothing.I01"}, r"no such file"),
        (
            {"signals": {"O101": "lamp", "dac1": "lamp"}},
            r"O101 and dac1 both drive the wire 'lamp'; expected one output",
        ),
        ({"signals": {"I101": ""}}, r"I101 has no wire; expected a name"),
        ({"parameters": {"axis1": {7: float("inf")}}}, r"@Par1\[7\] .*: inf is not a number; expected 0.001"),
        ({"costs": {"control_us": 2_000}}, r"control_us and scheduler_us take all of @Par\[1\] \(2 ms\)"),
        (
            {"exchange": {"receive": [{"node": 10, "channel": 1, "words": ["V1"]}]}},
            r"node 10 is this card; expected the node-ID of another",
        ),
        (
            {"exchange": {"send": [{"channel": 1, "words": ["V1"]}]}, "parameters": {"general": {5: 64}}},
            r"@Par\[5\] is 64; expected a node-ID up to 63",
        ),
    ],
)
@pytest.mark.manual("ARP-005")
def test_a_mistake_is_reported_with_what_was_expected(tmp_path: Path, settings: dict[str, Any], says: str) -> None:
    found = wrong(tmp_path, **settings)
    assert len(found) == 1
    assert re.search(says, found[0], re.DOTALL), found[0]


def test_each_wrong_parameter_input_and_tie_is_reported_at_its_key(tmp_path: Path) -> None:
    found = wrong(
        tmp_path,
        parameters={"axis2": {26: 1, 4: 9}},
        inputs={"I109": True, "I108": 5, "I107": True},
        signals={"O101": "lamp", "O102": "lamp", "O103": ""},
    )
    keys = ("parameters.axis2[26]", "parameters.axis2[4]", "inputs.I109", "inputs.I108", "signals.O102", "signals.O103")
    assert [f"devices.card1.{key}: " in mistake for key, mistake in zip(keys, found, strict=True)] == [True] * 6


@pytest.mark.parametrize(
    "settings", [{"terminal": True}, {"io_nodes": [1]}, {"exchange": {"send": [{"channel": 1, "words": ["V1"]}]}}]
)
def test_what_is_on_a_can_needs_one(tmp_path: Path, settings: dict[str, Any]) -> None:
    config = from_dict({"time": "virtual", "devices": {"card1": {"kind": "arp", **settings}}}, tmp_path)
    (found,) = try_devices(config.devices.values())
    assert (found.key, found.remedy) == ("devices.card1", "add `can` to its links")


@pytest.mark.manual("ARP-117")
def test_every_mistake_in_a_program_has_its_line_and_column(tmp_path: Path) -> None:
    (tmp_path / "bad.I01").write_text("BEG MAIN\n  V1001 == 5\n  GOTO NOWHERE\nV1 = 3\nEND\n")
    found = wrong(tmp_path, program="bad.I01")
    assert [f"bad.I01:{place}" in mistake for place, mistake in zip(("2:3", "3:3", "4:4"), found, strict=True)] == [
        True
    ] * 3


def test_mistakes_of_a_program_are_reported_once_beside_those_of_the_rig_file(tmp_path: Path) -> None:
    (tmp_path / "bad.I01").write_text("BEG MAIN\nV1001 == 5\nEND\n")
    (tmp_path / "rig.yaml").write_text(
        "time: virtual\ndevices:\n"
        "  card1: {kind: arp, program: bad.I01}\n"
        "  card2: {kind: arp, program: bad.I01}\n"
        "  card3: {kind: arp, number: 100}\n"
    )
    config, right, mistakes = look_through(tmp_path / "rig.yaml")
    assert config is None
    assert [entry.name for entry in right] == ["card1", "card2"]
    assert [mistake.key for mistake in mistakes] == ["devices.card3.number"]
    (found,) = try_devices(right)
    assert found.file.startswith(str(tmp_path / "bad.I01"))


@pytest.mark.manual("ARP-118")
@pytest.mark.parametrize(
    ("file", "content", "number", "says"),
    [
        ("winder.I02", GOOD.encode(), 1, "it is for card 02, and the number of this one is 1"),
        ("winder.D02", OBJECT_OF_2, 1, "it is for card 02"),
        ("winder.D02", OBJECT_OF_2[:-3], 2, "damaged"),
        ("winder.O02", files.binary(OBJECT_OF_2, 2), 2, "name the object in ASCII, .Dnn"),
    ],
)
def test_a_program_for_another_card_is_refused(
    tmp_path: Path, file: str, content: bytes, number: int, says: str
) -> None:
    (tmp_path / file).write_bytes(content)
    (found,) = wrong(tmp_path, program=file, number=number)
    assert says in found


@pytest.mark.manual("ARP-118")
@pytest.mark.parametrize(
    ("file", "content"), [("winder.I02", GOOD.encode()), ("winder.D02", OBJECT_OF_2), ("any.txt", GOOD.encode())]
)
def test_a_source_or_an_object_for_this_card_is_right(tmp_path: Path, file: str, content: bytes) -> None:
    (tmp_path / file).write_bytes(content)
    assert wrong(tmp_path, program=file, number=2) == []


def test_lines_to_copy_name_what_reaches_the_card(tmp_path: Path) -> None:
    data = rig(parameters={"general": {5: 12}})
    data["time"] = "real"
    data["buses"] = {
        "wires": {"kind": "wires.hub"},
        "can0": {"kind": "can.hub", "socketcand": "127.0.0.1:29599"},
        "user1": {"kind": "serial.tcp", "listen": "127.0.0.1:7099"},
    }
    config = from_dict(data, tmp_path)
    card = config.devices["card1"]
    buses = {name: config.buses[several[0]].bus for name, several in card.links.items()}
    lines = {tool.label: tool.line for tool in ArpCard.tools("card1", cast(ArpSettings, card.settings), buses)}
    assert lines["state"].startswith("fieldrig get card1/state card1/error ")
    assert lines["USER port"] == "fieldrig arp state --port socket://127.0.0.1:7099"
    assert "n.add_node(12, " in lines["what it is"]


def test_a_card_in_virtual_time_is_reached_by_its_points(tmp_path: Path) -> None:
    config = from_dict(rig(), tmp_path)
    card = config.devices["card1"]
    buses = {name: config.buses[several[0]].bus for name, several in card.links.items()}
    assert [tool.label for tool in ArpCard.tools("card1", cast(ArpSettings, card.settings), buses)] == ["state"]
