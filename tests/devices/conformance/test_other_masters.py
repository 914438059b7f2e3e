"""Another master on the bus: that of the rig is kept from the node, and one from outside is named in the report."""

from typing import Any

import pytest
from broken_nodes import NODE_ID
from canopen_bench import IO32
from conform_bench import HERE, rig_of
from shipped import CONFIGS
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict, load
from fieldrig.errors import ControlError, UsageError
from fieldrig.system.exits import Exit
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.line import Seen
from fieldrig_devices.conformance.other_masters import foreign, kept_off, masters_of
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

CELL = CONFIGS / "arp-cell.yaml"
SPOILED = ("PDO 09", "PDO 17", "OD 02", "Heartbeat 02", "State 04", "Transition 0[1-4]")
"""Cases that the card of the cell, which starts its terminal at each heartbeat, once failed."""


def conform(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["conform", *map(str, arguments)])


def of_cell(*options: str, only: tuple[str, ...] = SPOILED) -> Any:
    chosen = [word for case in only for word in ("--only", case)]
    return conform("--rig", CELL, "--set", "time=virtual", "--bus", "can0", "--node", 20, *options, *chosen)


@pytest.mark.long
def test_the_master_in_the_rig_file_fails_no_case() -> None:
    done = of_cell()
    assert done.exit_code == Exit.OK, done.output
    assert "note: line is the master of node 20 in this rig; its commands are dropped during the run" in done.stderr
    assert "another master" not in done.output


@pytest.mark.long
def test_a_master_that_is_left_at_work_is_named_as_the_cause() -> None:
    done = of_cell("--with-masters", only=("Transition 02",))
    assert done.exit_code == Exit.NOT_CONFORMING
    assert "another master commanded node 20 or asked it during failed cases (10.2)" in done.stdout


@pytest.mark.parametrize(
    ("rig", "bus", "node", "masters"),
    [
        ("arp-cell", "can0", 20, ["line"]), ("arp-cell", "can0", 1, ["line"]), ("arp-cell", "can0", 11, []),
        ("conveyor", "can0", 20, []),
    ],
)  # fmt: skip
def test_masters_of_a_node_come_from_the_rig_file(rig: str, bus: str, node: int, masters: list[str]) -> None:
    assert masters_of(load(CONFIGS / f"{rig}.yaml", ["time=virtual"]), bus, node) == masters


def test_a_bus_that_takes_no_faults_is_refused_with_a_remedy() -> None:
    def add(fault: dict[str, Any]) -> int:
        raise ControlError("can0: can.udp takes no faults", "")

    is_master = pytest.raises(UsageError, match="line is the master of node 20 in this rig")
    with is_master as refused, kept_off(["line"], 20, add, lambda number: None):
        raise AssertionError("the run has begun")
    assert "--with-masters" in refused.value.remedy


def test_what_was_added_is_cleared_after_the_run_and_after_a_refusal() -> None:
    added: list[dict[str, Any]] = []
    cleared: list[int] = []

    def add(fault: dict[str, Any]) -> int:
        if len(added) == 2:
            raise ControlError("full", "")
        added.append(fault)
        return len(added)

    with pytest.raises(UsageError), kept_off(["line"], 20, add, cleared.append):
        raise AssertionError("the run has begun")
    assert cleared == [1, 2]


@pytest.mark.parametrize(
    "frame",
    [CanFrame(0, b"\x01\x05"), CanFrame(0, b"\x82\x00"), CanFrame(0x605, bytes(8)), CanFrame(0x605, b"\x40")],
)
def test_frames_of_a_master_from_outside_are_known(frame: CanFrame) -> None:
    assert foreign([Seen(0, False, frame)], NODE_ID) == [frame]
    assert foreign([Seen(0, True, frame)], NODE_ID) == []


@pytest.mark.parametrize(
    "frame",
    [
        CanFrame(0, b"\x01\x06"), CanFrame(0, b"\x01"), CanFrame(0x606, bytes(8)), CanFrame(0x585, bytes(8)),
        CanFrame(0x605, is_remote=True), CanFrame(0x605, bytes(8), is_extended=True), CanFrame(0x080),
        CanFrame(0x705, b"\x7f"),
    ],
)  # fmt: skip
def test_other_frames_are_not_taken_for_those_of_a_master(frame: CanFrame) -> None:
    assert foreign([Seen(0, False, frame)], NODE_ID) == []


def test_a_master_from_outside_is_named_with_the_cases_that_it_may_have_failed() -> None:
    with Rig(from_dict(rig_of(), HERE)) as rig:
        outsider = rig.attach("plc")
        link = outsider.link("can0")

        def start_again() -> None:
            link.send(CanFrame(0, bytes((1, NODE_ID))))
            outsider.clock.call_at(outsider.clock.now_ns() + 50 * MS, start_again)

        start_again()
        report = conform_virtual(rig, "can0", Description(IO32, NODE_ID), choose(["Transition 0[24]", "SDO 01"]))
    assert [result.case.number for result in report.of(Verdict.FAILED)] == ["10.2", "10.4"]
    assert all("another master sent 000#01 05" in result.notes[0] for result in report.of(Verdict.FAILED))
    assert any("during failed cases (10.2, 10.4)" in note for note in report.notes)
