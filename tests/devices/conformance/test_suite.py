"""The suite on correct nodes: no case fails, few are not applicable, and the node is left as it was."""

from pathlib import Path

import pytest
from broken_nodes import NODE_ID
from canopen_bench import IO32, LEVEL_SENSOR
from conform_bench import HERE, conformed, failures, numbers, rig_of

from fieldrig.config.rig_file import from_dict
from fieldrig.errors import RigError
from fieldrig.storage.store import MemoryStore
from fieldrig.virtual.rig import Rig
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.options import Options
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

# Number of cases per family, from the public log of CANopenNode under CiA's test tool.
FAMILIES = {
    "EDS checker": 1,
    "SDO": 30,
    "PDO": 33,
    "OD": 9,
    "Emergency": 6,
    "Synchronization": 10,
    "Guarding": 6,
    "Heartbeat": 7,
    "Heartbeat versus guarding": 7,
    "Testing other": 10,
    "State": 4,
    "Transition": 4,
}

MEMBER = "\n[1280sub{}]\nParameterName={}\nObjectType=0x7\nDataType={}\nAccessType={}\nDefaultValue={}\n"
SDO_CLIENT = "\n[1280]\nParameterName=SDO client parameter\nObjectType=0x9\nSubNumber=4\n" + "".join(
    MEMBER.format(*member)
    for member in (
        (0, "Highest sub-index supported", "0x0005", "const", "3"),
        (1, "COB-ID client to server", "0x0007", "rw", "0x80000000"),
        (2, "COB-ID server to client", "0x0007", "rw", "0x80000000"),
        (3, "Node-ID of the server", "0x0005", "rw", "0"),
    )
)


def test_there_are_the_127_cases_of_the_log() -> None:
    cases = choose(())
    assert len(cases) == 127
    assert {family: sum(1 for case in cases if case.family == family) for family in FAMILIES} == FAMILIES
    assert all(case.requirement.endswith(".") and case.clause for case in cases)
    assert (cases[0].number, cases[7].number, cases[7].name, cases[-1].number) == ("1.0", "2.7", "SDO 07", "10.4")


@pytest.mark.long
def test_io_node_passes_at_least_115_cases_and_fails_none() -> None:
    report = conformed()
    assert failures(report) == {}
    assert report.executed >= 115
    assert all(result.reason for result in report.of(Verdict.NOT_APPLICABLE))
    assert all(not result.notes for result in report.results)


@pytest.mark.long
def test_sensor_node_fails_none() -> None:
    report = conformed(eds=LEVEL_SENSOR)
    assert failures(report) == {}
    assert report.executed >= 80
    assert all(result.reason for result in report.of(Verdict.NOT_APPLICABLE))


@pytest.mark.long
def test_same_run_gives_the_same_frames() -> None:
    first, second = conformed("SDO", "State"), conformed("SDO", "State")
    assert [result.frames for result in first.results] == [result.frames for result in second.results]


def with_sdo_client(folder: Path) -> Path:
    eds = folder / "client.eds"
    eds.write_text(IO32.read_text() + SDO_CLIENT)
    return eds


def test_stored_parameters_of_an_sdo_client_are_tried(tmp_path: Path) -> None:
    eds = with_sdo_client(tmp_path)
    assert numbers(conformed("2.30", eds=eds), Verdict.PASSED) == ["2.30"]
    assert numbers(conformed("2.30", eds=eds, fault="StoresNothing"), Verdict.FAILED) == ["2.30"]


def test_eds_with_a_default_beyond_its_limit_fails(tmp_path: Path) -> None:
    eds = tmp_path / "wrong.eds"
    eds.write_text(
        IO32.read_text().replace("DefaultValue=0\nLowLimit=0\nHighLimit=2\n", "DefaultValue=3\nHighLimit=2\n")
    )
    with Rig(from_dict(rig_of(), HERE)) as rig:
        report = conform_virtual(rig, "can0", Description(eds, NODE_ID), choose(["1.0"]))
    assert "[1029sub1] DefaultValue 3" in failures(report)["1.0"]


# State of the node after a run.


def values(rig: Rig) -> dict[str, object]:
    """All points except the clock."""
    return {key: rig.get("node", key) for key in rig.keys("node") if key != "time"}


@pytest.mark.long
def test_node_is_as_it_was() -> None:
    store = MemoryStore()
    objects = {"1017:00": 700, "1018:04": 77, "6206:01": 3}
    with Rig(from_dict(rig_of(objects=objects), HERE), stores={"node": store}) as rig:
        rig.run_until(10_000_000)
        before = values(rig)
        report = conform_virtual(rig, "can0", Description(IO32, NODE_ID), choose(()))
        after = values(rig)
    assert {key: (before[key], after[key]) for key in before if before[key] != after[key]} == {}
    assert report.notes[0].startswith("the node has the same parameters as before")
    with Rig(from_dict(rig_of(objects=objects), HERE), stores={"node": store}) as rig:
        rig.run_until(10_000_000)
        assert values(rig) == before


@pytest.mark.long
def test_what_was_changed_since_power_on_is_put_back_too() -> None:
    with Rig(from_dict(rig_of(), HERE)) as rig:
        cob_id = int(rig.get("node", "1800:01"))
        changes = (("1017:00", 350), ("6200:02", 0xA5))
        # the inhibit time of a PDO is written while it does not exist
        for key, value in (*changes, ("1800:01", cob_id | 1 << 31), ("1800:03", 70), ("1800:01", cob_id)):
            rig.set("node", key, value)
        before = values(rig)
        report = conform_virtual(rig, "can0", Description(IO32, NODE_ID), choose(["State", "Testing other"]))
        assert values(rig) == before
    assert "values that a reset had changed were restored" in report.notes[0]


def test_store_is_left_alone_if_asked() -> None:
    store = MemoryStore()
    with Rig(from_dict(rig_of(), HERE), stores={"node": store}) as rig:
        options = Options(may_store=False)
        report = conform_virtual(rig, "can0", Description(IO32, NODE_ID), choose(["Testing other"]), options)
    assert store.load() is None
    assert len(report.of(Verdict.NOT_APPLICABLE)) == 9


def test_node_that_is_not_there_is_named() -> None:
    with Rig(from_dict(rig_of(), HERE)) as rig, pytest.raises(RigError, match="node 6 doesn't answer") as caught:
        conform_virtual(rig, "can0", Description(IO32, 6), choose(["2.1"]))
    assert "node-ID" in caught.value.remedy


def test_cases_are_chosen_by_number_name_and_family() -> None:
    def chosen(*patterns: str) -> list[str]:
        return [case.number for case in choose(patterns)]

    assert chosen("2.7") == chosen("SDO 07") == chosen("sdo 07") == ["2.7"]
    assert chosen("10.*") == chosen("Transition") == ["10.1", "10.2", "10.3", "10.4"]
    assert len(chosen("Heartbeat")) == 7
    with pytest.raises(RigError, match="no case matches sdo 99"):
        chosen("SDO 99")


def test_file_that_was_written_for_another_node_says_what_this_one_has(tmp_path: Path) -> None:
    """Exported files have the COB-IDs of their node as ParameterValue."""
    eds = tmp_path / "of-node-32.eds"
    text = IO32.read_text(encoding="latin-1")
    for sub, cob_id in ((1, 0x620), (2, 0x5A0)):
        text = text.replace(f"[1200sub{sub}]\n", f"[1200sub{sub}]\nParameterValue={cob_id:#x}\n")
    eds.write_text(text, encoding="latin-1")
    description = Description(eds, NODE_ID)
    assert [entry.default for entry in description.members(0x1200)] == [b"\x05\x06\0\0", b"\x85\x05\0\0"]


@pytest.mark.long
def test_mapping_with_limits_of_its_length_is_refused_as_too_long_and_not_as_too_high(tmp_path: Path) -> None:
    eds = tmp_path / "limits.eds"
    number = "ParameterName=Number of mapped objects in PDO\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\n"
    eds.write_text(IO32.read_text().replace(number, f"{number}LowLimit=0\nHighLimit=8\n"))
    assert eds.read_text() != IO32.read_text()
    assert failures(conformed("PDO 2*", "OD 06", "SDO 10", "SDO 11", eds=eds)) == {}
