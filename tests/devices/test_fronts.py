"""The law of fronts, over every kind of device: what a front names exists, and what it offers to a person works."""

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from every_kind import DEVICES, whole
from shipped import RIGS, in_virtual_time

from fieldrig.clock import MS
from fieldrig.config.build import build_alone
from fieldrig.config.rig_file import from_dict, load
from fieldrig.device import Device
from fieldrig.front import Clamp, Front, Key, Led, SevenSegment, Text
from fieldrig.virtual.rig import Rig
from fieldrig_devices.arp.terminal import panel

CONFIGS = Path(__file__).parents[2] / "configs"
LARGE = {"machine.yaml", "packaging-line.yaml"}
"""Rigs whose kinds the others have too."""


@pytest.fixture(scope="module")
def devices(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Device]:
    """A device of every kind, on its own and with power."""
    config = from_dict(whole(tmp_path_factory.mktemp("kinds")))
    devices = {name: build_alone(entry) for name, entry in config.devices.items()}
    for device in devices.values():
        device.start()
    return devices


@pytest.fixture(params=DEVICES)
def device(request: pytest.FixtureRequest, devices: dict[str, Device]) -> Device:
    return devices[request.param]


def test_each_point_of_a_front_exists(device: Device) -> None:
    assert device.front().points - device.points().keys() == set()
    assert [group.title for group in device.front().groups if not group.parts] == []


def test_what_is_operated_can_be_written(device: Device) -> None:
    points = device.points()
    operated = [part.point for part in device.front().parts if part.is_operated]
    assert [key for key in operated if points[key].write is None] == []


@pytest.mark.parametrize(
    ("rig", "device", "driven", "free"),
    [
        ("lab.yaml", "io", ["6000:01.0", "6401:01"], ["6000:01.2", "6401:02"]),
        ("machine.yaml", "line", ["I107"], ["I106", "adc1"]),
        ("pam-machine.yaml", "paper", ["IN16", "IN17"], ["IN0"]),
    ],
)
def test_a_terminal_that_a_wire_drives_only_shows_its_level(
    rig: str, device: str, driven: list[str], free: list[str]
) -> None:
    entry = load(CONFIGS / rig, ["time=virtual"]).devices[device]
    clamps = {
        part.words()["name"]: part.is_operated for part in build_alone(entry).front().parts if isinstance(part, Clamp)
    }
    assert [name for name in driven if clamps[name]] == []
    assert [name for name in free if not clamps[name]] == []


def test_what_is_operated_has_a_name_of_its_own(device: Device) -> None:
    names = [part.words()["name"] for part in device.front().parts if part.is_operated or isinstance(part, Clamp)]
    assert len(names) == len(set(names))


def unclear(front: Front) -> list[tuple[str, str, str]]:
    """Group, sort and label of parts that a person cannot tell from another one of their group."""
    seen = Counter(
        (group.title, part.sort, part.label) for group in front.groups for part in group.parts if part.sort != "gap"
    )
    return [which for which, count in seen.items() if count > 1]


def test_parts_of_a_group_are_told_from_each_other_by_their_labels(device: Device) -> None:
    assert unclear(device.front()) == []


@pytest.mark.long
@pytest.mark.parametrize("rig", [rig for rig in RIGS if rig not in LARGE])
def test_so_they_are_in_the_shipped_rigs(rig: str) -> None:
    devices = in_virtual_time(rig).devices
    found = {name: unclear(build_alone(entry).front()) for name, entry in devices.items()}
    assert {name: parts for name, parts in found.items() if parts} == {}


def test_each_unit_of_a_modbus_device_has_groups_of_its_own() -> None:
    front = build_alone(load(CONFIGS / "energy-meter.yaml", ["time=virtual"]).devices["meters"]).front()
    titles = [f"unit {number}: {sort}" for number in (1, 2, 3) for sort in ("terminals", "registers")]
    assert [group.title for group in front.groups] == titles
    first = {part.label: part.point for part in front.groups[1].parts}
    assert first["voltage_l1"] == "1/voltage_l1"


def test_values_that_a_part_waits_for_are_of_the_type_of_its_point(device: Device) -> None:
    points = device.points()
    for part in device.front().parts:
        if isinstance(part, Led | Text):
            present = points[part.point].read()
            waited = (*part.lit, *part.blinks) if isinstance(part, Led) else (*part.good, *part.bad)
            assert {type(value) for value in waited} <= {type(present)}, part


def test_a_value_with_states_is_compared_with_states_that_it_has(device: Device) -> None:
    points = device.points()
    for part in device.front().parts:
        states = points[part.point].states if part.point else ()
        if states and isinstance(part, Led | Text):
            waited = (*part.lit, *part.blinks) if isinstance(part, Led) else (*part.good, *part.bad)
            assert set(waited) <= set(states), part


def test_the_plate_names_the_kind_and_all_of_it_is_json(device: Device) -> None:
    words = device.front_words()
    assert words["plate"]["kind"] in {entry["kind"] for entry in DEVICES.values()}
    assert words["plate"]["kind"] == device.kind
    assert json.loads(json.dumps(words)) == words


def test_a_front_stays_as_it_is_and_reads_change_nothing(device: Device) -> None:
    assert device.front_words() == device.front_words()


def test_a_device_without_a_front_of_its_own_has_one_from_its_points(devices: dict[str, Device]) -> None:
    front = Front.of_points(devices["tank"].points())
    by_label = {part.label: part for part in front.parts}
    assert {label: part.sort for label, part in by_label.items()} == {
        "level": "knob", "volume": "number", "inflow": "number", "outflow": "number", "leak": "number",
        "outlet": "number", "high": "led", "low": "led", "overflow": "number", "overflows": "number",
        "dry_runs": "number",
    }  # fmt: skip


@pytest.mark.manual("ARP-064")
@pytest.mark.parametrize("model", ["TR4", "TR5"])
def test_each_key_and_led_of_a_terminal_is_on_its_front(model: panel.Model) -> None:
    parts = [*_terminal(model).front().parts]
    assert {part.point.removeprefix("key.") for part in parts if isinstance(part, Key)} == panel.keys(model).keys()
    assert {part.point.removeprefix("led.") for part in parts if isinstance(part, Led)} == panel.leds(model).keys()


def test_the_front_of_a_card_says_what_its_codes_mean(devices: dict[str, Device]) -> None:
    [error] = [part for part in devices["card"].front().parts if part.label == "error" and isinstance(part, Text)]
    words = dict(error.names)
    assert (words[0], words[105]) == ("none", "reset: Enable is open (105)")
    assert words[devices["card"].points()["error"].read()]


def _terminal(model: str) -> Device:
    rig = {
        "time": "virtual",
        "buses": {"can": {"kind": "can.virtual", "bitrate": 500_000}},
        "devices": {"panel": {"kind": "terminal.tr", "model": model, "links": {"can": "can"}}},
    }
    return build_alone(from_dict(rig).devices["panel"])


def test_display_of_a_smart_io_node_shows_its_segments(devices: dict[str, Device]) -> None:
    device = devices["smart"]
    write = device.points()["display.character"].write
    assert write is not None
    write(ord("7"))
    [display] = [part for part in device.front().parts if isinstance(part, SevenSegment)]
    assert device.points()[display.segments].read() == "abc"


@pytest.mark.long
@pytest.mark.parametrize("processes", ["one", pytest.param("each", marks=pytest.mark.system)])
def test_a_rig_answers_with_the_front_of_a_device(processes: str) -> None:
    rig = {
        "time": "virtual", "processes": processes,
        "buses": {"wires": {"kind": "wires.virtual"}},
        "devices": {"tank": {"links": {"wires": "wires"}, **DEVICES["tank"]}},
    }  # fmt: skip
    with Rig(from_dict(rig)) as running:
        front = running.front("tank")
        assert front["plate"]["kind"] == "plant.tank"
        assert front["units"]["level"] == "m"
        assert [part["shape"] for group in front["groups"] for part in group["parts"] if "shape" in part] == ["tank"]
        running.run_for(10 * MS)
        number = running.add_fault("tank", {"what": "power_off"})
        running.run_for(10 * MS)
        assert running.front("tank") == front, "the sheet metal stays where it is"
        running.clear_fault("tank", number)


@pytest.fixture(scope="module")
def fronts_of_shipped_rigs() -> dict[str, list[Device]]:
    return {file: [*_built(file)] for file in RIGS if file not in LARGE}


def _built(file: str) -> Iterator[Device]:
    for entry in in_virtual_time(file).devices.values():
        device = build_alone(entry)
        device.start()
        yield device


@pytest.mark.long
def test_each_point_of_the_fronts_of_shipped_rigs_exists(fronts_of_shipped_rigs: dict[str, list[Device]]) -> None:
    for file, devices in fronts_of_shipped_rigs.items():
        for device in devices:
            assert device.front().points - device.points().keys() == set(), (file, device.kind)


@pytest.mark.parametrize(("limits", "sort"), [({}, "number"), ({"low_stop_rad": -3.0, "high_stop_rad": 12.0}, "gauge")])
def test_a_drive_shows_its_position_between_its_limits(limits: dict[str, float], sort: str) -> None:
    rig = {
        "time": "virtual",
        "buses": {"can": {"kind": "can.virtual", "bitrate": 500_000}},
        "devices": {"drive": {"kind": "cia402.drive", "node_id": 3, "links": {"can": "can"}, **limits}},
    }
    front = build_alone(from_dict(rig).devices["drive"]).front()
    [position] = [part.words() for part in front.parts if part.label == "position"]
    assert position["sort"] == sort
    assert [position[key] for key in ("low", "high") if limits] == [*limits.values()]


@pytest.mark.manual("SCU-074")
def test_the_front_of_a_panel_has_the_pins_of_its_pwm_channels() -> None:
    rig = {
        "time": "virtual",
        "buses": {"wires": {"kind": "wires.virtual"}},
        "devices": {"scu": {"kind": "hmiscu", "channel_0": {"mode": "pwm"}, "links": {"wires": "wires"}}},
    }
    front = build_alone(from_dict(rig).devices["scu"]).front()
    [channel] = [group for group in front.groups if group.title == "channel PWM00"]
    shown = [part.point for part in channel.parts]
    assert shown[2:] == ["PWM00.InFrequency", "PWM00.Busy", "PWM00.Error"]
