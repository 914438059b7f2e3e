"""Every shipped rig is recorded, a rig is made of the recording alone, and the master's side is played to it.

Nothing may differ but what the recording could not show, which the rig file says, and which is listed here by rig.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from made_rigs import put, save
from recorded_logs import MS, recorded

from fieldrig import Rig
from fieldrig.config.rig_file import load
from fieldrig.errors import UsageError
from fieldrig.traces.names import members_of
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_devices.from_recording.content import content_for
from fieldrig_devices.replay import replay
from fieldrig_devices.replay.families import OUTER

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]  # the machine takes ten seconds of an idle host
CONFIGS = Path(__file__).parents[3] / "configs"
RIGS = sorted(file.stem for file in CONFIGS.glob("*.yaml") if file.stem != "lab-vcan")  # the lab on another CAN bus
WITHOUT_DEVICES = {"modems"}
"""Rigs whose buses carry bytes of which no device can be made."""
MAY_DIFFER = {
    "lab": {
        "node6 did not send TPDO 1 9130h:01 Object 9130h, sub-index 1 500 (1F4h), 6150h:01 Object 6150h, "
        "sub-index 1 0 (2 of them in a row)": "TPDO 1, 186h, 5 bytes: sent 3 times, too seldom to find a rhythm",
    },
}
"""Differences in words, each with the sentence of the rig file that says why."""
ASKED = (
    "40 00 10", "40 18 10 01", "40 18 10 02", "40 17 10", *(f"40 00 1a {place:02x}" for place in range(5)),
    *(f"40 00 16 {place:02x}" for place in range(5)), "40 00 60 01", "40 41 60", "40 64 60", "40 00 20",
)  # fmt: skip
POLLED = ("03 0000 0004", "04 0000 0004", "01 0000 0004")


def claimed(rig: Rig, family: str, what: str) -> dict[str, list[int]]:
    """The node-IDs or units of a rig by bus."""

    def numbers(bus: str) -> Iterator[int]:
        for member in members_of(rig.config, bus):
            yield from (claim.value for claim in member.claims(what) if isinstance(claim.value, int))

    buses = (name for name, entry in rig.config.buses.items() if entry.bus.family == family)
    return {bus: sorted(set(numbers(bus))) for bus in buses}


def ask_all(rig: Rig) -> None:
    """A master that asks each node for its identity and mappings, starts all of them, and polls all units."""
    nodes, units = claimed(rig, "can", "node-ID"), claimed(rig, "modbus", "unit")
    member = rig.attach("master")
    links = {bus: member.link(bus) for bus in (*nodes, *units)}
    rig.run_until(500 * MS)
    for bus, node_ids in nodes.items():
        for node_id in node_ids:
            for request in ASKED:
                links[bus].send(CanFrame(0x600 + node_id, bytes.fromhex(request).ljust(8, b"\0")))
                rig.run_for(5 * MS)
    for bus in nodes:
        links[bus].send(CanFrame(0, b"\x01\x00"))
    number = 0
    for _ in range(10):
        for bus, unit_ids in units.items():
            for unit in unit_ids:
                for pdu in POLLED:
                    number += 1
                    links[bus].send(ModbusRequest(unit, bytes.fromhex(pdu), number))
                    rig.run_for(30 * MS)
        rig.run_for(50 * MS)
    rig.run_for(500 * MS)


@pytest.mark.parametrize("name", RIGS)
def test_a_shipped_rig_differs_only_in_what_its_recording_could_not_show(tmp_path: Path, name: str) -> None:
    log = [entry for entry in recorded(CONFIGS / f"{name}.yaml", ask_all) if entry.family in OUTER]
    file = save(log, tmp_path / f"{name}.jsonl")
    if name in WITHOUT_DEVICES:
        with pytest.raises(UsageError, match="shows no device of which a rig could be made"):
            content_for(file)
        return
    made = content_for(file)
    rig = put(made, tmp_path / "rig")
    result = replay(log, rig)
    text = " ".join(rig.read_text(encoding="utf-8").replace("#", " ").split())
    listed = MAY_DIFFER.get(name, {})
    found = {each.words for each in result.differences if not each.words.startswith("the rig has no bus that ")}
    assert found == set(listed)
    assert all(why in text for why in listed.values())
    without = [each.bus for each in result.differences if each.words.startswith("the rig has no bus that ")]
    assert sorted(without) == sorted(made.without)
    lines = sum(entry.family == "serial" for entry in log if entry.bus in without)
    if lines:
        assert f"{lines} messages of the family serial: no device can be made of them" in text
    assert result.compared >= 16


def test_all_rigs_of_the_list_are_shipped() -> None:
    assert {*MAY_DIFFER, *WITHOUT_DEVICES} <= set(RIGS)
    assert load(CONFIGS / "lab-vcan.yaml").buses.keys() == load(CONFIGS / "lab.yaml").buses.keys()
